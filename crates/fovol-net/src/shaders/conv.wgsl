// Convolutions of concatenated tensors. Twin of cpu/conv.
//
// A workgroup makes some rows of 16 pixels of up to 32 channels. For four channels of the inputs at a time it brings what
// its pixels read (resized, joined, padded) and the weights into workgroup memory; each thread adds up four pixels, one
// below the other, of eight channels in registers.

/// The edge of the window: 1 or 3.
override SIZE: u32;
/// 1 or 2.
override STRIDE: u32;
/// Whether the nearest value lies beyond the border; else zero.
override REPLICATE: bool;
/// See `activated`.
override ACTIVATION: u32;
/// Eights of channels that a workgroup makes.
override GROUPS: u32;
/// Fours of rows that a workgroup makes.
override ROWS: u32;
/// Which sources are of halves, a bit each; then the output, then the weights.
override HALVES: u32;
/// How sources are read, two bits each: as they are, bilinearly at twice the resolution, the nearest there, or with 2×2
/// pixels as four channels.
override READS: u32;

const OUTPUT_HALVED = 4u;
const WEIGHTS_HALVED = 5u;
const BILINEAR = 1u;
const NEAREST = 2u;
const FOLDED = 3u;

const COLUMNS = 16u;
override PATCH_WIDTH: u32 = (COLUMNS - 1u) * STRIDE + SIZE;
override PATCH_HEIGHT: u32 = (4u * ROWS - 1u) * STRIDE + SIZE;
override PATCH: u32 = PATCH_WIDTH * PATCH_HEIGHT;
override WEIGHTS: u32 = SIZE * SIZE * GROUPS * 8u;
override THREADS: u32 = COLUMNS * ROWS * GROUPS;

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
/// In the order of their use: \[workgroup\]\[block\]\[tap\]\[eight channels\]\[half of them\]\[input\], four channels each.
@group(0) @binding(6) var<storage, read> weights: array<vec2u>;
@group(0) @binding(7) var<storage, read> biases: array<vec4f>;
@group(0) @binding(8) var<storage, read_write> result: array<vec2u>;

/// Four channels of what the pixels read.
var<workgroup> patch_pixels: array<vec4f, PATCH>;
/// Their weights.
var<workgroup> kernels: array<vec4f, WEIGHTS>;

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

/// 2×2 pixels of channel `z` as four channels.
fn folded(source: u32, z: u32, at: vec2u, size: vec2u) -> vec4f {
    let first = ((z / 4u) * 2u * size.y + 2u * at.y) * 2u * size.x + 2u * at.x;
    let below = first + 2u * size.x;
    return vec4f(
        stored(source, first)[z % 4u],
        stored(source, first + 1u)[z % 4u],
        stored(source, below)[z % 4u],
        stored(source, below + 1u)[z % 4u],
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

/// Brings the weights of block `block` for the channels of workgroup `group` into workgroup memory.
fn fill_kernels(block: u32, group: u32, thread: u32) {
    let first = (group * sources.ends.w + block) * WEIGHTS;
    for (var i = thread; i < WEIGHTS; i += THREADS) {
        if extractBits(HALVES, WEIGHTS_HALVED, 1u) == 1u {
            kernels[i] = from_halves(weights[first + i]);
        } else {
            kernels[i] = bitcast<vec4f>(vec4u(weights[2u * (first + i)], weights[2u * (first + i) + 1u]));
        }
    }
}

/// Four pixels of eight channels.
struct Sums {
    a0: vec4f,
    a1: vec4f,
    a2: vec4f,
    a3: vec4f,
    b0: vec4f,
    b1: vec4f,
    b2: vec4f,
    b3: vec4f,
}

/// Adds what four pixels weigh with the eight columns of weights from `at` on.
fn add(sums: ptr<function, Sums>, at: u32, p0: vec4f, p1: vec4f, p2: vec4f, p3: vec4f) {
    let a = mat4x4f(kernels[at], kernels[at + 1u], kernels[at + 2u], kernels[at + 3u]);
    let b = mat4x4f(kernels[at + 4u], kernels[at + 5u], kernels[at + 6u], kernels[at + 7u]);
    (*sums).a0 += a * p0;
    (*sums).a1 += a * p1;
    (*sums).a2 += a * p2;
    (*sums).a3 += a * p3;
    (*sums).b0 += b * p0;
    (*sums).b1 += b * p1;
    (*sums).b2 += b * p2;
    (*sums).b3 += b * p3;
}

/// Adds tap (`column`, `row`) of the window for the four pixels whose part of the patch begins at `corner`.
fn add_tap(sums: ptr<function, Sums>, group: u32, corner: u32, column: u32, row: u32) {
    let at = corner + row * PATCH_WIDTH + column;
    let step = STRIDE * PATCH_WIDTH;
    let first = ((row * SIZE + column) * GROUPS + group) * 8u;
    add(sums, first, patch_pixels[at], patch_pixels[at + step], patch_pixels[at + 2u * step], patch_pixels[at + 3u * step]);
}

/// Adds a column of the window of 3×3: the pixels share what they read.
fn add_column(sums: ptr<function, Sums>, group: u32, corner: u32, column: u32) {
    let at = corner + column;
    let p0 = patch_pixels[at];
    let p1 = patch_pixels[at + PATCH_WIDTH];
    let p2 = patch_pixels[at + 2u * PATCH_WIDTH];
    let p3 = patch_pixels[at + 3u * PATCH_WIDTH];
    let p4 = patch_pixels[at + 4u * PATCH_WIDTH];
    let p5 = patch_pixels[at + 5u * PATCH_WIDTH];
    add(sums, (column * GROUPS + group) * 8u, p0, p1, p2, p3);
    add(sums, ((3u + column) * GROUPS + group) * 8u, p1, p2, p3, p4);
    add(sums, ((6u + column) * GROUPS + group) * 8u, p2, p3, p4, p5);
}

fn add_window(sums: ptr<function, Sums>, group: u32, corner: u32) {
    if SIZE == 1u {
        add_tap(sums, group, corner, 0u, 0u);
    } else if STRIDE == 1u {
        add_column(sums, group, corner, 0u);
        add_column(sums, group, corner, 1u);
        add_column(sums, group, corner, 2u);
    } else {
        for (var row = 0u; row < 3u; row += 1u) {
            add_tap(sums, group, corner, 0u, row);
            add_tap(sums, group, corner, 1u, row);
            add_tap(sums, group, corner, 2u, row);
        }
    }
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

@compute @workgroup_size(COLUMNS, ROWS, GROUPS)
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
        fill_kernels(block, workgroup.z, thread);
        workgroupBarrier();
        add_window(&sums, local.z, corner);
    }
    let x = first.x + local.x;
    let y = first.y + 4u * local.y;
    let z = 2u * (workgroup.z * GROUPS + local.z);
    finish(sums.a0, x, y, z);
    finish(sums.a1, x, y + 1u, z);
    finish(sums.a2, x, y + 2u, z);
    finish(sums.a3, x, y + 3u, z);
    finish(sums.b0, x, y, z + 1u);
    finish(sums.b1, x, y + 1u, z + 1u);
    finish(sums.b2, x, y + 2u, z + 1u);
    finish(sums.b3, x, y + 3u, z + 1u);
}
