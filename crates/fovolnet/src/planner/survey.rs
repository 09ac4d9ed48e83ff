use super::candidate::{Candidate, STEPS, scaled};
use super::costs::Costs;
use super::errors::Errors;
use super::probes::{Colours, Probes, Shown, mean_square, squared};
use super::sizes::RATIOS;
use super::way::Way;
use crate::Result;
use fovol_core::{Frame, FrameSize, Pixel, Region, SampleList, ShadowMode};
use std::time::Instant;

/// Measures what frames of other steps and sizes than the one that is shown would be wrong by.
///
/// Both are measured without the error of the light: other steps at the probe pixels, other sizes by making the frame smaller.
pub struct Survey<'a, 'b> {
    probes: &'a mut Probes<'b>,
    shadows: ShadowMode,
    /// Colours of probe pixels at each of [`STEPS`], where the device can march them.
    by_step: Vec<Option<Colours>>,
}

/// Weight of what was known of errors of steps.
const MEMORY: f64 = 0.7;
/// Places at which a frame is compared with itself made smaller.
const PLACES: usize = 384;
/// Pixels and scale of the frame that is marched where none is shown yet, at most.
const FIRST_PIXELS: f64 = 16_384.0;
const FIRST_SCALE: f64 = 0.25;
/// Smallest part of a frame's error that its size is taken to have.
const LEAST: f64 = 0.1;

impl<'a, 'b> Survey<'a, 'b> {
    /// Marches the pixels of `probes` with `shadows` at every step.
    ///
    /// # Errors
    /// A lost device, too little memory.
    pub fn new(probes: &'a mut Probes<'b>, shadows: ShadowMode) -> Result<Self> {
        let mut by_step = Vec::new();
        for step in STEPS {
            by_step.push(probes.colours(shadows, step)?);
        }
        Ok(Self { probes, shadows, by_step })
    }

    /// Adds what longer steps are wrong by to `errors`.
    pub fn measure_steps(&self, errors: &mut Errors) {
        let [Some(whole), longer @ ..] = &self.by_step[..] else { return };
        for (longer, error) in longer.iter().zip(&mut errors.steps) {
            if let Some(longer) = longer {
                error.add(self.probes.squares(longer, whole), MEMORY);
            }
        }
    }

    /// Learns what smaller and larger frames are wrong by from the frame that is `shown`, made as `candidate`, whose whole error
    /// is `known`.
    pub fn measure_sizes(
        &self,
        (shown, candidate): (Shown<'_>, Candidate),
        known: Option<f64>,
        errors: &mut Errors,
    ) {
        let error = match (candidate.scale >= 1.0, self.marched_alike(&candidate), known) {
            (true, ..) => 0.0,
            (false, Some(colours), _) => self.size_error(shown, colours),
            (false, None, Some(known)) if candidate.way.is_full() => {
                let others = errors.of(&Candidate { scale: 1.0, ..candidate });
                (known - others).max(LEAST * known)
            }
            (false, None, _) => return,
        };
        errors.sizes.see(candidate.scale, error, self.differences(shown));
    }

    /// Marches a small frame, and learns from it what frames are wrong by for their size, and what every pixel costs.
    ///
    /// # Errors
    /// A lost device, too little memory.
    pub fn measure_sizes_anew(
        &mut self,
        region: Region,
        (errors, costs): (&mut Errors, &mut Costs),
    ) -> Result<()> {
        let scale = (FIRST_PIXELS / region.size.pixels() as f64).sqrt().min(FIRST_SCALE);
        let Some(at) = self.by_step.iter().rposition(Option::is_some) else { return Ok(()) };
        let step = STEPS[at.min(1)];
        let started = Instant::now();
        let Some(frame) = self.small_frame(scaled(self.probes.size(), scale), step)? else { return Ok(()) };
        // Few rays do without what shadow rays need to be quick, so their time says little of a whole frame with shadow rays.
        if self.shadows == ShadowMode::Cached {
            let candidate = Candidate { way: Way::CachedLight, scale, step, density: 1.0 };
            costs.try_out(&candidate, self.probes.asked(), started.elapsed().as_secs_f64() * 1e3);
        }
        let shown = Shown { frame: &frame, on_screen: false };
        if let Some(colours) = &self.by_step[at.min(1)] {
            let error = self.size_error(shown, colours);
            errors.sizes.see(scale, error, self.differences(shown));
        }
        Ok(())
    }

    /// Colours of probe pixels with the light and step of `candidate`.
    fn marched_alike(&self, candidate: &Candidate) -> Option<&Colours> {
        let light = match candidate.way {
            Way::CachedLight => ShadowMode::Cached,
            Way::ExactLight => self.probes.exact_shadows(),
            Way::LightRatio | Way::FewShadowRays | Way::Colours => return None,
        };
        let at = STEPS.iter().position(|step| *step == candidate.step)?;
        self.by_step[at].as_ref().filter(|_| light == self.shadows)
    }

    /// Error of `shown` by its size: against the probe pixels' own `colours`.
    fn size_error(&self, shown: Shown<'_>, colours: &Colours) -> f64 {
        let enlarged: Colours = self.probes.pixels()[..colours.len()]
            .iter()
            .map(|at| shown.colour(*at, self.probes.size()))
            .collect();
        mean_square(self.probes.squares(&enlarged, colours))
    }

    /// Differences between the frame that is `shown` and itself made smaller by each of [`RATIOS`].
    fn differences(&self, shown: Shown<'_>) -> [f64; RATIOS.len()] {
        let size = self.probes.size();
        let places = self.probes.places(PLACES);
        let whole: Colours = places.iter().map(|(at, _)| shown.colour(*at, size)).collect();
        RATIOS.map(|ratio| {
            let smaller = scaled(shown.frame.size(), ratio);
            let made = places.iter().map(|(at, _)| shown.colour_made_smaller(*at, [size, smaller]));
            let squares = squared(made, whole.iter().copied());
            mean_square(squares.zip(&places).map(|(square, (_, weight))| square * weight))
        })
    }

    /// Frame of `size` at this factor of the asked step.
    fn small_frame(&mut self, size: FrameSize, step: f64) -> Result<Option<Frame>> {
        let all =
            (0..size.height).flat_map(|y| (0..size.width).map(move |x| Pixel { x: x as u16, y: y as u16 }));
        let list = SampleList::new(size, all.collect());
        let marched = self.probes.march((self.shadows, step), &list)?;
        let pixels = |colours: Colours| colours.into_iter().map(|[r, g, b]| [r, g, b, 1.0]).collect();
        Ok(marched.and_then(|colours| Frame::from_pixels(size, pixels(colours)).ok()))
    }
}

#[cfg(all(test, feature = "files", feature = "procedural"))]
mod tests {
    use super::*;
    use crate::{
        Device, Pipeline, RenderSettings, Sampling, SpeedSettings, Viewpoint, VolumeSettings, open_volume,
    };

    /// Error of `made`, enlarged, against the `whole` frame, over the region that can show anything.
    fn truth(made: &Frame, whole: &Frame, region: Region) -> f64 {
        let shown = Shown { frame: made, on_screen: false };
        let Region { x, y, size } = region;
        let at = (y..y + size.height)
            .flat_map(|y| (x..x + size.width).map(move |x| Pixel { x: x as u16, y: y as u16 }));
        mean_square(at.map(|at| {
            let (shown, whole) = (shown.colour(at, whole.size()), whole.pixel(at.x.into(), at.y.into()));
            (0..3).map(|c| f64::from(shown[c] - whole[c].clamp(0.0, 1.0)).powi(2)).sum::<f64>() / 3.0
        }))
    }

    #[test]
    fn errors_of_other_sizes_and_steps_are_told_from_one_frame() {
        let volume =
            open_volume("head", &VolumeSettings { dims: Some([48; 3]), ..Default::default() }).unwrap();
        let asked = RenderSettings {
            size: FrameSize::new(320, 180).unwrap(),
            sampling: Sampling::Full,
            shadows: ShadowMode::Cached,
            ..RenderSettings::default()
        };
        let speed = SpeedSettings { device: Some(Device::Cpu), ..SpeedSettings::default() };
        let mut pipeline = Pipeline::new(&volume, &asked, &speed).unwrap();
        let mut rendered = |candidate: Candidate| {
            pipeline.change(&candidate.settings(&asked)).unwrap();
            pipeline.render(0).unwrap().frame
        };
        let candidate = |scale, step| Candidate { way: Way::CachedLight, scale, step, density: 1.0 };
        let whole = rendered(candidate(1.0, 1.0));
        let others = [(0.75, 1.0), (0.5, 1.0), (0.3333, 1.0), (0.2, 1.0), (1.0, 4.0)];
        let frames = others.map(|(scale, step)| rendered(candidate(scale, step)));
        for shown in [0, 1, 2] {
            let viewpoint = Viewpoint { camera: pipeline.camera(0), fovea: pipeline.fovea(0) };
            let made = Shown { frame: &frames[shown], on_screen: false };
            let mut probes =
                Probes::new((&mut pipeline, &viewpoint, &asked), (0, 512, Some(made)), &mut Costs::default())
                    .unwrap()
                    .unwrap();
            let region = probes.region();
            let survey = Survey::new(&mut probes, ShadowMode::Cached).unwrap();
            let mut errors = Errors::default();
            survey.measure_steps(&mut errors);
            survey.measure_sizes((made, candidate(others[shown].0, 1.0)), None, &mut errors);
            for ((scale, step), frame) in others.into_iter().zip(&frames) {
                let exact = Candidate { way: Way::ExactLight, ..candidate(scale, step) };
                let far = 10.0 * (errors.of(&exact) / truth(frame, &whole, region)).log10();
                assert!(far.abs() < 2.5, "{scale} {step} told {far} dB off by {:?}", others[shown]);
            }
        }
    }
}
