// Fine integration: what lies between samples is integrated. Twin of cpu/fine/march.rs.

/// Whether rays integrate between samples.
override FINE: bool = false;

/// The sums of extinction before each entry of the transfer table and after the last, in units of
/// `scene.extinction_unit`; after these the packed colours between any two of 256 values.
@group(0) @binding(7) var<storage, read> extinction: array<u32>;

/// Values that colours are tabulated at.
const COLOURS: u32 = 256;
/// Beyond this optical depth it is dark.
const DEEP: f32 = 6.907755;

/// How much light comes to a point.
struct Light {
    /// Optical depth of what is near the point.
    near: f32,
    /// Transmittance of what is farther away.
    far: f32,
}

/// The extinction of one step between two entries: the mean of all from one to the other.
fn mean_extinction(front: u32, behind: u32) -> f32 {
    let low = min(front, behind);
    let end = max(front, behind) + 1u;
    if GAPS && end > scene.last_entry + 1u {
        return scene.nan_extinction;
    }
    return f32(i32(extinction[end]) - i32(extinction[low])) / f32(end - low) * scene.extinction_unit;
}

/// The colour between two entries of the transfer table.
fn colour_between(front: u32, behind: u32) -> vec3f {
    if GAPS && max(front, behind) > scene.last_entry {
        return colour_of(extinction[scene.last_entry + 2u + COLOURS * COLOURS]);
    }
    let scale = f32(COLOURS - 1u) / f32(scene.last_entry);
    let f = f32(front) * scale;
    let b = f32(behind) * scale;
    let low = u32(min(f, b));
    let high = min(u32(ceil(max(f, b))), COLOURS - 1u);
    let at = select(high * COLOURS + low, low * COLOURS + high, f < b);
    return colour_of(extinction[scene.last_entry + 2u + at]);
}

/// The mean of e^(−x·s) over s from 0 to 1.
fn mean_passing(x: f32) -> f32 {
    if abs(x) < 0.05 {
        return 1.0 - x * (0.5 - x * (1.0 / 6.0 - x / 24.0));
    }
    return (1.0 - exp(-x)) / x;
}

/// How many steps it is from `p` out of the box.
fn way_out(p: vec3f) -> f32 {
    let moving = scene.light_inverse != vec3f(0.0);
    let steps = select(vec3f(NEVER), (scene.light_exit - p) * scene.light_inverse, moving);
    return min(steps.x, min(steps.y, steps.z));
}

/// How much light comes to `p`.
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
        return Light(near, cached_transmittance(q));
    }
    return Light(near, transmittance(q));
}

/// The far transmittance between two points. A point in the deep does not know its own.
fn far_between(before: Light, after: Light) -> f32 {
    if before.near > DEEP {
        return after.far;
    }
    if after.near > DEEP {
        return before.far;
    }
    return 0.5 * (before.far + after.far);
}

/// Where a ray is `steps` steps after it entered the box, and never beyond the box.
fn boundary(segment: Segment, steps: f32) -> vec3f {
    return fma(vec3f(min(steps, segment.length) - 0.5), segment.delta, segment.start);
}

/// What the ray of `segment` brings back.
fn fine_march(segment: Segment) -> Marched {
    let inverse = inverse_of(segment.delta);
    var colour = vec3f(0.0);
    var opacity = 0.0;
    var half_at = -1.0;
    var weighted_number = 0.0;
    var number = 0.0;
    // Up to this step something may show.
    var known = 0.0;
    var front = entry(field(boundary(segment, 0.0)));
    var lit = false;
    var before = Light(0.0, 1.0);
    while number < segment.length && opacity < OPAQUE {
        if SKIP && number >= known {
            let ahead = look_ahead(boundary(segment, number), inverse);
            // The last of these steps may leave the empty box.
            let jump = select(0.0, floor(0.5 * (ahead.steps - 1.0)) * 2.0, ahead.empty);
            known = number + select(ahead.steps, 2.0, ahead.empty);
            if jump > 0.0 {
                number += jump;
                front = entry(field(boundary(segment, number)));
                lit = false;
                continue;
            }
        }
        let middle = entry(field(boundary(segment, number + 1.0)));
        let behind = entry(field(boundary(segment, number + 2.0)));
        let lengths = clamp(vec2f(segment.length - number, segment.length - number - 1.0), vec2f(0.0), vec2f(1.0));
        let depths = vec2f(mean_extinction(front, middle), mean_extinction(middle, behind)) * lengths;
        let depth = depths.x + depths.y;
        if depth > 0.0 {
            if !lit {
                before = light_at(boundary(segment, number));
            }
            let after = light_at(boundary(segment, number + 2.0));
            let between = fma(after.near - before.near, depths.x / depth, before.near);
            let far = far_between(before, after);
            var near = before.near;
            var entries = vec2u(front, middle);
            for (var i = 0; i < 2; i += 1) {
                let next = select(between, after.near, i == 1);
                if depths[i] > 0.0 {
                    let passing = 1.0 - opacity;
                    let alpha = 1.0 - exp(-depths[i]);
                    var direct = far * exp(-near) * depths[i] * mean_passing(depths[i] + next - near);
                    if GRADIENT {
                        direct *= facing(boundary(segment, number + f32(i) + 0.5));
                    }
                    let weight = passing * (scene.ambient * alpha + (1.0 - scene.ambient) * direct);
                    colour += weight * colour_between(entries.x, entries.y);
                    opacity += passing * alpha;
                    weighted_number = fma(passing * alpha, number + f32(i), weighted_number);
                    if half_at < 0.0 && opacity >= 0.5 {
                        half_at = number + f32(i);
                    }
                }
                near = next;
                entries = vec2u(middle, behind);
            }
            before = after;
        }
        lit = depth > 0.0;
        front = behind;
        number += 2.0;
    }
    colour += (1.0 - opacity) * scene.background;
    if opacity == 0.0 {
        return Marched(colour, 0.0, 0.0);
    }
    let at = select(half_at, weighted_number / opacity, half_at < 0.0);
    return Marched(colour, opacity, 1.0 / fma(at, scene.delta, segment.distance));
}
