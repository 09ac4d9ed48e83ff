//! Cost and quality of a way, measured over a clip.

use super::super::evaluation::Evaluation;
use super::super::methods;
use super::way::{Finish, Way};
use crate::interrupt;
use anyhow::Result;
use fovolnet::core::{Frame, Light};
use fovolnet::io::image;
use fovolnet::metrics::{ClipQuality, ColorVideoVdp, Display, FovVideoVdp};
use fovolnet::{Freedom, Limit, OpenVolume, Pipeline, PlannedPipeline, RenderSettings};
use std::time::Instant;

/// Consecutive frames of the clip. The first ones are not judged, since networks have no history there.
const CLIP: u32 = 16;
const SETTLED: u32 = 8;
/// First frames by which a way is judged too slow; the very first one prepares what the others use.
const TRIED: u32 = 3;
const FPS: f64 = 30.0;
/// Degrees that moving light turns from frame to frame, about the z axis.
const TURN: f64 = 3.0;

/// Cost and quality of one way.
#[derive(Clone, Copy)]
pub struct Found {
    /// Median of a frame's time.
    pub ms: f64,
    /// Decibels against exact frames.
    pub psnr: f64,
    /// JOD of FovVideoVDP.
    pub jod: f64,
    /// JOD of ColorVideoVDP.
    pub colour_jod: f64,
}

/// Volume whose frames are compared with exact ones.
pub struct Clip<'a> {
    evaluation: &'a Evaluation,
    volume: &'a OpenVolume,
    references: Vec<Frame>,
}

impl<'a> Clip<'a> {
    /// Clip of the frames that `exact` makes.
    pub fn new(evaluation: &'a Evaluation, volume: &'a OpenVolume, exact: &Way) -> Result<Self> {
        let mut pipeline = Pipeline::new(volume, &exact.settings, &evaluation.speed)?;
        let mut references = Vec::new();
        for frame in 0..CLIP {
            check()?;
            pipeline.change(&at(exact, frame)?)?;
            references.push(pipeline.reference(frame)?);
        }
        Ok(Self { evaluation, volume, references })
    }

    /// Cost and quality of `way`; `None` if its first frames take longer than `most_ms` each.
    pub fn run(&self, way: &Way, most_ms: f64) -> Result<Option<Found>> {
        match way.finish {
            Finish::Planned(ms) => self.run_planned(way, ms).map(Some),
            _ => self.run_fixed(way, most_ms),
        }
    }

    fn run_planned(&self, way: &Way, ms: f64) -> Result<Found> {
        let asked = (&way.settings, Freedom::ALL);
        let mut pipeline = PlannedPipeline::new(self.volume, asked, Limit::Time(ms), &self.evaluation.speed)?;
        let mut measured = Measured::new()?;
        for (number, reference) in (0..CLIP).zip(&self.references) {
            check()?;
            pipeline.ask(&at(way, number)?);
            let (rendered, _) = pipeline.render(number)?;
            measured.push(number, rendered.timings.total, reference, &rendered.frame)?;
        }
        Ok(measured.found())
    }

    fn run_fixed(&self, way: &Way, most_ms: f64) -> Result<Option<Found>> {
        let mut pipeline = Pipeline::new(self.volume, &way.settings, &self.evaluation.speed)?;
        if let Finish::Bilateral = way.finish {
            pipeline.keep_guide();
        }
        let background = way.settings.background.map(|value| value as f32);
        let mut measured = Measured::new()?;
        let mut quickest = f64::INFINITY;
        for (number, reference) in (0..CLIP).zip(&self.references) {
            check()?;
            let settings = at(way, number)?;
            let changing = Instant::now();
            pipeline.change(&settings)?;
            let changed = milliseconds(changing);
            let rendered = pipeline.render(number)?;
            let mut total = rendered.timings.total + changed;
            let frame = match way.finish {
                Finish::Nothing | Finish::Planned(_) => rendered.frame,
                Finish::Enlarge => {
                    let started = Instant::now();
                    let frame = image::resized(&rendered.frame, self.evaluation.size);
                    total += milliseconds(started);
                    frame
                }
                Finish::Bilateral => {
                    let started = Instant::now();
                    let frame = methods::bilateral(&rendered, background);
                    total += milliseconds(started) - rendered.timings.reconstruct;
                    frame
                }
            };
            if (1..TRIED).contains(&number) {
                quickest = quickest.min(total);
            }
            if number + 1 == TRIED && quickest > most_ms {
                return Ok(None);
            }
            measured.push(number, total, reference, &frame)?;
        }
        Ok(Some(measured.found()))
    }
}

/// Settings of frame `number`.
fn at(way: &Way, number: u32) -> Result<RenderSettings> {
    let mut settings = way.settings.clone();
    if way.moves {
        let turn = glam::DQuat::from_rotation_z((TURN * f64::from(number)).to_radians());
        settings.light = Light::towards(turn * settings.light.direction())?;
    }
    Ok(settings)
}

fn check() -> Result<()> {
    interrupt::check("this figure is not complete")
}

fn milliseconds(since: Instant) -> f64 {
    since.elapsed().as_secs_f64() * 1e3
}

/// Times and quality of the frames that count.
struct Measured {
    ms: Vec<f64>,
    quality: ClipQuality,
    seen: FovVideoVdp,
    seen_in_colour: ColorVideoVdp,
}

impl Measured {
    fn new() -> Result<Self> {
        let display = Display::named("standard_4k")?;
        Ok(Self {
            ms: Vec::new(),
            quality: ClipQuality::new().without_ms_ssim(),
            seen: FovVideoVdp::video(&display, FPS)?,
            seen_in_colour: ColorVideoVdp::video(&display, FPS)?,
        })
    }

    fn push(&mut self, number: u32, ms: f64, reference: &Frame, frame: &Frame) -> Result<()> {
        if number >= SETTLED {
            self.ms.push(ms);
            self.quality.push(reference, frame)?;
            self.seen.push(reference, frame, None)?;
            self.seen_in_colour.push(reference, frame)?;
        }
        Ok(())
    }

    fn found(mut self) -> Found {
        self.ms.sort_by(f64::total_cmp);
        Found {
            ms: self.ms[self.ms.len() / 2],
            psnr: self.quality.summary().map_or(f64::NAN, |summary| summary.psnr),
            jod: self.seen.jod().unwrap_or(f64::NAN),
            colour_jod: self.seen_in_colour.jod().unwrap_or(f64::NAN),
        }
    }
}
