// Stream compaction: the sampled pixels of a mask, tile by tile, row by row within a tile. Pixels that are neighbours in
// the list are so neighbours in the frame, and their rays read the same voxels. cpu/compact.rs packs the same pixels in
// raster order; the host sorts lists that it reads back.
//
// Three passes without atomics: `count` the pixels of each block of words, `scan` the counts into places,
// and `pack` the pixels of each block from its place on (Blelloch 1990; Billeter, Olsson and Assarsson 2009).

@group(0) @binding(0) var<uniform> extent: Extent;
@group(0) @binding(1) var<storage, read> mask: array<u32>;
/// Pixels of each block; after `scan` the place of its first one in the list.
@group(0) @binding(2) var<storage, read_write> blocks: array<u32>;
@group(0) @binding(3) var<storage, read_write> list_length: ListLength;
/// Pixels, packed.
@group(0) @binding(4) var<storage, read_write> list: array<u32>;

/// The sparse frame, row by row, which is cleared for the samples.
@group(0) @binding(5) var<storage, read_write> frame: array<vec4f>;
@group(0) @binding(6) var<storage, read_write> frame_inverse_depths: array<f32>;

/// Rows of a tile. It is a word wide.
const TILE_ROWS: u32 = 32;

/// Number of words of whole tiles.
fn word_count() -> u32 {
    return words_per_row(extent) * ((extent.height + TILE_ROWS - 1u) / TILE_ROWS * TILE_ROWS);
}

/// Column and row of word `i`, counted tile by tile.
fn word_place(i: u32) -> vec2u {
    let tile = i / TILE_ROWS;
    return vec2u(tile % words_per_row(extent), tile / words_per_row(extent) * TILE_ROWS + i % TILE_ROWS);
}

/// Word `i`, counted tile by tile; 0 beyond the end of the mask.
fn word(i: u32) -> u32 {
    let place = word_place(i);
    if place.y < extent.height {
        return mask[place.y * words_per_row(extent) + place.x];
    }
    return 0u;
}

/// Counts the pixels of each block.
@compute @workgroup_size(BLOCK)
fn count(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) thread: u32) {
    let sum = inclusive_sum(thread, countOneBits(word(group.x * BLOCK + thread)));
    if thread == BLOCK - 1u {
        blocks[group.x] = sum;
    }
}

/// Turns the counts into places, by one workgroup.
@compute @workgroup_size(BLOCK)
fn scan(@builtin(local_invocation_index) thread: u32) {
    let block_count = (word_count() + BLOCK - 1u) / BLOCK;
    var before = 0u;
    for (var first = 0u; first < block_count; first += BLOCK) {
        let block = first + thread;
        var pixels = 0u;
        if block < block_count {
            pixels = blocks[block];
        }
        let sum = inclusive_sum(thread, pixels);
        if block < block_count {
            blocks[block] = before + sum - pixels;
        }
        before += sums[BLOCK - 1u];
        workgroupBarrier();
    }
    if thread == 0u {
        list_length = list_length_of(before);
    }
}

/// Clears the pixels of `block`.
fn clear(block: u32, thread: u32) {
    for (var i = thread; i < 32u * BLOCK; i += BLOCK) {
        let place = word_place(block * BLOCK + i / 32u);
        let pixel = vec2u(32u * place.x + i % 32u, place.y);
        if pixel.x < extent.width && pixel.y < extent.height {
            let at = pixel.y * extent.width + pixel.x;
            frame[at] = vec4f(0.0);
            frame_inverse_depths[at] = 0.0;
        }
    }
}

/// Writes the pixels of each block to the list, and clears them in the frame.
@compute @workgroup_size(BLOCK)
fn pack(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) thread: u32) {
    clear(group.x, thread);
    let i = group.x * BLOCK + thread;
    var bits = word(i);
    let pixels = countOneBits(bits);
    var place = blocks[group.x] + inclusive_sum(thread, pixels) - pixels;
    let at = word_place(i);
    while bits != 0u {
        list[place] = packed(vec2u(32u * at.x + firstTrailingBit(bits), at.y));
        place += 1u;
        bits &= bits - 1u;
    }
}
