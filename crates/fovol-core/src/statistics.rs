//! Statistics, histograms and distinct values of volumes.

use crate::found::Bins;
use crate::outliers::{self, Extremes};
use crate::{Endian, Rescale, Statistics, Volume, Voxel, stop, with_voxel_type};
use rayon::prelude::*;
use std::sync::PoisonError;

/// Voxels per parallel piece. A fixed size makes sums independent of the number of threads.
const PIECE: usize = 1 << 20;

#[derive(Clone, Copy)]
struct Partial {
    extremes: Extremes,
    sum: f64,
    finite: u64,
    nan: u64,
}

impl Partial {
    const NONE: Self = Self { extremes: Extremes::NONE, sum: 0.0, finite: 0, nan: 0 };
}

impl Statistics {
    fn of(volume: &Volume) -> Self {
        let partials = partials(volume);
        let voxels = volume.grid().voxels() as u64;
        let mut all = Partial::NONE;
        for p in partials {
            all.extremes.merge(&p.extremes);
            all.sum += p.sum;
            all.finite += p.finite;
            all.nan += p.nan;
        }
        let Some([min, max]) = all.extremes.ends() else {
            return Self {
                min: 0.0,
                max: 0.0,
                mean: 0.0,
                non_finite: voxels,
                nan: all.nan,
                shown: [0.0; 2],
                outliers: Vec::new(),
            };
        };
        let (shown, outliers) = outliers::split(volume, &all.extremes);
        let (mean, non_finite) = (all.sum / all.finite as f64, voxels - all.finite);
        Self { min, max, mean, non_finite, nan: all.nan, shown, outliers }
    }
}

impl Volume {
    /// Statistics of the values; computed once.
    pub fn statistics(&self) -> &Statistics {
        self.found.statistics.get_or_init(|| Statistics::of(self))
    }

    /// Histogram of the finite values in `bins` equal parts of `range` (scaled values). The last bin includes its
    /// upper end; values outside are not counted. The last histogram is remembered.
    pub fn histogram(&self, bins: usize, range: [f64; 2]) -> Vec<u64> {
        let [lo, hi] = range;
        let bins = Bins { count: bins, lo, hi };
        // Threads that count may take up other work, which may ask for a histogram: nothing is locked meanwhile.
        let last = || self.found.histogram.lock().unwrap_or_else(PoisonError::into_inner);
        let known = last().as_ref().filter(|(known, _)| *known == bins).map(|(_, counts)| counts.clone());
        known.unwrap_or_else(|| {
            let counts = histogram(self, bins);
            *last() = Some((bins, counts.clone()));
            counts
        })
    }

    /// The smallest value (scaled) above 0, if there is one; computed once.
    pub fn least_positive(&self) -> Option<f64> {
        *self.found.least_positive.get_or_init(|| {
            let mut least = f64::INFINITY;
            with_voxel_type!(self.dtype(), T => self.for_each_raw(0..=self.grid().voxels() - 1, |raw: T| {
                let value = self.rescale().apply(raw.to_f64());
                if value > 0.0 && value < least {
                    least = value;
                }
            }));
            least.is_finite().then_some(least)
        })
    }

    /// Different finite values (scaled), smallest first; `None` if there are more than `limit`.
    pub fn distinct_values(&self, limit: usize) -> Option<Vec<f64>> {
        with_voxel_type!(self.dtype(), T => distinct::<T>(self, limit))
    }
}

fn distinct<T: Voxel>(volume: &Volume, limit: usize) -> Option<Vec<f64>> {
    let stride = volume.components() * size_of::<T>();
    let mut found: Vec<f64> = Vec::new();
    let mut last = f64::NAN;
    for voxel in volume.data().chunks_exact(stride) {
        let value = volume.rescale().apply(T::decode(&voxel[..size_of::<T>()], volume.endian()).to_f64());
        if value == last || !value.is_finite() {
            continue;
        }
        last = value;
        if let Err(at) = found.binary_search_by(|known| known.total_cmp(&value)) {
            if found.len() == limit {
                return None;
            }
            found.insert(at, value);
        }
    }
    Some(found)
}

fn pieces(volume: &Volume) -> impl IndexedParallelIterator<Item = &[u8]> {
    volume.data().par_chunks(PIECE * volume.components() * volume.dtype().size())
}

/// Counts the voxels of one piece: bytes, distance between voxels in bytes, byte order and scaling.
///
/// Parallel loops call a function pointer, so that rayon's code is not compiled for every type of voxel.
type CountPiece = fn(&[u8], usize, Endian, Rescale) -> Partial;

fn partials(volume: &Volume) -> Vec<Partial> {
    let count = with_voxel_type!(volume.dtype(), T => partial_of_order::<T> as CountPiece);
    let (rescale, endian) = (volume.rescale(), volume.endian());
    let stride = volume.components() * volume.dtype().size();
    pieces(volume)
        .map(|bytes| {
            stop::point();
            count(bytes, stride, endian, rescale)
        })
        .collect()
}

/// [`partial`], compiled for each byte order.
fn partial_of_order<T: Voxel>(bytes: &[u8], stride: usize, endian: Endian, rescale: Rescale) -> Partial {
    match endian {
        Endian::Little => partial::<T>(bytes, stride, Endian::Little, rescale),
        Endian::Big => partial::<T>(bytes, stride, Endian::Big, rescale),
    }
}

#[inline]
fn partial<T: Voxel>(bytes: &[u8], stride: usize, endian: Endian, rescale: Rescale) -> Partial {
    let mut p = Partial::NONE;
    for voxel in bytes.chunks_exact(stride) {
        let value = rescale.apply(T::decode(&voxel[..size_of::<T>()], endian).to_f64());
        if value.is_finite() {
            p.extremes.add(value);
            p.sum += value;
            p.finite += 1;
        } else if value.is_nan() {
            p.nan += 1;
        }
    }
    p
}

fn histogram(volume: &Volume, bins: Bins) -> Vec<u64> {
    let count = with_voxel_type!(volume.dtype(), T => counts::<T> as fn(&Volume, &[u8], Bins) -> Vec<u64>);
    pieces(volume).map(|bytes| count(volume, bytes, bins)).reduce(
        || vec![0; bins.count],
        |mut a, b| {
            a.iter_mut().zip(b).for_each(|(a, b)| *a += b);
            a
        },
    )
}

/// Counts the values in `bytes`, a piece of `volume`, by bin.
fn counts<T: Voxel>(volume: &Volume, bytes: &[u8], Bins { count, lo, hi }: Bins) -> Vec<u64> {
    let (rescale, endian) = (volume.rescale(), volume.endian());
    let stride = volume.components() * size_of::<T>();
    let to_bin = if hi > lo { count as f64 / (hi - lo) } else { 0.0 };
    let mut counts = vec![0u64; count];
    for voxel in bytes.chunks_exact(stride) {
        let value = rescale.apply(T::decode(&voxel[..size_of::<T>()], endian).to_f64());
        if value >= lo && value <= hi && count > 0 {
            counts[(((value - lo) * to_bin) as usize).min(count - 1)] += 1;
        }
    }
    counts
}

#[cfg(test)]
mod tests {
    use crate::{Grid, Rescale, Volume};

    #[test]
    fn non_finite_values_are_counted_and_left_out() {
        let grid = Grid::new([4, 1, 1], [1.0; 3]).unwrap();
        let values = vec![1.0f32, f32::NAN, f32::NEG_INFINITY, 4.0];
        let s = Volume::from_values(grid, values).unwrap().statistics().clone();
        assert_eq!((s.min, s.max, s.mean, s.non_finite, s.nan), (1.0, 4.0, 2.5, 2, 1));
    }

    #[test]
    fn all_nan_is_zero_and_counted() {
        let grid = Grid::new([2, 1, 1], [1.0; 3]).unwrap();
        let s = Volume::from_values(grid, vec![f64::NAN; 2]).unwrap().statistics().clone();
        assert_eq!((s.min, s.max, s.mean, s.non_finite, s.nan), (0.0, 0.0, 0.0, 2, 2));
    }

    #[test]
    fn histogram_counts_everything_once() {
        let grid = Grid::new([16, 16, 1], [1.0; 3]).unwrap();
        let volume = Volume::from_values(grid, (0..=255u8).collect()).unwrap();
        assert_eq!(volume.histogram(4, [0.0, 255.0]), vec![64; 4]);
    }

    #[test]
    fn what_was_found_does_not_outlast_its_values() {
        let grid = Grid::new([4, 1, 1], [1.0; 3]).unwrap();
        let volume = Volume::from_values(grid, vec![-1i16, 0, 3, 9]).unwrap();
        for _ in 0..2 {
            assert_eq!(volume.histogram(2, [0.0, 10.0]), [2, 1]);
            assert_eq!(volume.histogram(1, [0.0, 10.0]), [3]);
            assert_eq!(volume.least_positive(), Some(3.0));
        }
        let turned = volume.with_rescale(Rescale { slope: -1.0, intercept: 0.0 }).unwrap();
        assert_eq!((turned.histogram(1, [0.0, 10.0]), turned.least_positive()), (vec![2], Some(1.0)));
        let none = Volume::from_values(grid, vec![0u8; 4]).unwrap();
        assert_eq!(none.least_positive(), None);
    }
}
