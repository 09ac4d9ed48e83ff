//! Pixels of a slice.

use super::orientation::{Lie, Way};
use eframe::egui::{Color32, ColorImage};
use fovolnet::core::{Volume, Voxel, with_voxel_type};

/// Slice of a grid.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Slice {
    /// How its picture lies in the grid.
    pub lie: Lie,
    /// Number of the slice along the grid's axis.
    pub number: usize,
    /// Every so many voxels are shown along each axis; 1 shows all.
    pub every: usize,
}

impl Slice {
    /// Width and height in pixels of a slice of a grid of `dims`.
    pub fn size(&self, dims: [usize; 3]) -> [usize; 2] {
        [self.lie.right, self.lie.down].map(|way| dims[way.axis].div_ceil(self.every))
    }

    /// Picture of `volume`, each voxel in the `colour` of its scaled value. No other voxels are read.
    pub fn picture(&self, volume: &Volume, colour: impl FnMut(f64) -> Color32) -> ColorImage {
        let size = self.size(volume.grid().dims());
        let pixels = with_voxel_type!(volume.dtype(), T => self.pixels::<T>(volume, colour));
        ColorImage::new(size, pixels)
    }

    fn pixels<T: Voxel>(&self, volume: &Volume, mut colour: impl FnMut(f64) -> Color32) -> Vec<Color32> {
        let dims = volume.grid().dims();
        let [width, height] = self.size(dims);
        let (first, [right, down]) = self.places(dims);
        let (data, endian, rescale) = (volume.data(), volume.endian(), volume.rescale());
        let voxel = volume.components() * volume.dtype().size();
        let mut pixels = vec![Color32::BLACK; width * height];
        // Neighbours in memory are read one after another.
        let by_rows = right.abs() <= down.abs();
        let ((count, step), (lines, next)) = match by_rows {
            true => ((width, right), (height, down)),
            false => ((height, down), (width, right)),
        };
        let mut raw = Vec::with_capacity(count);
        for line in 0..lines {
            // Reading a line alone, before any colour, keeps more reads of far memory under way.
            let start = first + line as isize * next;
            raw.clear();
            raw.extend((0..count as isize).map(|i| {
                let at = (start + i * step) as usize * voxel;
                T::decode(&data[at..at + size_of::<T>()], endian)
            }));
            for (i, raw) in raw.iter().enumerate() {
                let at = if by_rows { line * width + i } else { i * width + line };
                pixels[at] = colour(rescale.apply(raw.to_f64()));
            }
        }
        pixels
    }

    /// Place of the first pixel's voxel among all voxels, and the steps to the pixels on its right and below.
    fn places(&self, dims: [usize; 3]) -> (isize, [isize; 2]) {
        let strides = [1, dims[0], dims[0] * dims[1]];
        let mut first = self.number * strides[self.lie.across.axis];
        let mut step = |way: Way| {
            let stride = strides[way.axis];
            if way.rises {
                return (stride * self.every) as isize;
            }
            first += (dims[way.axis] - 1) * stride;
            -((stride * self.every) as isize)
        };
        let steps = [step(self.lie.right), step(self.lie.down)];
        (first as isize, steps)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ui::slices::orientation::Plane;
    use fovolnet::core::{Grid, Placement, Rescale, Space};
    use glam::{DMat3, DVec3};

    /// Every voxel of this volume has another value: x + 10 y + 100 z.
    fn volume() -> Volume {
        let values = (0..3 * 4 * 2u16).map(|i| i % 3 + 10 * (i / 3 % 4) + 100 * (i / 12)).collect();
        Volume::from_values(Grid::new([3, 4, 2], [1.0; 3]).unwrap(), values).unwrap()
    }

    /// Values of a slice, row by row.
    fn values(volume: &Volume, slice: Slice) -> Vec<f64> {
        let mut values = Vec::new();
        let mut order = Vec::new();
        let picture = slice.picture(volume, |value| {
            values.push(value);
            Color32::from_gray(values.len() as u8)
        });
        order.extend(picture.pixels.iter().map(|pixel| values[pixel.r() as usize - 1]));
        order
    }

    fn slice(plane: Plane, placement: Option<&Placement>, number: usize) -> Slice {
        Slice { lie: Lie::new(plane, placement), number, every: 1 }
    }

    #[test]
    fn the_patients_left_is_on_the_right_pixel_by_pixel() {
        let volume = volume();
        // x rises to the left, y to the back, z to the head: as stored, but for head and feet.
        let lps = Placement::new(DMat3::IDENTITY, DVec3::ZERO, Space::Patient).unwrap();
        assert_eq!(
            values(&volume, slice(Plane::Axial, Some(&lps), 1)),
            [100.0, 101.0, 102.0, 110.0, 111.0, 112.0, 120.0, 121.0, 122.0, 130.0, 131.0, 132.0]
        );
        assert_eq!(
            values(&volume, slice(Plane::Coronal, Some(&lps), 2)),
            [120.0, 121.0, 122.0, 20.0, 21.0, 22.0]
        );
        assert_eq!(
            values(&volume, slice(Plane::Sagittal, Some(&lps), 1)),
            [101.0, 111.0, 121.0, 131.0, 1.0, 11.0, 21.0, 31.0]
        );
        // x rises to the right hand and y to the face: both are turned.
        let axes = DMat3::from_cols(DVec3::NEG_X, DVec3::NEG_Y, DVec3::Z);
        let ras = Placement::new(axes, DVec3::ZERO, Space::Patient).unwrap();
        assert_eq!(
            values(&volume, slice(Plane::Axial, Some(&ras), 0)),
            [32.0, 31.0, 30.0, 22.0, 21.0, 20.0, 12.0, 11.0, 10.0, 2.0, 1.0, 0.0]
        );
        assert_eq!(
            values(&volume, slice(Plane::Sagittal, Some(&ras), 2)),
            [132.0, 122.0, 112.0, 102.0, 32.0, 22.0, 12.0, 2.0]
        );
    }

    #[test]
    fn grids_without_a_patient_rise_right_and_up() {
        let volume = volume();
        assert_eq!(
            values(&volume, slice(Plane::Axial, None, 0)),
            [30.0, 31.0, 32.0, 20.0, 21.0, 22.0, 10.0, 11.0, 12.0, 0.0, 1.0, 2.0]
        );
        assert_eq!(
            values(&volume, slice(Plane::Sagittal, None, 2)),
            [102.0, 112.0, 122.0, 132.0, 2.0, 12.0, 22.0, 32.0]
        );
    }

    #[test]
    fn values_are_scaled_and_large_slices_thinned_out() {
        let scaled = volume().with_rescale(Rescale { slope: 2.0, intercept: -5.0 }).unwrap();
        let thin = Slice { every: 2, ..slice(Plane::Axial, None, 1) };
        assert_eq!(thin.size([3, 4, 2]), [2, 2]);
        assert_eq!(values(&scaled, thin), [255.0, 259.0, 215.0, 219.0]);
    }
}
