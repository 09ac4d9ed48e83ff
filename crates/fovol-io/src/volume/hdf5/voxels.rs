//! The values of a part of a dataset, mapped where they lie together in the file, else unpacked.

use super::element::Element;
use super::file::File;
use super::limits::{BYTES_PER_BYTE, FREE_BYTES};
use crate::{Error, Result};
use bytemuck::TransparentWrapper;
use fovol_core::memory::{self, Estimate};
use fovol_core::{VoxelBytes, stop};
use hdf5_reader::error::{Error as Problem, Result as Outcome};
use hdf5_reader::messages::HdfMessage;
use hdf5_reader::messages::layout::DataLayout;
use hdf5_reader::{Dataset, Datatype, H5Type, SliceInfo, SliceInfoElem, dtype_element_size};
use std::ops::Range;
use std::sync::Arc;

/// Bytes that are unpacked between two looks at whether to stop.
const SLAB: usize = 64 << 20;

/// Fewer bytes are unpacked by one thread: on a busy machine others come late.
const SHARED: usize = 1 << 20;

/// Advice for datasets that do not fit in memory.
const ADVICE: &str = "a part of it, saved as NRRD or .npy, needs less; or save it without chunks, which needs no memory until it is rendered";

/// Bytes that hold the `part` of `dataset` in C order, and where they begin.
///
/// # Errors
/// Damaged data, unknown compressions, too little memory, more values than so small a file can hold.
pub fn read(
    file: &File<'_>,
    dataset: &Dataset,
    element: &Element,
    part: &[Range<usize>],
) -> Result<(VoxelBytes, usize)> {
    let too_large =
        || file.source.malformed("its dataset is larger than any file; copy or download it again");
    let length = part.iter().try_fold(element.size(), |length, range| length.checked_mul(range.len()));
    let length = length.filter(|&length| length < isize::MAX as usize).ok_or_else(too_large)?;
    if let Some(start) = mapped(file, dataset, element, part) {
        let end = start.checked_add(length).filter(|&end| end <= file.source.bytes().len());
        end.ok_or_else(|| {
            file.source.malformed("it ends before the last value of its dataset; copy or download it again")
        })?;
        return Ok((file.source.shared(), start));
    }
    let justified = file.source.bytes().len().saturating_mul(BYTES_PER_BYTE).saturating_add(FREE_BYTES);
    if length > justified {
        return Err(file.source.malformed(format!(
            "its dataset has {length} bytes of values, which so small a file can only leave empty; save it with its values"
        )));
    }
    let scarce = |shortage| Error::memory(file.source.path(), shortage);
    Estimate::new("unpacking it").with("its values", length as u64).check(ADVICE).map_err(scarce)?;
    let mut out = Vec::new();
    memory::reserve(&mut out, length, "unpacking it", ADVICE).map_err(scarce)?;
    let unpacked = match element.size() {
        1 => slabs::<1>(dataset, part, &mut out),
        2 => slabs::<2>(dataset, part, &mut out),
        4 => slabs::<4>(dataset, part, &mut out),
        8 => slabs::<8>(dataset, part, &mut out),
        _ => whole(dataset, part).map(|bytes| out = bytes),
    };
    unpacked.map_err(|problem| file.failed(problem))?;
    if out.len() != length {
        return Err(file
            .source
            .malformed("its dataset has fewer values than its shape says; copy or download it again"));
    }
    Ok((Arc::new(out), 0))
}

/// Where the values of `part` begin in the bytes of the file; none where they do not lie together.
fn mapped(file: &File<'_>, dataset: &Dataset, element: &Element, part: &[Range<usize>]) -> Option<usize> {
    let header = file.header(dataset.address())?;
    let is_outside = header.messages.iter().any(|message| matches!(message, HdfMessage::ExternalFiles(_)));
    let layout = header.messages.iter().find_map(|message| match message {
        HdfMessage::DataLayout(layout) => Some(&layout.layout),
        _ => None,
    })?;
    let DataLayout::Contiguous { address, size } = *layout else { return None };
    let shape: Vec<usize> =
        dataset.shape().iter().map(|&length| usize::try_from(length).unwrap_or(0)).collect();
    // Values that were never written have no address, and no place in the file.
    if is_outside || size == 0 || address > file.source.bytes().len() as u64 {
        return None;
    }
    let is_full = |axis: usize| part[axis] == (0..shape[axis]);
    let last_cut = (0..part.len()).rev().find(|&axis| !is_full(axis)).unwrap_or(0);
    if part.len() != shape.len() || part.iter().take(last_cut).any(|range| range.len() != 1) {
        return None;
    }
    let strides = part.iter().zip(&shape).try_fold(0usize, |position, (range, &length)| {
        position.checked_mul(length)?.checked_add(range.start)
    })?;
    let offset = strides.checked_mul(element.size())?;
    file.start.checked_add(usize::try_from(address).ok()?)?.checked_add(offset)
}

/// Appends the values of `part` to `out`, slab by slab.
fn slabs<const N: usize>(dataset: &Dataset, part: &[Range<usize>], out: &mut Vec<u8>) -> Outcome<()> {
    let axis = part.iter().position(|range| range.len() > 1).unwrap_or(0);
    let Some(along) = part.get(axis).cloned() else {
        return Err(Problem::InvalidData("a dataset without axes".into()));
    };
    let slice: usize = N * part[axis + 1..].iter().map(Range::len).product::<usize>();
    let chunk = dataset
        .chunks()
        .and_then(|chunks| chunks.get(axis).copied())
        .map_or(1, |length| length.max(1) as usize);
    // Whole chunks: each is unpacked once.
    let step = (SLAB / slice.max(1)).max(1).next_multiple_of(chunk);
    let mut from = along.start;
    while from < along.end {
        stop::point();
        let to = along.end.min((from / chunk * chunk).saturating_add(step)).max(from + 1);
        let mut slab = part.to_vec();
        slab[axis] = from..to;
        let selection = selection(&slab);
        let values = match (to - from).saturating_mul(slice) >= SHARED {
            true => dataset.read_slice_parallel::<Raw<N>>(&selection)?,
            false => dataset.read_slice::<Raw<N>>(&selection)?,
        };
        let values = values.as_slice().ok_or_else(|| Problem::InvalidData("values out of order".into()))?;
        out.extend_from_slice(Raw::peel_slice(values).as_flattened());
        from = to;
    }
    Ok(())
}

/// All values, where `part` is all.
fn whole(dataset: &Dataset, part: &[Range<usize>]) -> Outcome<Vec<u8>> {
    let is_all = part.iter().zip(dataset.shape()).all(|(range, &length)| range.len() as u64 == length);
    match is_all {
        true => dataset.read_raw_bytes(),
        false => Err(Problem::UnsupportedEncoding("parts of arrays of arrays are not read".into())),
    }
}

fn selection(part: &[Range<usize>]) -> SliceInfo {
    let selections = part.iter().map(|range| SliceInfoElem::Slice {
        start: range.start as u64,
        end: range.end as u64,
        step: 1,
    });
    SliceInfo { selections: selections.collect() }
}

/// A value of `N` bytes as the file has it.
#[derive(Debug, Clone, Copy, TransparentWrapper)]
#[repr(transparent)]
struct Raw<const N: usize>([u8; N]);

impl<const N: usize> H5Type for Raw<N> {
    fn hdf5_type() -> Datatype {
        Datatype::Opaque { size: N as u32, tag: String::new() }
    }

    fn from_bytes(bytes: &[u8], _: &Datatype) -> Outcome<Self> {
        bytes
            .first_chunk()
            .map(|bytes| Self(*bytes))
            .ok_or_else(|| Problem::InvalidData("too few bytes".into()))
    }

    fn element_size(_: &Datatype) -> usize {
        N
    }

    fn decode_vec(raw: &[u8], _: &Datatype, count: usize) -> Option<Outcome<Vec<Self>>> {
        let values = raw.as_chunks().0.get(..count)?;
        Some(Ok(values.iter().map(|value| Self(*value)).collect()))
    }

    fn native_copy_compatible(datatype: &Datatype) -> bool {
        dtype_element_size(datatype).is_ok_and(|size| size == N)
    }
}
