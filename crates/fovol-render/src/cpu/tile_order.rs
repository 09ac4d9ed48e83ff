//! Order of the pixels of a full frame's tiles.

/// Edge of the tiles that full frames are marched in, in pixels.
pub const TILE: u32 = 32;

/// The pixels of a tile in blocks of 4x4: rays of one packet have much the same way.
pub const TILE_ORDER: [[u32; 2]; (TILE * TILE) as usize] = {
    let mut order = [[0; 2]; (TILE * TILE) as usize];
    let mut i = 0;
    while i < TILE * TILE {
        let block = [i / 16 % (TILE / 4), i / 16 / (TILE / 4)];
        order[i as usize] = [4 * block[0] + i % 4, 4 * block[1] + i / 4 % 4];
        i += 1;
    }
    order
};
