// Input and output of convolutions, for both ways to compute them. A workgroup computes some rows of 16 pixels of
// some channels.

/// Edge of the window in pixels: 1 or 3.
override SIZE: u32;
/// Step between windows in pixels: 1 or 2.
override STRIDE: u32;
/// Whether the nearest value lies beyond the border; otherwise zero.
override REPLICATE: bool;
/// Number of the activation, see `activated`.
override ACTIVATION: u32;
/// Whether each input, and then the output, is f16, one bit each.
override HALVES: u32;
/// Reading of inputs, two bits each: unchanged, bilinear or nearest at twice the resolution, or 2×2 pixels folded
/// into four channels.
override READS: u32;

const OUTPUT_HALVED = 4u;
const BILINEAR = 1u;
const NEAREST = 2u;
const FOLDED = 3u;

const COLUMNS = 16u;

/// Ends of the input tensors. Twin of `Sources` in gpu/conv/mod.rs.
struct Sources {
    /// For each input tensor its end, in blocks of all inputs together.
    ends: vec4u,
}

@group(0) @binding(0) var<uniform> shape: Shape;
@group(0) @binding(1) var<uniform> sources: Sources;
@group(0) @binding(2) var<storage, read> source_0: array<vec2u>;
@group(0) @binding(3) var<storage, read> source_1: array<vec2u>;
@group(0) @binding(4) var<storage, read> source_2: array<vec2u>;
@group(0) @binding(5) var<storage, read> source_3: array<vec2u>;
@group(0) @binding(7) var<storage, read> biases: array<vec4f>;
@group(0) @binding(8) var<storage, read_write> result: array<vec2u>;

fn word(source: u32, i: u32) -> vec2u {
    switch source {
        case 0u: { return source_0[i]; }
        case 1u: { return source_1[i]; }
        case 2u: { return source_2[i]; }
        default: { return source_3[i]; }
    }
}

/// Four elements of an input tensor.
fn stored(source: u32, i: u32) -> vec4f {
    if extractBits(HALVES, source, 1u) == 1u {
        return from_halves(word(source, i));
    }
    return bitcast<vec4f>(vec4u(word(source, 2u * i), word(source, 2u * i + 1u)));
}

/// Interpolates block `z` of an input tensor of `size` pixels at twice its resolution.
fn doubled(source: u32, z: u32, at: vec2u, size: vec2u) -> vec4f {
    let i = z * size.x * size.y + pixels_around(at, size);
    return between(stored(source, i.x), stored(source, i.y), stored(source, i.z), stored(source, i.w));
}

/// Channel `c` of pixel `i` of an input tensor of f32.
fn one_number(source: u32, i: u32, c: u32) -> f32 {
    return bitcast<f32>(word(source, 2u * i + c / 2u)[c % 2u]);
}

/// Folds 2×2 pixels of channel `z` of an input tensor of f32 into four channels.
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

/// Block `block`, of all inputs together, at pixel `at` of `size`.
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

/// Block `block` of the input pixel `tap` within the window of output pixel `first`, padded at the border.
fn read_padded(block: u32, first: vec2u, tap: vec2u) -> vec4f {
    let size = STRIDE * vec2u(shape.width, shape.height);
    let wanted = vec2i(STRIDE * first + tap) - i32(SIZE / 2u);
    let at = vec2u(clamp(wanted, vec2i(0), vec2i(size) - 1));
    if REPLICATE || all(vec2i(at) == wanted) {
        return read_block(block, at, size);
    }
    return vec4f(0.0);
}

/// Adds the bias, applies the activation and writes block `z` of pixel (`x`, `y`), if it is inside.
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
