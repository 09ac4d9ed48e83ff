// Pull-push pyramid of weighted pixels. Twin of cpu/fill/pyramid.rs, and of the code before and after it in
// cpu/fill/spread.rs and cpu/history/accumulate.rs.

/// Input of the pyramid: weighted pixels, their residuals, or their mean squared residuals. Residuals are relative
/// to a picture of half the resolution; squares also to one of full resolution.
override PULLED: u32;
/// Output: the picture, the picture added to another one, or the confidence in earlier samples.
override MADE: u32;
/// Whether there is a coarser level to push from.
override IS_PUSHED: bool;
/// Equal to the constants of plan/layers/history_confidence.rs.
override CONFIDENCE_EPSILON: f32;
override CONFIDENCE_ALLOWED: f32;
override CONFIDENCE_SHARE: f32;

const DIFFERENCES = 1u;
const SQUARES = 2u;
const CORRECTED = 1u;
const BELIEVED = 2u;

/// Pixels of a workgroup along each axis.
const TILE = 8u;
/// Source pixels of a workgroup along each axis.
const PATCH = 2u * TILE + 2u;

/// Shape of the output.
@group(0) @binding(0) var<uniform> shape: Shape;
@group(0) @binding(1) var<storage, read> finer: array<vec4f>;
@group(0) @binding(2) var<storage, read> prior: array<vec4f>;
@group(0) @binding(3) var<storage, read> fresh: array<vec4f>;
@group(0) @binding(4) var<storage, read_write> pulled: array<vec4f>;

@group(0) @binding(1) var<storage, read> coarser: array<vec4f>;
@group(0) @binding(2) var<storage, read_write> pushed: array<vec4f>;

@group(0) @binding(2) var<storage, read> level: array<vec4f>;
@group(0) @binding(3) var<storage, read> base: array<vec4f>;
@group(0) @binding(4) var<storage, read_write> made: array<vec4f>;

var<workgroup> patch_pixels: array<vec4f, PATCH * PATCH>;

/// Interpolates the picture of half the resolution at pixel `at` of twice its resolution.
fn doubled_fresh(at: vec2u) -> vec3f {
    let i = pixels_around(at, vec2u(shape.width, shape.height));
    return between(fresh[i.x], fresh[i.y], fresh[i.z], fresh[i.w]).rgb;
}

fn mean_square(known: vec4f, expected: vec3f) -> f32 {
    let apart = known.rgb - known.a * expected;
    return dot(apart, apart) / 3.0;
}

/// Input of the pyramid at pixel `at` of twice the resolution.
fn known(at: vec2u) -> vec4f {
    let i = at.y * 2u * shape.width + at.x;
    let found = finer[i];
    // A pixel of weight 0 has no residual.
    if PULLED == 0u || all(found == vec4f(0.0)) {
        return found;
    }
    if PULLED == DIFFERENCES {
        return vec4f(found.rgb - found.a * doubled_fresh(at), found.a);
    }
    return vec4f(mean_square(found, prior[i].rgb), mean_square(found, doubled_fresh(at)), 0.0, found.a);
}

/// Binomial mean of four pixels of the patch, one below the other.
fn blended(i: u32) -> vec4f {
    return binomial(patch_pixels[i], patch_pixels[i + PATCH], patch_pixels[i + 2u * PATCH], patch_pixels[i + 3u * PATCH]);
}

/// Pulls to half the resolution: means over 4×4 pixels, replicated at the border.
@compute @workgroup_size(TILE, TILE)
fn pull(
    @builtin(workgroup_id) group: vec3u,
    @builtin(global_invocation_id) at: vec3u,
    @builtin(local_invocation_id) local: vec3u,
    @builtin(local_invocation_index) thread: u32,
) {
    let last = 2 * vec2i(vec2u(shape.width, shape.height)) - 1;
    let corner = 2 * vec2i(TILE * group.xy) - 1;
    for (var i = thread; i < PATCH * PATCH; i += TILE * TILE) {
        patch_pixels[i] = known(vec2u(clamp(corner + vec2i(vec2u(i % PATCH, i / PATCH)), vec2i(0), last)));
    }
    workgroupBarrier();
    if !is_inside(shape, at) {
        return;
    }
    let first = 2u * local.y * PATCH + 2u * local.x;
    let mean = binomial(blended(first), blended(first + 1u), blended(first + 2u), blended(first + 3u));
    pulled[at.y * shape.width + at.x] = gained(mean);
}

/// Interpolates the coarser level at pixel `at`.
fn doubled_coarser(at: vec2u) -> vec4f {
    let i = pixels_around(at, vec2u(shape.width, shape.height) / 2u);
    return between(coarser[i.x], coarser[i.y], coarser[i.z], coarser[i.w]);
}

/// Pushes: adds the coarser level, by the weight that is missing to 1.
@compute @workgroup_size(8, 8)
fn push(@builtin(global_invocation_id) at: vec3u) {
    if is_inside(shape, at) {
        let i = at.y * shape.width + at.x;
        pushed[i] += (1.0 - pushed[i].a) * doubled_coarser(at.xy);
    }
}

/// Confidence in earlier samples, given the mean squared residuals of both pictures.
fn believed(squares: vec3f) -> f32 {
    let v = squares.g + CONFIDENCE_EPSILON;
    return v / (v + CONFIDENCE_SHARE * max(squares.r - CONFIDENCE_ALLOWED * v, 0.0));
}

/// Pushes to the last level and computes the output from it.
@compute @workgroup_size(8, 8)
fn make(@builtin(global_invocation_id) at: vec3u) {
    if !is_inside(shape, at) {
        return;
    }
    let i = at.y * shape.width + at.x;
    var found = level[i];
    if IS_PUSHED {
        found += (1.0 - found.a) * doubled_coarser(at.xy);
    }
    let numbers = found.rgb / max(found.a, SMALLEST);
    switch MADE {
        case CORRECTED: { made[i] = vec4f(numbers + base[i].rgb, 0.0); }
        case BELIEVED: { made[i] = vec4f(believed(numbers), 0.0, 0.0, 0.0); }
        default: { made[i] = vec4f(numbers, 0.0); }
    }
}
