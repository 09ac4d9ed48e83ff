use crate::memory::{self, Shortage};
use crate::volume::bytes::Plain;
use crate::{Error, Grid, Result, Volume, Voxel, stop, with_voxel_type};
use bytemuck::Zeroable;
use rayon::prelude::*;

impl Volume {
    /// Downsamples the volume: `factor`³ voxels are averaged to one, and the displayed range stays. A factor of 2
    /// needs an eighth of the memory.
    ///
    /// Blocks at the far ends may be smaller. Non-finite values are left out of averages, and remain where a block
    /// has nothing else. 64-bit integers are averaged as f64.
    ///
    /// # Errors
    /// [`Error::Extent`] for a factor of 0; no memory for the averages.
    pub fn downsampled(&self, factor: usize) -> Result<Self> {
        if factor == 0 {
            return Err(Error::Extent {
                what: "factor of downsampling".into(),
                found: "0".into(),
                expected: "1 or more".into(),
            });
        }
        if factor == 1 {
            return Ok(self.clone());
        }
        let spacing = self.grid().spacing().map(|side| side * factor as f64);
        let grid = Grid::new(self.grid().dims().map(|dim| dim.div_ceil(factor)), spacing)?;
        let made =
            with_voxel_type!(self.dtype(), T => Self::from_values(grid, self.averages::<T>(&grid, factor)?))?;
        Ok(self.dressed(made))
    }

    fn averages<T: Voxel + Plain + Zeroable>(
        &self,
        grid: &Grid,
        factor: usize,
    ) -> std::result::Result<Vec<T>, Shortage> {
        let [nx, ny, _] = grid.dims();
        let mut averages =
            memory::zeroed::<T>(grid.voxels(), "the smaller volume", "a larger --downsample needs less")?;
        averages.par_chunks_mut(nx * ny).enumerate().for_each(|(z, slice)| {
            stop::point();
            let mut sums = vec![Sum::default(); nx * ny];
            self.add_slices(z * factor..(z + 1) * factor, factor, nx, &mut sums);
            for (average, sum) in slice.iter_mut().zip(&sums) {
                *average = T::from_f64(sum.mean());
            }
        });
        Ok(averages)
    }

    /// Adds the voxels of the slices `along_z` to the `sums` of their blocks, in rows of `width`.
    fn add_slices(&self, along_z: std::ops::Range<usize>, factor: usize, width: usize, sums: &mut [Sum]) {
        let [nx, ny, nz] = self.grid().dims();
        for z in along_z.start..along_z.end.min(nz) {
            for y in 0..ny {
                let row = &mut sums[y / factor * width..][..width];
                let first = (z * ny + y) * nx;
                let mut x = 0;
                with_voxel_type!(self.dtype(), T => self.for_each_raw(first..=first + nx - 1, |value: T| {
                    row[x / factor].add(value.to_f64());
                    x += 1;
                }));
            }
        }
    }
}

/// Sum and number of the finite values of a block.
#[derive(Debug, Clone, Copy, Default)]
struct Sum {
    sum: f64,
    finite: u32,
}

impl Sum {
    fn add(&mut self, value: f64) {
        if value.is_finite() {
            self.sum += value;
            self.finite += 1;
        }
    }

    fn mean(&self) -> f64 {
        if self.finite > 0 { self.sum / f64::from(self.finite) } else { f64::NAN }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn blocks_are_averaged_and_rounded() {
        let grid = Grid::new([3, 2, 2], [1.0, 2.0, 3.0]).unwrap();
        let volume = Volume::from_values(grid, vec![0u8, 1, 10, 2, 3, 11, 4, 5, 12, 6, 8, 13]).unwrap();
        let half = volume.downsampled(2).unwrap();
        assert_eq!((half.grid().dims(), half.grid().spacing()), ([2, 1, 1], [2.0, 4.0, 6.0]));
        // 29 / 8 and 46 / 4, rounded.
        assert_eq!(half.data(), [4, 12]);
        assert_eq!(half.range(), [0.0, 255.0]);
        assert_eq!(volume.downsampled(1).unwrap().data(), volume.data());
        assert_eq!(volume.downsampled(100).unwrap().grid().dims(), [1; 3]);
        assert!(volume.downsampled(0).unwrap_err().to_string().contains("1 or more"));
    }

    #[test]
    fn what_is_not_finite_does_not_count_and_the_range_stays() {
        let grid = Grid::new([4, 1, 1], [1.0; 3]).unwrap();
        let volume = Volume::from_values(grid, vec![1.0f32, f32::NAN, f32::NAN, f32::INFINITY]).unwrap();
        let volume = volume.with_range([-1.0, 7.0]).unwrap().downsampled(2).unwrap();
        assert_eq!(volume.value([0, 0, 0]), 1.0);
        assert!(volume.value([1, 0, 0]).is_nan());
        assert_eq!(volume.range(), [-1.0, 7.0]);
        let grid = Grid::new([2, 2, 1], [1.0; 3]).unwrap();
        let volume = Volume::from_values(grid, vec![0i16, 100, -300, 40]).unwrap();
        assert_eq!(volume.downsampled(2).unwrap().range(), [-300.0, 100.0]);
    }

    proptest! {
        #[test]
        fn the_mean_stays(values in prop::collection::vec(-1000i32..1000, 64), factor in 1usize..=4) {
            prop_assume!(4 % factor == 0);
            let grid = Grid::new([4; 3], [1.0; 3]).unwrap();
            let values: Vec<f64> = values.into_iter().map(f64::from).collect();
            let mean = values.iter().sum::<f64>() / 64.0;
            let small = Volume::from_values(grid, values).unwrap().downsampled(factor).unwrap();
            let sides = small.grid().dims();
            let mut sum = 0.0;
            for i in 0..small.grid().voxels() {
                sum += small.value([i % sides[0], i / sides[0] % sides[1], i / sides[0] / sides[1]]);
            }
            prop_assert!((sum / small.grid().voxels() as f64 - mean).abs() < 1e-9);
        }
    }
}
