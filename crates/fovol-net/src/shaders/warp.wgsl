// Reprojection of images along the motion. Twin of cpu/history/warp.rs.

/// Whether elements are f16.
override HALVED: bool;
/// Number of times that the resolution of the motion is halved.
override LEVEL: u32;

@group(0) @binding(0) var<uniform> shape: Shape;
@group(0) @binding(1) var<storage, read> input: array<vec2u>;
@group(0) @binding(2) var<storage, read> motion: array<vec4f>;
@group(0) @binding(3) var<storage, read_write> warped: array<vec2u>;

/// Mean motion of the pixels of a square, in squares.
fn mean_motion(at: vec2u) -> vec2f {
    let side = 1u << LEVEL;
    let width = shape.width << LEVEL;
    var sum = vec2f(0.0);
    for (var y = at.y * side; y < (at.y + 1u) * side; y += 1u) {
        for (var x = at.x * side; x < (at.x + 1u) * side; x += 1u) {
            sum += motion[y * width + x].xy;
        }
    }
    return sum / f32(side * side * side);
}

fn number(x: u32, y: u32, z: u32) -> vec4f {
    let i = place(shape, x, y, z);
    if HALVED {
        return from_halves(input[i]);
    }
    return bitcast<vec4f>(vec4u(input[2u * i], input[2u * i + 1u]));
}

/// The two pixels of a line around a position, and their weights, which are 0 beyond the ends.
struct Along {
    pixels: vec2u,
    weights: vec2f,
}

fn along(at: f32, count: u32) -> Along {
    let last = f32(count - 1u);
    // Positions further out, and NaN, have no sources.
    if !is_finite(at) || at <= -1.0 || at >= last + 1.0 {
        return Along(vec2u(0u), vec2f(0.0));
    }
    let first = floor(at);
    let part = at - first;
    let near = select(0.0, 1.0 - part, first >= 0.0);
    let far = select(0.0, part, first + 1.0 <= last);
    return Along(vec2u(u32(max(first, 0.0)), u32(min(first + 1.0, last))), vec2f(near, far));
}

@compute @workgroup_size(8, 8)
fn warp(@builtin(global_invocation_id) at: vec3u) {
    if !is_inside(shape, at) {
        return;
    }
    let wanted = vec2f(at.xy) + mean_motion(at.xy);
    let x = along(wanted.x, shape.width);
    let y = along(wanted.y, shape.height);
    let above = y.weights[0] * x.weights[0] * number(x.pixels[0], y.pixels[0], at.z)
        + y.weights[0] * x.weights[1] * number(x.pixels[1], y.pixels[0], at.z);
    let below = y.weights[1] * x.weights[0] * number(x.pixels[0], y.pixels[1], at.z)
        + y.weights[1] * x.weights[1] * number(x.pixels[1], y.pixels[1], at.z);
    let value = above + below;
    let i = place(shape, at.x, at.y, at.z);
    if HALVED {
        warped[i] = to_halves(value);
    } else {
        let words = bitcast<vec4u>(value);
        warped[2u * i] = words.xy;
        warped[2u * i + 1u] = words.zw;
    }
}
