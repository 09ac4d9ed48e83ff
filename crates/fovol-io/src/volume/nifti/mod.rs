//! NIfTI-1 and NIfTI-2, in one file or two, gzipped or not: <https://nifti.nimh.nih.gov/>.

mod forms;
mod header;
mod write;

use super::decompress::{Compression, decompress};
use super::layout::{Layout, dims_of, placed, spacing_of};
use super::{Overrides, Source};
use crate::Result;
use fovol_core::{Contents, Rescale, Space, Volume, VoxelBytes, path_of_text, text_of_path};
pub use header::is_nifti;
use header::{Header, Kind};
use std::borrow::Cow;
use std::path::{Path, PathBuf};
use std::sync::Arc;
pub use write::{units_code, write};

/// Reads a NIfTI file: `.nii`, `.hdr` or `.img` of a pair, each with `.gz` too.
///
/// # Errors
/// A damaged header, a missing half of a pair, too few bytes, types that are not read.
pub fn parse(source: &Source, overrides: &Overrides) -> Result<Volume> {
    match header_beside(source.path()) {
        Some(path) => parse_header(&Source::open(&path)?, Some(source), overrides),
        None => parse_header(source, None, overrides),
    }
}

/// The header of the pair to which the image at `path` belongs.
pub fn header_beside(path: &Path) -> Option<PathBuf> {
    other_half(path, ".img", ".hdr")
}

/// The existing file named as `path` with `theirs` for `ours`, compressed or not.
fn other_half(path: &Path, ours: &str, theirs: &str) -> Option<PathBuf> {
    let name = text_of_path(Path::new(path.file_name()?));
    let name = strip_ending(&name, ".gz").unwrap_or(&name);
    let stem = strip_ending(name, ours)?;
    let upper = theirs.to_ascii_uppercase();
    let candidates = [theirs, upper.as_str()].map(|ending| format!("{stem}{ending}"));
    let candidates = candidates.iter().flat_map(|name| [name.clone(), format!("{name}.gz")]);
    candidates.map(|name| path.with_file_name(path_of_text(&name).as_os_str())).find(|path| path.is_file())
}

/// `name` without `ending`, in whatever case it is.
fn strip_ending<'a>(name: &'a str, ending: &str) -> Option<&'a str> {
    let (stem, found) = name.split_at_checked(name.len().checked_sub(ending.len())?)?;
    found.eq_ignore_ascii_case(ending).then_some(stem)
}

/// The volume whose header is in `source` and whose voxels are in `image`, or where the header says.
fn parse_header(source: &Source, image: Option<&Source>, overrides: &Overrides) -> Result<Volume> {
    let header = Header::parse(source, &header_bytes(source)?)?;
    let (dims, _) = dims_of(&header.sizes);
    let (contents, block) = contents(source, &header, overrides)?;
    let place = header.forms.placed(spacing_of(&header.spacings));
    let layout = Layout {
        dims,
        spacing: place.spacing,
        dtype: header.dtype,
        endian: header.endian,
        components: header.components,
    };
    let length = layout.length(source)?;
    let offset = length.checked_mul(block).and_then(|before| before.checked_add(header.offset));
    let end = offset.and_then(|offset| offset.checked_add(length));
    let (Some(offset), Some(end)) = (offset, end) else {
        return Err(source.malformed("its header says that voxels begin beyond any file"));
    };
    let bytes = match (header.is_single, image) {
        (true, _) => voxels(source, end)?,
        (false, Some(image)) => voxels(image, end)?,
        (false, None) => voxels(&image_beside(source)?, end)?,
    };
    let mut volume =
        layout.volume(source, bytes, offset)?.with_format(header.kind.name()).with_contents(contents);
    if header.rescale != Rescale::IDENTITY {
        volume = volume.with_rescale(header.rescale).map_err(|e| source.malformed(e.to_string()))?;
    }
    for note in place.notes {
        volume = volume.with_note(note);
    }
    if header.kind == Kind::Analyze {
        volume =
            volume.with_note("ANALYZE 7.5 does not say how the patient lies; left and right may be swapped");
    }
    let placement = place.affine.map(|affine| affine.placement(source, Space::Patient)).transpose()?;
    Ok(placed(volume, placement, header.units))
}

/// Lists the contents of the file, and selects the index of the block of x, y and z to read.
///
/// Axis 4 is time. The components of vectors lie along axis 5 and later axes.
///
/// # Errors
/// Sizes that are 0 or overflow, vectors of colours, and a time point or component out of range.
fn contents(source: &Source, header: &Header, overrides: &Overrides) -> Result<(Contents, usize)> {
    let product = |sizes: &[usize]| sizes.iter().try_fold(1usize, |product, &size| product.checked_mul(size));
    let times = header.sizes.get(3).copied().unwrap_or(1);
    let planes = product(header.sizes.get(4..).unwrap_or_default());
    let planes = planes.filter(|&planes| planes.checked_mul(times).is_some());
    let planes =
        planes.ok_or_else(|| source.malformed("its header says more volumes than any file holds"))?;
    if times == 0 || planes == 0 {
        return Err(source.malformed("its header says that it holds no volume"));
    }
    let time = overrides.time_of(source, times)?;
    let is_interleaved = header.components > 1;
    if is_interleaved && planes > 1 {
        return Err(
            source.unsupported("it holds vectors of colours, which are not read; save one of them alone")
        );
    }
    let component = if is_interleaved { 0 } else { overrides.component_of(source, planes)? };
    let contents = Contents {
        times,
        time,
        components: planes.max(header.components),
        component,
        are_colours: header.are_colours,
        are_labels: header.are_labels,
        ..Contents::default()
    };
    Ok((contents, component * times + time))
}

/// The header at the start of `source`, decompressed where need be.
fn header_bytes(source: &Source) -> Result<Cow<'_, [u8]>> {
    if !is_gzip(source.bytes()) {
        return Ok(Cow::Borrowed(source.bytes()));
    }
    let first = decompress(source, source.bytes(), Compression::Gzip, 4)?;
    let length = header::length(source, &first)?;
    decompress(source, source.bytes(), Compression::Gzip, length).map(Cow::Owned)
}

/// The first `end` bytes of `source` at least, mapped where they are not compressed.
fn voxels(source: &Source, end: usize) -> Result<VoxelBytes> {
    if is_gzip(source.bytes()) {
        return Ok(Arc::new(decompress(source, source.bytes(), Compression::Gzip, end)?));
    }
    let found = source.bytes().len();
    if found < end {
        return Err(
            source.malformed(format!("it ends after {found} of {end} bytes; copy or download it again"))
        );
    }
    Ok(source.shared())
}

fn image_beside(source: &Source) -> Result<Source> {
    let image = other_half(source.path(), ".hdr", ".img");
    let image = image.ok_or_else(|| {
        source
            .malformed("its voxels are in a file of the same name that ends in .img; put it beside this one")
    })?;
    Source::open(&image)
}

fn is_gzip(bytes: &[u8]) -> bool {
    bytes.starts_with(&[0x1F, 0x8B])
}

#[cfg(test)]
mod tests;
