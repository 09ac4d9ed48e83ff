// The trilinear field as the device's samplers have it: one access a sample, and weights in steps of 1/256. In place of
// field.wgsl.

/// Voxels at a type that samplers filter: of the largest stored value 1, or f32.
@group(0) @binding(1) var volume: texture_3d<f32>;

/// The trilinear value at `p`, clamped to the edge, as an entry of the transfer table that need not be whole.
fn field(p: vec3f) -> f32 {
    let clamped = clamp(p, vec3f(0.0), scene.last);
    let value = textureSampleLevel(volume, linear, (clamped + 0.5) / (scene.last + 1.0), 0.0).x;
    if GAPS && value < 0.0 {
        return f32(scene.last_entry + 1u);
    }
    return value * scene.scale;
}
