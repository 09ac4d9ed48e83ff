//! Voxels on their way out: the first component, scaled, little-endian.

use super::reals;
use fovol_core::{Dtype, Endian, Rescale, Volume, stop};
use std::io::{self, Write};

/// This many voxels are held in memory while they are turned.
const CHUNK: usize = 1 << 16;

/// The voxels of a volume as files have them.
pub struct Voxels<'a> {
    volume: &'a Volume,
    dtype: Dtype,
    rescale: Rescale,
}

impl<'a> Voxels<'a> {
    /// The voxels of `volume`. Scaled ones become floats: f32 where it holds every value exactly, else f64.
    pub fn of(volume: &'a Volume) -> Self {
        let dtype = match volume.rescale() == Rescale::IDENTITY {
            true => volume.dtype(),
            false if fits_f32(volume) => Dtype::F32,
            false => Dtype::F64,
        };
        Self { volume, dtype, rescale: volume.rescale() }
    }

    /// The voxels of `volume` as they are stored, for formats that hold the scaling.
    pub fn stored(volume: &'a Volume) -> Self {
        Self { volume, dtype: volume.dtype(), rescale: Rescale::IDENTITY }
    }

    /// The scaling that turns what is written into values.
    pub fn scaling(&self) -> Rescale {
        if self.rescale == self.volume.rescale() { Rescale::IDENTITY } else { self.volume.rescale() }
    }

    /// The type that is written.
    pub fn dtype(&self) -> Dtype {
        self.dtype
    }

    /// Writes all voxels, x fastest.
    ///
    /// # Errors
    /// Errors of `out`.
    pub fn write_to(&self, out: &mut dyn Write) -> io::Result<()> {
        if self.rescale != Rescale::IDENTITY {
            return self.write_scaled(out);
        }
        let size = self.dtype.size();
        let is_turned = self.volume.endian() == Endian::Big && size > 1;
        if self.volume.components() == 1 && !is_turned {
            return self.volume.data().chunks(CHUNK * size).try_for_each(|chunk| {
                stop::point();
                out.write_all(chunk)
            });
        }
        let stride = self.volume.components() * size;
        let mut buffer = Vec::with_capacity(CHUNK * size);
        for chunk in self.volume.data().chunks(CHUNK * stride) {
            stop::point();
            buffer.clear();
            for voxel in chunk.chunks_exact(stride) {
                match is_turned {
                    true => buffer.extend(voxel[..size].iter().rev()),
                    false => buffer.extend_from_slice(&voxel[..size]),
                }
            }
            out.write_all(&buffer)?;
        }
        Ok(())
    }

    fn write_scaled(&self, out: &mut dyn Write) -> io::Result<()> {
        let voxels = self.volume.grid().voxels();
        let mut buffer = Vec::with_capacity(CHUNK * self.dtype.size());
        for start in (0..voxels).step_by(CHUNK) {
            stop::point();
            buffer.clear();
            for_each_scaled(self.volume, start..voxels.min(start + CHUNK), |value| match self.dtype {
                Dtype::F32 => buffer.extend((value as f32).to_le_bytes()),
                _ => buffer.extend(value.to_le_bytes()),
            });
            out.write_all(&buffer)?;
        }
        Ok(())
    }
}

/// Whether every scaled value is an f32.
fn fits_f32(volume: &Volume) -> bool {
    let mut fits = true;
    for_each_scaled(volume, 0..volume.grid().voxels(), |value| {
        fits &= f64::from(value as f32) == value || value.is_nan();
    });
    fits
}

/// Calls `visit` with the scaled first component of each of `voxels`.
fn for_each_scaled(volume: &Volume, voxels: std::ops::Range<usize>, mut visit: impl FnMut(f64)) {
    let (components, dtype, rescale) = (volume.components(), volume.dtype(), volume.rescale());
    let stride = components * dtype.size();
    let bytes = &volume.data()[voxels.start * stride..voxels.end * stride];
    let mut component = 0;
    reals::for_each(bytes, dtype, volume.endian(), |raw| {
        if component == 0 {
            visit(rescale.apply(raw));
        }
        component = if component + 1 == components { 0 } else { component + 1 };
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use fovol_core::Grid;
    use std::sync::Arc;

    fn written(volume: &Volume) -> (Dtype, Vec<u8>) {
        let voxels = Voxels::of(volume);
        let mut out = Vec::new();
        voxels.write_to(&mut out).unwrap();
        (voxels.dtype(), out)
    }

    #[test]
    fn the_first_component_is_turned() {
        let grid = Grid::new([2, 1, 1], [1.0; 3]).unwrap();
        let bytes = Arc::new(vec![1u8, 2, 9, 9, 3, 4, 9, 9]);
        let volume = Volume::with_layout(grid, Dtype::U16, Endian::Big, 2, bytes, 0).unwrap();
        assert_eq!(written(&volume), (Dtype::U16, vec![2, 1, 4, 3]));
    }

    #[test]
    fn scaled_values_become_the_smallest_float_that_holds_them() {
        let grid = Grid::new([2, 1, 1], [1.0; 3]).unwrap();
        let volume = Volume::from_values(grid, vec![1i16, -2]).unwrap();
        let half = volume.clone().with_rescale(Rescale { slope: 0.5, intercept: 1.0 }).unwrap();
        let expected = [1.5f32, 0.0].iter().flat_map(|value| value.to_le_bytes()).collect();
        assert_eq!(written(&half), (Dtype::F32, expected));
        let tenth = volume.with_rescale(Rescale { slope: 0.1, intercept: 0.0 }).unwrap();
        assert_eq!(written(&tenth).0, Dtype::F64);
    }
}
