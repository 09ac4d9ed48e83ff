// Predicted kernels: prediction, normalisation and weighted sum in one pass, so that the kernels of a frame never
// exist in memory. Twin of cpu/filter.rs.
//
// A thread handles one feature, and the one or four pixels that it serves. Its kernels lie in workgroup memory,
// some taps at a time.

/// Edge of the square of pixels that a feature serves: 1 or 2.
override EXPAND: u32;
/// Number of blocks of channels of the features. A constant, since some drivers compile a shader for every command if
/// a uniform limits one of its loops.
override FEATURE_BLOCKS: u32;
/// Number of weights of a kernel.
override TAPS: u32;
/// Whether weights are eʷ / Σeʷ; otherwise they are (w² + ε) / (Σw² + nε).
override SOFTMAX: bool;
/// Whether features are f16.
override HALVED: bool;
/// For each image the end of its taps.
override END_0: u32;
override END_1: u32;
override END_2: u32;
/// Whether images are weighed by 3×3 taps, one bit each.
override AROUND: u32;
/// Resize of images, two bits each: unchanged, bilinear or nearest at twice the resolution.
override READS: u32;

const BILINEAR = 1u;
const NEAREST = 2u;

/// Equals SQUARED_EPSILON of plan/layers/filter.rs.
const EPSILON = 1e-6;
/// Less than any weight.
const LEAST = -1e30;
const THREADS = 64u;
/// Number of blocks of four weights that a thread holds, a multiple of four.
override HELD: u32;
override HELD_BY_ALL: u32 = HELD * THREADS;
/// Number of blocks of four weights of a feature.
override BLOCKS: u32 = (EXPAND * EXPAND * TAPS + 3u) / 4u;

@group(0) @binding(0) var<uniform> shape: Shape;
@group(0) @binding(1) var<uniform> served: Shape;
@group(0) @binding(2) var<storage, read> features: array<vec2u>;
/// \[block of weights\]\[channel of the features\], four weights each.
@group(0) @binding(3) var<storage, read> weights: array<vec4f>;
@group(0) @binding(4) var<storage, read> biases: array<vec4f>;
@group(0) @binding(5) var<storage, read> image_0: array<vec4f>;
@group(0) @binding(6) var<storage, read> image_1: array<vec4f>;
@group(0) @binding(7) var<storage, read> image_2: array<vec4f>;
@group(0) @binding(8) var<storage, read> image_3: array<vec4f>;
@group(0) @binding(9) var<storage, read_write> result: array<vec4f>;

/// \[block\]\[thread\]. Each thread reads only its own entries.
var<workgroup> kernels: array<vec4f, HELD_BY_ALL>;

fn feature(at: vec2u, z: u32) -> vec4f {
    let i = place(served, at.x, at.y, z);
    if HALVED {
        return from_halves(features[i]);
    }
    return bitcast<vec4f>(vec4u(features[2u * i], features[2u * i + 1u]));
}

fn plus_product(sum: vec4f, i: u32, p: vec4f) -> vec4f {
    return sum + weights[i] * p.x + weights[i + 1u] * p.y + weights[i + 2u] * p.z + weights[i + 3u] * p.w;
}

/// Predicts blocks of weights of the feature at `at`, from block `first` on, as many as a thread holds.
fn predict(first: u32, at: vec2u, thread: u32) {
    let row = 4u * FEATURE_BLOCKS;
    for (var block = first; block < min(first + HELD, BLOCKS); block += 4u) {
        let last = BLOCKS - 1u;
        let blocks = min(vec4u(block, block + 1u, block + 2u, block + 3u), vec4u(last));
        var a = biases[blocks.x];
        var b = biases[blocks.y];
        var c = biases[blocks.z];
        var d = biases[blocks.w];
        for (var z = 0u; z < FEATURE_BLOCKS; z += 1u) {
            let value = feature(at, z);
            a = plus_product(a, blocks.x * row + 4u * z, value);
            b = plus_product(b, blocks.y * row + 4u * z, value);
            c = plus_product(c, blocks.z * row + 4u * z, value);
            d = plus_product(d, blocks.w * row + 4u * z, value);
        }
        let held = (block - first) * THREADS + thread;
        kernels[held] = a;
        kernels[held + THREADS] = b;
        kernels[held + 2u * THREADS] = c;
        kernels[held + 3u * THREADS] = d;
    }
}

fn stored(image: u32, i: u32) -> vec4f {
    switch image {
        case 0u: { return image_0[i]; }
        case 1u: { return image_1[i]; }
        case 2u: { return image_2[i]; }
        default: { return image_3[i]; }
    }
}

/// Interpolates block `z` of an image of half the resolution at pixel `at`.
fn doubled(image: u32, at: vec2u, z: u32) -> vec4f {
    let size = vec2u(shape.width, shape.height) / 2u;
    let i = z * size.x * size.y + pixels_around(at, size);
    return between(stored(image, i.x), stored(image, i.y), stored(image, i.z), stored(image, i.w));
}

/// Block `z` of the image pixel that tap `tap` of pixel `at` weighs; zero beyond the border.
fn weighed(tap: u32, at: vec2u, z: u32) -> vec4f {
    let ends = vec3u(END_0, END_1, END_2);
    let passed = vec3u(vec3u(tap) >= ends);
    let image = passed.x + passed.y + passed.z;
    var step = vec2i(0);
    if extractBits(AROUND, image, 1u) == 1u {
        var tap_of_image = tap;
        if image > 0u {
            tap_of_image -= ends[image - 1u];
        }
        step = vec2i(vec2u(tap_of_image % 3u, tap_of_image / 3u)) - 1;
    }
    let wanted = vec2i(at) + step;
    if any(wanted < vec2i(0)) || any(wanted >= vec2i(vec2u(shape.width, shape.height))) {
        return vec4f(0.0);
    }
    let found = vec2u(wanted);
    switch extractBits(READS, 2u * image, 2u) {
        case BILINEAR: { return doubled(image, found, z); }
        case NEAREST: {
            return stored(image, (z * (shape.height / 2u) + found.y / 2u) * (shape.width / 2u) + found.x / 2u);
        }
        default: { return stored(image, place(shape, found.x, found.y, z)); }
    }
}

/// Weighted sums of the pixels that a feature serves, one column each.
struct Sums {
    sums: mat4x4f,
    totals: vec4f,
    /// Largest weights so far.
    largest: vec4f,
}

/// Turns predictions into positive weights, not yet normalised. With `EXPAND` 1 only the first component counts.
fn shaped(found: ptr<function, Sums>, weights: vec4f) -> vec4f {
    if !SOFTMAX {
        return weights * weights + EPSILON;
    }
    // Earlier sums are relative to the former largest weight, so they are rescaled.
    let largest = max((*found).largest, weights);
    let shrink = exp((*found).largest - largest);
    (*found).largest = largest;
    (*found).totals *= shrink;
    (*found).sums[0] *= shrink.x;
    (*found).sums[1] *= shrink.y;
    (*found).sums[2] *= shrink.z;
    (*found).sums[3] *= shrink.w;
    return exp(weights - largest);
}

/// Adds the contribution of tap `tap` to the pixels from `first` on.
fn add(found: ptr<function, Sums>, tap: u32, weights: vec4f, first: vec2u, z: u32) {
    let w = shaped(found, weights);
    (*found).totals += w;
    (*found).sums[0] += w.x * weighed(tap, first, z);
    if EXPAND == 2u {
        (*found).sums[1] += w.y * weighed(tap, first + vec2u(1u, 0u), z);
        (*found).sums[2] += w.z * weighed(tap, first + vec2u(0u, 1u), z);
        (*found).sums[3] += w.w * weighed(tap, first + vec2u(1u, 1u), z);
    }
}

/// Adds the contributions of the taps in block `block`.
fn add_block(found: ptr<function, Sums>, block: u32, held: vec4f, first: vec2u, z: u32) {
    if EXPAND == 2u {
        add(found, block, held, first, z);
        return;
    }
    for (var i = 0u; i < min(4u, TAPS - 4u * block); i += 1u) {
        add(found, 4u * block + i, vec4f(held[i]), first, z);
    }
}

@compute @workgroup_size(8, 8)
fn weigh(@builtin(global_invocation_id) at: vec3u, @builtin(local_invocation_index) thread: u32) {
    if at.x >= served.width || at.y >= served.height {
        return;
    }
    let first = EXPAND * at.xy;
    var found = Sums();
    found.largest = vec4f(LEAST);
    for (var start = 0u; start < BLOCKS; start += HELD) {
        predict(start, at.xy, thread);
        for (var block = start; block < min(start + HELD, BLOCKS); block += 1u) {
            add_block(&found, block, kernels[(block - start) * THREADS + thread], first, at.z);
        }
    }
    result[place(shape, first.x, first.y, at.z)] = found.sums[0] / found.totals.x;
    if EXPAND == 2u {
        result[place(shape, first.x + 1u, first.y, at.z)] = found.sums[1] / found.totals.y;
        result[place(shape, first.x, first.y + 1u, at.z)] = found.sums[2] / found.totals.z;
        result[place(shape, first.x + 1u, first.y + 1u, at.z)] = found.sums[3] / found.totals.w;
    }
}
