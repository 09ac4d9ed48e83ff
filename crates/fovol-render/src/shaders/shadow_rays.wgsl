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
    return min(steps.x, min(steps.y, steps.z));
}

/// Number of shadow samples between `p` and the end of the box: those j with 2 + 4j < the number of primary steps.
fn shadow_samples(p: vec3f) -> f32 {
    return ceil((way_out(p) - SHADOW_START) / SHADOW_STEP);
}

/// T = ∏(1 − α_j) along the shadow ray of `p`.
fn transmittance(p: vec3f) -> f32 {
    let count = shadow_samples(p);
    let inverse = scene.light_inverse / SHADOW_STEP;
    var transmittance = 1.0;
    var j = 0.0;
    // Samples before this one may be visible.
    var known = 0.0;
    while j < count && transmittance >= DARK {
        let at = fma(vec3f(fma(SHADOW_STEP, j, SHADOW_START)), scene.light_delta, p);
        if SKIP && j >= known {
            let ahead = look_ahead(at, inverse);
            known = j + ahead.steps;
            if ahead.empty {
                j = known;
                continue;
            }
        }
        transmittance *= 1.0 - shadow_alpha[entry(field(at))];
        j += 1.0;
    }
    return transmittance;
}
