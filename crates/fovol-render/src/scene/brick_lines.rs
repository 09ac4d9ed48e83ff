use super::brick_layout::BRICK;
use super::bricks::{BrickData, Bricks};

impl Bricks {
    /// Writes the stored values of a line of voxels, each times `factor`, to `line`. The line begins at `voxel` and runs along
    /// `axis`; NaN stays NaN.
    ///
    /// # Panics
    /// If `line` is longer than the grid.
    pub(crate) fn put_line(&self, voxel: [usize; 3], axis: usize, factor: f32, line: &mut [f32]) {
        let layout = self.layout();
        assert!(voxel[axis] + line.len() <= layout.dims[axis], "the line ends with the grid");
        let unit = layout.unit[axis];
        let (mut voxel, mut rest) = (voxel, line);
        while !rest.is_empty() {
            let length = rest.len().min(BRICK - voxel[axis] % BRICK);
            let (part, after) = rest.split_at_mut(length);
            let first = layout.index(voxel);
            match self.data() {
                BrickData::Corners(words) => {
                    put(words, (first, unit), part, |word| factor * (word & 0xFF) as f32);
                }
                BrickData::U8(values) => put(values, (first, unit), part, |value| factor * f32::from(value)),
                BrickData::U16(values) => put(values, (first, unit), part, |value| factor * f32::from(value)),
                BrickData::F32(values) => put(values, (first, unit), part, |value| factor * value),
                BrickData::Gaps(values) => put(values, (first, unit), part, |value| factor * value.0),
            }
            voxel[axis] += length;
            rest = after;
        }
    }
}

/// Writes every `unit`-th of `values`, from the first on, to `line`.
#[inline(always)]
fn put<T: Copy>(values: &[T], (first, unit): (usize, usize), line: &mut [f32], number: impl Fn(T) -> f32) {
    // Most lines are as long as a brick: a loop of known length becomes vectors.
    if let (1, Ok(whole)) = (unit, <&mut [f32; BRICK]>::try_from(&mut *line)) {
        let values = &values[first..first + BRICK];
        for i in 0..BRICK {
            whole[i] = number(values[i]);
        }
        return;
    }
    let values = &values[first..=first + (line.len() - 1) * unit];
    for (to, value) in line.iter_mut().zip(values.iter().step_by(unit)) {
        *to = number(*value);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fovol_core::{Grid, Volume};

    #[test]
    fn lines_have_the_voxels_of_the_grid() {
        let grid = Grid::new([19, 10, 17], [1.0; 3]).unwrap();
        let number = |i: usize| (i * 37 % 251) as u16;
        let small: Vec<u8> = (0..grid.voxels()).map(|i| number(i) as u8).collect();
        let wide: Vec<u16> = (0..grid.voxels()).map(|i| number(i) * 9).collect();
        let real: Vec<f32> = (0..grid.voxels()).map(|i| f32::from(number(i)) * 0.37).collect();
        let volumes = [
            Volume::from_values(grid, small).unwrap(),
            Volume::from_values(grid, wide).unwrap(),
            Volume::from_values(grid, real).unwrap(),
        ];
        for volume in volumes {
            let bricks = Bricks::of_volume(&volume).unwrap();
            for axis in 0..3 {
                for (begin, length) in [(0, grid.dims()[axis]), (3, 6), (9, 1)] {
                    let mut voxel = [4, 7, 13];
                    voxel[axis] = begin;
                    let mut line = vec![0.0; length];
                    bricks.put_line(voxel, axis, bricks.scale(), &mut line);
                    for (i, found) in line.into_iter().enumerate() {
                        let mut at = voxel;
                        at[axis] += i;
                        assert_eq!(found, bricks.voxel(at), "{axis} {at:?}");
                    }
                }
            }
        }
    }
}
