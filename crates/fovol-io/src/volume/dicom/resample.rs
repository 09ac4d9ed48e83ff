//! Slices at any distance and slid against each other, resampled linearly to a regular grid.

use crate::volume::reals;
use fovol_core::{Dtype, Endian, stop};
use rayon::prelude::*;

/// Where the values of a regular grid come from.
pub struct Resampling {
    size: [usize; 2],
    /// For each slice of the result the lower of two slices, and the part of the way to the next.
    sources: Vec<(usize, f64)>,
    /// How far each slice is slid along x and y, in pixels.
    slides: Vec<[f64; 2]>,
    /// Columns and rows that are added before and behind.
    margins: [[usize; 2]; 2],
}

/// Voxels to resample.
pub struct Voxels<'a> {
    /// Little-endian components, x fastest.
    pub bytes: &'a [u8],
    /// The type of a component.
    pub dtype: Dtype,
    /// Components of a voxel.
    pub components: usize,
    /// The stored value where there is no slice.
    pub outside: f64,
}

impl Resampling {
    /// `count` slices from those that lie `at` places, in units of slices, each of them slid.
    pub fn new(size: [usize; 2], count: usize, at: &[f64], slides: Vec<[f64; 2]>) -> Self {
        let last = at.len().saturating_sub(1);
        let source = |slice: usize| {
            let wanted = slice as f64;
            let above = at.partition_point(|&place| place <= wanted + 1e-6).clamp(1, last.max(1));
            let lower = above - 1;
            let step = at.get(above).map_or(1.0, |next| next - at[lower]);
            let part = ((wanted - at[lower]) / step).clamp(0.0, 1.0);
            // Slices that are there stay what they are.
            let part = if part < 1e-3 {
                0.0
            } else if part > 0.999 {
                1.0
            } else {
                part
            };
            if part == 1.0 && above <= last { (above, 0.0) } else { (lower, part) }
        };
        let sources = (0..count).map(source).collect();
        let margin = |axis: usize| {
            let ends = slides.iter().map(|slide| slide[axis]);
            let (least, most) = ends.fold((0.0f64, 0.0f64), |(a, b), slide| (a.min(slide), b.max(slide)));
            [(-least).ceil() as usize, most.ceil() as usize]
        };
        Self { size, sources, margins: [margin(0), margin(1)], slides }
    }

    /// Columns and rows before those of the first slice.
    pub fn before(&self) -> [f64; 2] {
        self.margins.map(|[before, _]| before as f64)
    }

    /// Voxels of the result along x, y and z.
    pub fn dims(&self) -> [usize; 3] {
        let [[x0, x1], [y0, y1]] = self.margins;
        [self.size[0] + x0 + x1, self.size[1] + y0 + y1, self.sources.len()]
    }

    /// Fills `out`, of the size of the result, with what `voxels` are there.
    pub fn apply(&self, voxels: &Voxels<'_>, out: &mut [u8]) {
        let [nx, ny, _] = self.dims();
        let row = nx * voxels.components * voxels.dtype.size();
        out.par_chunks_mut(row * ny).zip(&self.sources).for_each(|(out, &(lower, part))| {
            stop::point();
            let below = self.slice(voxels, lower);
            let above = (part != 0.0).then(|| self.slice(voxels, lower + 1));
            let mut values = vec![0.0; nx * voxels.components];
            for (y, out) in out.chunks_exact_mut(row).enumerate() {
                for (i, value) in values.iter_mut().enumerate() {
                    let (x, component) = (i / voxels.components, i % voxels.components);
                    let below = below.sample([x, y], component);
                    *value = match &above {
                        None => below,
                        Some(above) => (1.0 - part) * below + part * above.sample([x, y], component),
                    };
                }
                reals::encode(&values, voxels.dtype, out);
            }
        });
    }

    fn slice<'a>(&'a self, voxels: &'a Voxels<'_>, slice: usize) -> Slice<'a> {
        let length = self.size[0] * self.size[1] * voxels.components * voxels.dtype.size();
        let bytes = &voxels.bytes[slice * length..][..length];
        Slice { resampling: self, slice, voxels, values: reals::decoded(bytes, voxels.dtype, Endian::Little) }
    }
}

/// A slice that is there.
struct Slice<'a> {
    resampling: &'a Resampling,
    slice: usize,
    voxels: &'a Voxels<'a>,
    values: Vec<f64>,
}

impl Slice<'_> {
    /// The value at a pixel of the result.
    fn sample(&self, pixel: [usize; 2], component: usize) -> f64 {
        let Resampling { margins, slides, .. } = self.resampling;
        let place: [f64; 2] = std::array::from_fn(|axis| {
            pixel[axis] as f64 - margins[axis][0] as f64 - slides[self.slice][axis]
        });
        let whole = place.map(f64::floor);
        let parts = [place[0] - whole[0], place[1] - whole[1]];
        let mut sum = 0.0;
        for corner in [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]] {
            let weight = |axis: usize| if corner[axis] == 1.0 { parts[axis] } else { 1.0 - parts[axis] };
            let weight = weight(0) * weight(1);
            if weight > 0.0 {
                sum += weight * self.stored([whole[0] + corner[0], whole[1] + corner[1]], component);
            }
        }
        sum
    }

    fn stored(&self, [x, y]: [f64; 2], component: usize) -> f64 {
        let [nx, ny] = self.resampling.size;
        if x < 0.0 || y < 0.0 || x >= nx as f64 || y >= ny as f64 {
            return self.voxels.outside;
        }
        self.values[(y as usize * nx + x as usize) * self.voxels.components + component]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn resampled(resampling: &Resampling, bytes: &[u8]) -> Vec<u8> {
        let mut out = vec![0; resampling.dims().iter().product()];
        let voxels = Voxels { bytes, dtype: Dtype::U8, components: 1, outside: 0.0 };
        resampling.apply(&voxels, &mut out);
        out
    }

    #[test]
    fn missing_slices_lie_between_their_neighbours() {
        let resampling = Resampling::new([1, 1], 4, &[0.0, 1.0, 3.0], vec![[0.0; 2]; 3]);
        assert_eq!(resampled(&resampling, &[10, 20, 40]), [10, 20, 30, 40]);
    }

    #[test]
    fn slid_slices_are_moved() {
        let resampling = Resampling::new([2, 1], 2, &[0.0, 1.0], vec![[0.0; 2], [1.0, 0.0]]);
        assert_eq!(resampling.dims(), [3, 1, 2]);
        assert_eq!(resampled(&resampling, &[1, 2, 3, 4]), [1, 2, 0, 0, 3, 4]);
        let back = Resampling::new([2, 1], 2, &[0.0, 1.0], vec![[0.0; 2], [-0.5, 0.0]]);
        assert_eq!((back.dims(), back.before()), ([3, 1, 2], [1.0, 0.0]));
        assert_eq!(resampled(&back, &[2, 4, 6, 8]), [0, 2, 4, 3, 7, 4]);
    }
}
