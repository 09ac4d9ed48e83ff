// Loads the inputs of a network from a sparse frame, and writes its output to a frame. Twin of the ends of
// cpu/engine/network.rs.

/// Shape of the frame.
@group(0) @binding(0) var<uniform> frame: Shape;
/// Shape of the input or output tensor, which is padded at the right and at the bottom.
@group(0) @binding(1) var<uniform> padded: Shape;
/// Sparse frame, row by row; alpha is 1 where a pixel was sampled.
@group(0) @binding(2) var<storage, read> sparse: array<vec4f>;
/// Motion: for each pixel the way to its position in the last frame.
@group(0) @binding(2) var<storage, read> motion: array<vec2f>;
@group(0) @binding(2) var<storage, read> picture: array<vec4f>;
@group(0) @binding(3) var<storage, read_write> tensor: array<vec4f>;

/// Index of the frame's pixel that is nearest to pixel `at` of the padded tensor.
fn nearest(at: vec3u) -> u32 {
    return min(at.y, frame.height - 1u) * frame.width + min(at.x, frame.width - 1u);
}

/// Sampled colour in 0…1 and weight 1, or zeros where not sampled.
fn known(at: vec3u) -> vec4f {
    let pixel = sparse[nearest(at)];
    let finite = is_finite(pixel.r) && is_finite(pixel.g) && is_finite(pixel.b) && is_finite(pixel.a);
    if finite && pixel.a > 0.5 {
        return vec4f(clamp(pixel.rgb, vec3f(0.0), vec3f(1.0)), 1.0);
    }
    return vec4f(0.0);
}

/// Loads colours and, as a fourth channel, the sample mask.
@compute @workgroup_size(8, 8)
fn load_colour(@builtin(global_invocation_id) at: vec3u) {
    if is_inside(padded, at) {
        tensor[place(padded, at.x, at.y, 0u)] = known(at);
    }
}

/// Loads the sample mask.
@compute @workgroup_size(8, 8)
fn load_mask(@builtin(global_invocation_id) at: vec3u) {
    if is_inside(padded, at) {
        tensor[place(padded, at.x, at.y, 0u)] = vec4f(known(at).a, 0.0, 0.0, 0.0);
    }
}

@compute @workgroup_size(8, 8)
fn load_motion(@builtin(global_invocation_id) at: vec3u) {
    if is_inside(padded, at) {
        tensor[place(padded, at.x, at.y, 0u)] = vec4f(motion[nearest(at)], 0.0, 0.0);
    }
}

/// Writes the top left of the output to the frame, clamped to 0…1 and opaque.
@compute @workgroup_size(8, 8)
fn show(@builtin(global_invocation_id) at: vec3u) {
    if at.x < frame.width && at.y < frame.height {
        let pixel = picture[place(padded, at.x, at.y, 0u)];
        tensor[at.y * frame.width + at.x] = vec4f(clamp(pixel.rgb, vec3f(0.0), vec3f(1.0)), 1.0);
    }
}
