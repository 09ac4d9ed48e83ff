// Accumulation of samples of earlier frames. Twin of cpu/history/accumulate.rs.

/// Factor of the weights of earlier samples.
override FADE: f32;
/// Whether there is a confidence map for earlier samples.
override IS_SHARED: bool;
/// Number of times that the resolution of this map is halved.
override SHARE_LEVEL: u32;

@group(0) @binding(0) var<uniform> shape: Shape;
@group(0) @binding(1) var<storage, read> known: array<vec4f>;
@group(0) @binding(2) var<storage, read> before: array<vec4f>;
@group(0) @binding(3) var<storage, read> share: array<vec4f>;
@group(0) @binding(4) var<storage, read_write> accumulated: array<vec4f>;

/// Points of the last frame, which the motion moves first.
@group(0) @binding(2) var<storage, read> points: array<vec4f>;
@group(0) @binding(5) var<storage, read> motion: array<vec4f>;

/// Confidence in earlier samples at pixel `at`: bilinear between the centres of squares, replicated at the border.
fn believed(at: vec2u) -> f32 {
    let size = vec2u(shape.width, shape.height) >> vec2u(SHARE_LEVEL);
    let scale = f32(1u << SHARE_LEVEL);
    let wanted = clamp((vec2f(at) + 0.5) / scale - 0.5, vec2f(0.0), vec2f(size - 1u));
    let first = vec2u(wanted);
    let second = min(first + 1u, size - 1u);
    let t = wanted - vec2f(first);
    let above = mix(share[first.y * size.x + first.x].r, share[first.y * size.x + second.x].r, t.x);
    let below = mix(share[second.y * size.x + first.x].r, share[second.y * size.x + second.x].r, t.x);
    return mix(above, below, t.y);
}

/// Factor of the weights of earlier samples at pixel `at`.
fn share_at(at: vec2u) -> f32 {
    if IS_SHARED {
        return FADE * believed(at);
    }
    return FADE;
}

@compute @workgroup_size(8, 8)
fn accumulate(@builtin(global_invocation_id) at: vec3u) {
    if !is_inside(shape, at) {
        return;
    }
    let i = place(shape, at.x, at.y, 0u);
    let open = 1.0 - known[i].a;
    // Further blocks hold the offsets of points.
    if at.z > 0u {
        let j = place(shape, at.x, at.y, at.z);
        accumulated[j] = open * before[j];
        return;
    }
    accumulated[i] = known[i] + (open * share_at(at.xy)) * before[i];
}

/// Moves the points of the last frame along the motion and accumulates them.
@compute @workgroup_size(8, 8)
fn accumulate_moved(@builtin(global_invocation_id) at: vec3u) {
    if at.x >= shape.width || at.y >= shape.height {
        return;
    }
    let i = place(shape, at.x, at.y, 0u);
    let open = 1.0 - known[i].a;
    let point = reprojected_point(at.xy);
    accumulated[i] = known[i] + (open * share_at(at.xy)) * point.known;
    accumulated[place(shape, at.x, at.y, 1u)] = open * vec4f(point.apart, 0.0, 0.0);
}
