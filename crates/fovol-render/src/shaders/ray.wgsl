// Image formation: what every way to march shares. Twin of cpu/march.rs.

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
/// Whether results of the list go to the places of their pixels in the frame.
override STRAIGHT: bool = false;

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

/// Factors of the colour at `p`, which the share `arriving` of the light reaches: ambient + (1 − ambient)·T·|n·l|, and the same
/// without shadow rays.
fn light_of(p: vec3f, arriving: f32) -> vec2f {
    var light = vec2f(arriving, select(arriving, 1.0, SHADOWS == RAYS));
    if GRADIENT {
        light *= facing(p);
    }
    return scene.ambient + (1.0 - scene.ambient) * light;
}

/// Factors of the colour at `p`; see `light_of`.
fn light(p: vec3f) -> vec2f {
    var arriving = 1.0;
    if SHADOWS == RAYS {
        arriving = transmittance(p);
    } else if SHADOWS == CACHED {
        arriving = cached_transmittance(p);
    }
    return light_of(p, arriving);
}

/// Sums of a ray so far.
struct Sums {
    colour: vec3f,
    /// The colour without shadow rays.
    unshadowed: vec3f,
    opacity: f32,
    /// Number of the sample that took opacity past one half; negative before.
    half_at: f32,
    weighted_number: f32,
}

/// Sums of a ray without samples.
fn no_sums() -> Sums {
    return Sums(vec3f(0.0), vec3f(0.0), 0.0, -1.0, 0.0);
}

/// Adds sample `number` of opacity `alpha` to all sums but the colours; returns its weight.
fn cover(sums: ptr<function, Sums>, number: f32, alpha: f32) -> f32 {
    let weight = alpha * (1.0 - (*sums).opacity);
    (*sums).opacity += weight;
    (*sums).weighted_number = fma(weight, number, (*sums).weighted_number);
    if (*sums).half_at < 0.0 && (*sums).opacity >= 0.5 {
        (*sums).half_at = number;
    }
    return weight;
}

/// Adds a sample of `weight` and packed colour `bits`, lit by `light`, to the colours.
fn shine(sums: ptr<function, Sums>, weight: f32, bits: u32, light: vec2f) {
    let lit = weight * light;
    let rgb = colour_of(bits);
    (*sums).colour += lit.x * rgb;
    if GUIDE {
        (*sums).unshadowed += lit.y * rgb;
    }
}

/// Result of the ray of `segment`.
fn result_of(sums: Sums, segment: Segment) -> RayResult {
    let colour = sums.colour + (1.0 - sums.opacity) * scene.background;
    if sums.opacity == 0.0 {
        return RayResult(colour, sums.unshadowed, 0.0, 0.0);
    }
    let number = select(sums.half_at, sums.weighted_number / sums.opacity, sums.half_at < 0.0);
    return RayResult(colour, sums.unshadowed, sums.opacity, 1.0 / fma(number, scene.delta, segment.distance));
}

/// Whether `pixel` is in the mask.
fn is_masked(pixel: vec2u) -> bool {
    return (mask[pixel.y * words_per_row(extent) + pixel.x / 32u] >> (pixel.x % 32u) & 1u) != 0u;
}

/// Stores the result of pixel `i` of the list.
fn put_in_list(i: u32, marched: RayResult) {
    colours[i] = vec4f(marched.colour, marched.opacity);
    inverse_depths[4u * i] = marched.inverse_depth;
    inverse_depths[4u * i + 1u] = marched.unshadowed.r;
    inverse_depths[4u * i + 2u] = marched.unshadowed.g;
    inverse_depths[4u * i + 3u] = marched.unshadowed.b;
}

/// Stores the result of pixel `i` of the list, which is `pixel`, where it is wanted.
fn put_listed(i: u32, pixel: vec2u, marched: RayResult) {
    if STRAIGHT {
        put_in_frame(pixel, marched);
    } else {
        put_in_list(i, marched);
    }
}

/// Stores the result of `pixel` of the frame.
fn put_in_frame(pixel: vec2u, marched: RayResult) {
    let i = pixel.y * extent.width + pixel.x;
    colours[i] = vec4f(marched.colour, 1.0);
    inverse_depths[i] = marched.inverse_depth;
}
