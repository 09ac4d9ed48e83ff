//! NIfTI out: one file, compressed where its name ends in `.gz`.

use super::header::{LENGTH_1, LENGTH_2};
use crate::volume::detached::Beside;
use crate::volume::voxels::Voxels;
use crate::{Error, Result, atomic};
use fovol_core::{Dtype, Placement, Space, Volume};
use glam::{DMat3, DQuat, DVec3};
use std::io::{self, Write};
use std::path::Path;

/// Writes `volume` to `path`: NIfTI-1, or NIfTI-2 where the numbers of NIfTI-1 are too small.
///
/// # Errors
/// Half-precision voxels, which NIfTI lacks; errors of the operating system.
pub fn write(volume: &Volume, path: &Path, _: Beside) -> Result<()> {
    // Scaled halves are numbers of single precision.
    let voxels = if volume.dtype() == Dtype::F16 { Voxels::of(volume) } else { Voxels::stored(volume) };
    let numbers = Numbers::of(volume, &voxels, path)?;
    let header = if numbers.fit_one() { numbers.header_1() } else { numbers.header_2() };
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

/// The intent of labels.
const LABELS: i16 = 1002;

/// The code of coordinates of a scanner.
const SCANNER: i16 = 1;

/// The numbers of a header.
struct Numbers {
    dims: [usize; 3],
    /// The handedness of the qform, then the spacings.
    pixdim: [f64; 8],
    code: i16,
    bits: i16,
    intent: i16,
    units: u8,
    /// Slope and intercept of the values.
    scaling: [f64; 2],
    /// The codes of qform and sform.
    codes: [i16; 2],
    /// b, c, d of the qform, and the place of the first voxel, in RAS.
    qform: [f64; 6],
    /// The rows of the sform.
    sform: [f64; 12],
}

impl Numbers {
    fn of(volume: &Volume, voxels: &Voxels<'_>, path: &Path) -> Result<Self> {
        let (code, bits) = code(voxels.dtype())
            .ok_or_else(|| Error::unsupported(path, "NIfTI has no half precision; write .raw instead"))?;
        let [x, y, z] = volume.grid().spacing();
        let rescale = voxels.scaling();
        let mut numbers = Self {
            dims: volume.grid().dims(),
            pixdim: [1.0, x, y, z, 1.0, 1.0, 1.0, 1.0],
            code,
            bits,
            intent: if volume.contents().are_labels { LABELS } else { 0 },
            units: volume.units().map_or(0, units_code),
            scaling: [rescale.slope, rescale.intercept],
            codes: [0; 2],
            qform: [0.0; 6],
            sform: [0.0; 12],
        };
        if let Some(placement) = volume.placement().filter(|placement| placement.space() == Space::Patient) {
            numbers.place(placement);
        }
        Ok(numbers)
    }

    /// Takes over the place of the grid, from LPS to RAS.
    fn place(&mut self, placement: &Placement) {
        let ras = DVec3::new(-1.0, -1.0, 1.0);
        let axes = placement.directions();
        let [x, y, z] = [axes.x_axis, axes.y_axis, axes.z_axis].map(|axis| axis * ras);
        let origin = placement.origin() * ras;
        self.codes[1] = SCANNER;
        for row in 0..3 {
            let entries = [x * self.pixdim[1], y * self.pixdim[2], z * self.pixdim[3], origin];
            for (column, vector) in entries.into_iter().enumerate() {
                self.sform[4 * row + column] = vector[row];
            }
        }
        // A quaternion holds right angles alone.
        if placement.shear() < MOST_SHEAR {
            let is_mirrored = DMat3::from_cols(x, y, z).determinant() < 0.0;
            self.pixdim[0] = if is_mirrored { -1.0 } else { 1.0 };
            let turn = DQuat::from_mat3(&DMat3::from_cols(x, y, z * self.pixdim[0])).normalize();
            let turn = if turn.w < 0.0 { -turn } else { turn };
            self.codes[0] = SCANNER;
            self.qform = [turn.x, turn.y, turn.z, origin.x, origin.y, origin.z];
        }
    }

    /// Whether NIfTI-1, with sizes of 16 bits and numbers of single precision, holds them.
    fn fit_one(&self) -> bool {
        self.dims.iter().all(|&dim| i16::try_from(dim).is_ok())
            && self.pixdim[1..4].iter().all(|&spacing| (spacing as f32).is_normal())
            && self.scaling.iter().all(|&number| f64::from(number as f32) == number)
    }

    /// The `dim` field: the number of axes, then their sizes.
    fn axes(&self) -> [usize; 8] {
        let [x, y, z] = self.dims;
        [3, x, y, z, 1, 1, 1, 1]
    }

    fn header_1(&self) -> Vec<u8> {
        let mut header = Header(vec![0; LENGTH_1 + 4]);
        header.put(0, (LENGTH_1 as i32).to_le_bytes());
        header.put(68, self.intent.to_le_bytes());
        header.put(70, self.code.to_le_bytes());
        header.put(72, self.bits.to_le_bytes());
        header.put(108, ((LENGTH_1 + 4) as f32).to_le_bytes());
        for (axis, size) in self.axes().into_iter().enumerate() {
            header.put(40 + 2 * axis, (size as i16).to_le_bytes());
        }
        header.put_singles(76, &self.pixdim);
        header.put_singles(112, &self.scaling);
        header.put(123, [self.units]);
        header.put(252, self.codes[0].to_le_bytes());
        header.put(254, self.codes[1].to_le_bytes());
        header.put_singles(256, &self.qform);
        header.put_singles(280, &self.sform);
        header.put(344, *b"n+1\0");
        header.0
    }

    fn header_2(&self) -> Vec<u8> {
        let mut header = Header(vec![0; LENGTH_2 + 4]);
        header.put(0, (LENGTH_2 as i32).to_le_bytes());
        header.put(4, *b"n+2\0\r\n\x1A\n");
        header.put(12, self.code.to_le_bytes());
        header.put(14, self.bits.to_le_bytes());
        for (axis, size) in self.axes().into_iter().enumerate() {
            header.put(16 + 8 * axis, (size as i64).to_le_bytes());
        }
        header.put_doubles(104, &self.pixdim);
        header.put(168, ((LENGTH_2 + 4) as i64).to_le_bytes());
        header.put_doubles(176, &self.scaling);
        header.put(344, i32::from(self.codes[0]).to_le_bytes());
        header.put(348, i32::from(self.codes[1]).to_le_bytes());
        header.put_doubles(352, &self.qform);
        header.put_doubles(400, &self.sform);
        header.put(500, i32::from(self.units).to_le_bytes());
        header.put(504, i32::from(self.intent).to_le_bytes());
        header.0
    }
}

/// Degrees by which axes may differ from right angles in a qform.
const MOST_SHEAR: f64 = 1e-3;

/// The bytes of a header.
struct Header(Vec<u8>);

impl Header {
    fn put<const N: usize>(&mut self, at: usize, bytes: [u8; N]) {
        self.0[at..at + N].copy_from_slice(&bytes);
    }

    fn put_singles(&mut self, at: usize, numbers: &[f64]) {
        for (i, &number) in numbers.iter().enumerate() {
            self.put(at + 4 * i, (number as f32).to_le_bytes());
        }
    }

    fn put_doubles(&mut self, at: usize, numbers: &[f64]) {
        for (i, &number) in numbers.iter().enumerate() {
            self.put(at + 8 * i, number.to_le_bytes());
        }
    }
}

/// The code of a unit of length; 0 for those that NIfTI does not have.
pub fn units_code(symbol: &str) -> u8 {
    match symbol {
        "m" => 1,
        "mm" => 2,
        "µm" => 3,
        _ => 0,
    }
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
