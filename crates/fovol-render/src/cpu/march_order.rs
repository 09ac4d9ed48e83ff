//! In which order the pixels of a list are marched.

use crate::scene::RayResult;
use fovol_core::{Pixel, SampleList};

/// Edge of the tiles that a list is marched in, in pixels.
const TILE: u16 = 32;
/// Edge of the blocks of a tile, whose pixels follow each other.
const BLOCK: u16 = 8;
/// Blocks of a tile.
const BLOCKS: usize = ((TILE / BLOCK) * (TILE / BLOCK)) as usize;

/// The pixels of a list sorted by tile, and by block within a tile: rays that are marched in succession read the same
/// bricks, and those of a packet skip empty space together.
pub struct MarchOrder {
    pixels: Vec<Pixel>,
    /// For each of `pixels`, its index in the list.
    places: Vec<u32>,
}

impl MarchOrder {
    /// Sorts the pixels of `list` by tile and block.
    pub fn new(list: &SampleList) -> Self {
        let columns = list.size().width.div_ceil(TILE.into()) as usize;
        let rows = list.size().height.div_ceil(TILE.into()) as usize;
        let block = |pixel: &Pixel| {
            let tile = (pixel.y / TILE) as usize * columns + (pixel.x / TILE) as usize;
            let [x, y] = [pixel.x, pixel.y].map(|at| usize::from(at % TILE / BLOCK));
            // Blocks in the order of a Z, twice over.
            tile * BLOCKS + (x & 1 | (y & 1) << 1 | (x & 2) << 1 | (y & 2) << 2)
        };
        // A counting sort: where each block begins, then where its next pixel goes.
        let mut next = vec![0u32; columns * rows * BLOCKS + 1];
        list.pixels().iter().for_each(|pixel| next[block(pixel) + 1] += 1);
        (1..next.len()).for_each(|at| next[at] += next[at - 1]);
        let mut pixels = vec![Pixel { x: 0, y: 0 }; list.len()];
        let mut places = vec![0; list.len()];
        for (place, pixel) in list.pixels().iter().enumerate() {
            let to = &mut next[block(pixel)];
            (pixels[*to as usize], places[*to as usize]) = (*pixel, place as u32);
            *to += 1;
        }
        Self { pixels, places }
    }

    /// The pixels in the order in which they are marched.
    pub fn pixels(&self) -> &[Pixel] {
        &self.pixels
    }

    /// Returns `marched`, the results in the order of [`Self::pixels()`], in the order of the list.
    pub fn in_list_order<'a>(&self, marched: impl Iterator<Item = &'a RayResult>) -> Vec<RayResult> {
        let mut listed = vec![RayResult::nothing([0.0; 3]); self.places.len()];
        self.places.iter().zip(marched).for_each(|(&place, marched)| listed[place as usize] = *marched);
        listed
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fovol_core::FrameSize;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn tile_by_tile_and_back(w in 1u32..200, h in 1u32..100, at in prop::collection::vec(any::<[u16; 2]>(), 0..300)) {
            let place = |at: u16, side: u32| (u32::from(at) % side) as u16;
            let pixels = at.iter().map(|at| Pixel { x: place(at[0], w), y: place(at[1], h) }).collect();
            let list = SampleList::new(FrameSize::new(w, h).unwrap(), pixels);
            let order = MarchOrder::new(&list);
            let tiles: Vec<_> = order.pixels().iter().map(|pixel| (pixel.y / TILE, pixel.x / TILE)).collect();
            prop_assert!(tiles.is_sorted());
            let marched: Vec<RayResult> =
                order.pixels().iter().map(|pixel| RayResult::nothing([pixel.x.into(), pixel.y.into(), 0.0])).collect();
            for (pixel, marched) in list.pixels().iter().zip(order.in_list_order(marched.iter())) {
                prop_assert_eq!(marched.colour, [pixel.x.into(), pixel.y.into(), 0.0]);
            }
        }
    }
}
