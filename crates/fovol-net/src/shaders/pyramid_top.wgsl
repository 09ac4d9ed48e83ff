// The three coarsest levels of a pull-push pyramid, pulled and pushed back by one dispatch. Same numbers as pulls and pushes of
// pyramid.wgsl, one level after the other. Twin of cpu/fill/pyramid.rs.
//
// A workgroup fills 8×8 pixels of the finest of the three levels. It pulls all that these depend on, so that neighbouring
// workgroups pull some pixels twice. `low`, `middle` and `high` are the levels, the finest first.

/// Filled pixels of a workgroup along each axis.
const TILE = 8u;
/// Pixels of each level along each axis that a workgroup pulls.
const LOW = 22u;
const MIDDLE = 10u;
const HIGH = 4u;
/// Pixels of `low` and `middle` before the first one that is filled.
const BEFORE_LOW = 7;
const BEFORE_MIDDLE = 3;

/// Shape of `low`.
@group(0) @binding(0) var<uniform> shape: Shape;
/// Level of twice the resolution of `low`.
@group(0) @binding(1) var<storage, read> finer: array<vec4f>;
/// Filled pixels of `low`.
@group(0) @binding(2) var<storage, read_write> filled: array<vec4f>;

var<workgroup> low: array<vec4f, LOW * LOW>;
var<workgroup> middle: array<vec4f, MIDDLE * MIDDLE>;
var<workgroup> high: array<vec4f, HIGH * HIGH>;

/// Positions along an axis of the four pixels that pixel `at` of half the resolution is a mean of, replicated at the border.
fn four(at: i32, count: i32) -> vec4i {
    return clamp(2 * at + vec4i(-1, 0, 1, 2), vec4i(0), vec4i(count - 1));
}

/// Mean of four pixels of `finer` in column `x`.
fn mean_of_finer(x: i32, rows: vec4i) -> vec4f {
    let i = vec4u(rows) * (2u * shape.width) + u32(x);
    return binomial(finer[i.x], finer[i.y], finer[i.z], finer[i.w]);
}

/// Mean of four pixels of `low` in column `x`; positions are within the workgroup's own pixels.
fn mean_of_low(x: i32, rows: vec4i) -> vec4f {
    let i = vec4u(rows) * LOW + u32(x);
    return binomial(low[i.x], low[i.y], low[i.z], low[i.w]);
}

fn mean_of_middle(x: i32, rows: vec4i) -> vec4f {
    let i = vec4u(rows) * MIDDLE + u32(x);
    return binomial(middle[i.x], middle[i.y], middle[i.z], middle[i.w]);
}

/// Position of pixel `i` of a square of `edge` pixels that begins at `first`.
fn position(i: u32, edge: u32, first: vec2i) -> vec2i {
    return first + vec2i(vec2u(i % edge, i / edge));
}

fn is_between(at: vec2i, size: vec2i) -> bool {
    return all(at >= vec2i(0)) && all(at < size);
}

/// The pixel of half the resolution that is nearest to a pixel along an axis, and the next one, replicated at the border.
fn two(at: i32, count: i32) -> vec2i {
    let near = at / 2;
    return vec2i(near, select(max(near - 1, 0), min(near + 1, count - 1), at % 2 == 1));
}

/// Fills a pixel of `middle` from `high`, whose first pixel is `first`.
fn doubled_high(at: vec2i, size: vec2i, first: vec2i) -> vec4f {
    let x = vec2u(two(at.x, size.x) - first.x);
    let y = vec2u(two(at.y, size.y) - first.y) * HIGH;
    return between(high[y[0] + x[0]], high[y[0] + x[1]], high[y[1] + x[0]], high[y[1] + x[1]]);
}

/// Fills a pixel of `low` from `middle`, whose first pixel is `first`.
fn doubled_middle(at: vec2i, size: vec2i, first: vec2i) -> vec4f {
    let x = vec2u(two(at.x, size.x) - first.x);
    let y = vec2u(two(at.y, size.y) - first.y) * MIDDLE;
    return between(middle[y[0] + x[0]], middle[y[0] + x[1]], middle[y[1] + x[0]], middle[y[1] + x[1]]);
}

@compute @workgroup_size(TILE, TILE)
fn turn(
    @builtin(workgroup_id) group: vec3u,
    @builtin(global_invocation_id) at: vec3u,
    @builtin(local_invocation_id) local: vec3u,
    @builtin(local_invocation_index) thread: u32,
) {
    let size = vec2i(vec2u(shape.width, shape.height));
    let tile = vec2i(group.xy);
    let first_low = i32(TILE) * tile - BEFORE_LOW;
    let first_middle = i32(TILE) / 2 * tile - BEFORE_MIDDLE;
    let first_high = i32(TILE) / 4 * tile - 1;
    for (var i = thread; i < LOW * LOW; i += TILE * TILE) {
        let pixel = position(i, LOW, first_low);
        if is_between(pixel, size) {
            let x = four(pixel.x, 2 * size.x);
            let y = four(pixel.y, 2 * size.y);
            low[i] = gained(binomial(mean_of_finer(x[0], y), mean_of_finer(x[1], y), mean_of_finer(x[2], y), mean_of_finer(x[3], y)));
        }
    }
    workgroupBarrier();
    for (var i = thread; i < MIDDLE * MIDDLE; i += TILE * TILE) {
        let pixel = position(i, MIDDLE, first_middle);
        if is_between(pixel, size / 2) {
            let x = four(pixel.x, size.x) - first_low.x;
            let y = four(pixel.y, size.y) - first_low.y;
            middle[i] = gained(binomial(mean_of_low(x[0], y), mean_of_low(x[1], y), mean_of_low(x[2], y), mean_of_low(x[3], y)));
        }
    }
    workgroupBarrier();
    let pixel = position(thread, HIGH, first_high);
    if thread < HIGH * HIGH && is_between(pixel, size / 4) {
        let x = four(pixel.x, size.x / 2) - first_middle.x;
        let y = four(pixel.y, size.y / 2) - first_middle.y;
        high[thread] = gained(binomial(mean_of_middle(x[0], y), mean_of_middle(x[1], y), mean_of_middle(x[2], y), mean_of_middle(x[3], y)));
    }
    workgroupBarrier();
    // Only the pixels around the filled ones of `low` are filled.
    const AROUND = TILE / 2u + 2u;
    if thread < AROUND * AROUND {
        let pixel = position(thread, AROUND, i32(TILE) / 2 * tile - 1);
        if is_between(pixel, size / 2) {
            let place = vec2u(pixel - first_middle);
            let i = place.y * MIDDLE + place.x;
            middle[i] += (1.0 - middle[i].a) * doubled_high(pixel, size / 4, first_high);
        }
    }
    workgroupBarrier();
    if is_inside(shape, at) {
        let own = local.xy + u32(BEFORE_LOW);
        let pixel = low[own.y * LOW + own.x];
        filled[at.y * shape.width + at.x] = pixel + (1.0 - pixel.a) * doubled_middle(vec2i(at.xy), size / 2, first_middle);
    }
}
