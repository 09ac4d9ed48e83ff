// Distances of the pixels, from samples of this and of earlier frames. Twin of src/motion/depths.rs.

// Inverse distances of sampled pixels, 0 elsewhere: of this frame, or for `splat` of an earlier one.
@group(0) @binding(1) var<storage, read> inverse_depths: array<f32>;
// Bits of the largest inverse distance from earlier frames. Positive numbers have the order of their bits.
@group(0) @binding(2) var<storage, read_write> nearest: array<atomic<u32>>;
// Samples of this frame.
@group(0) @binding(3) var<storage, read> sparse: array<vec4f>;
// Known inverse distances as a sparse frame: in red, with alpha 1 where known.
@group(0) @binding(4) var<storage, read_write> known: array<vec4f>;
// The filled frame.
@group(0) @binding(5) var<storage, read> filled: array<vec4f>;
// Red of the filled frame.
@group(0) @binding(6) var<storage, read_write> inverse_filled: array<f32>;

fn known_as(inverse: f32) -> vec4f {
    return select(vec4f(0.0), vec4f(inverse, 0.0, 0.0, 1.0), inverse > 0.0);
}

/// Takes the inverse distances of this frame's samples.
@compute @workgroup_size(8, 8)
fn know(@builtin(global_invocation_id) at: vec3u) {
    if is_inside(at.xy) {
        let i = at.y * reprojection.width + at.x;
        known[i] = known_as(inverse_depths[i]);
    }
}

/// Splats the samples of an earlier frame into this one.
@compute @workgroup_size(8, 8)
fn splat(@builtin(global_invocation_id) at: vec3u) {
    if !is_inside(at.xy) {
        return;
    }
    let inverse = inverse_depths[at.y * reprojection.width + at.x];
    let pixel = vec2f(at.xy);
    let seen = seen_from_there(pixel, inverse);
    if inverse <= 0.0 || seen.x <= 1e-6 {
        return;
    }
    let place = floor(place_of(seen) + 0.5);
    if place.x < 0.0 || place.y < 0.0 || place.x >= f32(reprojection.width) || place.y >= f32(reprojection.height) {
        return;
    }
    let away = length(vec3f(seen.x, seen.y * reprojection.half_width, seen.z * reprojection.half_height));
    let bits = bitcast<u32>(nearness(pixel, inverse) / away);
    atomicMax(&nearest[u32(place.y) * reprojection.width + u32(place.x)], bits);
}

/// Combines all frames. Samples of this frame take precedence.
@compute @workgroup_size(8, 8)
fn know_all(@builtin(global_invocation_id) at: vec3u) {
    if is_inside(at.xy) {
        let i = at.y * reprojection.width + at.x;
        known[i] = known_as(select(bitcast<f32>(atomicLoad(&nearest[i])), inverse_depths[i], sparse[i].a > 0.5));
    }
}

/// Keeps red of the filled frame.
@compute @workgroup_size(8, 8)
fn keep(@builtin(global_invocation_id) at: vec3u) {
    if is_inside(at.xy) {
        let i = at.y * reprojection.width + at.x;
        inverse_filled[i] = filled[i].x;
    }
}
