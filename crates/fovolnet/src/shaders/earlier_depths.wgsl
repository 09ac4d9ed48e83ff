// Distances of samples of earlier frames, seen from this one. Twin of src/motion/depths.rs.

/// Earlier frames, and the reprojection from each to this one.
const REMEMBERED: u32 = 6u;
@group(0) @binding(0) var<uniform> reprojections: array<Reprojection, REMEMBERED>;
// Inverse distances of the samples of each earlier frame, 0 elsewhere.
@group(0) @binding(1) var<storage, read> inverse_depths_0: array<f32>;
@group(0) @binding(2) var<storage, read> inverse_depths_1: array<f32>;
@group(0) @binding(3) var<storage, read> inverse_depths_2: array<f32>;
@group(0) @binding(4) var<storage, read> inverse_depths_3: array<f32>;
@group(0) @binding(5) var<storage, read> inverse_depths_4: array<f32>;
@group(0) @binding(6) var<storage, read> inverse_depths_5: array<f32>;
// Bits of the largest inverse distance from earlier frames. Positive numbers have the order of their bits.
@group(0) @binding(7) var<storage, read_write> nearest: array<atomic<u32>>;

/// The reprojection of a thread.
var<private> reprojection: Reprojection;

/// Inverse distance of pixel number `i` of an earlier frame.
fn earlier(frame: u32, i: u32) -> f32 {
    switch frame {
        case 0u: { return inverse_depths_0[i]; }
        case 1u: { return inverse_depths_1[i]; }
        case 2u: { return inverse_depths_2[i]; }
        case 3u: { return inverse_depths_3[i]; }
        case 4u: { return inverse_depths_4[i]; }
        default: { return inverse_depths_5[i]; }
    }
}

/// Splats the samples of earlier frames into this one.
@compute @workgroup_size(8, 8)
fn splat(@builtin(global_invocation_id) at: vec3u) {
    reprojection = reprojections[at.z];
    if !is_inside(at.xy) {
        return;
    }
    let inverse = earlier(at.z, at.y * reprojection.width + at.x);
    let pixel = vec2f(at.xy);
    let seen = seen_from_there(pixel, inverse);
    if inverse <= 0.0 || seen.x <= 1e-6 {
        return;
    }
    let place = floor(place_of(seen) + 0.5);
    if place.x < 0.0 || place.y < 0.0 || place.x >= f32(reprojection.width) || place.y >= f32(reprojection.height) {
        return;
    }
    let bits = bitcast<u32>(inverse_from_there(pixel, inverse, seen));
    atomicMax(&nearest[u32(place.y) * reprojection.width + u32(place.x)], bits);
}
