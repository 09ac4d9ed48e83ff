// Light ratios of samples, and colours from light ratios. Twin of src/guide/light_ratio.rs.

/// Twin of `RatioSettings` in pipeline/gpu/guide/light_ratio.rs.
struct RatioSettings {
    /// First column and row of the guide's region, and its columns and rows.
    region_from: vec2u,
    region_size: vec2u,
    /// Width and height of the frame.
    size: vec2u,
    /// Colour behind everything.
    background: vec3f,
    /// By how much pixels can be brighter than the guide.
    headroom: f32,
}

/// ε, and the least sum of a guide's channels that has a ratio.
const EPSILON: f32 = 0.02;
const FAINT: f32 = 4.5 / 255.0;

@group(0) @binding(0) var<uniform> settings: RatioSettings;
/// Samples of the frame: alpha is 1 where there is one.
@group(0) @binding(1) var<storage, read> sparse: array<vec4f>;
/// Guide pixels of the region, row by row.
@group(0) @binding(2) var<storage, read> guide: array<vec4f>;
/// For `compose` the light ratio of every pixel.
@group(0) @binding(3) var<storage, read> filled: array<vec4f>;
/// From `light_ratios` the light ratios of the samples, with alpha 1; from `compose` the frame.
@group(0) @binding(4) var<storage, read_write> made: array<vec4f>;

fn is_inside(pixel: vec2u) -> bool {
    return all(pixel < settings.size);
}

/// Whether the guide has `pixel`.
fn is_guided(pixel: vec2u) -> bool {
    // Left of or above the region the difference wraps round to a large number.
    return all(pixel - settings.region_from < settings.region_size);
}

fn guide_at(pixel: vec2u) -> vec4f {
    let at = pixel - settings.region_from;
    return guide[at.y * settings.region_size.x + at.x];
}

@compute @workgroup_size(8, 8)
fn light_ratios(@builtin(global_invocation_id) at: vec3u) {
    if !is_inside(at.xy) {
        return;
    }
    let i = at.y * settings.size.x + at.x;
    var ratio = vec4f(0.0);
    if sparse[i].a > 0.5 && is_guided(at.xy) {
        let guide = guide_at(at.xy);
        if guide.r + guide.g + guide.b > FAINT {
            let colour = sparse[i].rgb - (1.0 - guide.a) * settings.background;
            let whole = settings.headroom * (guide.rgb + EPSILON);
            ratio = vec4f(clamp((colour + EPSILON) / whole, vec3f(0.0), vec3f(1.0)), 1.0);
        }
    }
    made[i] = ratio;
}

@compute @workgroup_size(8, 8)
fn compose(@builtin(global_invocation_id) at: vec3u) {
    if !is_inside(at.xy) {
        return;
    }
    let i = at.y * settings.size.x + at.x;
    var colour = settings.background;
    if sparse[i].a > 0.5 {
        colour = sparse[i].rgb;
    } else if is_guided(at.xy) {
        let guide = guide_at(at.xy);
        let lit = max(settings.headroom * (guide.rgb + EPSILON) * filled[i].rgb - EPSILON, vec3f(0.0));
        colour = lit + (1.0 - guide.a) * settings.background;
    }
    made[i] = vec4f(clamp(colour, vec3f(0.0), vec3f(1.0)), 1.0);
}
