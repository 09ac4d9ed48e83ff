//! NIfTI out: one file, compressed where its name ends in `.gz`.

use super::header::{LENGTH_1, LENGTH_2};
use crate::volume::voxels::Voxels;
use crate::{Error, Result, atomic};
use fovol_core::{Dtype, Grid, Volume};
use std::io::{self, Write};
use std::path::Path;

/// Writes `volume` to `path`: NIfTI-1, or NIfTI-2 where the numbers of NIfTI-1 are too small.
///
/// # Errors
/// Half precision, which NIfTI does not have; what the system said.
pub fn write(volume: &Volume, path: &Path) -> Result<()> {
    let voxels = Voxels::of(volume);
    let (code, bits) = code(voxels.dtype())
        .ok_or_else(|| Error::unsupported(path, "NIfTI has no half precision; write .raw instead"))?;
    let header = match fits_one(volume.grid()) {
        true => header_1(volume.grid(), code, bits),
        false => header_2(volume.grid(), code, bits),
    };
    let fill = |out: &mut dyn Write| -> io::Result<()> {
        out.write_all(&header)?;
        voxels.write_to(out)
    };
    atomic::write(path, |out| match path.extension().is_some_and(|e| e.eq_ignore_ascii_case("gz")) {
        true => {
            let mut packed = flate2::write::GzEncoder::new(out, flate2::Compression::default());
            fill(&mut packed)?;
            packed.finish().map(|_| ())
        }
        false => fill(out),
    })
}

/// Whether NIfTI-1, with sizes of 16 bits and spacings of single precision, holds `grid`.
fn fits_one(grid: &Grid) -> bool {
    grid.dims().iter().all(|&dim| i16::try_from(dim).is_ok())
        && grid.spacing().iter().all(|&spacing| (spacing as f32).is_normal())
}

fn header_1(grid: &Grid, code: i16, bits: i16) -> Vec<u8> {
    let mut header = vec![0; LENGTH_1 + 4];
    let mut put = |at: usize, bytes: &[u8]| header[at..at + bytes.len()].copy_from_slice(bytes);
    put(0, &(LENGTH_1 as i32).to_le_bytes());
    put(70, &code.to_le_bytes());
    put(72, &bits.to_le_bytes());
    put(108, &((LENGTH_1 + 4) as f32).to_le_bytes());
    put(112, &1f32.to_le_bytes());
    for (axis, size) in axes(grid).into_iter().enumerate() {
        put(40 + 2 * axis, &(size as i16).to_le_bytes());
    }
    for (axis, spacing) in spacings(grid).into_iter().enumerate() {
        put(76 + 4 * axis, &(spacing as f32).to_le_bytes());
    }
    put(344, b"n+1\0");
    header
}

fn header_2(grid: &Grid, code: i16, bits: i16) -> Vec<u8> {
    let mut header = vec![0; LENGTH_2 + 4];
    let mut put = |at: usize, bytes: &[u8]| header[at..at + bytes.len()].copy_from_slice(bytes);
    put(0, &(LENGTH_2 as i32).to_le_bytes());
    put(4, b"n+2\0\r\n\x1A\n");
    put(12, &code.to_le_bytes());
    put(14, &bits.to_le_bytes());
    put(168, &((LENGTH_2 + 4) as i64).to_le_bytes());
    put(176, &1f64.to_le_bytes());
    for (axis, size) in axes(grid).into_iter().enumerate() {
        put(16 + 8 * axis, &(size as i64).to_le_bytes());
    }
    for (axis, spacing) in spacings(grid).into_iter().enumerate() {
        put(104 + 8 * axis, &spacing.to_le_bytes());
    }
    header
}

/// The `dim` field: the number of axes, then their sizes.
fn axes(grid: &Grid) -> [usize; 8] {
    let [x, y, z] = grid.dims();
    [3, x, y, z, 1, 1, 1, 1]
}

/// The `pixdim` field: the handedness of the qform, then the spacings.
fn spacings(grid: &Grid) -> [f64; 8] {
    let [x, y, z] = grid.spacing();
    [1.0, x, y, z, 1.0, 1.0, 1.0, 1.0]
}

/// The code of a type and its bits.
fn code(dtype: Dtype) -> Option<(i16, i16)> {
    let code = match dtype {
        Dtype::U8 => 2,
        Dtype::I8 => 256,
        Dtype::U16 => 512,
        Dtype::I16 => 4,
        Dtype::U32 => 768,
        Dtype::I32 => 8,
        Dtype::U64 => 1280,
        Dtype::I64 => 1024,
        Dtype::F16 => return None,
        Dtype::F32 => 16,
        Dtype::F64 => 64,
    };
    Some((code, 8 * dtype.size() as i16))
}
