//! Reads the pictures of a stack, and makes a volume of them.

use super::arrange::arranged;
use super::file::DicomFile;
use super::frames::Frames;
use super::header::Header;
use super::plane::Plane;
use super::resample::{Resampling, Voxels};
use super::values::{self, Values};
use crate::volume::layout::{Layout, placed};
use crate::volume::{Overrides, Source};
use crate::{Error, Result};
use fovol_core::memory::{self, SMALLER_VOLUME};
use fovol_core::{Contents, Dtype, Rescale, Space, Volume, stop};
use rayon::prelude::*;
use std::sync::Arc;

/// Files that headers and pictures are of.
pub struct Files<'a> {
    /// The file or folder that was named.
    pub source: &'a Source,
    /// What the files say.
    pub headers: &'a [Header],
}

/// Voxels in memory.
pub struct Block {
    /// Little-endian components.
    pub bytes: Vec<u8>,
    /// The type of a component.
    pub dtype: Dtype,
    /// What is left of the scaling.
    pub rescale: Rescale,
}

/// The volume of `times`, whose pictures are sorted along the normal.
///
/// # Errors
/// Damaged pictures, and sizes that no volume has.
pub fn volume(files: &Files<'_>, times: &[Vec<Plane>], overrides: &Overrides) -> Result<Volume> {
    let time = overrides.time_of(files.source, times.len())?;
    let planes = &times[time];
    let header = &files.headers[planes[0].file];
    let arrangement = arranged(header, planes);
    let mut block = block(files, planes)?;
    let mut dims = [header.format.size[0], header.format.size[1], planes.len()];
    let components = header.format.components();
    if let Some(resampling) = &arrangement.resampling {
        block = resampled(files.source, &block, components, resampling)?;
        dims = resampling.dims();
    }
    let contents = Contents {
        times: times.len(),
        time,
        components,
        are_colours: header.format.is_coloured(),
        ..Contents::default()
    };
    let layout = Layout { spacing: arrangement.spacing, components, ..Layout::new(dims, block.dtype) };
    let volume = finished(files.source, &layout, block)?.with_contents(contents);
    let placement =
        arrangement.affine.map(|affine| affine.placement(files.source, Space::Patient)).transpose()?;
    let is_measured = !matches!(header.spacing_from, None | Some("PixelAspectRatio"));
    let volume = placed(volume, placement, is_measured.then_some("mm"));
    Ok(arrangement.notes.into_iter().fold(volume, Volume::with_note))
}

/// The volume of `block`.
pub fn finished(source: &Source, layout: &Layout, block: Block) -> Result<Volume> {
    let volume = layout.volume(source, Arc::new(block.bytes), 0)?.with_format("DICOM");
    match block.rescale == Rescale::IDENTITY {
        true => Ok(volume),
        false => volume.with_rescale(block.rescale).map_err(|e| source.malformed(e.to_string())),
    }
}

/// Zeros for `length` bytes of voxels.
pub fn zeros(source: &Source, length: usize) -> Result<Vec<u8>> {
    let scarce = |shortage| Error::memory(source.path(), shortage);
    let estimate = memory::Estimate::new("reading it").with("its voxels", length as u64);
    estimate.check(SMALLER_VOLUME).map_err(scarce)?;
    memory::zeroed(length, "its voxels", SMALLER_VOLUME).map_err(scarce)
}

/// The voxels of `planes`, one behind the other.
fn block(files: &Files<'_>, planes: &[Plane]) -> Result<Block> {
    let format = files.headers[planes[0].file].format;
    let how = Values::of(planes, format.is_coloured());
    let values = format.pixels() * format.components();
    let dtype = if how == Values::Each { Dtype::F32 } else { format.dtype() };
    let slice = values * dtype.size();
    let length = slice.checked_mul(planes.len());
    let length = length.ok_or_else(|| files.source.malformed("its voxels are too many; name one series"))?;
    // Nothing is taken for frames that the files cannot hold.
    for plane in distinct(planes) {
        check(files, plane)?;
    }
    let mut bytes = zeros(files.source, length)?;
    let mut jobs: Vec<Job<'_>> = Vec::new();
    for (plane, out) in planes.iter().zip(bytes.chunks_exact_mut(slice.max(1))) {
        match jobs.last_mut() {
            Some(job) if job.file == plane.file => job.frames.push((plane, out)),
            _ => jobs.push(Job { file: plane.file, frames: vec![(plane, out)] }),
        }
    }
    jobs.into_par_iter().try_for_each(|job| job.run(files, how))?;
    match how {
        Values::Each => Ok(Block { bytes, dtype, rescale: Rescale::IDENTITY }),
        Values::Alike(scale) => {
            let (dtype, rescale) = values::folded(&mut bytes, dtype, scale);
            Ok(Block { bytes, dtype, rescale })
        }
    }
}

/// The first plane of each run of planes that are of one file.
fn distinct(planes: &[Plane]) -> impl Iterator<Item = &Plane> {
    let is_first = |&i: &usize| i == 0 || planes[i].file != planes[i - 1].file;
    (0..planes.len()).filter(is_first).map(|i| &planes[i])
}

/// Refuses files that changed or are too short since their headers were read.
fn check(files: &Files<'_>, plane: &Plane) -> Result<()> {
    with_frames(files, plane.file, |_| Ok(()))
}

/// Calls `read` with the frames of a file.
pub fn with_frames<T>(
    files: &Files<'_>,
    file: usize,
    read: impl FnOnce(&Frames<'_>) -> std::result::Result<T, String>,
) -> Result<T> {
    let header = &files.headers[file];
    // The named file may be in memory alone.
    let opened = match files.source.path() == header.path && !files.source.bytes().is_empty() {
        true => files.source.clone(),
        false => Source::open(&header.path)?,
    };
    let dicom = DicomFile::open(&opened)?;
    let set = dicom.data_set();
    let problem = |problem: String| opened.malformed(problem);
    let frames = Frames::of(&set, dicom.syntax, header.planes.len()).map_err(problem)?;
    if frames.format() != &header.format {
        return Err(opened.malformed("it changed while it was read; try again"));
    }
    read(&frames).map_err(problem)
}

/// Pictures of one file.
struct Job<'a> {
    file: usize,
    frames: Vec<(&'a Plane, &'a mut [u8])>,
}

impl Job<'_> {
    fn run(self, files: &Files<'_>, how: Values) -> Result<()> {
        let format = files.headers[self.file].format;
        with_frames(files, self.file, |frames| {
            self.frames.into_par_iter().try_for_each(|(plane, out)| {
                stop::point();
                if how != Values::Each {
                    return frames.decode(plane.frame, out);
                }
                let mut samples = vec![0; format.values() * format.sample_size()];
                frames.decode(plane.frame, &mut samples)?;
                values::scaled(&samples, format.dtype(), plane.scale, out);
                Ok(())
            })
        })
    }
}

fn resampled(source: &Source, block: &Block, components: usize, how: &Resampling) -> Result<Block> {
    let [x, y, z] = how.dims();
    let length = [y, z, components, block.dtype.size()].into_iter().try_fold(x, usize::checked_mul);
    let length = length.ok_or_else(|| source.malformed("its voxels are too many; name one series"))?;
    let mut bytes = zeros(source, length)?;
    let outside = values::least(&block.bytes, block.dtype);
    how.apply(&Voxels { bytes: &block.bytes, dtype: block.dtype, components, outside }, &mut bytes);
    Ok(Block { bytes, dtype: block.dtype, rescale: block.rescale })
}
