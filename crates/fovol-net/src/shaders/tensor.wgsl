// How tensors lie in memory: in blocks of four channels, each an image row by row. What the last block has more than there
// are channels is finite and read by nobody.
//
// A number takes four bytes, or two in wide tensors: those that may have either are bound as words, two of which are four
// halves or two numbers.

/// Twin of `Shape` in gpu/tensor.rs.
struct Shape {
    width: u32,
    height: u32,
    /// Blocks of four channels.
    blocks: u32,
    channels: u32,
}

/// The largest half.
const LARGEST_HALF = 65504.0;

/// Where a pixel of block `z` lies.
fn place(shape: Shape, x: u32, y: u32, z: u32) -> u32 {
    return (z * shape.height + y) * shape.width + x;
}

fn is_inside(shape: Shape, at: vec3u) -> bool {
    return at.x < shape.width && at.y < shape.height && at.z < shape.blocks;
}

/// Four numbers of halves.
fn from_halves(words: vec2u) -> vec4f {
    return vec4f(unpack2x16float(words.x), unpack2x16float(words.y));
}

/// Four numbers as halves; what is too large for these becomes the largest.
fn to_halves(numbers: vec4f) -> vec2u {
    let near = clamp(numbers, vec4f(-LARGEST_HALF), vec4f(LARGEST_HALF));
    return vec2u(pack2x16float(near.xy), pack2x16float(near.zw));
}

/// Whether `x` is a number and not infinite; in bits, since devices may take for granted that it is.
fn is_finite(x: f32) -> bool {
    return (bitcast<u32>(x) & 0x7f800000u) != 0x7f800000u;
}

/// x for x > 0, else eˣ − 1.
fn elu(x: vec4f) -> vec4f {
    return select(exp(min(x, vec4f(0.0))) - 1.0, x, x > vec4f(0.0));
}

/// What follows a convolution or a normalisation: nothing, max(x, 0) or [`elu`].
fn activated(x: vec4f, activation: u32) -> vec4f {
    switch activation {
        case 1u: { return max(x, vec4f(0.0)); }
        case 2u: { return elu(x); }
        default: { return x; }
    }
}
