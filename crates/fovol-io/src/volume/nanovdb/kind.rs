//! The type of a grid, and where the numbers of its nodes are. All nodes begin at multiples of 32 bytes.

use fovol_core::Dtype;

/// How the voxels of a leaf are stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Store {
    /// Unchanged.
    Plain,
    /// A bit for each voxel.
    Bits,
    /// Nothing but the active state of each voxel.
    States,
    /// Steps of so many bits between the least and the greatest value of the leaf.
    Steps(u32),
    /// Steps of a number of bits that each leaf has of its own.
    StepsOfLeaf,
}

/// The type of a grid.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Kind {
    /// The type of one component.
    pub dtype: Dtype,
    /// Values per voxel.
    pub components: usize,
    /// How voxels are stored.
    pub store: Store,
    /// Whether the components are red, green, blue and opacity.
    pub is_colour: bool,
    /// Bytes of an average of values.
    average: usize,
}

impl Kind {
    /// The type with this number.
    ///
    /// # Errors
    /// Types that are not read, as a remark that follows the grid's name.
    pub fn of(number: u32) -> Result<Self, String> {
        let plain = |dtype: Dtype, components| {
            let average = if dtype.size() == 8 { 8 } else { 4 };
            Self { dtype, components, store: Store::Plain, is_colour: false, average }
        };
        let packed = |store| Self { store, ..plain(Dtype::F32, 1) };
        let bits = |store| Self { store, average: 1, ..plain(Dtype::U8, 1) };
        Ok(match number {
            1 => plain(Dtype::F32, 1),
            2 => plain(Dtype::F64, 1),
            3 => plain(Dtype::I16, 1),
            4 => plain(Dtype::I32, 1),
            5 => plain(Dtype::I64, 1),
            6 => plain(Dtype::F32, 3),
            7 => plain(Dtype::F64, 3),
            8 => bits(Store::States),
            10 => plain(Dtype::U32, 1),
            11 => bits(Store::Bits),
            12 => Self { is_colour: true, ..plain(Dtype::U8, 4) },
            13 => packed(Store::Steps(4)),
            14 => packed(Store::Steps(8)),
            15 => packed(Store::Steps(16)),
            16 => packed(Store::StepsOfLeaf),
            17 => plain(Dtype::F32, 4),
            18 => plain(Dtype::F64, 4),
            19..=22 => {
                return Err("holds indices into values outside of it; write it as a float grid".into());
            }
            23 => return Err("holds points, not voxels; rasterize them to a float grid".into()),
            _ => {
                return Err(format!(
                    "has the type number {number}, which is not read; write it as a float grid"
                ));
            }
        })
    }

    /// Bytes of a value.
    pub fn size(self) -> usize {
        self.dtype.size() * self.components
    }

    /// A multiple of this is the place of every value.
    fn alignment(self) -> usize {
        // Colours are numbers of 32 bits to NanoVDB.
        if self.is_colour { 4 } else { self.dtype.size() }
    }

    /// Where statistics of values that begin at `at` end: two values, their average and deviation.
    fn after_statistics(self, at: usize) -> usize {
        let extremes = at.next_multiple_of(self.alignment()) + 2 * self.size();
        (extremes.next_multiple_of(self.average) + 2 * self.average).next_multiple_of(32)
    }

    /// Where the background of a root is, and where its table begins.
    pub fn root(self) -> [usize; 2] {
        let background = 28usize.next_multiple_of(self.alignment());
        [background, self.after_statistics(background + self.size())]
    }

    /// Where the value of an entry of a root's table is, and how long the entry is.
    pub fn root_tile(self) -> [usize; 2] {
        let value = 20usize.next_multiple_of(self.alignment());
        [value, (value + self.size()).next_multiple_of(32)]
    }

    /// Where the table of a node of `count` children begins, behind a box, flags and two masks; how long an entry is.
    pub fn table(self, count: usize) -> [usize; 2] {
        [self.after_statistics(32 + 2 * count / 8), self.size().max(8).next_multiple_of(8)]
    }

    /// Where the values of a leaf begin.
    pub fn leaf(self) -> usize {
        match self.store {
            Store::Plain => self.after_statistics(LEAF_MASK + 64),
            Store::Bits => LEAF_MASK + 64,
            Store::States => LEAF_MASK,
            Store::Steps(_) | Store::StepsOfLeaf => 96,
        }
    }
}

/// Where the active states of a leaf are.
pub const LEAF_MASK: usize = 16;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_those_of_the_structs() {
        let float = Kind::of(1).unwrap();
        assert_eq!((float.root(), float.root_tile(), float.leaf()), ([28, 64], [20, 32], 96));
        assert_eq!(float.table(1 << 15), [32 + 8192 + 32, 8]);
        let bits = Kind::of(11).unwrap();
        assert_eq!((bits.root(), bits.leaf(), bits.table(1 << 12)), ([28, 64], 80, [32 + 1024 + 32, 8]));
        let double = Kind::of(2).unwrap();
        assert_eq!((double.root(), double.root_tile(), double.leaf()), ([32, 96], [24, 32], 128));
        assert!(Kind::of(19).unwrap_err().contains("; ") && Kind::of(99).unwrap_err().contains("; "));
    }
}
