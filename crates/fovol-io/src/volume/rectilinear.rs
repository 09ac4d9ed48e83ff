//! Values at points whose distances differ from place to place, brought to equal distances.

use super::affine::Affine;
use super::layout::{Layout, placed};
use super::{Source, reals};
use crate::{Error, Result};
use fovol_core::memory::{self, Estimate, SMALLER_VOLUME};
use fovol_core::{Dtype, Space, Volume, stop};
use glam::DVec3;
use rayon::prelude::*;
use std::sync::Arc;

/// Distances that differ by less than this part of their mean are equal: coordinates are often rounded to 32 bits.
const ROUNDING: f64 = 1e-4;

/// Resampled axes have at most so many times as many points.
const MOST_POINTS: usize = 2;

/// Positions of values along one axis.
#[derive(Debug, Clone, PartialEq)]
struct Axis {
    first: f64,
    /// The distance to each value from the first, growing.
    along: Vec<f64>,
    /// 1 where positions grow, -1 where they fall.
    sign: f64,
    /// The distance to the next value where there is only one.
    alone: f64,
}

impl Axis {
    /// The axis of values at `points`, or in the middle between them for values of cells.
    fn of(points: &[f64], is_of_cells: bool) -> Option<Self> {
        let positions: Vec<f64> = match points {
            [a, .., b] if is_of_cells && a != b => {
                points.windows(2).map(|ends| (ends[0] + ends[1]) / 2.0).collect()
            }
            _ => points.to_vec(),
        };
        let (&first, &last) = (positions.first()?, positions.last()?);
        let sign = if last < first { -1.0 } else { 1.0 };
        let along: Vec<f64> = positions.iter().map(|position| (position - first) * sign).collect();
        let is_growing = along.windows(2).all(|ends| ends[1] > ends[0]);
        let width = match points {
            [a, b] if is_of_cells && a != b => (b - a).abs(),
            _ => 1.0,
        };
        (is_growing && along.iter().all(|position| position.is_finite())).then_some(Self {
            first,
            along,
            sign,
            alone: width,
        })
    }

    fn length(&self) -> f64 {
        self.along.last().copied().unwrap_or(0.0)
    }

    /// The mean distance between values.
    fn mean(&self) -> f64 {
        match self.along.len() {
            0 | 1 => self.alone,
            count => self.length() / (count - 1) as f64,
        }
    }

    fn is_even(&self) -> bool {
        let mean = self.mean();
        let expected = (0..self.along.len()).map(|index| index as f64 * mean);
        self.along
            .iter()
            .zip(expected)
            .all(|(position, expected)| (position - expected).abs() <= ROUNDING * mean)
    }

    /// The number of points that keep the smallest distance, as far as they are not too many.
    fn resampled(&self) -> usize {
        let smallest = self.along.windows(2).map(|ends| ends[1] - ends[0]).fold(f64::INFINITY, f64::min);
        let count = self.along.len();
        match self.is_even() {
            true => count,
            // The ratio is infinite where two points nearly coincide.
            false => {
                ((self.length() / smallest - 1e-3).ceil() as usize).saturating_add(1).min(MOST_POINTS * count)
            }
        }
    }

    /// For each of `count` points at equal distances, the value before it and the part of the way to the next.
    fn places(&self, count: usize) -> Vec<(usize, f64)> {
        let step = self.length() / (count.max(2) - 1) as f64;
        let mut before = 0;
        let place = |index: usize| {
            let position = index as f64 * step;
            while before + 2 < self.along.len() && self.along[before + 1] <= position {
                before += 1;
            }
            match self.along.get(before..before + 2) {
                Some([a, b]) => (before, ((position - a) / (b - a)).clamp(0.0, 1.0)),
                _ => (before, 0.0),
            }
        };
        (0..count).map(place).collect()
    }
}

/// Coordinates of a grid along its axes.
#[derive(Debug, Clone, PartialEq)]
pub struct Coordinates([Axis; 3]);

impl Coordinates {
    /// The coordinates of values at the points of a grid, or of its cells.
    ///
    /// # Errors
    /// Coordinates that neither grow nor fall, or other numbers of them than `points`.
    pub fn new(
        source: &Source,
        coordinates: &[Vec<f64>; 3],
        points: [usize; 3],
        is_of_cells: bool,
    ) -> Result<Self> {
        let axis = |index: usize| {
            let found = &coordinates[index];
            let axis = Axis::of(found, is_of_cells).filter(|_| found.len() == points[index]);
            axis.ok_or_else(|| {
                source.malformed(format!(
                    "its {} coordinates along {} are not {} numbers that grow or fall; write the file again",
                    found.len(),
                    ["x", "y", "z"][index],
                    points[index]
                ))
            })
        };
        Ok(Self([axis(0)?, axis(1)?, axis(2)?]))
    }

    /// Brings `volume`, the values at these coordinates, to equal distances and to its place.
    ///
    /// # Errors
    /// Too little memory.
    pub fn applied(&self, source: &Source, volume: Volume) -> Result<Volume> {
        let dims = [0, 1, 2].map(|axis| self.0[axis].resampled());
        let is_even = self.0.iter().all(Axis::is_even);
        let steps = [0, 1, 2].map(|axis| match (is_even, dims[axis]) {
            (false, count @ 2..) => self.0[axis].length() / (count - 1) as f64,
            _ => self.0[axis].mean(),
        });
        let volume = match is_even {
            true => volume.with_spacing(steps).map_err(|e| source.malformed(e.to_string()))?,
            false => self.resampled(source, &volume, dims, steps)?,
        };
        let [x, y, z] = [0, 1, 2].map(|axis| steps[axis] * self.0[axis].sign);
        let affine = Affine {
            steps: [DVec3::X * x, DVec3::Y * y, DVec3::Z * z],
            origin: DVec3::from_array([0, 1, 2].map(|axis| self.0[axis].first)),
        };
        let placement = affine.placement(source, Space::Other)?;
        Ok(placed(volume, Some(placement), None))
    }

    fn resampled(
        &self,
        source: &Source,
        volume: &Volume,
        dims: [usize; 3],
        spacing: [f64; 3],
    ) -> Result<Volume> {
        let dtype = match volume.dtype() {
            Dtype::U8 | Dtype::I8 | Dtype::U16 | Dtype::I16 | Dtype::F16 | Dtype::F32 => Dtype::F32,
            _ => Dtype::F64,
        };
        let layout = Layout { spacing, components: volume.components(), ..Layout::new(dims, dtype) };
        let length = layout.length(source)?;
        let scarce = |shortage| Error::memory(source.path(), shortage);
        let work = "resampling it to equal distances";
        Estimate::new(work).with("its voxels", length as u64).check(SMALLER_VOLUME).map_err(scarce)?;
        let mut out = memory::zeroed(length, work, SMALLER_VOLUME).map_err(scarce)?;
        self.interpolate(volume, dims, dtype, &mut out);
        let resampled = layout.volume(source, Arc::new(out), 0)?;
        let [x, y, z] = dims;
        Ok(resampled
            .with_format(volume.format().to_owned())
            .with_contents(volume.contents().clone())
            .with_notes_of(volume)
            .with_note(format!(
                "has points at unequal distances; it is resampled to {x}x{y}x{z} points at equal ones by linear interpolation"
            )))
    }

    /// Fills `out`, `dims` points of type `dtype` at equal distances, from the values of `volume`.
    fn interpolate(&self, volume: &Volume, dims: [usize; 3], dtype: Dtype, out: &mut [u8]) {
        let [along_x, along_y, along_z] = [0, 1, 2].map(|axis| self.0[axis].places(dims[axis]));
        let row = dims[0] * volume.components() * dtype.size();
        out.par_chunks_exact_mut((row * dims[1]).max(1)).zip(&along_z).for_each(|(slice, &(z, c))| {
            stop::point();
            for (row, &(y, b)) in slice.chunks_exact_mut(row).zip(&along_y) {
                let plane =
                    |z: usize| mixed(b, line(volume, &along_x, y, z), || line(volume, &along_x, y + 1, z));
                reals::encode(&mixed(c, plane(z), || plane(z + 1)), dtype, row);
            }
        });
    }
}

/// The values of a row of `volume`, interpolated at `places`.
fn line(volume: &Volume, places: &[(usize, f64)], y: usize, z: usize) -> Vec<f64> {
    let ([nx, ny, _], components) = (volume.grid().dims(), volume.components());
    let length = nx * components * volume.dtype().size();
    let row = &volume.data()[(z * ny + y) * length..][..length];
    let values = reals::decoded(row, volume.dtype(), volume.endian());
    let mut line = Vec::with_capacity(places.len() * components);
    for &(x, part) in places {
        for at in x * components..(x + 1) * components {
            let a = values[at];
            line.push(if part == 0.0 { a } else { a + part * (values[at + components] - a) });
        }
    }
    line
}

/// The values `part` of the way from `a` to `b`. Those of `b` may be NaN, or not exist, where they do not count.
fn mixed(part: f64, mut a: Vec<f64>, b: impl FnOnce() -> Vec<f64>) -> Vec<f64> {
    if part != 0.0 {
        a.iter_mut().zip(b()).for_each(|(a, b)| *a += part * (b - *a));
    }
    a
}

#[cfg(test)]
mod tests {
    use super::*;
    use fovol_core::Grid;
    use std::path::Path;

    fn applied(coordinates: [&[f64]; 3], is_of_cells: bool, values: Vec<u8>) -> Result<Volume> {
        let source = Source::from_bytes(Path::new("x.vtr"), vec![]);
        let points = coordinates.map(<[f64]>::len);
        let dims = if is_of_cells { points.map(|count| (count - 1).max(1)) } else { points };
        let volume = Volume::from_values(Grid::new(dims, [1.0; 3]).unwrap(), values).unwrap();
        Coordinates::new(&source, &coordinates.map(<[f64]>::to_vec), points, is_of_cells)?
            .applied(&source, volume)
    }

    #[test]
    fn equal_distances_are_kept_as_they_are() {
        let volume = applied([&[1.0, 1.5, 2.0], &[9.0, 8.0], &[4.0]], false, vec![1, 2, 3, 4, 5, 6]).unwrap();
        assert_eq!((volume.dtype(), volume.grid().spacing()), (Dtype::U8, [0.5, 1.0, 1.0]));
        let placement = volume.placement().unwrap();
        assert_eq!(placement.origin(), DVec3::new(1.0, 9.0, 4.0));
        assert_eq!(placement.directions().y_axis, DVec3::NEG_Y);
        let cells = applied([&[1.0, 3.0, 5.0], &[0.0, 4.0], &[2.0]], true, vec![7, 8]).unwrap();
        assert_eq!(cells.grid().spacing(), [2.0, 4.0, 1.0]);
        assert_eq!(cells.placement().unwrap().origin(), DVec3::new(2.0, 2.0, 2.0));
    }

    #[test]
    fn unequal_distances_are_resampled() {
        let volume = applied([&[0.0, 1.0, 3.0], &[0.0], &[0.0]], false, vec![0, 10, 30]).unwrap();
        assert_eq!((volume.grid().dims(), volume.dtype()), ([4, 1, 1], Dtype::F32));
        assert_eq!([0, 1, 2, 3].map(|x| volume.value([x, 0, 0])), [0.0, 10.0, 20.0, 30.0]);
        assert!(volume.notes().iter().any(|note| note.contains("resampled")));
    }

    #[test]
    fn points_may_nearly_coincide() {
        let volume = applied([&[0.0, 5e-324, 1.0], &[0.0], &[0.0]], false, vec![0, 10, 30]).unwrap();
        assert_eq!(volume.grid().dims(), [6, 1, 1]);
        assert!((volume.value([5, 0, 0]), volume.value([0, 0, 0])) == (30.0, 0.0));
    }

    #[test]
    fn coordinates_must_grow_or_fall() {
        for axis in
            [&[0.0, 1.0, 1.0][..], &[0.0, 2.0, 1.0], &[0.0, f64::NAN, 2.0], &[0.0, 1.0, f64::INFINITY]]
        {
            assert!(applied([axis, &[0.0], &[0.0]], false, vec![1; 3]).is_err(), "{axis:?}");
        }
    }
}
