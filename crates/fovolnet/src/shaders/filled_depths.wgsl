// Fills known distances by pull-push, two pictures at once: from the samples of this frame, and from these with those of earlier
// frames. Twin of fovol-net/src/fill/numbers.rs.
//
// A pixel of level k stands for 2^k by 2^k pixels. Levels from 1 on lie one after the other, each row by row.

@group(0) @binding(0) var<uniform> reprojection: Reprojection;
// Inverse distances of this frame's samples, 0 elsewhere.
@group(0) @binding(1) var<storage, read> inverse_depths: array<f32>;
// Bits of the largest inverse distance from earlier frames; cleared once they have been used.
@group(0) @binding(2) var<storage, read_write> nearest: array<atomic<u32>>;
// Samples of this frame.
@group(0) @binding(3) var<storage, read> sparse: array<vec4f>;
// Numbers of both pictures, times their weights, then these weights.
@group(0) @binding(4) var<storage, read_write> levels: array<vec4f>;
// Both filled pictures.
@group(0) @binding(5) var<storage, read_write> near: array<f32>;
@group(0) @binding(6) var<storage, read_write> seen: array<f32>;

/// Edge of a tile of the frame: one pixel of level `TILE_LEVEL`.
const TILE: u32 = 64u;
const TILE_LEVEL: u32 = 6u;
/// Edge of a tile at level 2, one pixel to a thread.
const EDGE: u32 = 16u;
const THREADS: u32 = EDGE * EDGE;

/// Columns and rows of a level.
fn level_size(level: u32) -> vec2u {
    return (vec2u(reprojection.width, reprojection.height) + (1u << level) - 1u) >> vec2u(level);
}

/// Index of the first pixel of a level.
fn level_first(level: u32) -> u32 {
    var first = 0u;
    for (var before = 1u; before < level; before += 1u) {
        let size = level_size(before);
        first += size.x * size.y;
    }
    return first;
}

/// Pixel of a level; nothing beyond its edge.
fn pulled(level: u32, at: vec2u) -> vec4f {
    let size = level_size(level);
    if any(at >= size) {
        return vec4f(0.0);
    }
    return levels[level_first(level) + at.y * size.x + at.x];
}

/// Keeps a pixel of a level, if the level has it.
fn put(level: u32, at: vec2u, pixel: vec4f) {
    let size = level_size(level);
    if all(at < size) {
        levels[level_first(level) + at.y * size.x + at.x] = pixel;
    }
}

/// Known inverse distances of a pixel in both pictures; 0 where unknown or outside the frame.
fn known(at: vec2u) -> vec2f {
    if !is_inside(at) {
        return vec2f(0.0);
    }
    let i = at.y * reprojection.width + at.x;
    let own = inverse_depths[i];
    return vec2f(own, select(bitcast<f32>(atomicLoad(&nearest[i])), own, sparse[i].a > 0.5));
}

/// Known numbers with the weight 1, others with none.
fn weighed(numbers: vec2f) -> vec4f {
    return select(vec4f(0.0), vec4f(numbers, 1.0, 1.0), (numbers > vec2f(0.0)).xyxy);
}

/// A sum of four pixels, with the weights limited to 1.
fn limited(sum: vec4f) -> vec4f {
    return sum / max(sum.zwzw, vec4f(1.0));
}

/// Pixel of `level` above four of the level below.
fn pulled_from(level: u32, at: vec2u) -> vec4f {
    let below = level - 1u;
    let first = 2u * at;
    return limited(
        pulled(below, first) + pulled(below, first + vec2u(1u, 0u))
            + pulled(below, first + vec2u(0u, 1u)) + pulled(below, first + vec2u(1u, 1u)),
    );
}

var<workgroup> tile_pixels: array<vec4f, THREADS>;

/// Pulls a tile to levels 1 to `TILE_LEVEL`.
@compute @workgroup_size(EDGE, EDGE)
fn pull(
    @builtin(workgroup_id) tile: vec3u,
    @builtin(local_invocation_id) local: vec3u,
    @builtin(local_invocation_index) thread: u32,
) {
    let at = EDGE * tile.xy + local.xy;
    var sum = vec4f(0.0);
    for (var i = 0u; i < 4u; i += 1u) {
        let half = 2u * at + vec2u(i % 2u, i / 2u);
        var of_half = vec4f(0.0);
        for (var j = 0u; j < 4u; j += 1u) {
            of_half += weighed(known(2u * half + vec2u(j % 2u, j / 2u)));
        }
        of_half = limited(of_half);
        put(1u, half, of_half);
        sum += of_half;
    }
    sum = limited(sum);
    put(2u, at, sum);
    tile_pixels[thread] = sum;
    var edge = EDGE / 2u;
    for (var level = 3u; level <= TILE_LEVEL; level += 1u) {
        workgroupBarrier();
        let is_pixel = all(local.xy < vec2u(edge));
        if is_pixel {
            let first = 2u * (local.y * EDGE + local.x);
            sum = tile_pixels[first] + tile_pixels[first + 1u] + tile_pixels[first + EDGE] + tile_pixels[first + EDGE + 1u];
            sum = limited(sum);
        }
        workgroupBarrier();
        if is_pixel {
            tile_pixels[thread] = sum;
            put(level, edge * tile.xy + local.xy, sum);
        }
        edge /= 2u;
    }
}

/// The two coarse pixels around the centre of a fine pixel, and its position between them, 0…1.
struct Neighbours {
    first: vec2u,
    second: vec2u,
    part: vec2f,
}

/// Neighbours at `level` of pixel `at` of the level below.
fn neighbours(level: u32, at: vec2u) -> Neighbours {
    let is_even = at % 2u == vec2u(0u);
    let here = at / 2u;
    let after = min(here + 1u, level_size(level) - 1u);
    let before = max(here, vec2u(1u)) - 1u;
    return Neighbours(select(here, before, is_even), select(after, here, is_even), select(vec2f(0.25), vec2f(0.75), is_even));
}

/// The value at `part` of the way between four.
fn blended(a: vec2f, b: vec2f, c: vec2f, d: vec2f, part: vec2f) -> vec2f {
    let top = a + part.x * (b - a);
    let low = c + part.x * (d - c);
    return top + part.y * (low - top);
}

/// Fills level `TILE_LEVEL` by the levels above it, by one workgroup.
@compute @workgroup_size(THREADS)
fn turn(@builtin(local_invocation_index) thread: u32) {
    var level = TILE_LEVEL;
    while any(level_size(level) > vec2u(1u)) {
        level += 1u;
        let size = level_size(level);
        for (var i = thread; i < size.x * size.y; i += THREADS) {
            let at = vec2u(i % size.x, i / size.x);
            put(level, at, pulled_from(level, at));
        }
        storageBarrier();
    }
    if thread == 0u {
        let pixel = pulled(level, vec2u(0u));
        put(level, vec2u(0u), vec4f(select(vec2f(0.0), pixel.xy / pixel.zw, pixel.zw > vec2f(0.0)), 1.0, 1.0));
    }
    storageBarrier();
    while level > TILE_LEVEL {
        let above = level;
        level -= 1u;
        let size = level_size(level);
        for (var i = thread; i < size.x * size.y; i += THREADS) {
            let at = vec2u(i % size.x, i / size.x);
            let pixel = pulled(level, at);
            let by = neighbours(above, at);
            let a = pulled(above, by.first).xy;
            let b = pulled(above, vec2u(by.second.x, by.first.y)).xy;
            let c = pulled(above, vec2u(by.first.x, by.second.y)).xy;
            let d = pulled(above, by.second).xy;
            put(level, at, vec4f(pixel.xy + (1.0 - pixel.zw) * blended(a, b, c, d, by.part), 1.0, 1.0));
        }
        storageBarrier();
    }
}

/// Filled numbers of a tile and one pixel around it, at the level in use and the one above: levels 1, 3, 5 and 2, 4, 6.
var<workgroup> odd: array<vec2f, 1156>;
var<workgroup> even: array<vec2f, 324>;

/// Columns of a tile at a level, with the pixels around it.
fn columns_around(level: u32) -> u32 {
    return (TILE >> level) + 2u;
}

/// Filled numbers of pixel `at` of `level`, in or beside the tile.
fn filled(level: u32, at: vec2u, tile: vec2u) -> vec2f {
    let place = at + 1u - (TILE >> level) * tile;
    let i = place.y * columns_around(level) + place.x;
    if level % 2u == 1u {
        return odd[i];
    }
    return even[i];
}

/// Filled numbers of `level` at pixel `at` of the level below.
fn between(level: u32, at: vec2u, tile: vec2u) -> vec2f {
    let by = neighbours(level, at);
    let a = filled(level, by.first, tile);
    let b = filled(level, vec2u(by.second.x, by.first.y), tile);
    let c = filled(level, vec2u(by.first.x, by.second.y), tile);
    let d = filled(level, by.second, tile);
    return blended(a, b, c, d, by.part);
}

/// Fills a tile of both pictures, level by level, and forgets the distances from earlier frames.
@compute @workgroup_size(THREADS)
fn push(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) thread: u32) {
    let tile = group.xy;
    for (var level = TILE_LEVEL; level > 0u; level -= 1u) {
        let columns = columns_around(level);
        for (var i = thread; i < columns * columns; i += THREADS) {
            // One more than the pixel's place in its level.
            let after = vec2u(i % columns, i / columns) + (TILE >> level) * tile;
            if any(after == vec2u(0u)) || any(after > level_size(level)) {
                continue;
            }
            let pixel = pulled(level, after - 1u);
            var numbers = pixel.xy;
            if level < TILE_LEVEL {
                numbers += (1.0 - pixel.zw) * between(level + 1u, after - 1u, tile);
            }
            if level % 2u == 1u {
                odd[i] = numbers;
            } else {
                even[i] = numbers;
            }
        }
        workgroupBarrier();
    }
    for (var i = thread; i < TILE * TILE; i += THREADS) {
        let at = TILE * tile + vec2u(i % TILE, i / TILE);
        if is_inside(at) {
            let own = known(at);
            let numbers = select(between(1u, at, tile), own, own > vec2f(0.0));
            let pixel = at.y * reprojection.width + at.x;
            near[pixel] = numbers.x;
            seen[pixel] = numbers.y;
            atomicStore(&nearest[pixel], 0u);
        }
    }
}
