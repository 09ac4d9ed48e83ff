// Fine integration: colour and opacity are integrated between samples. Twin of cpu/fine/march.rs.

/// Whether rays integrate between samples.
override FINE: bool = false;

/// Two tables, one after the other.
///
/// The first has two words for each entry of the transfer table, NaN last: the integral of extinction up to the entry, and the
/// bits of its extinction. Both are in units of `scene.extinction_unit`. The second has the packed colours between any two of
/// 256 bins of values, and the colour of NaN.
@group(0) @binding(7) var<storage, read> extinction: array<u32>;

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

/// Light that reaches `p`.
fn light_at(p: vec3f) -> Light {
    if SHADOWS == UNSHADOWED {
        return Light(0.0, 1.0);
    }
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
    if near > DEEP || way_out(q) < 0.5 * SHADOW_STEP {
        return Light(near, 1.0);
    }
    if SHADOWS == CACHED {
        return Light(near, grid_transmittance(q));
    }
    return Light(near, transmittance(q));
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

/// Position on a ray `steps` steps after it entered the box, limited to the end of the box.
fn boundary(segment: Segment, steps: f32) -> vec3f {
    return fma(vec3f(min(steps, segment.length) - 0.5), segment.delta, segment.start);
}

/// Colour and opacity of a ray so far.
struct Gathered {
    colour: vec3f,
    /// The colour without shadow rays.
    unshadowed: vec3f,
    opacity: f32,
    /// Number of the step that took opacity past one half; negative before.
    half_at: f32,
    weighted_number: f32,
}

/// One step of a ray.
struct Step {
    /// The first step has number 0.
    number: f32,
    front: u32,
    behind: u32,
    /// Optical depth.
    depth: f32,
}

/// Composites `step`, which receives the share `arriving` of the light.
fn add_step(gathered: ptr<function, Gathered>, segment: Segment, step: Step, arriving: f32) {
    let passing = 1.0 - (*gathered).opacity;
    let alpha = 1.0 - exp(-step.depth);
    var direct = vec2f(arriving, select(arriving, 1.0, SHADOWS == RAYS));
    if GRADIENT {
        direct *= facing(boundary(segment, step.number + 0.5));
    }
    let weight = passing * alpha * (scene.ambient + (1.0 - scene.ambient) * direct);
    let rgb = colour_between(step.front, step.behind);
    (*gathered).colour += weight.x * rgb;
    if GUIDE {
        (*gathered).unshadowed += weight.y * rgb;
    }
    (*gathered).opacity += passing * alpha;
    (*gathered).weighted_number = fma(passing * alpha, step.number, (*gathered).weighted_number);
    if (*gathered).half_at < 0.0 && (*gathered).opacity >= 0.5 {
        (*gathered).half_at = step.number;
    }
}

/// Marches the ray of `segment`.
fn fine_march(segment: Segment) -> RayResult {
    let inverse = inverse_of(segment.delta);
    var gathered = Gathered(vec3f(0.0), vec3f(0.0), 0.0, -1.0, 0.0);
    var number = 0.0;
    // Steps before this one may be visible.
    var known = 0.0;
    var front = entry(field(boundary(segment, 0.0)));
    var lit = false;
    var before = Light(0.0, 1.0);
    while number < segment.length && gathered.opacity < FINE_OPAQUE {
        if SKIP && number >= known {
            let ahead = look_ahead(boundary(segment, number), inverse);
            // The last of these steps may leave the empty box.
            let jump = select(0.0, floor(0.25 * (ahead.steps - 1.0)) * 4.0, ahead.empty);
            known = number + select(ahead.steps, 4.0, ahead.empty);
            if jump > 0.0 {
                number += jump;
                front = entry(field(boundary(segment, number)));
                lit = false;
                continue;
            }
        }
        var entries = array<u32, 5>(front, 0u, 0u, 0u, 0u);
        var depths = array<f32, 4>(0.0, 0.0, 0.0, 0.0);
        var depth = 0.0;
        for (var i = 0; i < 4; i += 1) {
            let length = clamp(segment.length - number - f32(i), 0.0, 1.0);
            entries[i + 1] = entries[i];
            if length > 0.0 {
                entries[i + 1] = entry(field(boundary(segment, number + f32(i + 1))));
                depths[i] = mean_extinction(entries[i], entries[i + 1]) * length;
            }
            depth += depths[i];
        }
        let steps = select(2, 4, depth <= THIN);
        for (var first = 0; first < 4; first += steps) {
            var whole = 0.0;
            for (var i = first; i < first + steps; i += 1) {
                whole += depths[i];
            }
            if whole == 0.0 {
                lit = false;
                continue;
            }
            if !lit {
                before = light_at(boundary(segment, number + f32(first)));
            }
            let after = light_at(boundary(segment, number + f32(first + steps)));
            let share = mean_passing(whole + after.near - before.near) / mean_passing(whole);
            let arriving = far_between(before, after) * exp(-before.near) * share;
            for (var i = first; i < first + steps; i += 1) {
                if depths[i] > 0.0 {
                    let step = Step(number + f32(i), entries[i], entries[i + 1], depths[i]);
                    add_step(&gathered, segment, step, arriving);
                }
            }
            before = after;
            lit = true;
        }
        front = entries[4];
        number += 4.0;
    }
    let is_opaque = gathered.opacity >= FINE_OPAQUE;
    let opacity = select(gathered.opacity, 1.0, is_opaque);
    let whole = select(1.0, gathered.opacity, is_opaque);
    var colour = gathered.colour / whole;
    let unshadowed = gathered.unshadowed / whole;
    let half_at = gathered.half_at;
    let weighted_number = gathered.weighted_number;
    colour += (1.0 - opacity) * scene.background;
    if opacity == 0.0 {
        return RayResult(colour, unshadowed, 0.0, 0.0);
    }
    let at = select(half_at, weighted_number / gathered.opacity, half_at < 0.0);
    return RayResult(colour, unshadowed, opacity, 1.0 / fma(at, scene.delta, segment.distance));
}
