// Convolutions on any device. Twin of cpu/conv.
//
// A workgroup computes up to 16 channels. For four input channels at a time it loads the inputs of its pixels
// (resized, concatenated, padded) into workgroup memory. Each thread accumulates four pixels, one below the other,
// in registers. All threads of a workgroup read the same weights.

/// Number of blocks of four channels of a workgroup, up to four.
override TILES: u32;
/// Number of groups of four rows of a workgroup.
override ROWS: u32;

override PATCH_WIDTH: u32 = (COLUMNS - 1u) * STRIDE + SIZE;
override PATCH_HEIGHT: u32 = (4u * ROWS - 1u) * STRIDE + SIZE;
override PATCH: u32 = PATCH_WIDTH * PATCH_HEIGHT;
override THREADS: u32 = COLUMNS * ROWS;

/// Packed weights, \[workgroup\]\[block of inputs\]\[tap\]\[block of outputs\]; a column for each input.
@group(0) @binding(6) var<storage, read> weights: array<mat4x4f>;

/// Four input channels of the pixels.
var<workgroup> patch_pixels: array<vec4f, PATCH>;

/// Loads input block `block`, for the pixels from `first` on, into workgroup memory.
fn fill_patch(block: u32, first: vec2u, thread: u32) {
    for (var i = thread; i < PATCH; i += THREADS) {
        patch_pixels[i] = read_padded(block, first, vec2u(i % PATCH_WIDTH, i / PATCH_WIDTH));
    }
}

/// Four pixels, one below the other, of four channels.
struct Pixels {
    p0: vec4f,
    p1: vec4f,
    p2: vec4f,
    p3: vec4f,
}

/// Sums of up to four blocks of channels.
struct Sums {
    a: Pixels,
    b: Pixels,
    c: Pixels,
    d: Pixels,
}

/// Products are added one after the other, so that each is one FMA instruction.
fn plus_product(sum: vec4f, w: mat4x4f, p: vec4f) -> vec4f {
    return sum + w[0] * p.x + w[1] * p.y + w[2] * p.z + w[3] * p.w;
}

fn plus_products(sums: Pixels, w: mat4x4f, p: Pixels) -> Pixels {
    return Pixels(
        plus_product(sums.p0, w, p.p0),
        plus_product(sums.p1, w, p.p1),
        plus_product(sums.p2, w, p.p2),
        plus_product(sums.p3, w, p.p3),
    );
}

/// Adds the products of tap `tap`. `first` is the index of the first weights of the window.
fn plus_tap(sums: Sums, first: u32, tap: u32, p: Pixels) -> Sums {
    let i = first + tap * TILES;
    var found = sums;
    found.a = plus_products(sums.a, weights[i], p);
    if TILES > 1u {
        found.b = plus_products(sums.b, weights[i + 1u], p);
    }
    if TILES > 2u {
        found.c = plus_products(sums.c, weights[i + 2u], p);
    }
    if TILES > 3u {
        found.d = plus_products(sums.d, weights[i + 3u], p);
    }
    return found;
}

/// Adds the products of tap (`column`, `row`) of the window. `corner` is the index in the patch of the window's
/// first pixel.
fn plus_one(sums: Sums, first: u32, corner: u32, column: u32, row: u32) -> Sums {
    let at = corner + row * PATCH_WIDTH + column;
    let step = STRIDE * PATCH_WIDTH;
    let p = Pixels(
        patch_pixels[at],
        patch_pixels[at + step],
        patch_pixels[at + 2u * step],
        patch_pixels[at + 3u * step],
    );
    return plus_tap(sums, first, row * SIZE + column, p);
}

/// Adds the products of a column of a 3×3 window, whose taps share input pixels.
fn plus_column(sums: Sums, first: u32, corner: u32, column: u32) -> Sums {
    let at = corner + column;
    let p0 = patch_pixels[at];
    let p1 = patch_pixels[at + PATCH_WIDTH];
    let p2 = patch_pixels[at + 2u * PATCH_WIDTH];
    let p3 = patch_pixels[at + 3u * PATCH_WIDTH];
    let p4 = patch_pixels[at + 4u * PATCH_WIDTH];
    let p5 = patch_pixels[at + 5u * PATCH_WIDTH];
    let top = plus_tap(sums, first, column, Pixels(p0, p1, p2, p3));
    let middle = plus_tap(top, first, 3u + column, Pixels(p1, p2, p3, p4));
    return plus_tap(middle, first, 6u + column, Pixels(p2, p3, p4, p5));
}

fn plus_window(sums: Sums, first: u32, corner: u32) -> Sums {
    if SIZE == 1u {
        return plus_one(sums, first, corner, 0u, 0u);
    }
    if STRIDE == 1u {
        let left = plus_column(sums, first, corner, 0u);
        return plus_column(plus_column(left, first, corner, 1u), first, corner, 2u);
    }
    var found = sums;
    for (var row = 0u; row < 3u; row += 1u) {
        found = plus_one(found, first, corner, 0u, row);
        found = plus_one(found, first, corner, 1u, row);
        found = plus_one(found, first, corner, 2u, row);
    }
    return found;
}

/// Writes the sums of block `z` of four pixels, from (`x`, `y`) down.
fn finish_block(sums: Pixels, x: u32, y: u32, z: u32) {
    finish(sums.p0, x, y, z);
    finish(sums.p1, x, y + 1u, z);
    finish(sums.p2, x, y + 2u, z);
    finish(sums.p3, x, y + 3u, z);
}

@compute @workgroup_size(COLUMNS, ROWS)
fn convolve(
    @builtin(workgroup_id) workgroup: vec3u,
    @builtin(local_invocation_id) local: vec3u,
    @builtin(local_invocation_index) thread: u32,
) {
    let first = workgroup.xy * vec2u(COLUMNS, 4u * ROWS);
    let corner = 4u * local.y * STRIDE * PATCH_WIDTH + local.x * STRIDE;
    var sums = Sums();
    for (var block = 0u; block < sources.ends.w; block += 1u) {
        workgroupBarrier();
        fill_patch(block, first, thread);
        workgroupBarrier();
        let window = (workgroup.z * sources.ends.w + block) * SIZE * SIZE * TILES;
        sums = plus_window(sums, window, corner);
    }
    let x = first.x + local.x;
    let y = first.y + 4u * local.y;
    let z = workgroup.z * TILES;
    finish_block(sums.a, x, y, z);
    if TILES > 1u {
        finish_block(sums.b, x, y, z + 1u);
    }
    if TILES > 2u {
        finish_block(sums.c, x, y, z + 2u);
    }
    if TILES > 3u {
        finish_block(sums.d, x, y, z + 3u);
    }
}
