//! The type of a tree: of its values and of its nodes.

use fovol_core::{Dtype, Endian, Voxel, f16};

/// How values of a tree are stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Store {
    /// Unchanged.
    Plain,
    /// Floats of 16 bits in arrays; single values outside of arrays are unchanged.
    Half,
    /// Voxels as bits, tiles as bytes.
    Bits,
    /// Voxels as their active states, tiles as bytes.
    States,
}

/// The type of a tree.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Kind {
    /// The type of one component in memory and in a plain file.
    pub dtype: Dtype,
    /// Values per voxel.
    pub components: usize,
    /// How they are stored.
    pub store: Store,
    /// The logarithm of the side of each node in its children, root's children first, leaves last.
    pub levels: Vec<u32>,
}

/// Sides of a node in its children that are read, as logarithms.
const SIDES: std::ops::RangeInclusive<u32> = 1..=6;

impl Kind {
    /// The type that is called `name`, such as `Tree_float_5_4_3_HalfFloat`.
    ///
    /// # Errors
    /// Types that are not read, as a remark that follows the grid's name.
    pub fn of(name: &str) -> Result<Self, String> {
        let (bare, is_half) = match name.strip_suffix("_HalfFloat") {
            Some(bare) => (bare, true),
            None => (name, false),
        };
        let unread = || format!("has the type {name}, which is not read; save it as a float grid");
        let mut words = bare.strip_prefix("Tree_").ok_or_else(unread)?.split('_');
        let (dtype, components) = match words.next().unwrap_or_default() {
            "float" => (Dtype::F32, 1),
            "double" => (Dtype::F64, 1),
            "half" => (Dtype::F16, 1),
            "int32" => (Dtype::I32, 1),
            "int64" => (Dtype::I64, 1),
            "uint32" => (Dtype::U32, 1),
            "bool" | "mask" => (Dtype::U8, 1),
            "vec3s" => (Dtype::F32, 3),
            "vec3d" => (Dtype::F64, 3),
            "vec3i" => (Dtype::I32, 3),
            "ptdataidx32" | "ptdataidx64" | "ptidx32" | "ptidx64" => {
                return Err("holds points, not voxels; rasterize them to a float grid, by vdb_tool or Houdini for one".into());
            }
            _ => return Err(unread()),
        };
        let store = match () {
            () if bare.starts_with("Tree_bool") => Store::Bits,
            () if bare.starts_with("Tree_mask") => Store::States,
            () if is_half && matches!(dtype, Dtype::F32 | Dtype::F64) => Store::Half,
            () => Store::Plain,
        };
        let levels: Vec<u32> = words.map_while(|word| word.parse().ok()).collect();
        let is_sound = (1..=4).contains(&levels.len())
            && levels.iter().all(|side| SIDES.contains(side))
            && levels.iter().sum::<u32>() <= 20;
        if is_sound { Ok(Self { dtype, components, store, levels }) } else { Err(unread()) }
    }

    /// The type of one component in the volume.
    pub fn shown_dtype(&self) -> Dtype {
        if self.store == Store::Half { Dtype::F16 } else { self.dtype }
    }

    /// Bytes of a value in the volume and in arrays of the file.
    pub fn size(&self) -> usize {
        self.shown_dtype().size() * self.components
    }

    /// Bytes of a value that stands alone in the file.
    pub fn full_size(&self) -> usize {
        self.dtype.size() * self.components
    }

    /// A value that stood alone in the file, as arrays have it.
    pub fn stored(&self, full: &[u8]) -> Vec<u8> {
        match (self.store, self.dtype) {
            (Store::Half, Dtype::F32) => halves::<f32>(full),
            (Store::Half, _) => halves::<f64>(full),
            _ => full.to_vec(),
        }
    }

    /// The opposite of `value`, as arrays have it: inside of a surface where `value` is outside.
    pub fn negated(&self, value: &[u8]) -> Vec<u8> {
        let dtype = self.shown_dtype();
        let mut negated = value.to_vec();
        for part in negated.chunks_exact_mut(dtype.size()) {
            match dtype {
                // The sign is the highest bit of the last byte.
                Dtype::F16 | Dtype::F32 | Dtype::F64 => part[dtype.size() - 1] ^= 0x80,
                Dtype::U8 => part.iter_mut().for_each(|byte| *byte = u8::from(*byte == 0)),
                _ => negate(part),
            }
        }
        negated
    }
}

/// Negates a little-endian integer: all bits turned, and one added.
fn negate(part: &mut [u8]) {
    let mut carry = true;
    for byte in part {
        (*byte, carry) = (!*byte).overflowing_add(u8::from(carry));
    }
}

fn halves<T: Voxel>(full: &[u8]) -> Vec<u8> {
    let values = full.chunks_exact(size_of::<T>());
    values.flat_map(|value| f16::from_f64(T::decode(value, Endian::Little).to_f64()).to_le_bytes()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn types_are_known_by_their_names() {
        let kind = Kind::of("Tree_vec3s_5_4_3_HalfFloat").unwrap();
        assert_eq!((kind.size(), kind.full_size(), kind.levels.as_slice()), (6, 12, &[5, 4, 3][..]));
        assert_eq!(Kind::of("Tree_bool_5_4_3").unwrap().store, Store::Bits);
        for name in ["Tree_ptdataidx32_5_4_3", "Tree_float", "Tree_float_9_9_9", "Tree_string_5_4_3", "float"]
        {
            assert!(Kind::of(name).unwrap_err().contains("; "), "{name}");
        }
    }

    #[test]
    fn opposites() {
        let kind = |name: &str| Kind::of(&format!("Tree_{name}_5_4_3")).unwrap();
        assert_eq!(kind("float").negated(&3f32.to_le_bytes()), (-3f32).to_le_bytes());
        assert_eq!(kind("int32").negated(&256i32.to_le_bytes()), (-256i32).to_le_bytes());
        assert_eq!(kind("int64").negated(&(-7i64).to_le_bytes()), 7i64.to_le_bytes());
        assert_eq!(kind("bool").negated(&[0]), [1]);
        assert_eq!(kind("float_5_4_3_HalfFloat").stored(&1.5f32.to_le_bytes()).len(), 4);
    }
}
