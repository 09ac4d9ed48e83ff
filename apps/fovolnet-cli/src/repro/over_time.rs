//! Figures: PSNR, SSIM and tPSNR over time.

use super::evaluation::{Evaluation, SPARSE};
use super::methods::{self, COUNT, Comparison};
use super::plot::{self, Axes, Line};
use super::section::{Cell, Section};
use crate::interrupt;
use anyhow::Result;
use fovolnet::metrics::{ClipQuality, FrameQuality};

/// Number of frames of each of the two clips.
const CLIP: u32 = 50;
/// Frame of the fly-through at which the second clip begins.
const CUT: u32 = 150;

pub fn section(evaluation: &Evaluation) -> Result<Section> {
    let mut section = Section::new(
        "Quality over time",
        &[
            "Two clips of a fly-through at (P_b, σ) = (0.03, 0.02), with a cut between them (red). Each begins and ends fast and \
           is slow in the middle. Nothing is reset at the cut: how long the network needs to recover is seen.",
            "PSNR and SSIM compare frames, tPSNR the differences between frames. The paper shows the chameleon; volumes and \
           transfer functions differ, so levels cannot be compared, courses can.",
            methods::LEGEND,
        ],
    );
    let data = evaluation.shown("head");
    let settings = evaluation.settings(data, SPARSE);
    let mut comparison = Comparison::new(&data.open()?, &settings, &evaluation.speed)?;
    let mut courses: [Vec<FrameQuality>; COUNT] = Default::default();
    let mut qualities = [(); COUNT].map(|()| ClipQuality::new().without_ms_ssim());
    let length = CLIP.min(evaluation.frames.max(8));
    for number in journey(length) {
        interrupt::check("this figure is not complete")?;
        let reference = comparison.reference(number)?;
        let made = comparison.render(number)?.frames;
        for ((course, quality), frame) in courses.iter_mut().zip(&mut qualities).zip(&made) {
            course.push(quality.push(&reference, frame)?);
        }
    }
    let cut = [f64::from(length) - 0.5];
    type Of = fn(&FrameQuality) -> Option<f64>;
    let measures: [(&str, &str, Of); 3] = [
        ("psnr", "PSNR, dB", |q| Some(q.psnr)),
        ("ssim", "SSIM", |q| q.ssim),
        ("tpsnr", "tPSNR, dB", |q| q.tpsnr),
    ];
    for (name, unit, of) in measures {
        let course = |number: usize| {
            let values = courses[number].iter().enumerate();
            values.filter_map(|(frame, quality)| Some([frame as f64, of(quality)?])).collect()
        };
        let names = methods::names().into_iter().enumerate();
        let lines: Vec<Line> = names.map(|(i, name)| Line { name: name.into(), points: course(i) }).collect();
        let caption = format!("{}: {unit}", data.name);
        section.drawing(name, &caption, plot::lines(Axes { x: "frame", y: unit }, &lines, false, &cut)?);
    }
    section.data("over_time", &["frame", "method", "psnr", "ssim", "tpsnr"], rows(&courses));
    let summary = methods::names().into_iter().zip(&qualities).filter_map(|(name, quality)| {
        let summary = quality.summary()?;
        Some(vec![name.into(), summary.psnr.into(), summary.ssim.into(), summary.tpsnr.into()])
    });
    section.table("means", &["method", "PSNR", "SSIM", "tPSNR"], summary.collect());
    Ok(section)
}

fn rows(courses: &[Vec<FrameQuality>; COUNT]) -> Vec<Vec<Cell>> {
    let row = |name: &str, frame: usize, quality: &FrameQuality| {
        vec![
            (frame as f64).into(),
            name.into(),
            quality.psnr.into(),
            quality.ssim.into(),
            quality.tpsnr.into(),
        ]
    };
    let each = methods::names().into_iter().zip(courses);
    each.flat_map(|(name, course)| {
        course.iter().enumerate().map(move |(frame, quality)| row(name, frame, quality))
    })
    .collect()
}

/// Frame numbers of two clips of `length` frames. Steps along the path are 4 frames at the ends of a clip and 1 in the
/// middle.
fn journey(length: u32) -> Vec<u32> {
    let mut frames = Vec::new();
    for start in [0, CUT] {
        let mut place = start;
        for number in 0..length {
            frames.push(place);
            let is_slow = (length / 3..length - length / 3).contains(&number);
            place += if is_slow { 1 } else { 4 };
        }
    }
    frames
}

#[cfg(test)]
mod tests {
    #[test]
    fn clips_are_fast_slow_fast_and_apart() {
        let frames = super::journey(50);
        assert_eq!(frames.len(), 100);
        let steps: Vec<u32> = frames[..50].windows(2).map(|pair| pair[1] - pair[0]).collect();
        assert_eq!((steps[0], steps[25], steps[48]), (4, 1, 4));
        assert_eq!(frames[50], 150);
        assert!(frames[49] != 149);
    }
}
