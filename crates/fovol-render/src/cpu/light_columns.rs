//! Which samples of a shadow ray could meet anything, known before the ray is traced.

use crate::scene::{LightPath, Macrocells, SHADOW_STEP};
use bytemuck::cast_slice;
use fovol_core::stop;
use fovol_simd::SimdF32;
use rayon::prelude::*;

/// Slabs that one word tells of.
pub const SLABS: u32 = u32::BITS;
/// Columns are widened until there are no more words than this.
const MOST_WORDS: usize = 4 << 20;
/// Margin around columns and slabs, as a fraction of their size.
///
/// It keeps every sample, despite rounding, inside the space that its bit was computed from.
const ROUNDING: f64 = 0.02;

/// Columns of space along the light direction, cut into slabs of one shadow step each.
///
/// One bit per slab of a column says whether it touches a visible macrocell. All shadow rays have one direction, so
/// each stays in one column. Consecutive samples of a ray lie in consecutive slabs. The words of its column, from the
/// slab of its first sample on, thus say which samples to take.
#[derive(Debug, Clone)]
pub struct LightColumns {
    axes: Axes,
    /// Columns along both lateral axes.
    columns: [usize; 2],
    /// One bit per slab, [`SLABS`] slabs per word: word w of a column lies at w · columns + column.
    words: Vec<u32>,
}

/// The sheared coordinates that columns and slabs are counted in.
#[derive(Debug, Clone, Copy)]
pub struct Axes {
    /// The axis along which light travels most voxels, and the two others.
    pub order: [usize; 3],
    /// Where the first slab starts on the first of them: the face turned away from the light, in
    /// voxels.
    pub origin: f32,
    /// Slabs per voxel, negative where light comes from below.
    pub slabs: f32,
    /// Voxels along the lateral axes per slab.
    pub shear: [f32; 2],
    /// Where the first columns start, in voxels.
    pub low: [f32; 2],
    /// Edge of a column in voxels.
    pub width: f32,
}

impl LightColumns {
    /// Makes the columns of a volume of `dims` voxels from the visible `cells`.
    ///
    /// They become invalid when the transfer function, the light or the step changes.
    pub fn new(cells: &Macrocells, dims: [usize; 3], light: &LightPath) -> Self {
        let a = (0..3).fold(0, |a, b| if light.delta[b].abs() > light.delta[a].abs() { b } else { a });
        let order = [a, (a + 1) % 3, (a + 2) % 3];
        let slabs = light.inverse[a] / SHADOW_STEP;
        let shear = [order[1], order[2]].map(|b| light.delta[b] * SHADOW_STEP);
        let origin = if slabs > 0.0 { -0.5 } else { dims[a] as f32 - 0.5 };
        let deep = (dims[a] as f32 * slabs.abs()).ceil() + 1.0;
        let low = shear.map(|s| -0.5 - (s * deep).max(0.0));
        let mut axes = Axes { order, origin, slabs, shear, low, width: (1u32 << cells.shift()) as f32 / 2.0 };
        let words = (deep as usize).div_ceil(SLABS as usize);
        let columns = loop {
            let columns = [0, 1]
                .map(|i| ((dims[order[i + 1]] as f32 + (shear[i] * deep).abs()) / axes.width) as usize + 1);
            if columns[0] * columns[1] * words <= MOST_WORDS {
                break columns;
            }
            axes.width *= 2.0;
        };
        let mut out = Self { axes, columns, words: vec![0; columns[0] * columns[1] * words] };
        let plane = columns[0] * columns[1];
        let mut bits = std::mem::take(&mut out.words);
        bits.par_chunks_mut(plane).enumerate().for_each(|(word, plane)| {
            stop::point();
            for bit in 0..SLABS {
                out.mark(cells, word as u32 * SLABS + bit, bit, plane);
            }
        });
        out.words = bits;
        out
    }

    /// The coordinates that columns and slabs are counted in.
    #[cfg(feature = "gpu")]
    pub fn axes(&self) -> Axes {
        self.axes
    }

    /// Columns along both lateral axes, and words of a column.
    #[cfg(feature = "gpu")]
    pub fn dims(&self) -> [usize; 3] {
        let [across, down] = self.columns;
        [across, down, self.words.len() / (across * down)]
    }

    /// All words: those of the first slabs of all columns first.
    #[cfg(feature = "gpu")]
    pub fn all_words(&self) -> &[u32] {
        &self.words
    }

    /// Sets `bit` in the words of all columns that meet anything in slab `slab`.
    fn mark(&self, cells: &Macrocells, slab: u32, bit: u32, plane: &mut [u32]) {
        let Axes { order, origin, slabs, shear, low, width } = self.axes;
        let counts = order.map(|axis| cells.cells()[axis]);
        let all = cells.cells();
        let pitch = order.map(|axis| [1, all[0], all[0] * all[1]][axis]);
        let cell = |p: f64, count: usize| ((p.max(0.0) as usize) >> cells.shift()).min(count - 1);
        let ends = [f64::from(slab) - ROUNDING, f64::from(slab) + 1.0 + ROUNDING];
        let depth = ends.map(|s| f64::from(origin) + s / f64::from(slabs));
        let layers = cell(depth[0].min(depth[1]), counts[0])..=cell(depth[0].max(depth[1]), counts[0]);
        // The cells that a column touches along one lateral axis; shear moves the column within the slab.
        let touched = |i: usize| -> Vec<[usize; 2]> {
            let moved = ends.map(|s| f64::from(low[i]) + s * f64::from(shear[i]));
            let [least, most] = [moved[0].min(moved[1]), moved[0].max(moved[1])];
            (0..self.columns[i])
                .map(|column| {
                    let from = least + (column as f64 - ROUNDING) * f64::from(width);
                    let to = most + (column as f64 + 1.0 + ROUNDING) * f64::from(width);
                    [cell(from, counts[i + 1]), cell(to, counts[i + 1])]
                })
                .collect()
        };
        let (across, down) = (touched(0), touched(1));
        // Reduced along one axis after the other: layers, then columns of the first axis, then of the second.
        let mut rows = vec![0u8; counts[2] * across.len()];
        let mut row = vec![0u8; counts[1]];
        for (c, out) in rows.chunks_mut(across.len()).enumerate() {
            row.fill(0);
            for layer in layers.clone() {
                let start = layer * pitch[0] + c * pitch[2];
                for (b, any) in row.iter_mut().enumerate() {
                    *any |= u8::from(cells.distances()[start + b * pitch[1]] == 0);
                }
            }
            for (any, &[from, to]) in out.iter_mut().zip(&across) {
                *any = row[from..=to].iter().fold(0, |any, &x| any | x);
            }
        }
        for (words, &[from, to]) in plane.chunks_mut(across.len()).zip(&down) {
            for c in from..=to {
                let row = &rows[c * across.len()..][..across.len()];
                for (word, &any) in words.iter_mut().zip(row) {
                    *word |= u32::from(any) << bit;
                }
            }
        }
    }

    /// The columns and the slabs (both as whole numbers) of the first shadow samples from points `p`.
    #[inline(always)]
    pub fn locate<V: SimdF32>(&self, p: [V; 3]) -> (V::I32, V::I32) {
        let Axes { order: [a, b, c], origin, slabs, shear, low, width } = self.axes;
        let zero = p[0].splat(0.0);
        // A point a rounding error outside the box is taken for one on its face.
        let depth = ((p[a] - zero.splat(origin)) * zero.splat(slabs)).max(zero);
        let column = |p: V, i: usize| {
            let entry = p - depth.mul_add(zero.splat(shear[i]), zero.splat(low[i]));
            let most = zero.splat((self.columns[i] - 1) as f32);
            (entry * zero.splat(1.0 / width)).max(zero).min(most).to_i32()
        };
        let at = column(p[c], 1) * zero.splat_i32(self.columns[0] as i32);
        (at + column(p[b], 0), (depth + zero.splat(0.5)).to_i32())
    }

    /// Words number `word` (whole numbers) of each `column` where `wanted`, else any: their lowest bits are for slabs
    /// `word` · [`SLABS`].
    ///
    /// # Safety
    /// Wanted columns and words must be those of rays inside the volume.
    #[inline(always)]
    pub unsafe fn words<V: SimdF32>(&self, wanted: V::Mask, column: V::I32, word: V) -> V::I32 {
        let zero = word.splat(0.0);
        let plane = zero.splat_i32((self.columns[0] * self.columns[1]) as i32);
        let index = word.to_i32() * plane + column;
        let index = V::select(wanted, V::from_bits(index), zero).to_bits();
        // SAFETY: the caller's for wanted words; the others are replaced by the first word.
        unsafe { V::gather_bytes::<4>(cast_slice(&self.words), index) }
    }

    /// Word `word` of `column`.
    #[cfg(test)]
    fn word(&self, column: usize, word: usize) -> u32 {
        self.words[word * self.columns[0] * self.columns[1] + column]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Bricks;
    use fovol_core::{ClipBox, ControlPoint, Grid, Light, RayMode, TransferFunction, Volume};
    use fovol_simd::{Arithmetic, Portable, SimdI32};
    use glam::DVec3;
    use proptest::prelude::*;

    /// Cells of a volume with a few bright voxels, and its grid.
    fn scattered(dims: [usize; 3], spacing: [f64; 3], bright: &[usize]) -> (Macrocells, Grid) {
        let grid = Grid::new(dims, spacing).unwrap();
        let mut values = vec![0u8; grid.voxels()];
        for &at in bright {
            values[at % grid.voxels()] = 255;
        }
        let volume = Volume::from_values(grid, values).unwrap();
        let mut cells = Macrocells::new(&Bricks::of_volume(&volume).unwrap()).unwrap();
        let point = |v, a| ControlPoint::new(v, [1.0; 3], a);
        let bright_only = vec![point(0.0, 0.0), point(0.5, 0.0), point(1.0, 1.0)];
        cells.classify(&TransferFunction::new(bright_only).unwrap(), RayMode::Composite);
        (cells, grid)
    }

    fn occupied(cells: &Macrocells, p: [f32; 3]) -> bool {
        let [nx, ny, _] = cells.cells();
        let cell: [usize; 3] =
            std::array::from_fn(|a| ((p[a].max(0.0) as usize) >> cells.shift()).min(cells.cells()[a] - 1));
        cells.distances()[(cell[2] * ny + cell[1]) * nx + cell[0]] == 0
    }

    /// Whether sample `j` of the shadow ray from `p` need be taken.
    fn may_meet(columns: &LightColumns, p: [f32; 3], j: u32) -> bool {
        let (column, first) = columns.locate(p.map(|x| Portable::zero().splat(x)));
        let [column, first] = [column, first].map(|integers| {
            let mut lanes = [0; Portable::N];
            integers.store(&mut lanes);
            lanes[0]
        });
        let slab = first as u32 + j;
        columns.word(column as usize, (slab / SLABS) as usize) >> (slab % SLABS) & 1 == 1
    }

    proptest! {
        #[test]
        fn no_sample_in_an_occupied_cell_is_left_out(
            dims in prop::array::uniform3(1usize..40),
            spacing in prop::array::uniform3(0.3f64..3.0),
            bright in prop::collection::vec(any::<usize>(), 1..4),
            direction in prop::array::uniform3(-1.0f64..1.0),
            parallel in prop::array::uniform3(any::<bool>()),
            step in 0.05f64..6.0,
            at in prop::array::uniform3(0.0f32..1.0),
        ) {
            let mut direction = DVec3::from_array(direction);
            (0..3).filter(|&a| parallel[a]).for_each(|a| direction[a] = 0.0);
            prop_assume!(direction.length() > 0.01);
            let (cells, grid) = scattered(dims, spacing, &bright);
            let light = LightPath::new(&Light::towards(direction).unwrap(), &grid, &ClipBox::whole(&grid), step);
            let columns = LightColumns::new(&cells, dims, &light);
            let p: [f32; 3] = std::array::from_fn(|a| at[a].mul_add(dims[a] as f32, -0.5));
            for j in 0..light.count(p) {
                let meets = occupied(&cells, light.position(p, j));
                prop_assert!(!meets || may_meet(&columns, p, j), "sample {j} of {p:?}");
            }
        }
    }

    #[test]
    fn most_of_empty_space_is_left_out() {
        let (cells, grid) = scattered([64; 3], [1.0; 3], &[(32 * 64 + 32) * 64 + 32]);
        let light = Light::towards(DVec3::new(0.5, 1.0, 0.3)).unwrap();
        let light = LightPath::new(&light, &grid, &ClipBox::whole(&grid), 0.5);
        let columns = LightColumns::new(&cells, [64; 3], &light);
        let points = (0..4096u32).map(|i| [i % 16, i / 16 % 16, i / 256].map(|x| x as f32 * 4.0));
        let (mut all, mut taken) = (0, 0);
        for p in points {
            let count = light.count(p);
            all += count;
            taken += (0..count).filter(|&j| may_meet(&columns, p, j)).count();
        }
        // The bright voxel is in 8 of 4,096 cells; columns widen them by about a cell on every side.
        assert!(taken > 0 && taken * 40 < all as usize, "{taken} of {all}");
    }

    #[test]
    fn fine_steps_widen_the_columns_rather_than_fill_memory() {
        let (cells, grid) = scattered([100, 90, 80], [1.0; 3], &[5]);
        let light = Light::towards(DVec3::new(0.5, 1.0, 0.3)).unwrap();
        let light = LightPath::new(&light, &grid, &ClipBox::whole(&grid), 0.0005);
        let columns = LightColumns::new(&cells, [100, 90, 80], &light);
        assert!(columns.words.len() <= MOST_WORDS && columns.axes.width > 2.0);
    }
}
