// Image formation. Twin of cpu/march.rs.

/// A primary ray ends at this accumulated opacity.
const OPAQUE: f32 = 0.999;

/// Kind of shadows: `UNSHADOWED`, `RAYS` or `CACHED`.
override SHADOWS: u32 = 0;
const UNSHADOWED: u32 = 0;
const RAYS: u32 = 1;
const CACHED: u32 = 2;
/// Whether surfaces are shaded by their gradient.
override GRADIENT: bool = false;
/// Whether colours without shadow rays are kept.
override GUIDE: bool = false;
/// Whether pixels outside the mask end at once.
override REJECT: bool = false;

/// The pixels to march, packed.
@group(1) @binding(2) var<storage, read> list: array<u32>;
@group(1) @binding(3) var<storage, read> list_length: ListLength;
@group(1) @binding(4) var<storage, read> mask: array<u32>;
/// Red, green, blue over the background, and opacity (in lists) or 1 (in frames).
@group(1) @binding(5) var<storage, read_write> colours: array<vec4f>;
/// One over the distance from the eye at which opacity passes one half, in world units; 0 where nothing shows. In lists it is
/// followed by red, green and blue without shadows, before the background.
@group(1) @binding(6) var<storage, read_write> inverse_depths: array<f32>;

/// Result of a ray.
struct RayResult {
    colour: vec3f,
    /// The colour without shadow rays, before the background. Kept for lists only.
    unshadowed: vec3f,
    opacity: f32,
    inverse_depth: f32,
}

/// |n·l| with n from central differences over ±1 voxel in world units. It is 1 where the gradient is zero, or unknown beside
/// NaN.
fn facing(p: vec3f) -> f32 {
    let x = vec3f(1.0, 0.0, 0.0);
    let y = vec3f(0.0, 1.0, 0.0);
    let z = vec3f(0.0, 0.0, 1.0);
    let after = vec3f(field(p + x), field(p + y), field(p + z));
    let before = vec3f(field(p - x), field(p - y), field(p - z));
    if GAPS && any(max(after, before) > vec3f(f32(scene.last_entry) + 0.5)) {
        return 1.0;
    }
    let gradient = (after - before) * scene.to_voxels;
    let steepness = length(gradient);
    if steepness > 0.0 {
        return abs(dot(gradient, scene.light_direction) / steepness);
    }
    return 1.0;
}

/// Factors of the colour at `p`: ambient + (1 − ambient)·T·|n·l|, and the same without shadow rays.
fn light(p: vec3f) -> vec2f {
    var light = vec2f(1.0);
    if SHADOWS == RAYS {
        light.x = transmittance(p);
    } else if SHADOWS == CACHED {
        light = vec2f(cached_transmittance(p));
    }
    if GRADIENT {
        light *= facing(p);
    }
    return scene.ambient + (1.0 - scene.ambient) * light;
}

/// Unpacks a colour of the transfer table.
fn colour_of(bits: u32) -> vec3f {
    let fields = vec3u(bits & 0x7FFu, bits >> 11u & 0x7FFu, bits >> 22u);
    return vec3f(fields) * vec3f(1.0 / 2047.0, 1.0 / 2047.0, 1.0 / 1023.0);
}

/// Marches the ray through the centre of `pixel`.
fn march(pixel: vec2u) -> RayResult {
    let segment = segment_of(pixel);
    if FINE {
        return fine_march(segment);
    }
    let inverse = inverse_of(segment.delta);
    var colour = vec3f(0.0);
    var unshadowed = vec3f(0.0);
    var opacity = 0.0;
    var half_at = -1.0;
    var weighted_number = 0.0;
    var k = 0.0;
    // Samples before this one may be visible.
    var known = 0.0;
    while k < segment.count && opacity < OPAQUE {
        let p = fma(vec3f(k), segment.delta, segment.start);
        if SKIP && k >= known {
            let ahead = look_ahead(p, inverse);
            known = k + ahead.steps;
            if ahead.empty {
                k = known;
                continue;
            }
        }
        let looks = appearance[entry(field(p))];
        let alpha = bitcast<f32>(looks.x);
        if alpha > 0.0 {
            let weight = alpha * (1.0 - opacity);
            let lit = weight * light(p);
            let rgb = colour_of(looks.y);
            colour += lit.x * rgb;
            if GUIDE {
                unshadowed += lit.y * rgb;
            }
            opacity += weight;
            weighted_number = fma(weight, k, weighted_number);
            if half_at < 0.0 && opacity >= 0.5 {
                half_at = k;
            }
        }
        k += 1.0;
    }
    colour += (1.0 - opacity) * scene.background;
    if opacity == 0.0 {
        return RayResult(colour, unshadowed, 0.0, 0.0);
    }
    let number = select(half_at, weighted_number / opacity, half_at < 0.0);
    return RayResult(colour, unshadowed, opacity, 1.0 / fma(number, scene.delta, segment.distance));
}

/// Marches the pixels of the list. Results are in list order.
@compute @workgroup_size(LIST_GROUP)
fn march_list(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) thread: u32) {
    let i = list_position(group, thread);
    if i >= list_length.pixels {
        return;
    }
    let marched = march(unpacked(list[i]));
    colours[i] = vec4f(marched.colour, marched.opacity);
    inverse_depths[4u * i] = marched.inverse_depth;
    inverse_depths[4u * i + 1u] = marched.unshadowed.r;
    inverse_depths[4u * i + 2u] = marched.unshadowed.g;
    inverse_depths[4u * i + 3u] = marched.unshadowed.b;
}

/// Marches every pixel, or those of the mask. Results are at the places of their pixels.
@compute @workgroup_size(8, 8)
fn march_frame(@builtin(global_invocation_id) pixel: vec3u) {
    if pixel.x >= extent.width || pixel.y >= extent.height {
        return;
    }
    if REJECT {
        if (mask[pixel.y * words_per_row(extent) + pixel.x / 32u] >> (pixel.x % 32u) & 1u) == 0u {
            return;
        }
    }
    let i = pixel.y * extent.width + pixel.x;
    let marched = march(pixel.xy);
    colours[i] = vec4f(marched.colour, 1.0);
    inverse_depths[i] = marched.inverse_depth;
}
