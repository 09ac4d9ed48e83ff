// Smoothing, and filling from pictures of half the resolution. Twin of cpu/fill/spread.rs.

@group(0) @binding(0) var<uniform> shape: Shape;
@group(0) @binding(1) var<storage, read> known: array<vec4f>;
@group(0) @binding(2) var<storage, read> base: array<vec4f>;
@group(0) @binding(3) var<storage, read_write> blended: array<vec4f>;

@group(0) @binding(1) var<storage, read> input: array<vec4f>;
@group(0) @binding(2) var<storage, read_write> smoothed: array<vec4f>;

/// Fills weighted pixels from the picture of half the resolution: c + (1 − w) · base.
@compute @workgroup_size(8, 8)
fn blend(@builtin(global_invocation_id) at: vec3u) {
    if !is_inside(shape, at) {
        return;
    }
    let around = pixels_around(at.xy, vec2u(shape.width, shape.height) / 2u);
    let filling = between(base[around.x], base[around.y], base[around.z], base[around.w]);
    let i = place(shape, at.x, at.y, 0u);
    let pixel = known[i];
    blended[i] = vec4f(pixel.rgb + (1.0 - pixel.a) * filling.rgb, 0.0);
}

/// Smooths row `y` of block `z` by (1, 2, 1)/4 around `x`.
fn smoothed_row(x: u32, y: u32, z: u32) -> vec4f {
    let left = input[place(shape, max(x, 1u) - 1u, y, z)];
    let right = input[place(shape, min(x + 1u, shape.width - 1u), y, z)];
    return 0.25 * (left + right) + 0.5 * input[place(shape, x, y, z)];
}

/// Smooths by (1, 2, 1)/4 along both axes, replicated at the border.
@compute @workgroup_size(8, 8)
fn smooth_input(@builtin(global_invocation_id) at: vec3u) {
    if !is_inside(shape, at) {
        return;
    }
    let above = smoothed_row(at.x, max(at.y, 1u) - 1u, at.z);
    let below = smoothed_row(at.x, min(at.y + 1u, shape.height - 1u), at.z);
    smoothed[place(shape, at.x, at.y, at.z)] = 0.25 * (above + below) + 0.5 * smoothed_row(at.x, at.y, at.z);
}
