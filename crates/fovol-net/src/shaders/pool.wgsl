// Averages of 2×2 pixels. Twin of `pool` in cpu/layers/reshape.rs.

/// Whether elements are f16.
override HALVED: bool;

@group(0) @binding(0) var<uniform> shape: Shape;
@group(0) @binding(1) var<storage, read> input: array<vec2u>;
@group(0) @binding(2) var<storage, read_write> pooled: array<vec2u>;

fn number(i: u32) -> vec4f {
    if HALVED {
        return from_halves(input[i]);
    }
    return bitcast<vec4f>(vec4u(input[2u * i], input[2u * i + 1u]));
}

@compute @workgroup_size(8, 8)
fn pool(@builtin(global_invocation_id) at: vec3u) {
    if !is_inside(shape, at) {
        return;
    }
    let above = (at.z * 2u * shape.height + 2u * at.y) * 2u * shape.width + 2u * at.x;
    let below = above + 2u * shape.width;
    let value = 0.25 * ((number(above) + number(above + 1u)) + (number(below) + number(below + 1u)));
    let i = place(shape, at.x, at.y, at.z);
    if HALVED {
        pooled[i] = to_halves(value);
    } else {
        let words = bitcast<vec4u>(value);
        pooled[2u * i] = words.xy;
        pooled[2u * i + 1u] = words.zw;
    }
}
