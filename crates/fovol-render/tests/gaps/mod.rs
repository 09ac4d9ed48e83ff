//! A volume with NaN in it.

use crate::scenes::volumes;
use fovol_core::{Grid, Volume};

/// Floats with NaN strewn in, alone and in a block.
///
/// Sides are even: rays along the middle of an odd one would lie between cells with and without NaN.
pub fn volume() -> Volume {
    let (_, whole) = volumes().remove(2);
    let grid = Grid::new([44, 38, 50], [1.0; 3]).unwrap();
    let value = |i: usize| {
        let [x, y, z] = [i % 44, i / 44 % 38, i / (44 * 38)];
        let is_in_block = (20..30).contains(&x) && (18..26).contains(&y) && z > 27;
        if is_in_block || i.is_multiple_of(997) { f32::NAN } else { whole.value([x, y, z]) as f32 }
    };
    Volume::from_values(grid, (0..grid.voxels()).map(value).collect()).unwrap()
}
