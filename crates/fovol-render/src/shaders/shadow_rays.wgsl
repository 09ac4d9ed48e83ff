// The light's way to a sample. Twin of cpu/shadow_rays.rs and of `LightPath` in scene/segment.rs.

/// Shadow steps are this many primary steps long.
const SHADOW_STEP: f32 = 4.0;
/// The first shadow sample is this many primary steps from its point.
const SHADOW_START: f32 = 2.0;
/// A shadow ray ends below this transmittance.
const DARK: f32 = 0.001;

/// How many shadow samples lie between `p` and the box: those j with 2 + 4j < the number of primary steps.
fn shadow_samples(p: vec3f) -> f32 {
    let moving = scene.light_inverse != vec3f(0.0);
    let steps = select(vec3f(NEVER), (scene.light_exit - p) * scene.light_inverse, moving);
    return ceil((min(steps.x, min(steps.y, steps.z)) - SHADOW_START) / SHADOW_STEP);
}

/// T = ∏(1 − α_j) along the shadow ray of `p`.
fn transmittance(p: vec3f) -> f32 {
    let count = shadow_samples(p);
    let inverse = scene.light_inverse / SHADOW_STEP;
    var transmittance = 1.0;
    var j = 0.0;
    // Up to this sample something may show.
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
