// Shadow rays from a sample towards the light. Twin of cpu/shadow_rays.rs and of `LightPath` in scene/segment.rs.

/// Length of a shadow step in primary steps.
const SHADOW_STEP: f32 = 4.0;
/// Distance of the first shadow sample from its point, in primary steps.
const SHADOW_START: f32 = 2.0;
/// Transmittance below which a shadow ray ends.
const DARK: f32 = 0.001;

/// Number of steps from `p` along the light direction to the end of the box.
fn way_out(p: vec3f) -> f32 {
    let moving = scene.light_inverse != vec3f(0.0);
    let steps = select(vec3f(NEVER), (scene.light_exit - p) * scene.light_inverse, moving);
    var way = min(steps.x, min(steps.y, steps.z));
    for (var i = 0u; i < PLANES; i += 1u) {
        way = min(way, dot(scene.light_planes[i], vec4f(p, 1.0)));
    }
    return way;
}

/// Number of shadow samples between `p` and the end of the box: those j with 2 + 4j < the number of primary steps.
fn shadow_samples(p: vec3f) -> f32 {
    return ceil((way_out(p) - SHADOW_START) / SHADOW_STEP);
}

/// Whether shadow rays load two samples before they use the first.
override PAIRS: bool = false;

/// A shadow ray on its way.
struct ShadowRay {
    /// Its point.
    p: vec3f,
    /// T = ∏(1 − α_j) so far.
    transmittance: f32,
    /// Without columns: the next sample, the first one that may be visible, and the number of samples.
    j: f32,
    known: f32,
    count: f32,
    /// With columns: the column, the slabs of its first sample and after its last one, the next word, and the samples that are left
    /// of the word before.
    column: vec2i,
    first: u32,
    end: u32,
    word: u32,
    bits: u32,
}

/// The shadow ray from `p`.
fn shadow_ray(p: vec3f) -> ShadowRay {
    let count = shadow_samples(p);
    var ray = ShadowRay(p, 1.0, 0.0, 0.0, count, vec2i(0), 0u, 0u, 0u, 0u);
    if COLUMNS {
        let place = in_column(p);
        ray.column = place.column;
        ray.first = place.first;
        ray.end = place.first + u32(max(count, 0.0));
        ray.word = place.first / SLABS;
    }
    return ray;
}

/// α of sample `j` of the shadow ray of `p`.
fn shadow_alpha_at(p: vec3f, j: f32) -> f32 {
    return shadow_alpha_of(fma(vec3f(fma(SHADOW_STEP, j, SHADOW_START)), scene.light_delta, p));
}

/// Takes a step; whether there was one to take.
fn advance(ray: ptr<function, ShadowRay>) -> bool {
    if COLUMNS {
        return advance_listed(ray);
    }
    if (*ray).j >= (*ray).count || (*ray).transmittance < DARK {
        return false;
    }
    if SKIP && (*ray).j >= (*ray).known {
        let at = fma(vec3f(fma(SHADOW_STEP, (*ray).j, SHADOW_START)), scene.light_delta, (*ray).p);
        let ahead = look_ahead(at, scene.light_inverse / SHADOW_STEP);
        (*ray).known = (*ray).j + ahead.steps;
        if ahead.empty {
            (*ray).j = (*ray).known;
            return true;
        }
    }
    (*ray).transmittance *= 1.0 - shadow_alpha_at((*ray).p, (*ray).j);
    (*ray).j += 1.0;
    return true;
}

/// Takes the next sample that the column lists, or the next two; whether there was one.
fn advance_listed(ray: ptr<function, ShadowRay>) -> bool {
    if (*ray).transmittance < DARK {
        return false;
    }
    while (*ray).bits == 0u {
        if (*ray).word * SLABS >= (*ray).end {
            return false;
        }
        (*ray).bits = listed((*ray).column, (*ray).word, (*ray).first, (*ray).end);
        (*ray).word += 1u;
    }
    let start = ((*ray).word - 1u) * SLABS - (*ray).first;
    let bits = (*ray).bits;
    let rest = bits & (bits - 1u);
    let j = f32(start + firstTrailingBit(bits));
    if PAIRS {
        // Without another sample the second one is the first again, and does not count.
        let other = f32(start + firstTrailingBit(select(bits, rest, rest != 0u)));
        let alphas = vec2f(shadow_alpha_at((*ray).p, j), shadow_alpha_at((*ray).p, other));
        (*ray).transmittance *= 1.0 - alphas.x;
        if (*ray).transmittance >= DARK && rest != 0u {
            (*ray).transmittance *= 1.0 - alphas.y;
        }
        (*ray).bits = rest & (rest - min(rest, 1u));
    } else {
        (*ray).transmittance *= 1.0 - shadow_alpha_at((*ray).p, j);
        (*ray).bits = rest;
    }
    return true;
}

/// T along the shadow ray of `p`.
fn transmittance(p: vec3f) -> f32 {
    var ray = shadow_ray(p);
    var goes_on = true;
    while goes_on {
        goes_on = advance(&ray);
    }
    return ray.transmittance;
}
