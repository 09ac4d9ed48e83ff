//! The box of the active voxels of a sparse tree, filled with the values of the tree.

use super::Source;
use super::affine::Affine;
use super::layout::{Layout, placed};
use crate::{Error, Result};
use fovol_core::memory::{self, Estimate};
use fovol_core::{Dtype, Space, Volume};
use glam::DVec3;
use std::sync::Arc;

/// Voxels of a box that each leaf or active tile in it justifies, and bytes that every box may have: leaves may lie far apart.
const VOXELS_PER_LEAF: u64 = 1 << 18;
const FREE_BYTES: u64 = 256 << 20;

/// A tile justifies its own voxels, but no more than these: it costs a bit in the file.
const MOST_VOXELS_PER_TILE: u64 = 1 << 21;

/// Advice for boxes that do not fit in memory.
const ADVICE: &str = "resample it to larger voxels or cut it, by -resample or -clip of vdb_tool or VDB Resample of Houdini for one";

/// The note on a level set.
pub const LEVEL_SET: &str =
    "is a level set: its values are distances to a surface, negative inside, so that the surface lies at 0";

/// First and last active voxel along each axis. Nothing is active at first.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Bounds {
    /// Voxels that a box may have for all that was added.
    justified: u64,
    /// The lowest indices.
    pub first: [i64; 3],
    /// The highest indices.
    pub last: [i64; 3],
}

impl Default for Bounds {
    fn default() -> Self {
        Self { justified: 0, first: [i64::MAX; 3], last: [i64::MIN; 3] }
    }
}

impl Bounds {
    /// Adds the active tile of `side` voxels that begins at `origin`.
    pub fn add_tile(&mut self, origin: [i64; 3], side: i64) {
        let voxels = side.unsigned_abs().saturating_pow(3);
        self.justify(voxels.clamp(VOXELS_PER_LEAF, MOST_VOXELS_PER_TILE));
        self.add(origin, side);
    }

    fn justify(&mut self, voxels: u64) {
        self.justified = self.justified.saturating_add(voxels);
    }

    /// Adds the cube of `side` voxels that begins at `origin`.
    fn add(&mut self, origin: [i64; 3], side: i64) {
        for axis in 0..3 {
            self.first[axis] = self.first[axis].min(origin[axis]);
            self.last[axis] = self.last[axis].max(origin[axis] + side - 1);
        }
    }

    /// Adds the voxels of `mask` that are on, in a leaf of `side` voxels at `origin`, z fastest.
    pub fn add_leaf(&mut self, origin: [i64; 3], side: i64, mask: &[u8]) {
        self.justify(VOXELS_PER_LEAF);
        for index in on_bits(mask) {
            let index = index as i64;
            let [x, y, z] = [index / (side * side), index / side % side, index % side];
            self.add([origin[0] + x, origin[1] + y, origin[2] + z], 1);
        }
    }

    fn dims(&self) -> Option<[usize; 3]> {
        let mut dims = [0; 3];
        for (axis, dim) in dims.iter_mut().enumerate() {
            let steps = self.last[axis].checked_sub(self.first[axis]).filter(|&steps| steps >= 0)?;
            *dim = usize::try_from(steps).ok()?.checked_add(1)?;
        }
        Some(dims)
    }
}

/// The indices of the bits of `mask` that are on, lowest first.
pub fn on_bits(mask: &[u8]) -> impl Iterator<Item = usize> {
    mask.iter()
        .enumerate()
        .filter(|(_, byte)| **byte != 0)
        .flat_map(|(at, &byte)| (0..8).filter(move |bit| byte >> bit & 1 == 1).map(move |bit| 8 * at + bit))
}

/// Whether the bit `index` of `mask` is on.
pub fn is_on(mask: &[u8], index: usize) -> bool {
    mask.get(index / 8).is_some_and(|byte| byte >> (index % 8) & 1 == 1)
}

/// A box of voxels, x fastest.
pub struct ActiveBox {
    first: [i64; 3],
    dims: [usize; 3],
    /// Bytes of one voxel.
    size: usize,
    bytes: Vec<u8>,
}

impl ActiveBox {
    /// The box `bounds` full of `background`, the bytes of one voxel.
    ///
    /// # Errors
    /// No active voxels, more bytes than so small a file can justify, too little memory.
    pub fn new(source: &Source, bounds: Bounds, background: &[u8]) -> Result<Self> {
        let dims = bounds.dims().ok_or_else(|| {
            source
                .malformed("its grid has no active voxels, so there is nothing to show; choose another grid")
        })?;
        let size = background.len();
        let length = dims.iter().try_fold(size, |length, &dim| length.checked_mul(dim));
        let justified = bounds.justified.saturating_mul(size as u64).saturating_add(FREE_BYTES);
        let length = length.filter(|&length| length as u64 <= justified).ok_or_else(|| {
            let [x, y, z] = dims;
            source.unsupported(format!(
                "the box of its active voxels is {x}x{y}x{z} large and almost empty; {ADVICE}"
            ))
        })?;
        let scarce = |shortage| Error::memory(source.path(), shortage);
        let work = "filling the box of its active voxels";
        Estimate::new(work).with("its voxels", length as u64).check(ADVICE).map_err(scarce)?;
        let mut bytes = memory::zeroed(length, work, ADVICE).map_err(scarce)?;
        if background.iter().any(|&byte| byte != 0) {
            bytes.chunks_exact_mut(size).for_each(|voxel| voxel.copy_from_slice(background));
        }
        Ok(Self { first: bounds.first, dims, size, bytes })
    }

    /// Sets all voxels of the cube of `side` voxels at `origin` to `value`, as far as they lie in the box.
    pub fn fill(&mut self, origin: [i64; 3], side: i64, value: &[u8]) {
        self.rows(origin, side, |_, row| {
            row.chunks_exact_mut(value.len()).for_each(|voxel| voxel.copy_from_slice(value));
        });
    }

    /// Sets the voxels of the cube of `side` voxels at `origin` to `values`, z fastest, as far as they lie in the box.
    pub fn set(&mut self, origin: [i64; 3], side: usize, values: &[u8]) {
        match self.size {
            1 => self.set_sized::<1>(origin, side, values),
            2 => self.set_sized::<2>(origin, side, values),
            4 => self.set_sized::<4>(origin, side, values),
            6 => self.set_sized::<6>(origin, side, values),
            8 => self.set_sized::<8>(origin, side, values),
            12 => self.set_sized::<12>(origin, side, values),
            16 => self.set_sized::<16>(origin, side, values),
            24 => self.set_sized::<24>(origin, side, values),
            _ => self.set_sized::<32>(origin, side, values),
        }
    }

    fn set_sized<const N: usize>(&mut self, origin: [i64; 3], side: usize, values: &[u8]) {
        let values = values.as_chunks::<N>().0;
        self.rows(origin, side as i64, |[x, y, z], row| {
            for (step, voxel) in row.as_chunks_mut::<N>().0.iter_mut().enumerate() {
                if let Some(value) = values.get(((x + step) * side + y) * side + z) {
                    *voxel = *value;
                }
            }
        });
    }

    /// Visits the rows along x of the cube of `side` voxels at `origin` that lie in the box: the place of their first voxel
    /// in the cube, and their bytes.
    fn rows(&mut self, origin: [i64; 3], side: i64, mut visit: impl FnMut([usize; 3], &mut [u8])) {
        let from = [0, 1, 2].map(|axis| (self.first[axis] - origin[axis]).max(0));
        let to = [0, 1, 2].map(|axis| (self.first[axis] + self.dims[axis] as i64 - origin[axis]).min(side));
        if (0..3).any(|axis| from[axis] >= to[axis]) {
            return;
        }
        for z in from[2]..to[2] {
            for y in from[1]..to[1] {
                let at = [from[0], y, z];
                let [i, j, k] = [0, 1, 2].map(|axis| (origin[axis] + at[axis] - self.first[axis]) as usize);
                let start = ((k * self.dims[1] + j) * self.dims[0] + i) * self.size;
                let length = (to[0] - from[0]) as usize * self.size;
                visit(at.map(|part| part as usize), &mut self.bytes[start..start + length]);
            }
        }
    }

    /// The volume of `components` values of type `dtype` per voxel. `affine` leads from indices to the world.
    ///
    /// # Errors
    /// An affine map that spans no space.
    pub fn volume(self, source: &Source, dtype: Dtype, components: usize, affine: Affine) -> Result<Volume> {
        let [x, y, z] = self.first.map(|index| index as f64);
        let origin = affine.origin + affine.steps[0] * x + affine.steps[1] * y + affine.steps[2] * z;
        let affine = Affine { origin, ..affine };
        let layout = Layout { spacing: affine.spacing(), components, ..Layout::new(self.dims, dtype) };
        let volume = layout.volume(source, Arc::new(self.bytes), 0)?;
        let placement = affine.placement(source, Space::Other)?;
        Ok(placed(volume, Some(placement), None))
    }
}

/// The affine map whose steps are multiples `step` of the axes.
pub fn scaled(step: DVec3, origin: DVec3) -> Affine {
    Affine { steps: [DVec3::X * step.x, DVec3::Y * step.y, DVec3::Z * step.z], origin }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn source() -> Source {
        Source::from_bytes(Path::new("x.vdb"), vec![])
    }

    #[test]
    fn cubes_are_cut_at_the_box() {
        let mut bounds = Bounds::default();
        bounds.add([-1, 0, 0], 1);
        bounds.add([2, 1, 1], 1);
        let mut filled = ActiveBox::new(&source(), bounds, &[9]).unwrap();
        filled.fill([-8, -8, -8], 8, &[1]);
        // z is fastest in the cube, x in the box.
        filled.set([1, 0, 0], 2, &[10, 11, 12, 13, 14, 15, 16, 17]);
        filled.fill([100, 0, 0], 8, &[3]);
        assert_eq!(filled.bytes, [9, 9, 10, 14, 9, 9, 12, 16, 9, 9, 11, 15, 9, 9, 13, 17]);
    }

    #[test]
    fn masks_have_z_fastest() {
        let mut bounds = Bounds::default();
        bounds.add_leaf([8, 0, 0], 2, &[0b1000_0010]);
        assert_eq!((bounds.first, bounds.last), ([8, 0, 1], [9, 1, 1]));
    }

    #[test]
    fn empty_and_almost_empty_boxes_are_refused() {
        let empty = ActiveBox::new(&source(), Bounds::default(), &[0]).err().unwrap().to_string();
        assert!(empty.contains("no active voxels"), "{empty}");
        for last in [5000, i64::from(i32::MAX)] {
            let mut bounds = Bounds::default();
            bounds.add([0; 3], 1);
            bounds.add([last; 3], 1);
            let large = ActiveBox::new(&source(), bounds, &[0; 4]).err().unwrap().to_string();
            assert!(large.contains("resample"), "{large}");
        }
    }
}
