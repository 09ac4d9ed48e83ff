// Fine integration: colour and opacity are integrated between samples. What every way to march shares. Twin of
// cpu/fine/march.rs.

/// Whether rays integrate between samples.
override FINE: bool = false;

// `extinction` has two tables, one after the other.
//
// The first has two words for each entry of the transfer table, NaN last: the integral of extinction up to the entry, and the
// bits of its extinction. Both are in units of `scene.extinction_unit`. The second has the packed colours between any two of
// 256 bins of values, and the colour of NaN.

/// Bins that colours are tabulated for.
const COLOURS: u32 = 256;
/// Optical depth beyond which no light arrives.
const DEEP: f32 = 6.907755;
/// Opacity at which a ray ends. Its colour so far then stands for the rest of the ray.
const FINE_OPAQUE: f32 = 0.996;
/// Largest optical depth of four steps that are lit at their ends only.
const THIN: f32 = 0.25;

/// Light that reaches a point.
struct Light {
    /// Optical depth near the point.
    near: f32,
    /// Transmittance farther away.
    far: f32,
}

/// Extinction of one step inside one entry.
fn entry_extinction(entry: u32) -> f32 {
    return bitcast<f32>(extinction[2u * entry + 1u]) * scene.extinction_unit;
}

/// Extinction of one step between two entries: the mean of all entries from one to the other.
fn mean_extinction(front: u32, behind: u32) -> f32 {
    if GAPS && max(front, behind) > scene.last_entry {
        return entry_extinction(scene.last_entry + 1u);
    }
    if max(front, behind) - min(front, behind) <= 1u {
        return 0.5 * (entry_extinction(front) + entry_extinction(behind));
    }
    let difference = i32(extinction[2u * behind]) - i32(extinction[2u * front]);
    return f32(difference) / (f32(behind) - f32(front)) * scene.extinction_unit;
}

/// Bin of an entry of the transfer table.
fn bin(entry: u32) -> u32 {
    return (entry + (1u << scene.bin_bits) / 2u) >> scene.bin_bits;
}

/// Colour between two entries of the transfer table. Within one bin it is the colour of the entry with more extinction.
fn colour_between(front: u32, behind: u32) -> vec3f {
    let bins = vec2u(bin(front), bin(behind));
    var at = bins.x * COLOURS + bins.y;
    if GAPS && max(front, behind) > scene.last_entry {
        at = COLOURS * COLOURS;
    } else if bins.x == bins.y {
        return colour_of(appearance[select(behind, front, entry_extinction(front) > entry_extinction(behind))].y);
    }
    return colour_of(extinction[2u * scene.last_entry + 4u + at]);
}

/// Mean of e^(−x·s) over s from 0 to 1.
fn mean_passing(x: f32) -> f32 {
    if abs(x) < 0.05 {
        return 1.0 - x * (0.5 - x * (1.0 / 6.0 - x / 24.0));
    }
    return (1.0 - exp(-x)) / x;
}

/// The near part of the way from a point to the light.
struct NearPart {
    /// Its optical depth.
    depth: f32,
    /// Where it ends.
    end: vec3f,
    /// Whether nothing farther away counts.
    is_all: bool,
}

/// The near part of the way from `p` to the light.
fn near_part(p: vec3f) -> NearPart {
    let way = max(way_out(p), 0.0);
    let length = way - SHADOW_STEP * max(floor((way - SHADOW_STEP) / SHADOW_STEP), 0.0);
    var front = entry(field(p));
    var near = 0.0;
    var begin = 0.0;
    var end = 0.125;
    for (var i = 0; i < 4; i += 1) {
        let behind = entry(field(fma(vec3f(length * end), scene.light_delta, p)));
        near = fma(mean_extinction(front, behind) * length, end - begin, near);
        front = behind;
        begin = end;
        end *= 2.0;
    }
    let q = fma(vec3f(length), scene.light_delta, p);
    return NearPart(near, q, near > DEEP || way_out(q) < 0.5 * SHADOW_STEP);
}

/// Light that reaches `p`.
fn light_at(p: vec3f) -> Light {
    if SHADOWS == UNSHADOWED {
        return Light(0.0, 1.0);
    }
    let near = near_part(p);
    if near.is_all {
        return Light(near.depth, 1.0);
    }
    if SHADOWS == CACHED {
        return Light(near.depth, grid_transmittance(near.end));
    }
    return Light(near.depth, transmittance(near.end));
}

/// Far transmittance between two points. Points deeper than `DEEP` have none of their own.
fn far_between(before: Light, after: Light) -> f32 {
    if before.near > DEEP {
        return after.far;
    }
    if after.near > DEEP {
        return before.far;
    }
    return 0.5 * (before.far + after.far);
}

/// Share of the light that arrives at a part of optical `depth`, whose ends the light `before` and `after` reaches.
fn arriving_at(depth: f32, before: Light, after: Light) -> f32 {
    let share = mean_passing(depth + after.near - before.near) / mean_passing(depth);
    return far_between(before, after) * exp(-before.near) * share;
}

/// Position on a ray `steps` steps after it entered the box, limited to the end of the box.
fn boundary(segment: Segment, steps: f32) -> vec3f {
    return fma(vec3f(min(steps, segment.length) - 0.5), segment.delta, segment.start);
}

/// Up to four steps of a ray, one after the other.
struct Steps {
    /// Entries of the transfer table at their ends.
    entries: array<u32, 5>,
    /// Optical depths.
    depths: array<f32, 4>,
}

/// `count` steps of a ray from step `number` on, which begins at entry `front`. Steps beyond the box have no depth.
fn steps_from(segment: Segment, number: f32, count: i32, front: u32) -> Steps {
    var steps = Steps(array<u32, 5>(front, 0u, 0u, 0u, 0u), array<f32, 4>(0.0, 0.0, 0.0, 0.0));
    for (var i = 0; i < count; i += 1) {
        let length = clamp(segment.length - number - f32(i), 0.0, 1.0);
        steps.entries[i + 1] = steps.entries[i];
        if length > 0.0 {
            steps.entries[i + 1] = entry(field(boundary(segment, number + f32(i + 1))));
            steps.depths[i] = mean_extinction(steps.entries[i], steps.entries[i + 1]) * length;
        }
    }
    return steps;
}

/// Optical depth of `count` of the steps from number `first` of them on.
fn depth_of(steps: Steps, first: i32, count: i32) -> f32 {
    var depth = 0.0;
    for (var i = first; i < first + count; i += 1) {
        depth += steps.depths[i];
    }
    return depth;
}

/// Number of steps of a part of four steps whose optical depth is `depth`: light is known at its ends.
fn steps_of_part(depth: f32) -> i32 {
    return select(2, 4, depth <= THIN);
}

/// Opacity of a step of optical depth `depth`.
fn step_opacity(depth: f32) -> f32 {
    return 1.0 - exp(-depth);
}

/// Colour that a part of a ray sends to the eye.
struct Lit {
    colour: vec3f,
    /// The colour without shadow rays.
    unshadowed: vec3f,
    /// What shadows can take away from the colour.
    direct: vec3f,
}

/// Colour of `count` of the `steps` from number `first` of them on, where step 0 is step `number` of the ray. The ray has
/// this `opacity` before them; they receive the share `arriving` of the light.
fn lit_part(
    segment: Segment, number: f32, steps: Steps, first: i32, count: i32, opacity: f32, arriving: f32,
) -> Lit {
    var lit = Lit(vec3f(0.0), vec3f(0.0), vec3f(0.0));
    var before = opacity;
    for (var i = first; i < first + count; i += 1) {
        if steps.depths[i] == 0.0 {
            continue;
        }
        let covered = step_opacity(steps.depths[i]) * (1.0 - before);
        before += covered;
        var direct = vec2f(arriving, select(arriving, 1.0, SHADOWS == RAYS));
        if GRADIENT {
            direct *= facing(boundary(segment, number + f32(i) + 0.5));
        }
        let weight = covered * (scene.ambient + (1.0 - scene.ambient) * direct);
        let rgb = colour_between(steps.entries[i], steps.entries[i + 1]);
        lit.colour += weight.x * rgb;
        lit.direct += (weight.x - covered * scene.ambient) * rgb;
        if GUIDE {
            lit.unshadowed += weight.y * rgb;
        }
    }
    return lit;
}

/// Adds the opacity of `count` of the `steps` from number `first` of them on to the sums, where step 0 is step `number` of the
/// ray.
fn cover_part(sums: ptr<function, Sums>, number: f32, steps: Steps, first: i32, count: i32) {
    for (var i = first; i < first + count; i += 1) {
        if steps.depths[i] > 0.0 {
            _ = cover(sums, number + f32(i), step_opacity(steps.depths[i]));
        }
    }
}

/// Steps from number `number` on that show nothing, a multiple of four; at 0 the next four may show something. The last steps
/// that a look ahead finds empty may leave the empty box.
fn empty_steps(ahead: Ahead) -> f32 {
    return select(0.0, floor(0.25 * (ahead.steps - 1.0)) * 4.0, ahead.empty);
}

/// Result of the ray of `segment`. A ray that is opaque enough stands for the rest of it, too.
fn fine_result(sums: Sums, segment: Segment) -> RayResult {
    let is_opaque = sums.opacity >= FINE_OPAQUE;
    let opacity = select(sums.opacity, 1.0, is_opaque);
    let whole = select(1.0, sums.opacity, is_opaque);
    let colour = sums.colour / whole + (1.0 - opacity) * scene.background;
    let unshadowed = sums.unshadowed / whole;
    if opacity == 0.0 {
        return RayResult(colour, unshadowed, 0.0, 0.0);
    }
    let number = select(sums.half_at, sums.weighted_number / sums.opacity, sums.half_at < 0.0);
    return RayResult(colour, unshadowed, opacity, 1.0 / fma(number, scene.delta, segment.distance));
}
