// Weighs depth hypotheses (guesses) tile by tile, and finds the motion. Twin of src/motion/depth_hypotheses.rs and
// depth_confidence.rs.

/// Edge of the tiles in which guesses are judged, in pixels.
const TILE: u32 = 16u;
const PIXELS: u32 = TILE * TILE;
/// Weights of neighbouring tiles by their distance in rows and in columns.
const NEARBY = array<f32, 3>(1.0, 0.6, 0.2);
const AROUND: u32 = 2u;
const GUESSES: u32 = 6u;
const NEAR_GUESSES: u32 = 5u;
const OFFSETS = array<f32, NEAR_GUESSES>(0.0, -0.1, 0.1, -0.2, 0.2);
const HANDICAP = array<f32, GUESSES>(1.0, 1.05, 1.05, 1.05, 1.05, 1.0);
/// Exponent of the weights: a guess with twice the squared error of another gets 2^−SHARPNESS times its weight.
const SHARPNESS: f32 = 5.0;
/// Squared errors below this are noise.
const NOISE: f32 = 1e-6;
/// Smallest distance of a guess with an offset.
const NEAREST: f32 = 0.05;
/// Squared error of a sample that lay outside the last frame. A typical value, since such a sample says little about any guess.
const OUTSIDE: f32 = 0.01;

@group(0) @binding(0) var<uniform> reprojection: Reprojection;
// Inverse distance of every pixel: interpolated from the samples of this frame, and from these and those of earlier frames.
@group(0) @binding(1) var<storage, read> near: array<f32>;
@group(0) @binding(2) var<storage, read> seen: array<f32>;
@group(0) @binding(3) var<storage, read> sparse: array<vec4f>;
// The last reconstructed frame.
@group(0) @binding(4) var<storage, read> last: array<vec4f>;
// Squared errors of each guess, summed over the samples of a tile.
@group(0) @binding(5) var<storage, read_write> errors: array<array<f32, GUESSES>>;
// For each tile the offset to add to the distance from this frame's samples, and the weight of the guess from earlier frames.
@group(0) @binding(6) var<storage, read_write> beliefs: array<vec2f>;
// Motion in pixels, right and down.
@group(0) @binding(7) var<storage, read_write> motion: array<vec2f>;

/// Inverse distance of pixel number `i` by a guess; 0 where unknown.
fn inverse_of(guess: u32, i: u32) -> f32 {
    if guess == NEAR_GUESSES {
        return seen[i];
    }
    var offsets = OFFSETS;
    return moved_by(near[i], offsets[guess]);
}

/// Adds `offset` to the distance whose inverse is `inverse`, and returns the new inverse.
fn moved_by(inverse: f32, offset: f32) -> f32 {
    if inverse <= 0.0 || offset == 0.0 {
        return inverse;
    }
    return 1.0 / max(1.0 / inverse + offset, NEAREST);
}

/// Motion of pixel `at` at the distance 1/`inverse`.
fn moved(at: vec2u, inverse: f32) -> vec2f {
    return select(vec2f(0.0), way(vec2f(at), inverse), inverse > 0.0);
}

/// Squared difference of `colour` and the last frame at `place`.
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

fn is_unsampled(at: vec2u) -> bool {
    return is_inside(at) && sparse[at.y * reprojection.width + at.x].a <= 0.5;
}

/// Sums the errors of a tile. Each sample is looked up in the last frame along the motion of a neighbour that is no sample: the
/// pixel to the right for every other sample if possible, else the pixel below.
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
            let first = (at.x + at.y) % 2u;
            var beside = at + vec2u(1u - first, first);
            if !is_unsampled(beside) {
                beside = at + vec2u(first, 1u - first);
            }
            if is_unsampled(beside) {
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

/// Weighs the guesses of each tile by the errors in and around it.
@compute @workgroup_size(8, 8)
fn believe(@builtin(global_invocation_id) tile: vec3u) {
    let tiles = number_of_tiles();
    if any(tile.xy >= tiles) {
        return;
    }
    let first = max(tile.xy, vec2u(AROUND)) - AROUND;
    let end = min(tile.xy + AROUND + 1u, tiles);
    var nearby = NEARBY;
    var sum = array<f32, GUESSES>();
    for (var y = first.y; y < end.y; y++) {
        for (var x = first.x; x < end.x; x++) {
            let away = vec2u(abs(vec2i(vec2u(x, y)) - vec2i(tile.xy)));
            let share = nearby[away.x] * nearby[away.y];
            for (var guess = 0u; guess < GUESSES; guess++) {
                sum[guess] += share * errors[y * tiles.x + x][guess];
            }
        }
    }
    var handicap = HANDICAP;
    var least = 1e30;
    for (var guess = 0u; guess < GUESSES; guess++) {
        sum[guess] = (sum[guess] + NOISE) * handicap[guess];
        least = min(least, sum[guess]);
    }
    var offsets = OFFSETS;
    var trust = 0.0;
    var offset = 0.0;
    for (var guess = 0u; guess < NEAR_GUESSES; guess++) {
        let of_guess = pow(least / sum[guess], SHARPNESS);
        trust += of_guess;
        offset += of_guess * offsets[guess];
    }
    let of_seen = pow(least / sum[NEAR_GUESSES], SHARPNESS);
    let mean = select(0.0, offset / trust, trust > 0.0);
    beliefs[tile.y * tiles.x + tile.x] = vec2f(mean, of_seen / (trust + of_seen));
}

fn number_of_tiles() -> vec2u {
    return (vec2u(reprojection.width, reprojection.height) + TILE - 1u) / TILE;
}

/// Offset and weight at a pixel, interpolated between the centres of tiles and replicated at the edges.
fn belief_at(at: vec2u) -> vec2f {
    let tiles = number_of_tiles();
    let place = clamp((vec2f(at) + 0.5) / f32(TILE) - 0.5, vec2f(0.0), vec2f(tiles - 1u));
    let first = vec2u(place);
    let second = min(first + 1u, tiles - 1u);
    let part = place - vec2f(first);
    let left = mix(beliefs[first.y * tiles.x + first.x], beliefs[second.y * tiles.x + first.x], part.y);
    let right = mix(beliefs[first.y * tiles.x + second.x], beliefs[second.y * tiles.x + second.x], part.y);
    return mix(left, right, part.x);
}

/// Finds the motion from the weighted guesses.
@compute @workgroup_size(8, 8)
fn shift(@builtin(global_invocation_id) at: vec3u) {
    if !is_inside(at.xy) {
        return;
    }
    let belief = belief_at(at.xy);
    let i = at.y * reprojection.width + at.x;
    let nearer = moved_by(near[i], belief.x);
    let inverse = select(seen[i], mix(nearer, seen[i], belief.y), nearer > 0.0);
    motion[i] = moved(at.xy, inverse);
}

/// Finds the motion at the depths of this frame, where they are known at many pixels.
@compute @workgroup_size(8, 8)
fn shift_near(@builtin(global_invocation_id) at: vec3u) {
    if is_inside(at.xy) {
        let i = at.y * reprojection.width + at.x;
        motion[i] = moved(at.xy, near[i]);
    }
}
