// Convolutions with cooperative matrices, which the threads of a subgroup multiply together. Twin of cpu/conv.
//
// A workgroup computes ROWS rows of 16 pixels of up to four matrices of channels. For EDGE input channels at a time
// it loads the inputs of its pixels (resized, concatenated, padded) into workgroup memory as f16.
//
// A subgroup handles two matrices of pixels, EDGE in a row each, and all channels of the workgroup. Its sums stay
// in registers. A matrix of weights has a row for each output and a column for each input. A matrix of pixels has a
// row for each input and a column for each pixel.

/// Number of matrices of channels of a workgroup, up to four.
override TILES: u32;
/// Number of rows of pixels of a workgroup.
override ROWS: u32;
override THREADS: u32;
/// Largest number of subgroups that the threads may form.
override SUBGROUPS: u32;

/// Blocks of four channels in a matrix.
const BLOCKS = EDGE / 4u;
/// Matrices of pixels in a row.
const ACROSS = COLUMNS / EDGE;
/// Distance between pixels of the patch. Eight elements of padding spread them over the banks of workgroup memory.
const PIXEL = EDGE + 8u;

override PATCH_WIDTH: u32 = (COLUMNS - 1u) * STRIDE + SIZE;
override PATCH: u32 = PATCH_WIDTH * ((ROWS - 1u) * STRIDE + SIZE);
/// Number of subgroups with work of their own; further ones repeat the work of others.
override SHARES: u32 = ACROSS * ROWS / 2u;

/// Packed weights, \[workgroup\]\[EDGE inputs\]\[tap\]\[matrix of outputs\]; a column for each input.
@group(0) @binding(6) var<storage, read> weights: array<f16>;

/// EDGE input channels of the pixels, with those of a pixel together.
var<workgroup> patch_pixels: array<f16, PATCH * PIXEL>;
/// For each subgroup a matrix of sums, a column for each pixel.
var<workgroup> done: array<f32, SUBGROUPS * EDGE * EDGE>;

/// Loads input channels from block `block` on, for the pixels from `first` on, into workgroup memory.
fn fill_patch(block: u32, first: vec2u, thread: u32) {
    for (var i = thread; i < BLOCKS * PATCH; i += THREADS) {
        let pixel = i % PATCH;
        let z = i / PATCH;
        var value = vec4f(0.0);
        if block + z < sources.ends.w {
            value = read_padded(block + z, first, vec2u(pixel % PATCH_WIDTH, pixel / PATCH_WIDTH));
        }
        let near = vec4h(clamp(value, vec4f(-LARGEST_HALF), vec4f(LARGEST_HALF)));
        let at = pixel * PIXEL + 4u * z;
        patch_pixels[at] = near.x;
        patch_pixels[at + 1u] = near.y;
        patch_pixels[at + 2u] = near.z;
        patch_pixels[at + 3u] = near.w;
    }
}

/// First pixel, within the workgroup, of matrix `tile` of pixels.
fn corner_of(tile: u32) -> vec2u {
    return vec2u((tile % ACROSS) * EDGE, tile / ACROSS);
}

/// Index in the patch of the first element that the window at pixel `corner` reads.
fn patch_place(corner: vec2u) -> u32 {
    return (corner.y * STRIDE * PATCH_WIDTH + corner.x * STRIDE) * PIXEL;
}

/// Writes the sums of a subgroup: channels from block `z` on of the pixels from `first` on to the right.
fn finish_matrix(subgroup: u32, lane: u32, lanes: u32, first: vec2u, z: u32) {
    for (var i = lane; i < EDGE * BLOCKS; i += lanes) {
        let pixel = i % EDGE;
        let block = i / EDGE;
        let at = (subgroup * EDGE + pixel) * EDGE + 4u * block;
        let sum = vec4f(done[at], done[at + 1u], done[at + 2u], done[at + 3u]);
        finish(sum, first.x + pixel, first.y, z + block);
    }
}

@compute @workgroup_size(THREADS)
fn convolve(
    @builtin(workgroup_id) workgroup: vec3u,
    @builtin(local_invocation_index) thread: u32,
    @builtin(subgroup_id) subgroup: u32,
    @builtin(subgroup_invocation_id) lane: u32,
    @builtin(subgroup_size) lanes: u32,
) {
    let first = workgroup.xy * vec2u(COLUMNS, ROWS);
    let tile = 2u * (subgroup % SHARES);
    let corner_0 = corner_of(tile);
    let corner_1 = corner_of(tile + 1u);
    let patch_0 = patch_place(corner_0);
    let patch_1 = patch_place(corner_1);
    let chunks = (sources.ends.w + BLOCKS - 1u) / BLOCKS;

    // Sums for each matrix of outputs and each matrix of pixels.
    var sums_00 = Sums();
    var sums_01 = Sums();
    var sums_10 = Sums();
    var sums_11 = Sums();
    var sums_20 = Sums();
    var sums_21 = Sums();
    var sums_30 = Sums();
    var sums_31 = Sums();
    for (var chunk = 0u; chunk < chunks; chunk += 1u) {
        workgroupBarrier();
        fill_patch(chunk * BLOCKS, first, thread);
        workgroupBarrier();
        for (var tap = 0u; tap < SIZE * SIZE; tap += 1u) {
            let moved = ((tap / SIZE) * PATCH_WIDTH + tap % SIZE) * PIXEL;
            let pixels_0 = coopLoad<Pixels>(&patch_pixels[patch_0 + moved], STRIDE * PIXEL);
            let pixels_1 = coopLoad<Pixels>(&patch_pixels[patch_1 + moved], STRIDE * PIXEL);
            let w = (((workgroup.z * chunks + chunk) * SIZE * SIZE + tap) * TILES) * EDGE * EDGE;
            let weights_0 = coopLoad<Weights>(&weights[w], EDGE);
            sums_00 = coopMultiplyAdd(weights_0, pixels_0, sums_00);
            sums_01 = coopMultiplyAdd(weights_0, pixels_1, sums_01);
            if TILES > 1u {
                let weights_1 = coopLoad<Weights>(&weights[w + EDGE * EDGE], EDGE);
                sums_10 = coopMultiplyAdd(weights_1, pixels_0, sums_10);
                sums_11 = coopMultiplyAdd(weights_1, pixels_1, sums_11);
            }
            if TILES > 2u {
                let weights_2 = coopLoad<Weights>(&weights[w + 2u * EDGE * EDGE], EDGE);
                sums_20 = coopMultiplyAdd(weights_2, pixels_0, sums_20);
                sums_21 = coopMultiplyAdd(weights_2, pixels_1, sums_21);
            }
            if TILES > 3u {
                let weights_3 = coopLoad<Weights>(&weights[w + 3u * EDGE * EDGE], EDGE);
                sums_30 = coopMultiplyAdd(weights_3, pixels_0, sums_30);
                sums_31 = coopMultiplyAdd(weights_3, pixels_1, sums_31);
            }
        }
    }

    let is_mine = subgroup < SHARES;
    for (var i = 0u; i < 2u * TILES; i += 1u) {
        workgroupBarrier();
        switch i {
            case 0u: { coopStore(sums_00, &done[subgroup * EDGE * EDGE], EDGE); }
            case 1u: { coopStore(sums_01, &done[subgroup * EDGE * EDGE], EDGE); }
            case 2u: { coopStore(sums_10, &done[subgroup * EDGE * EDGE], EDGE); }
            case 3u: { coopStore(sums_11, &done[subgroup * EDGE * EDGE], EDGE); }
            case 4u: { coopStore(sums_20, &done[subgroup * EDGE * EDGE], EDGE); }
            case 5u: { coopStore(sums_21, &done[subgroup * EDGE * EDGE], EDGE); }
            case 6u: { coopStore(sums_30, &done[subgroup * EDGE * EDGE], EDGE); }
            default: { coopStore(sums_31, &done[subgroup * EDGE * EDGE], EDGE); }
        }
        workgroupBarrier();
        if is_mine {
            let corner = first + corner_of(tile + i % 2u);
            finish_matrix(subgroup, lane, lanes, corner, (workgroup.z * TILES + i / 2u) * BLOCKS);
        }
    }
}
