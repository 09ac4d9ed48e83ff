//! Figure: pictures of every method beside the full one, at the gaze and away from it.

use super::data_set::DataSet;
use super::evaluation::{Evaluation, SPARSE};
use super::methods::{self, COUNT, Compared, Comparison};
use super::section::{Cell, Section};
use crate::interrupt;
use crate::picture::{larger, side_by_side, smaller, stacked};
use anyhow::Result;
use fovolnet::core::{Frame, FrameSize};
use fovolnet::metrics::{SsimSettings, psnr, ssim};

/// Number of the shown frame. The history of networks has settled by then.
const FRAME: u32 = 15;
const GAP: u32 = 4;
/// Factor by which the shown details are smaller than the frame, along each axis.
const PART: u32 = 8;

pub fn section(evaluation: &Evaluation) -> Result<Section> {
    let mut section = Section::new(
        "Quality matrix",
        &[
            "One frame of every data set, the sixteenth of a fly-through, at (P_b, σ) = (0.03, 0.02): full, sparse, and every \
           method. Above the frame, then the part where the eye looks, then the most detailed part elsewhere; the \
           parts with every pixel enlarged. The tables give PSNR in dB and SSIM of the frame and of both parts.",
            methods::LEGEND,
        ],
    );
    let mut rows = Vec::new();
    for data in &evaluation.data_sets {
        let frames = Frames::of(evaluation, data)?;
        let parts = [frames.eye(), frames.elsewhere()];
        let caption = format!("{}: full, sparse, {}", data.name, methods::names().join(", "));
        section.picture(&data.name, &caption, frames.sheet(parts));
        for (method, frame) in methods::names().into_iter().zip(&frames.made) {
            let mut row: Vec<Cell> = vec![data.name.as_str().into(), method.into()];
            row.extend(likeness(&frames.full, frame)?);
            for corner in parts {
                row.extend(likeness(&frames.part(&frames.full, corner), &frames.part(frame, corner))?);
            }
            rows.push(row);
        }
    }
    let columns = [
        "data set",
        "method",
        "PSNR",
        "SSIM",
        "PSNR fovea",
        "SSIM fovea",
        "PSNR periphery",
        "SSIM periphery",
    ];
    section.table("quality", &columns, rows);
    Ok(section)
}

/// PSNR, and SSIM if the frames are large enough for its window.
fn likeness(reference: &Frame, frame: &Frame) -> Result<[Cell; 2]> {
    let (settings, FrameSize { width, height }) = (SsimSettings::default(), frame.size());
    let is_large = width.min(height) >= settings.min_side();
    let similar = is_large.then(|| ssim(reference, frame, &settings)).transpose()?;
    Ok([psnr(reference, frame)?.into(), similar.into()])
}

/// One frame, rendered by every method.
struct Frames {
    full: Frame,
    sparse: Frame,
    /// Full frames in the order of [`methods::METHODS`].
    made: [Frame; COUNT],
    gaze: [f64; 2],
}

impl Frames {
    fn of(evaluation: &Evaluation, data: &DataSet) -> Result<Self> {
        let settings = evaluation.settings(data, SPARSE);
        let mut comparison = Comparison::new(&data.open()?, &settings, &evaluation.speed)?;
        for frame in 0..FRAME {
            interrupt::check("this figure is not complete")?;
            comparison.render(frame)?;
        }
        let Compared { sparse, frames: made } = comparison.render(FRAME)?;
        Ok(Self { full: comparison.reference(FRAME)?, sparse, made, gaze: comparison.gaze(FRAME) })
    }

    /// Width and height of a detail.
    fn part_size(&self) -> FrameSize {
        let FrameSize { width, height } = self.full.size();
        FrameSize::new((width / PART).max(1), (height / PART).max(1)).expect("it is smaller than the frame")
    }

    /// Corner of the detail around the gaze.
    fn eye(&self) -> [u32; 2] {
        let (whole, part) = (self.full.size(), self.part_size());
        let corner = |at: f64, whole: u32, part: u32| {
            ((at * f64::from(whole)) as u32).saturating_sub(part / 2).min(whole - part)
        };
        [corner(self.gaze[0], whole.width, part.width), corner(self.gaze[1], whole.height, part.height)]
    }

    /// Corner of the detail away from the gaze where neighbouring pixels differ most.
    fn elsewhere(&self) -> [u32; 2] {
        let (whole, part, eye) = (self.full.size(), self.part_size(), self.eye());
        let steps = |whole: u32, part: u32| (0..=whole - part).step_by((part / 2).max(1) as usize);
        let corners = steps(whole.height, part.height)
            .flat_map(|y| steps(whole.width, part.width).map(move |x| [x, y]));
        let away =
            corners.filter(|[x, y]| x.abs_diff(eye[0]) > part.width || y.abs_diff(eye[1]) > part.height);
        away.max_by(|a, b| self.detail(*a).total_cmp(&self.detail(*b))).unwrap_or(eye)
    }

    /// Sum of differences between pixels and their right neighbours, in the detail at `corner`.
    fn detail(&self, corner: [u32; 2]) -> f64 {
        let part = self.part(&self.full, corner);
        let rows = part.pixels().chunks(part.size().width as usize);
        rows.flat_map(|row| row.windows(2)).map(|pair| f64::from((pair[0][1] - pair[1][1]).abs())).sum()
    }

    fn part(&self, frame: &Frame, [left, top]: [u32; 2]) -> Frame {
        let size = self.part_size();
        let places = (0..size.height).flat_map(|y| (0..size.width).map(move |x| (left + x, top + y)));
        let pixels = places.map(|(x, y)| frame.pixel(x, y)).collect();
        Frame::from_pixels(size, pixels).expect("as many pixels as the size says")
    }

    fn sheet(&self, parts: [[u32; 2]; 2]) -> Frame {
        let all: Vec<&Frame> = [&self.full, &self.sparse].into_iter().chain(&self.made).collect();
        let row = |frames: Vec<Frame>| side_by_side(&frames.iter().collect::<Vec<_>>(), GAP);
        let small = |frame: &Frame| smaller(frame, PART / 2);
        let mut rows = vec![row(all.iter().map(|frame| small(frame)).collect())];
        for corner in parts {
            rows.push(row(all.iter().map(|frame| larger(&self.part(frame, corner), 2)).collect()));
        }
        stacked(&rows, GAP)
    }
}
