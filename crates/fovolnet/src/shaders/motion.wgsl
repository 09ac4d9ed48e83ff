// Which guess of distances is believed where, and the motion that follows. Twin of src/motion/guesses.rs and choice.rs.

/// Edge of the tiles that a guess is chosen for.
const TILE: u32 = 16u;
const PIXELS: u32 = TILE * TILE;
/// Tiles to each side whose samples count too.
const AROUND: u32 = 2u;
const GUESSES: u32 = 6u;
const OFFSETS = array<f32, 5>(0.0, -0.1, 0.1, -0.2, 0.2);
const HANDICAP = array<f32, GUESSES>(1.0, 1.05, 1.05, 1.05, 1.05, 1.0);
/// No distance is below this.
const NEAREST: f32 = 0.05;
/// The squared error of what lay outside the last frame.
const OUTSIDE: f32 = 1.0;

// One over the distance of every pixel: between the samples of this frame, and between those of earlier ones too.
@group(0) @binding(1) var<storage, read> near: array<f32>;
@group(0) @binding(2) var<storage, read> seen: array<f32>;
@group(0) @binding(3) var<storage, read> sparse: array<vec4f>;
// The last frame, full.
@group(0) @binding(4) var<storage, read> last: array<vec4f>;
// Squared errors of each guess, of all samples of a tile.
@group(0) @binding(5) var<storage, read_write> errors: array<array<f32, GUESSES>>;
// The guess that is believed, tile by tile.
@group(0) @binding(6) var<storage, read_write> chosen: array<u32>;
// The way in pixels, x right, y down.
@group(0) @binding(7) var<storage, read_write> motion: array<vec2f>;

/// One over the distance of pixel number `i`; 0 where nothing is known.
fn inverse_of(guess: u32, i: u32) -> f32 {
    if guess + 1u == GUESSES {
        return seen[i];
    }
    var offsets = OFFSETS;
    let inverse = near[i];
    let offset = offsets[guess];
    if inverse <= 0.0 || offset == 0.0 {
        return inverse;
    }
    return 1.0 / max(1.0 / inverse + offset, NEAREST);
}

/// The motion of pixel `at` with that distance.
fn moved(at: vec2u, inverse: f32) -> vec2f {
    return select(vec2f(0.0), way(vec2f(at), inverse), inverse > 0.0);
}

/// The squared difference of `colour` and the last frame at `place`.
fn difference(place: vec2f, colour: vec3f) -> f32 {
    let end = vec2f(f32(reprojection.width - 1u), f32(reprojection.height - 1u));
    if !(all(place >= vec2f(0.0)) && all(place <= end)) {
        return OUTSIDE;
    }
    let first = vec2u(place);
    let second = min(first + 1u, vec2u(reprojection.width - 1u, reprojection.height - 1u));
    let part = place - vec2f(first);
    let width = reprojection.width;
    let above = mix(last[first.y * width + first.x].rgb, last[first.y * width + second.x].rgb, part.x);
    let below = mix(last[second.y * width + first.x].rgb, last[second.y * width + second.x].rgb, part.x);
    let way = mix(above, below, part.y) - colour;
    return dot(way, way) / 3.0;
}

var<workgroup> sums: array<array<f32, GUESSES>, PIXELS>;

/// Looks for the samples of a tile along the motion of the pixels right of them and below them.
@compute @workgroup_size(TILE, TILE)
fn judge(
    @builtin(workgroup_id) tile: vec3u,
    @builtin(num_workgroups) tiles: vec3u,
    @builtin(local_invocation_id) local: vec3u,
    @builtin(local_invocation_index) thread: u32,
) {
    let at = tile.xy * TILE + local.xy;
    var sum = array<f32, GUESSES>();
    if is_inside(at) {
        let colour = sparse[at.y * reprojection.width + at.x];
        if colour.a > 0.5 {
            for (var side = 0u; side < 2u; side++) {
                let beside = at + vec2u(1u - side, side);
                if !is_inside(beside) {
                    continue;
                }
                let i = beside.y * reprojection.width + beside.x;
                for (var guess = 0u; guess < GUESSES; guess++) {
                    sum[guess] += difference(vec2f(at) + moved(beside, inverse_of(guess, i)), colour.rgb);
                }
            }
        }
    }
    sums[thread] = sum;
    for (var reach = PIXELS / 2u; reach > 0u; reach /= 2u) {
        workgroupBarrier();
        if thread < reach {
            for (var guess = 0u; guess < GUESSES; guess++) {
                sums[thread][guess] += sums[thread + reach][guess];
            }
        }
    }
    if thread == 0u {
        errors[tile.y * tiles.x + tile.x] = sums[0];
    }
}

/// The guess with the least errors in and around each tile.
@compute @workgroup_size(8, 8)
fn choose(@builtin(global_invocation_id) tile: vec3u) {
    let tiles = (vec2u(reprojection.width, reprojection.height) + TILE - 1u) / TILE;
    if any(tile.xy >= tiles) {
        return;
    }
    let first = max(tile.xy, vec2u(AROUND)) - AROUND;
    let end = min(tile.xy + AROUND + 1u, tiles);
    var sum = array<f32, GUESSES>();
    for (var y = first.y; y < end.y; y++) {
        for (var x = first.x; x < end.x; x++) {
            for (var guess = 0u; guess < GUESSES; guess++) {
                sum[guess] += errors[y * tiles.x + x][guess];
            }
        }
    }
    var handicap = HANDICAP;
    var best = 0u;
    for (var guess = 1u; guess < GUESSES; guess++) {
        if sum[guess] * handicap[guess] < sum[best] * handicap[best] {
            best = guess;
        }
    }
    chosen[tile.y * tiles.x + tile.x] = best;
}

/// The motion along the guess of each pixel's tile.
@compute @workgroup_size(8, 8)
fn shift(@builtin(global_invocation_id) at: vec3u) {
    if !is_inside(at.xy) {
        return;
    }
    let columns = (reprojection.width + TILE - 1u) / TILE;
    let guess = chosen[at.y / TILE * columns + at.x / TILE];
    let i = at.y * reprojection.width + at.x;
    motion[i] = moved(at.xy, inverse_of(guess, i));
}
