// Guides of the light ratio, level by level. Twin of src/guide/between.rs and marched.rs.
//
// `begin` lists the pixels of the coarsest level. For each finer one, `between` interpolates its pixels and finds their
// contrasts, `limit` finds the contrast from which on pixels are marched, and `choose` lists them. Samples of the frame have
// a guide already, so they are not listed.

/// Places in `state`: pixels that are known, those that were marched in all, the limit of contrasts, and how many pixels there are
/// of each contrast.
const KNOWN: u32 = 0;
const MARCHED: u32 = 1;
const LIMIT: u32 = 2;
const COUNTS: u32 = 3;
const CONTRASTS: u32 = 256;

@group(0) @binding(0) var<uniform> level: Level;
/// Guide pixels of the coarser level, row by row: red, green and blue without shadows, and opacity.
@group(0) @binding(1) var<storage, read> coarse: array<vec4f>;
/// Guide pixels of the level.
@group(0) @binding(2) var<storage, read_write> fine: array<vec4f>;
/// Samples of the frame: alpha is 1 where there is one.
@group(0) @binding(3) var<storage, read> sparse: array<vec4f>;
/// Contrast around each pixel of the level, 0…255.
@group(0) @binding(4) var<storage, read_write> contrasts: array<u32>;
@group(0) @binding(5) var<storage, read_write> state: array<atomic<u32>>;
/// Pixels to march, in any order, and their number.
@group(0) @binding(6) var<storage, read_write> list: array<u32>;
@group(0) @binding(7) var<storage, read_write> list_length: atomic<u32>;

fn is_of_level(at: vec2u) -> bool {
    return all(at < level.size);
}

fn pixel_of(at: vec2u) -> vec2u {
    return level.first + at * level.step;
}

/// Pixels that the threads of a workgroup list, and where they begin in the list.
var<workgroup> listed: atomic<u32>;
var<workgroup> begins: u32;

/// Lists the pixel of every thread that has one. All threads of a workgroup must call it.
fn put_on_list(thread: u32, pixel: vec2u, is_listed: bool) {
    if thread == 0u {
        atomicStore(&listed, 0u);
    }
    workgroupBarrier();
    var place = 0u;
    if is_listed {
        place = atomicAdd(&listed, 1u);
    }
    workgroupBarrier();
    if thread == 0u {
        let number = atomicLoad(&listed);
        begins = atomicAdd(&list_length, number);
        atomicAdd(&state[MARCHED], number);
    }
    workgroupBarrier();
    if is_listed {
        list[begins + place] = pixel.y << 16u | pixel.x;
    }
}

fn is_sample(pixel: vec2u) -> bool {
    return sparse[pixel.y * level.width + pixel.x].a > 0.5;
}

/// Lists every pixel of the coarsest level.
@compute @workgroup_size(8, 8)
fn begin(@builtin(global_invocation_id) at: vec3u, @builtin(local_invocation_index) thread: u32) {
    let pixel = pixel_of(at.xy);
    var is_listed = false;
    if is_of_level(at.xy) {
        is_listed = !is_sample(pixel);
    }
    put_on_list(thread, pixel, is_listed);
    if all(at.xy == vec2u(0u)) {
        atomicAdd(&state[KNOWN], level.size.x * level.size.y);
    }
}

/// Column or row `at` of the coarser level along `axis`; −1 where it is 0.
fn source(at: i32, axis: u32) -> i32 {
    let last = i32(level.coarse_size[axis]) - 1;
    if at < 0 {
        return select(-1, 0, level.repeats_before[axis] != 0u);
    }
    if at > last {
        return select(-1, last, level.repeats_after[axis] != 0u);
    }
    return at;
}

fn coarse_at(x: i32, y: i32) -> vec4f {
    let place = vec2i(source(x, 0u), source(y, 1u));
    if any(place < vec2i(0)) {
        return vec4f(0.0);
    }
    return coarse[u32(place.y) * level.coarse_size.x + u32(place.x)];
}

/// Catmull and Rom's cubic halfway between the middle two of four neighbours.
fn halfway(a: vec4f, b: vec4f, c: vec4f, d: vec4f) -> vec4f {
    return -0.0625 * a + 0.5625 * b + 0.5625 * c - 0.0625 * d;
}

/// Guide pixel of row `y` of the coarser level at column `x`, or halfway to the next column.
fn along(x: i32, y: i32, is_halfway: bool) -> vec4f {
    if is_halfway {
        return halfway(coarse_at(x - 1, y), coarse_at(x, y), coarse_at(x + 1, y), coarse_at(x + 2, y));
    }
    return coarse_at(x, y);
}

/// Clamps overshoots: opacity lies in 0…1, and no channel above opacity.
fn possible(pixel: vec4f) -> vec4f {
    let opacity = clamp(pixel.a, 0.0, 1.0);
    return vec4f(clamp(pixel.rgb, vec3f(0.0), vec3f(opacity)), opacity);
}

/// Channels in steps of 1/255.
fn bytes(pixel: vec4f) -> vec4f {
    return round(min(pixel, vec4f(1.0)) * 255.0);
}

/// Counts of contrasts of a workgroup.
var<workgroup> counts: array<atomic<u32>, CONTRASTS>;

@compute @workgroup_size(8, 8)
fn between(@builtin(global_invocation_id) at: vec3u, @builtin(local_invocation_index) thread: u32) {
    for (var contrast = thread; contrast < CONTRASTS; contrast += 64u) {
        atomicStore(&counts[contrast], 0u);
    }
    workgroupBarrier();
    if is_of_level(at.xy) {
        // Places in half distances of the coarser level, from a whole distance before its first pixel on.
        let place = at.xy + 2u - (level.coarse_first - level.first) / level.step;
        let near = vec2i(place / 2u) - 1;
        let is_halfway = place % 2u == vec2u(1u);
        var pixel = along(near.x, near.y, is_halfway.x);
        if is_halfway.y {
            pixel = halfway(
                along(near.x, near.y - 1, is_halfway.x),
                pixel,
                along(near.x, near.y + 1, is_halfway.x),
                along(near.x, near.y + 2, is_halfway.x),
            );
        }
        let i = at.y * level.size.x + at.x;
        fine[i] = possible(pixel);
        let beyond = near + vec2i(is_halfway);
        let a = bytes(coarse_at(near.x, near.y));
        let b = bytes(coarse_at(beyond.x, near.y));
        let c = bytes(coarse_at(near.x, beyond.y));
        let d = bytes(coarse_at(beyond.x, beyond.y));
        let spread = max(max(a, b), max(c, d)) - min(min(a, b), min(c, d));
        let contrast = u32(max(max(spread.r, spread.g), max(spread.b, spread.a)));
        contrasts[i] = contrast;
        if contrast >= level.least {
            atomicAdd(&counts[contrast], 1u);
        }
    }
    workgroupBarrier();
    for (var contrast = thread; contrast < CONTRASTS; contrast += 64u) {
        let count = atomicLoad(&counts[contrast]);
        if count > 0u {
            atomicAdd(&state[COUNTS + contrast], count);
        }
    }
}

/// How many pixels there are of each contrast.
var<workgroup> of_contrast: array<u32, CONTRASTS>;

/// Finds the least contrast that no more pixels reach than may be marched, empties the list, and forgets the counts; by one
/// workgroup.
@compute @workgroup_size(CONTRASTS)
fn limit(@builtin(local_invocation_index) thread: u32) {
    of_contrast[thread] = atomicExchange(&state[COUNTS + thread], 0u);
    workgroupBarrier();
    if thread > 0u {
        return;
    }
    let known = atomicLoad(&state[KNOWN]);
    let room = max(level.most, known) - known;
    var reached = 0u;
    var limit = CONTRASTS;
    for (var contrast = CONTRASTS - 1u; contrast >= level.least; contrast -= 1u) {
        let together = reached + of_contrast[contrast];
        if together > room {
            break;
        }
        reached = together;
        limit = contrast;
    }
    atomicStore(&state[KNOWN], known + reached);
    atomicStore(&state[LIMIT], limit);
    atomicStore(&list_length, 0u);
}

/// Lists the pixels whose contrast reaches the limit.
@compute @workgroup_size(8, 8)
fn choose(@builtin(global_invocation_id) at: vec3u, @builtin(local_invocation_index) thread: u32) {
    let pixel = pixel_of(at.xy);
    var is_listed = false;
    if is_of_level(at.xy) && contrasts[at.y * level.size.x + at.x] >= atomicLoad(&state[LIMIT]) {
        is_listed = !is_sample(pixel);
    }
    put_on_list(thread, pixel, is_listed);
}
