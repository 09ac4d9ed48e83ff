//! The nodes of a grid: a root, two levels of nodes in it, and leaves of 8³ voxels. Places are counted from their parents.

use super::file::{u32_at, u64_at};
use super::kind::{Kind, LEAF_MASK, Store};
use crate::volume::active_box::{ActiveBox, Bounds, is_on, on_bits};
use std::collections::HashSet;

/// Where the tree begins in a grid, and where it says how far its root is.
const TREE: usize = 672;
const ROOT: usize = TREE + 24;

/// The logarithm of the side of a node in its children: below the root, below that, and of a leaf.
const LEVELS: [u32; 3] = [5, 4, 3];

/// The cubes and leaves of a grid.
#[derive(Debug)]
pub struct Tree<'a> {
    bytes: &'a [u8],
    kind: Kind,
    /// The value of everything that is not stored.
    pub background: &'a [u8],
    /// The box of all active voxels.
    pub bounds: Bounds,
    tiles: Vec<Tile<'a>>,
    leaves: Vec<Leaf>,
    /// Bytes of nodes that may still come: a damaged grid may lead to one node by many ways.
    left: usize,
}

/// A cube of one value.
#[derive(Debug)]
struct Tile<'a> {
    origin: [i64; 3],
    side: i64,
    value: &'a [u8],
}

/// Where a leaf is, in space and in the bytes.
#[derive(Debug)]
struct Leaf {
    origin: [i64; 3],
    at: usize,
}

impl<'a> Tree<'a> {
    /// Reads all of the tree in the grid `bytes` but its leaves; none if it is damaged.
    pub fn parse(bytes: &'a [u8], kind: Kind) -> Option<Self> {
        let root = moved(TREE, u64_at(bytes, ROOT)?)?;
        let [background, table] = kind.root();
        let mut tree = Self {
            bytes,
            kind,
            background: bytes.get(root.checked_add(background)?..)?.get(..kind.size())?,
            bounds: Bounds::default(),
            tiles: Vec::new(),
            leaves: Vec::new(),
            left: bytes.len(),
        };
        let count = u32_at(bytes, root.checked_add(24)?)?;
        let [value, length] = kind.root_tile();
        // Cubes of a root never overlap.
        let mut taken = HashSet::new();
        for index in 0..count as usize {
            let entry = (root + table).checked_add(index.checked_mul(length)?)?;
            let origin = origin(u64_at(bytes, entry)?);
            if !taken.insert(origin) {
                return None;
            }
            match u64_at(bytes, entry + 8)? {
                0 => {
                    let is_active = u32_at(bytes, entry + 16)? != 0;
                    let value = bytes.get(entry + value..)?.get(..kind.size())?;
                    tree.tile(origin, 1 << 12, value, is_active);
                }
                child => tree.node(moved(root, child)?, origin, &LEVELS)?,
            }
        }
        Some(tree)
    }

    fn tile(&mut self, origin: [i64; 3], side: i64, value: &'a [u8], is_active: bool) {
        if is_active {
            self.bounds.add_tile(origin, side);
        }
        if value != self.background {
            self.tiles.push(Tile { origin, side, value });
        }
    }

    /// Reads the node at `at` and all below it. `levels` are those from the node on.
    fn node(&mut self, at: usize, origin: [i64; 3], levels: &[u32]) -> Option<()> {
        let [level, below @ ..] = levels else { return None };
        let bytes = self.bytes;
        if below.is_empty() {
            self.left = self.left.checked_sub(self.kind.leaf())?;
            let mask = bytes.get(at.checked_add(LEAF_MASK)?..)?.get(..64)?;
            self.bounds.add_leaf(origin, 8, mask);
            self.leaves.push(Leaf { origin, at });
            return Some(());
        }
        let count = 1usize << (3 * level);
        let masks = bytes.get(at.checked_add(32)?..)?.get(..2 * count / 8)?;
        let (active, children) = masks.split_at(count / 8);
        let [table, length] = self.kind.table(count);
        self.left = self.left.checked_sub(table + count * length)?;
        let entries = bytes.get(at.checked_add(table)?..)?.get(..count * length)?;
        let side = 1 << below.iter().sum::<u32>();
        let place = |index: usize| {
            let [x, y, z] =
                [index >> (2 * level), index >> level, index].map(|part| (part & ((1 << level) - 1)) as i64);
            [origin[0] + side * x, origin[1] + side * y, origin[2] + side * z]
        };
        for (index, entry) in entries.chunks_exact(length).enumerate() {
            if !is_on(children, index) {
                self.tile(place(index), side, &entry[..self.kind.size()], is_on(active, index));
            }
        }
        on_bits(children).try_for_each(|index| {
            let child = u64_at(entries, index * length)?;
            self.node(moved(at, child)?, place(index), below)
        })
    }

    /// Sets all values in `filled`; none if the tree is damaged.
    pub fn fill(&self, filled: &mut ActiveBox) -> Option<()> {
        self.tiles.iter().for_each(|tile| filled.fill(tile.origin, tile.side, tile.value));
        for leaf in &self.leaves {
            fovol_core::stop::point();
            let values = self.values(leaf.at)?;
            filled.set(leaf.origin, 8, &values);
        }
        Some(())
    }

    /// The 512 values of the leaf at `at`, z fastest.
    fn values(&self, at: usize) -> Option<Vec<u8>> {
        let leaf = self.bytes.get(at..)?;
        let values = leaf.get(self.kind.leaf()..)?;
        let bits = match self.kind.store {
            Store::Plain => return values.get(..512 * self.kind.size()).map(<[u8]>::to_vec),
            Store::Bits | Store::States => {
                let bits = values.get(..64)?;
                return Some((0..512).map(|index| u8::from(is_on(bits, index))).collect());
            }
            Store::Steps(bits) => bits,
            Store::StepsOfLeaf => 1u32 << (leaf[15] >> 5).min(4),
        };
        let [least, step] = [u32_at(leaf, 80)?, u32_at(leaf, 84)?].map(f32::from_bits);
        let codes = values.get(..64 * bits as usize)?;
        let value = |code: u16| (f32::from(code) * step + least).to_le_bytes();
        Some(match bits {
            16 => codes.as_chunks().0.iter().flat_map(|code| value(u16::from_le_bytes(*code))).collect(),
            _ => {
                let mask = (1u16 << bits) - 1;
                let of_byte =
                    |byte: u8| (0..8 / bits).map(move |part| u16::from(byte) >> (part * bits) & mask);
                codes.iter().flat_map(|&byte| of_byte(byte)).flat_map(value).collect()
            }
        })
    }
}

/// The place `offset` bytes from `at`, forwards or backwards.
fn moved(at: usize, offset: u64) -> Option<usize> {
    at.checked_add_signed(isize::try_from(offset as i64).ok()?)
}

/// The first voxel of the cube that a key of the root names: 21 bits for each axis, x highest, without the 12 lowest.
fn origin(key: u64) -> [i64; 3] {
    [42, 21, 0].map(|shift| i64::from(((key >> shift & 0x1F_FFFF) << 12) as u32 as i32))
}
