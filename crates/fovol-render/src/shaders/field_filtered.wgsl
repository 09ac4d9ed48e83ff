// The trilinear field by the device's samplers: one access a sample, with weights in steps of 1/256. It replaces field.wgsl.

/// Voxels of a type that samplers filter: normalised so that the largest stored value is 1, or f32.
@group(0) @binding(1) var volume: texture_3d<f32>;

/// Trilinear value at `p`, or that of the nearest voxel, clamped to the edge, as a fractional entry of the transfer table.
fn field(p: vec3f) -> f32 {
    var clamped = clamp(p, vec3f(0.0), scene.last);
    if NEAREST {
        clamped = floor(clamped + 0.5);
    }
    let value = textureSampleLevel(volume, linear, (clamped + 0.5) / (scene.last + 1.0), 0.0).x;
    if GAPS && value < 0.0 {
        return f32(scene.last_entry + 1u);
    }
    return value * scene.scale;
}
