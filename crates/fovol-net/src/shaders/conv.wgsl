// Convolutions of concatenated tensors. Twin of cpu/conv.
//
// A workgroup makes some rows of 16 pixels of up to 16 channels. For four channels of the inputs at a time it brings what
// its pixels read (resized, joined, padded) into workgroup memory; each thread adds up four pixels, one below the other, in
// registers. Weights are the same for all threads of a workgroup.

/// The edge of the window: 1 or 3.
override SIZE: u32;
/// 1 or 2.
override STRIDE: u32;
/// Whether the nearest value lies beyond the border; else zero.
override REPLICATE: bool;
/// See `activated`.
override ACTIVATION: u32;
/// Blocks of four channels that a workgroup makes, up to four.
override BLOCKS: u32;
/// Fours of rows that a workgroup makes.
override ROWS: u32;
/// Which sources are of halves, a bit each; then the output.
override HALVES: u32;
/// How sources are read, two bits each: as they are, bilinearly at twice the resolution, the nearest there, or with 2×2
/// pixels as four channels.
override READS: u32;

const OUTPUT_HALVED = 4u;
const BILINEAR = 1u;
const NEAREST = 2u;
const FOLDED = 3u;

const COLUMNS = 16u;
override PATCH_WIDTH: u32 = (COLUMNS - 1u) * STRIDE + SIZE;
override PATCH_HEIGHT: u32 = (4u * ROWS - 1u) * STRIDE + SIZE;
override PATCH: u32 = PATCH_WIDTH * PATCH_HEIGHT;
override THREADS: u32 = COLUMNS * ROWS;

/// Twin of `Sources` in gpu/conv.rs.
struct Sources {
    /// For each source the block after its last one, of all blocks together.
    ends: vec4u,
}

@group(0) @binding(0) var<uniform> shape: Shape;
@group(0) @binding(1) var<uniform> sources: Sources;
@group(0) @binding(2) var<storage, read> source_0: array<vec2u>;
@group(0) @binding(3) var<storage, read> source_1: array<vec2u>;
@group(0) @binding(4) var<storage, read> source_2: array<vec2u>;
@group(0) @binding(5) var<storage, read> source_3: array<vec2u>;
/// In the order of their use, \[workgroup\]\[block of inputs\]\[tap\]\[block of outputs\]; a column for each input.
@group(0) @binding(6) var<storage, read> weights: array<mat4x4f>;
@group(0) @binding(7) var<storage, read> biases: array<vec4f>;
@group(0) @binding(8) var<storage, read_write> result: array<vec2u>;

/// Four channels of what the pixels read.
var<workgroup> patch_pixels: array<vec4f, PATCH>;

fn word(source: u32, i: u32) -> vec2u {
    switch source {
        case 0u: { return source_0[i]; }
        case 1u: { return source_1[i]; }
        case 2u: { return source_2[i]; }
        default: { return source_3[i]; }
    }
}

/// Four numbers of a source.
fn stored(source: u32, i: u32) -> vec4f {
    if extractBits(HALVES, source, 1u) == 1u {
        return from_halves(word(source, i));
    }
    return bitcast<vec4f>(vec4u(word(source, 2u * i), word(source, 2u * i + 1u)));
}

/// Block `z` of a source of `size` pixels at twice its resolution.
fn doubled(source: u32, z: u32, at: vec2u, size: vec2u) -> vec4f {
    let i = z * size.x * size.y + pixels_around(at, size);
    return between(stored(source, i.x), stored(source, i.y), stored(source, i.z), stored(source, i.w));
}

/// Channel `c` of pixel `i` of a source of f32.
fn one_number(source: u32, i: u32, c: u32) -> f32 {
    return bitcast<f32>(word(source, 2u * i + c / 2u)[c % 2u]);
}

/// 2×2 pixels of channel `z` of a source of f32 as four channels.
fn folded(source: u32, z: u32, at: vec2u, size: vec2u) -> vec4f {
    let above = ((z / 4u) * 2u * size.y + 2u * at.y) * 2u * size.x + 2u * at.x;
    let below = above + 2u * size.x;
    let c = z % 4u;
    return vec4f(
        one_number(source, above, c),
        one_number(source, above + 1u, c),
        one_number(source, below, c),
        one_number(source, below + 1u, c),
    );
}

/// Block `block` of all sources together at pixel `at` of `size`.
fn read_block(block: u32, at: vec2u, size: vec2u) -> vec4f {
    let passed = vec4u(vec4u(block) >= sources.ends);
    let source = passed.x + passed.y + passed.z;
    var z = block;
    if source > 0u {
        z -= sources.ends[source - 1u];
    }
    switch extractBits(READS, 2u * source, 2u) {
        case BILINEAR: { return doubled(source, z, at, size / 2u); }
        case NEAREST: { return stored(source, (z * (size.y / 2u) + at.y / 2u) * (size.x / 2u) + at.x / 2u); }
        case FOLDED: { return folded(source, z, at, size); }
        default: { return stored(source, (z * size.y + at.y) * size.x + at.x); }
    }
}

/// Brings block `block` of what the pixels from `first` on read into workgroup memory.
fn fill_patch(block: u32, first: vec2u, thread: u32) {
    let size = STRIDE * vec2u(shape.width, shape.height);
    let corner = vec2i(STRIDE * first) - i32(SIZE / 2u);
    for (var i = thread; i < PATCH; i += THREADS) {
        let wanted = corner + vec2i(vec2u(i % PATCH_WIDTH, i / PATCH_WIDTH));
        let at = vec2u(clamp(wanted, vec2i(0), vec2i(size) - 1));
        var value = vec4f(0.0);
        if REPLICATE || all(vec2i(at) == wanted) {
            value = read_block(block, at, size);
        }
        patch_pixels[i] = value;
    }
}

/// Four pixels, one below the other, of four channels.
struct Pixels {
    p0: vec4f,
    p1: vec4f,
    p2: vec4f,
    p3: vec4f,
}

/// Up to four blocks of them.
struct Sums {
    a: Pixels,
    b: Pixels,
    c: Pixels,
    d: Pixels,
}

/// One product after the other is added, so that each is one instruction.
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

/// The sums with what the pixels weigh at tap `tap`; `first` is the place of the first weights of the window.
fn plus_tap(sums: Sums, first: u32, tap: u32, p: Pixels) -> Sums {
    let i = first + tap * BLOCKS;
    var found = sums;
    found.a = plus_products(sums.a, weights[i], p);
    if BLOCKS > 1u {
        found.b = plus_products(sums.b, weights[i + 1u], p);
    }
    if BLOCKS > 2u {
        found.c = plus_products(sums.c, weights[i + 2u], p);
    }
    if BLOCKS > 3u {
        found.d = plus_products(sums.d, weights[i + 3u], p);
    }
    return found;
}

/// With tap (`column`, `row`) of the window of the pixels whose part of the patch begins at `corner`.
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

/// With a column of the window of 3×3: the pixels share what they read.
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

/// Writes a sum to block `z` of pixel (`x`, `y`) if there is one.
fn finish(sum: vec4f, x: u32, y: u32, z: u32) {
    if !is_inside(shape, vec3u(x, y, z)) {
        return;
    }
    let value = activated(sum + biases[z], ACTIVATION);
    let i = place(shape, x, y, z);
    if extractBits(HALVES, OUTPUT_HALVED, 1u) == 1u {
        result[i] = to_halves(value);
    } else {
        let words = bitcast<vec4u>(value);
        result[2u * i] = words.xy;
        result[2u * i + 1u] = words.zw;
    }
}

/// Writes sums to block `z` of the pixels from (`x`, `y`) down.
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
        let window = (workgroup.z * sources.ends.w + block) * SIZE * SIZE * BLOCKS;
        sums = plus_window(sums, window, corner);
    }
    let x = first.x + local.x;
    let y = first.y + 4u * local.y;
    let z = workgroup.z * BLOCKS;
    finish_block(sums.a, x, y, z);
    if BLOCKS > 1u {
        finish_block(sums.b, x, y, z + 1u);
    }
    if BLOCKS > 2u {
        finish_block(sums.c, x, y, z + 2u);
    }
    if BLOCKS > 3u {
        finish_block(sums.d, x, y, z + 3u);
    }
}
