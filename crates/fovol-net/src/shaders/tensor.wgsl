// Memory layout of tensors: blocks of four channels, each an image row by row. Padding in the last block is finite,
// and nobody reads it.
//
// Elements are f32, or f16 in wide tensors. Tensors that may have either type are bound as words: two words are
// four f16 or two f32.

/// Size of a tensor. Twin of `Shape` in gpu/tensor/layout.rs.
struct Shape {
    width: u32,
    height: u32,
    /// Blocks of four channels.
    blocks: u32,
    channels: u32,
}

/// Largest f16.
const LARGEST_HALF = 65504.0;

/// Index of a pixel of block `z`.
fn place(shape: Shape, x: u32, y: u32, z: u32) -> u32 {
    return (z * shape.height + y) * shape.width + x;
}

fn is_inside(shape: Shape, at: vec3u) -> bool {
    return at.x < shape.width && at.y < shape.height && at.z < shape.blocks;
}

/// Unpacks four f16.
fn from_halves(words: vec2u) -> vec4f {
    return vec4f(unpack2x16float(words.x), unpack2x16float(words.y));
}

/// Packs four numbers as f16, clamped to its range.
fn to_halves(numbers: vec4f) -> vec2u {
    let near = clamp(numbers, vec4f(-LARGEST_HALF), vec4f(LARGEST_HALF));
    return vec2u(pack2x16float(near.xy), pack2x16float(near.zw));
}

/// Whether `x` is neither NaN nor infinite. It tests bits, because compilers may assume that values are finite.
fn is_finite(x: f32) -> bool {
    return (bitcast<u32>(x) & 0x7f800000u) != 0x7f800000u;
}

/// ELU: x for x > 0, else eˣ − 1.
fn elu(x: vec4f) -> vec4f {
    return select(exp(min(x, vec4f(0.0))) - 1.0, x, x > vec4f(0.0));
}

/// Applies an activation: identity, max(x, 0) or [`elu`].
fn activated(x: vec4f, activation: u32) -> vec4f {
    switch activation {
        case 1u: { return max(x, vec4f(0.0)); }
        case 2u: { return elu(x); }
        default: { return x; }
    }
}
