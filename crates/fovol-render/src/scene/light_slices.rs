use super::{LightPath, SHADOW_START};

/// Slices of a grid in the order in which light passes them, and columns of light that cross them.
///
/// A column is a straight way along the light direction. It crosses the first slice at whole voxels, and moves by a constant
/// from slice to slice.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LightSlices {
    /// Axis across the slices, axis from row to row of a slice, and axis along a row.
    pub axes: [usize; 3],
    /// Voxels of the grid along x, y and z.
    dims: [usize; 3],
    /// Whether light comes to the last slice of the grid first.
    is_from_above: bool,
    /// Voxels by which columns move from a slice to the next, from row to row and along rows.
    shifts: [f64; 2],
    /// Primary steps from a slice to the next.
    pub steps: f64,
    near: f32,
}

/// Length of the first stretch of a shadow ray that begins on a slice, in ways from slice to slice. It ends halfway between the
/// first and the second slice on its way.
pub const FIRST_STRETCH: f64 = 1.5;

/// Primary step of the shadow rays that a sweep of light stands for, whatever step the scene has: what was swept serves every step.
pub const SWEEP_STEP: f64 = 0.5;

/// Where columns cross a slice: column c lies at voxel c + `whole` + `part`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Crossing {
    /// Whole voxels.
    pub whole: isize,
    /// The rest, 0…1.
    pub part: f32,
}

impl LightSlices {
    /// Slices of a grid of `dims` voxels for the light of `path`. They cross the axis along which light passes most voxels.
    pub fn new(dims: [usize; 3], path: &LightPath) -> Self {
        let deep = (0..3).fold(0, |a, b| if path.delta[b].abs() > path.delta[a].abs() { b } else { a });
        // Rows run along x where they can: voxels that follow each other in memory.
        let axes = [[0, 2, 1], [1, 2, 0], [2, 1, 0]][deep];
        let delta = path.delta.map(f64::from);
        let shifts = [axes[1], axes[2]].map(|axis| -delta[axis] / delta[deep].abs());
        let steps = 1.0 / delta[deep].abs();
        let near = (f64::from(SHADOW_START) / steps).clamp(0.5 * FIRST_STRETCH, 1.0) as f32;
        Self { axes, dims, is_from_above: delta[deep] > 0.0, shifts, steps, near }
    }

    /// These slices for primary steps of `factor` times the length.
    #[cfg(feature = "gpu")]
    #[must_use]
    pub fn with_longer_steps(self, factor: f64) -> Self {
        Self { steps: self.steps / factor, ..self }
    }

    /// Where the sample of the first stretch lies, as a part of the way to the slice before: where that of a shadow ray does, but
    /// not before the middle of the stretch.
    pub fn near(&self) -> f32 {
        self.near
    }

    /// Number of slices.
    pub fn count(&self) -> usize {
        self.dims[self.axes[0]]
    }

    /// Rows of a slice, and voxels of a row.
    pub fn size(&self) -> [usize; 2] {
        [self.dims[self.axes[1]], self.dims[self.axes[2]]]
    }

    /// Voxel along the first of [`Self::axes`] of slice `number`; 0 is the one that light comes to first. It also
    /// gives the number of the slice at a voxel.
    pub fn voxel(&self, number: usize) -> usize {
        if self.is_from_above { self.count() - 1 - number } else { number }
    }

    /// Where columns cross slice `number`, from row to row and along rows.
    pub fn crossings(&self, number: usize) -> [Crossing; 2] {
        self.shifts.map(|shift| {
            let moved = number as f64 * shift;
            let whole = moved.floor();
            Crossing { whole: whole as isize, part: (moved - whole) as f32 }
        })
    }

    /// First and last column that come within a voxel of any slice, from row to row and along rows.
    pub fn columns(&self) -> [[isize; 2]; 2] {
        let ends = [0, self.count().saturating_sub(1)].map(|number| self.crossings(number));
        [0, 1].map(|side| {
            let [a, b] = [ends[0][side].whole, ends[1][side].whole];
            [-1 - a.max(b), self.size()[side] as isize - 1 - a.min(b)]
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fovol_core::{ClipBox, Grid, Light};
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn columns_follow_the_light_and_cross_every_slice_around_its_voxels(
            light in prop::array::uniform3(-1.0f64..1.0), dims in prop::array::uniform3(1usize..40),
        ) {
            prop_assume!(light.iter().any(|x| x.abs() > 0.01));
            let grid = Grid::new(dims, [1.0, 1.3, 0.8]).unwrap();
            let path = LightPath::new(&Light::towards(light.into()).unwrap(), &grid, &ClipBox::whole(&grid), 0.5);
            let slices = LightSlices::new(dims, &path);
            let [deep, down, along] = slices.axes;
            prop_assert_eq!(slices.voxel(0), if path.delta[deep] > 0.0 { dims[deep] - 1 } else { 0 });
            let columns = slices.columns();
            for number in 0..slices.count() {
                let crossings = slices.crossings(number);
                for (side, axis) in [(0, down), (1, along)] {
                    let moved = crossings[side].whole as f64 + f64::from(crossings[side].part);
                    let expected = -f64::from(path.delta[axis]) * slices.steps * number as f64;
                    prop_assert!((moved - expected).abs() < 1e-4, "{moved} {expected}");
                    let [first, last] = columns[side];
                    prop_assert!(first + crossings[side].whole <= -1);
                    prop_assert!(last + crossings[side].whole >= dims[axis] as isize - 1);
                }
            }
        }
    }
}
