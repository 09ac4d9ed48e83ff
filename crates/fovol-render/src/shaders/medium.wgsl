// The medium of rays where it is one volume. layers.wgsl replaces it where there are several.

/// Number of volumes. Functions with a number `n` of a volume are there for shaders that also march several.
const VOLUMES: u32 = 1;

/// Opacity and colour at `p`, as in the transfer table.
fn look_at(p: vec3f) -> vec2u {
    return appearance[entry(field(p))];
}

/// α of one shadow step at `p`.
fn shadow_alpha_of(p: vec3f) -> f32 {
    return shadow_alpha[entry(field(p))];
}

/// |n·l| with n from central differences over ±1 voxel in world units. It is 1 where the gradient is zero, or unknown beside
/// NaN.
fn facing(p: vec3f) -> f32 {
    let x = vec3f(1.0, 0.0, 0.0);
    let y = vec3f(0.0, 1.0, 0.0);
    let z = vec3f(0.0, 0.0, 1.0);
    let after = vec3f(field(p + x), field(p + y), field(p + z));
    let before = vec3f(field(p - x), field(p - y), field(p - z));
    if GAPS && any(max(after, before) > vec3f(f32(scene.last_entry) + 0.5)) {
        return 1.0;
    }
    let gradient = (after - before) * scene.to_voxels;
    let steepness = length(gradient);
    if steepness > 0.0 {
        return abs(dot(gradient, scene.light_direction) / steepness);
    }
    return 1.0;
}

/// Value of volume `n` at `p`, as `field` has it.
fn field_of(n: u32, p: vec3f) -> f32 {
    return field(p);
}

/// Where the tables of volume `n` begin.
fn table_of(n: u32) -> u32 {
    return 0u;
}

/// Entry of the largest value of volume `n` in its tables; after it comes that of NaN.
fn last_entry_of(n: u32) -> u32 {
    return scene.last_entry;
}

fn has_gaps_of(n: u32) -> bool {
    return GAPS;
}

fn is_nearest_of(n: u32) -> bool {
    return NEAREST;
}

/// Length of the gradient of volume `n` at `p`, where its opacity depends on that.
fn length_of(n: u32, p: vec3f) -> f32 {
    return 0.0;
}

/// Transmittance of `steps` primary steps through volume `n` at `entry` of its tables, and at a gradient of `length`.
fn passing_of(n: u32, entry: u32, length: f32, steps: f32) -> f32 {
    return pow(1.0 - shadow_alpha[entry], steps / SHADOW_STEP);
}
