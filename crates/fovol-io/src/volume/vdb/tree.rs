//! A tree of nodes: first the shape of all of it, then the values of all leaves.

use super::cursor::Cursor;
use super::kind::{Kind, Store};
use super::values::{Arrays, Packing, Problem};
use crate::volume::active_box::{ActiveBox, Bounds, is_on, on_bits};
use std::collections::HashSet;

/// A tree without the values of its leaves.
#[derive(Debug)]
pub struct Tree<'a> {
    arrays: Arrays<'a>,
    /// The box of all active voxels.
    pub bounds: Bounds,
    tiles: Vec<Tile>,
    leaves: Vec<[i64; 3]>,
}

/// A cube of one value.
#[derive(Debug)]
struct Tile {
    origin: [i64; 3],
    side: i64,
    value: Vec<u8>,
}

/// Places of the cubes in a root, which never overlap.
struct Places {
    side: i64,
    taken: HashSet<[i64; 3]>,
}

impl Places {
    /// The place at `cursor`; none if it is taken or lies across others.
    fn next(&mut self, cursor: &mut Cursor<'_>) -> Option<[i64; 3]> {
        let origin = cursor.voxel()?;
        let is_aligned = origin.iter().all(|index| index.rem_euclid(self.side) == 0);
        (is_aligned && self.taken.insert(origin)).then_some(origin)
    }
}

impl<'a> Tree<'a> {
    /// Reads the shape of the tree at `cursor`.
    ///
    /// # Errors
    /// Damage, codecs that are not read.
    pub fn parse(kind: &'a Kind, packing: Packing, cursor: &mut Cursor<'_>) -> Result<Self, Problem> {
        let mut next = || {
            let _buffers = cursor.i32()?;
            let background = kind.stored(cursor.take(kind.full_size())?);
            Some((background, cursor.u32()?, cursor.u32()?))
        };
        let (background, tiles, children) = next().ok_or(Problem::Damaged)?;
        let arrays = Arrays { kind, packing, background };
        let mut tree = Self { arrays, bounds: Bounds::default(), tiles: Vec::new(), leaves: Vec::new() };
        let side = 1 << kind.levels.iter().sum::<u32>();
        let mut places = Places { side, taken: HashSet::new() };
        for _ in 0..tiles {
            let origin = places.next(cursor).ok_or(Problem::Damaged)?;
            tree.root_tile(cursor, origin, side).ok_or(Problem::Damaged)?;
        }
        for _ in 0..children {
            let origin = places.next(cursor).ok_or(Problem::Damaged)?;
            tree.node(cursor, origin, &kind.levels)?;
        }
        Ok(tree)
    }

    fn root_tile(&mut self, cursor: &mut Cursor<'_>, origin: [i64; 3], side: i64) -> Option<()> {
        let value = self.arrays.kind.stored(cursor.take(self.arrays.kind.full_size())?);
        let is_active = cursor.u8()? != 0;
        self.tile(origin, side, &value, is_active);
        Some(())
    }

    fn tile(&mut self, origin: [i64; 3], side: i64, value: &[u8], is_active: bool) {
        if is_active {
            self.bounds.add_tile(origin, side);
        }
        if value != self.arrays.background {
            self.tiles.push(Tile { origin, side, value: value.to_vec() });
        }
    }

    /// Reads the node at `cursor` and all below it. `levels` are those from the node on.
    fn node(&mut self, cursor: &mut Cursor<'_>, origin: [i64; 3], levels: &[u32]) -> Result<(), Problem> {
        let [level, below @ ..] = levels else { return Err(Problem::Damaged) };
        let count = 1usize << (3 * level);
        let mut mask = || cursor.take(count / 8).ok_or(Problem::Damaged);
        let first = mask()?;
        if below.is_empty() {
            self.bounds.add_leaf(origin, 1 << level, first);
            self.leaves.push(origin);
            return Ok(());
        }
        let (children, active) = (first, mask()?);
        let values = self.arrays.read(cursor, count, active)?;
        let side = 1 << below.iter().sum::<u32>();
        let place = |index: usize| {
            let [x, y, z] =
                [index >> (2 * level), index >> level, index].map(|part| (part & ((1 << level) - 1)) as i64);
            [origin[0] + side * x, origin[1] + side * y, origin[2] + side * z]
        };
        for (index, value) in values.chunks_exact(self.arrays.kind.size()).enumerate() {
            let is_active = is_on(active, index);
            if !is_on(children, index) && (is_active || value != self.arrays.background) {
                self.tile(place(index), side, value, is_active);
            }
        }
        on_bits(children).try_for_each(|index| self.node(cursor, place(index), below))
    }

    /// The value of everything that is not stored.
    pub fn background(&self) -> &[u8] {
        &self.arrays.background
    }

    /// Reads the values of all leaves at `cursor`, and sets them and the tiles in `filled`, if it is given.
    ///
    /// # Errors
    /// Damage, codecs that are not read.
    pub fn values(&self, cursor: &mut Cursor<'_>, mut filled: Option<&mut ActiveBox>) -> Result<(), Problem> {
        if let Some(filled) = &mut filled {
            self.tiles.iter().for_each(|tile| filled.fill(tile.origin, tile.side, &tile.value));
        }
        let level = *self.arrays.kind.levels.last().ok_or(Problem::Damaged)?;
        let count = 1usize << (3 * level);
        for &origin in &self.leaves {
            fovol_core::stop::point();
            let active = cursor.take(count / 8).ok_or(Problem::Damaged)?;
            let values = self.leaf(cursor, count, active)?;
            if let Some(filled) = &mut filled {
                filled.set(origin, 1 << level, &values);
            }
        }
        Ok(())
    }

    fn leaf(&self, cursor: &mut Cursor<'_>, count: usize, active: &[u8]) -> Result<Vec<u8>, Problem> {
        let bits = match self.arrays.kind.store {
            Store::Plain | Store::Half => return self.arrays.read(cursor, count, active),
            // The place of the leaf stands between both.
            Store::Bits => cursor.voxel().and_then(|_| cursor.take(count / 8)),
            Store::States => cursor.voxel().map(|_| active),
        };
        let bits = bits.ok_or(Problem::Damaged)?;
        Ok((0..count).map(|index| u8::from(is_on(bits, index))).collect())
    }
}
