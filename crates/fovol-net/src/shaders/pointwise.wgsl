// Pointwise layers. Twin of cpu/layers/pointwise.rs.

override FACTOR: f32;
override OFFSET: f32;

@group(0) @binding(0) var<uniform> shape: Shape;
@group(0) @binding(1) var<storage, read> input: array<vec4f>;
@group(0) @binding(2) var<storage, read_write> changed: array<vec4f>;
/// Second summand, or the sampled colours.
@group(0) @binding(3) var<storage, read> more: array<vec4f>;
@group(0) @binding(4) var<storage, read> mask: array<vec4f>;

/// Computes factor · x + offset.
@compute @workgroup_size(8, 8)
fn scale(@builtin(global_invocation_id) at: vec3u) {
    if is_inside(shape, at) {
        let i = place(shape, at.x, at.y, at.z);
        changed[i] = input[i] * FACTOR + OFFSET;
    }
}

/// Clamps x to 0…1.
@compute @workgroup_size(8, 8)
fn clamp_input(@builtin(global_invocation_id) at: vec3u) {
    if is_inside(shape, at) {
        let i = place(shape, at.x, at.y, at.z);
        changed[i] = clamp(input[i], vec4f(0.0), vec4f(1.0));
    }
}

/// Computes x + more.
@compute @workgroup_size(8, 8)
fn add(@builtin(global_invocation_id) at: vec3u) {
    if is_inside(shape, at) {
        let i = place(shape, at.x, at.y, at.z);
        changed[i] = input[i] + more[i];
    }
}

/// Computes x + more, with groups of four channels of `more` unfolded into 2×2 pixels.
@compute @workgroup_size(8, 8)
fn add_unfolded(@builtin(global_invocation_id) at: vec3u) {
    if is_inside(shape, at) {
        let i = place(shape, at.x, at.y, at.z);
        let part = 2u * (at.y % 2u) + at.x % 2u;
        let size = vec2u(shape.width, shape.height) / 2u;
        let first = (4u * at.z * size.y + at.y / 2u) * size.x + at.x / 2u;
        let blocks = min(4u, shape.channels - 4u * at.z);
        var unfolded = vec4f(0.0);
        for (var c = 0u; c < blocks; c += 1u) {
            unfolded[c] = more[first + c * size.y * size.x][part];
        }
        changed[i] = input[i] + unfolded;
    }
}

/// Computes mask · colour + (1 − mask) · x.
@compute @workgroup_size(8, 8)
fn bypass(@builtin(global_invocation_id) at: vec3u) {
    if is_inside(shape, at) {
        let i = place(shape, at.x, at.y, at.z);
        let m = mask[place(shape, at.x, at.y, 0u)].r;
        changed[i] = m * more[i] + (1.0 - m) * input[i];
    }
}

/// Computes mask · colour + (1 − mask) · x, with the mask as the fourth channel of the colours.
@compute @workgroup_size(8, 8)
fn bypass_known(@builtin(global_invocation_id) at: vec3u) {
    if is_inside(shape, at) {
        let i = place(shape, at.x, at.y, at.z);
        let colour = more[i];
        changed[i] = colour.a * colour + (1.0 - colour.a) * input[i];
    }
}
