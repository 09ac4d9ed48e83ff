// Projections and isosurfaces: a thread follows a ray. Twin of cpu/modes/march.rs.

/// Values along rays that pixels show.
override MODE: u32 = 0;
const COMPOSITE: u32 = 0;
const MIP: u32 = 1;
const MINIP: u32 = 2;
const AVERAGE: u32 = 3;
const ISOSURFACE: u32 = 4;

/// Number of times that the part of a ray in which it crosses an isosurface is halved.
const HALVINGS: u32 = 10;
/// Least transparency of an opaque volume, so that extinctions stay finite.
const CLEAREST: f32 = 1e-6;

/// Whether the value `found` of volume `n` is NaN.
fn is_gap(n: u32, found: f32) -> bool {
    return has_gaps_of(n) && found > f32(last_entry_of(n)) + 0.5;
}

/// Result of the ray of `segment` where it shows nothing.
fn nothing() -> RayResult {
    return RayResult(scene.background, vec3f(0.0), 0.0, 0.0);
}

/// Result of the ray of `segment` that shows the value `shown` of volume `n` at sample `number`. Opacities of the table are those
/// of one voxel.
fn projected(segment: Segment, n: u32, shown: f32, number: f32) -> RayResult {
    let looks = appearance[table_of(n) + entry(shown)];
    let opacity = bitcast<f32>(looks.x);
    if opacity == 0.0 {
        return nothing();
    }
    let unshadowed = opacity * colour_of(looks.y);
    let colour = unshadowed + (1.0 - opacity) * scene.background;
    return RayResult(colour, unshadowed, opacity, 1.0 / fma(number, scene.delta, segment.distance));
}

/// Shows the greatest, least or mean value of volume `n` along the ray of `segment`. NaN counts only where there is nothing else.
fn projection_of(segment: Segment, n: u32) -> RayResult {
    let inverse = inverse_of(segment.delta);
    var shown = 0.0;
    var number = 0.0;
    var count = 0.0;
    var has_gap = false;
    // Samples before this one may be visible.
    var known = 0.0;
    var k = 0.0;
    while k < segment.count {
        let p = fma(vec3f(k), segment.delta, segment.start);
        if SKIP && k >= known {
            let ahead = look_ahead(p, inverse);
            known = k + ahead.steps;
            if ahead.empty {
                k = known;
                continue;
            }
        }
        let value = field_of(n, p);
        if is_gap(n, value) {
            has_gap = true;
        } else {
            count += 1.0;
            if MODE == AVERAGE {
                shown += value;
                number += k;
            } else if count == 1.0 || (MODE == MIP && value > shown) || (MODE == MINIP && value < shown) {
                shown = value;
                number = k;
            }
        }
        k += 1.0;
    }
    if count == 0.0 {
        if has_gap {
            return projected(segment, n, f32(last_entry_of(n) + 1u), 0.0);
        }
        return nothing();
    }
    if MODE == AVERAGE {
        return projected(segment, n, shown / count, number / count);
    }
    return projected(segment, n, shown, number);
}

/// Projects each volume on its own and blends what they show: opacities add as extinctions, colours weigh by their extinction.
/// The depth is that of the most opaque volume. Twin of `blended_results` in scene/blend.rs.
fn projection_march(segment: Segment) -> RayResult {
    var shown = projection_of(segment, 0u);
    if VOLUMES == 1u {
        return shown;
    }
    var sums = vec3f(0.0);
    var whole = 0.0;
    var clear = 1.0;
    for (var n = 0u; n < VOLUMES; n += 1u) {
        let own = projection_of(segment, n);
        if own.opacity > 0.0 {
            let weight = -log(max(1.0 - own.opacity, CLEAREST));
            sums += weight / own.opacity * own.unshadowed;
            whole += weight;
            clear *= 1.0 - own.opacity;
        }
        if own.opacity >= shown.opacity {
            shown = own;
        }
    }
    if whole == 0.0 {
        return nothing();
    }
    let opacity = 1.0 - clear;
    let unshadowed = opacity / whole * sums;
    return RayResult(unshadowed + clear * scene.background, unshadowed, opacity, shown.inverse_depth);
}

/// Number of the sample, with a fraction, at which the ray of `segment` crosses the surface after sample `before`.
fn refined(segment: Segment, before: f32, is_from_above: bool) -> f32 {
    var low = before;
    var high = before + 1.0;
    for (var i = 0u; i < HALVINGS; i += 1u) {
        let middle = 0.5 * (low + high);
        if (field(fma(vec3f(middle), segment.delta, segment.start)) >= scene.iso) == is_from_above {
            low = middle;
        } else {
            high = middle;
        }
    }
    return 0.5 * (low + high);
}

/// Whether everything from `p` to the light is on the side of the surface that the eye is on.
fn is_surface_lit(p: vec3f, is_from_above: bool) -> bool {
    let way = way_out(p);
    for (var steps = SHADOW_START; steps < way; steps += 1.0) {
        let value = field(fma(vec3f(steps), scene.light_delta, p));
        if !is_gap(0u, value) && (value >= scene.iso) != is_from_above {
            return false;
        }
    }
    return true;
}

/// Shows the first place along the ray of `segment` where values cross that of the surface.
fn isosurface_march(segment: Segment) -> RayResult {
    let inverse = inverse_of(segment.delta);
    var known = 0.0;
    // The value of the sample before `k`, if that is at hand, and whether empty space was left to reach `k`.
    var before = 0.0;
    var has_before = false;
    var has_jumped = false;
    var k = 0.0;
    while k < segment.count {
        let p = fma(vec3f(k), segment.delta, segment.start);
        var is_empty = false;
        if SKIP && k >= known {
            let ahead = look_ahead(p, inverse);
            known = k + ahead.steps;
            is_empty = ahead.empty;
        }
        // The step to the first sample of empty space may cross the surface.
        if is_empty && !has_before {
            k = known;
            has_jumped = true;
            continue;
        }
        if has_jumped {
            before = field(fma(vec3f(k - 1.0), segment.delta, segment.start));
            has_before = !is_gap(0u, before);
            has_jumped = false;
        }
        let value = field(p);
        let has_value = !is_gap(0u, value);
        if has_before && has_value && (before >= scene.iso) != (value >= scene.iso) {
            return surface_result(segment, k - 1.0, before >= scene.iso);
        }
        before = value;
        has_before = has_value && !is_empty;
        has_jumped = is_empty;
        k = select(k + 1.0, known, is_empty);
    }
    return nothing();
}

/// Result of the ray of `segment`, which crosses the surface after sample `before`.
fn surface_result(segment: Segment, before: f32, is_from_above: bool) -> RayResult {
    let number = refined(segment, before, is_from_above);
    let p = fma(vec3f(number), segment.delta, segment.start);
    let unshadowed = scene.ambient + (1.0 - scene.ambient) * facing(p);
    let is_lit = SHADOWS == UNSHADOWED || is_surface_lit(p, is_from_above);
    let light = select(scene.ambient, unshadowed, is_lit);
    let rgb = colour_of(appearance[entry(scene.iso)].y);
    return RayResult(light * rgb, unshadowed * rgb, 1.0, 1.0 / fma(number, scene.delta, segment.distance));
}

/// Marches the ray of `segment` in a mode other than `COMPOSITE`.
fn mode_march(segment: Segment) -> RayResult {
    if MODE == ISOSURFACE {
        return isosurface_march(segment);
    }
    return projection_march(segment);
}
