//! Segmentations: frames of bits, parts or numbers at the slices where there are any.

use super::assemble::{Block, Files, finished, with_frames, zeros};
use super::header::Header;
use super::plane::Plane;
use super::segments::{Kind, Segments};
use super::stack::Stack;
use crate::Result;
use crate::volume::affine::Affine;
use crate::volume::layout::{Layout, placed};
use fovol_core::{Contents, Dtype, Rescale, Space, Volume, stop};

/// Voxels that a small file may stand for, and for each of its bytes: slices without segments are left out of files.
const FREE_VOXELS: usize = 1 << 20;
const VOXELS_PER_BYTE: usize = 1100;

/// The volumes of a segmentation: one of all segments, or one for each where voxels are parts.
pub fn stacks(segments: &Segments, planes: Vec<Plane>) -> Vec<Stack> {
    let all = |planes| Stack { times: vec![planes], part: String::new(), notes: Vec::new() };
    if !matches!(segments.kind, Kind::Fractional(_)) {
        return vec![all(planes)];
    }
    let mut stacks: Vec<(u16, Stack)> = Vec::new();
    for plane in planes {
        let number = number(&plane);
        match stacks.iter_mut().find(|(found, _)| *found == number) {
            Some((_, stack)) => stack.times[0].push(plane),
            None => stacks.push((number, Stack { part: format!("segment {number}"), ..all(vec![plane]) })),
        }
    }
    stacks.into_iter().map(|(_, stack)| stack).collect()
}

/// The number of the segment of a frame; 0 where it says none.
fn number(plane: &Plane) -> u16 {
    plane.keys.segment.parse().unwrap_or(0)
}

/// Where the frames lie.
struct Slots {
    /// The number of slices, with or without frames.
    depth: usize,
    spacing: f64,
    /// The slice of each frame.
    of: Vec<usize>,
    affine: Option<Affine>,
    is_uneven: bool,
}

/// The number of slices of the volume of `stack`.
pub fn depth(header: &Header, stack: &Stack) -> usize {
    slots(header, &stack.times[0]).depth
}

fn slots(header: &Header, planes: &[Plane]) -> Slots {
    let [x, y] = planes[0].spacing;
    let stated = header.between.or(header.thickness).unwrap_or(1.0);
    let heights: Option<Vec<f64>> =
        planes.iter().map(|plane| plane.place.map(|place| place.height())).collect();
    let (Some(heights), Some(first)) = (heights, planes[0].place) else {
        let of = (0..planes.len()).collect();
        return Slots { depth: planes.len(), spacing: stated, of, affine: None, is_uneven: false };
    };
    let lowest = (0..planes.len()).min_by(|&a, &b| heights[a].total_cmp(&heights[b])).unwrap_or(0);
    let mut levels = heights.clone();
    levels.sort_by(f64::total_cmp);
    let near = 0.01 * x.min(y);
    let steps: Vec<f64> =
        levels.windows(2).map(|pair| pair[1] - pair[0]).filter(|&step| step > near).collect();
    let least = steps.iter().copied().fold(f64::INFINITY, f64::min);
    // Some programs state the thickness for the distance.
    let spacing = match header.between {
        Some(between) if steps.iter().all(|step| (step / between - (step / between).round()).abs() < 0.1) => {
            between
        }
        _ if least.is_finite() => least,
        _ => stated,
    };
    let slot = |height: f64| (height - heights[lowest]) / spacing;
    let of = heights.iter().map(|&height| slot(height).round() as usize).collect::<Vec<_>>();
    let is_uneven = heights.iter().any(|&height| (slot(height) - slot(height).round()).abs() > 0.1);
    let position = planes[lowest].place.map_or(first.position, |place| place.position);
    let affine =
        Affine { steps: [first.along_x * x, first.along_y * y, first.normal() * spacing], origin: position };
    let depth = of.iter().copied().max().unwrap_or(0).saturating_add(1);
    Slots { depth, spacing, of, affine: Some(affine), is_uneven }
}

/// The volume of a segmentation.
///
/// # Errors
/// Damaged frames, and frames too far apart.
pub fn volume(files: &Files<'_>, segments: &Segments, planes: &[Plane]) -> Result<Volume> {
    let header = &files.headers[planes[0].file];
    let slots = slots(header, planes);
    let [nx, ny] = header.format.size;
    let slice = nx * ny;
    let most = files.source.bytes().len().max(file_length(header)).saturating_mul(VOXELS_PER_BYTE);
    let voxels = slice.checked_mul(slots.depth).filter(|&voxels| voxels <= most.saturating_add(FREE_VOXELS));
    let voxels = voxels.ok_or_else(|| {
        files.source.malformed("its frames lie too far apart for its size; check its SpacingBetweenSlices")
    })?;
    let (block, overlap) = filled(files, segments, planes, (&slots, voxels))?;
    let are_labels = !matches!(segments.kind, Kind::Fractional(_));
    let labels = if are_labels { segments.labels.clone() } else { Vec::new() };
    let contents = Contents { are_labels, labels, ..Contents::default() };
    let spacing = [planes[0].spacing[0], planes[0].spacing[1], slots.spacing];
    let layout = Layout { spacing, ..Layout::new([nx, ny, slots.depth], block.dtype) };
    let volume =
        finished(files.source, &layout, block)?.with_format("DICOM segmentation").with_contents(contents);
    let placement = slots.affine.map(|affine| affine.placement(files.source, Space::Patient)).transpose()?;
    let mut volume = placed(volume, placement, header.spacing_from.map(|_| "mm"));
    if overlap > 0 {
        volume = volume.with_note(format!(
            "{overlap} voxels are of several segments; the one with the highest number is shown"
        ));
    }
    if slots.is_uneven {
        volume = volume.with_note("its frames lie beside a regular grid; each is in the nearest slice");
    }
    Ok(volume)
}

fn file_length(header: &Header) -> usize {
    std::fs::metadata(&header.path).map_or(0, |found| usize::try_from(found.len()).unwrap_or(usize::MAX))
}

/// The voxels, and the number of those that several segments want.
fn filled(
    files: &Files<'_>,
    segments: &Segments,
    planes: &[Plane],
    (slots, voxels): (&Slots, usize),
) -> Result<(Block, usize)> {
    let header = &files.headers[planes[0].file];
    let format = header.format;
    let is_binary = segments.kind == Kind::Binary;
    let is_wide = is_binary && planes.iter().any(|plane| number(plane) > 255);
    let dtype = match (is_binary, is_wide) {
        (true, false) => Dtype::U8,
        (true, true) => Dtype::U16,
        (false, _) => format.dtype(),
    };
    let slice = format.pixels() * dtype.size();
    with_frames(files, planes[0].file, |_| Ok(()))?;
    let mut bytes = zeros(files.source, voxels * dtype.size())?;
    let mut order: Vec<usize> = (0..planes.len()).collect();
    order.sort_by_key(|&i| number(&planes[i]));
    let mut overlap = 0;
    with_frames(files, planes[0].file, |frames| {
        let mut frame = vec![0; format.pixels() * format.sample_size()];
        for i in order {
            stop::point();
            frames.decode(planes[i].frame, &mut frame)?;
            let out = &mut bytes[slots.of[i] * slice..][..slice];
            match is_binary {
                false => out.copy_from_slice(&frame),
                true => overlap += labelled(&frame, format.sample_size(), number(&planes[i]), out),
            }
        }
        Ok(())
    })?;
    let rescale = match segments.kind {
        Kind::Fractional(most) => Rescale { slope: 1.0 / most, intercept: 0.0 },
        _ => Rescale::IDENTITY,
    };
    Ok((Block { bytes, dtype, rescale }, overlap))
}

/// Gives `label` to the voxels of `out` where `frame` is not 0; returns how many had another.
fn labelled(frame: &[u8], size: usize, label: u16, out: &mut [u8]) -> usize {
    let width = out.len() / (frame.len() / size).max(1);
    let mut overlap = 0;
    for (sample, voxel) in frame.chunks_exact(size).zip(out.chunks_exact_mut(width.max(1))) {
        if sample.iter().any(|&byte| byte != 0) {
            let label = &label.to_le_bytes()[..width];
            overlap += usize::from(voxel.iter().any(|&byte| byte != 0) && voxel != label);
            voxel.copy_from_slice(label);
        }
    }
    overlap
}
