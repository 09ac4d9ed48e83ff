// Cached transmittance towards the light. Twin of `cached_transmittance` in cpu/march.rs.

/// Transmittance of every voxel; channel c of texel k holds voxel 4k + c along z.
@group(0) @binding(5) var shadow_grid: texture_3d<f32>;

/// Transmittance at `p` by the grid alone.
///
/// The sampler's weights in steps of 1/256 move a colour by at most 1/255: two axes, half a step each.
fn grid_transmittance(p: vec3f) -> f32 {
    let z = clamp(p.z, 0.0, scene.last.z);
    let low = floor(z);
    let layers = f32(textureDimensions(shadow_grid).z);
    let layer = floor(low / 4.0);
    let xy = (p.xy + 0.5) / (scene.last.xy + 1.0);
    let texel = textureSampleLevel(shadow_grid, linear, vec3f(xy, (layer + 0.5) / layers), 0.0);
    let channel = u32(low - 4.0 * layer);
    var above = texel[min(channel + 1u, 3u)];
    if channel == 3u {
        above = textureSampleLevel(shadow_grid, linear, vec3f(xy, (layer + 1.5) / layers), 0.0).x;
    }
    return mix(texel[channel], above, z - low);
}

/// Transmittance at `p`: by the first sample of its shadow ray, and by the grid from where that sample's stretch ends.
fn cached_transmittance(p: vec3f) -> f32 {
    let way = way_out(p);
    var transmittance = 1.0;
    if way > SHADOW_START {
        transmittance -= shadow_alpha_of(fma(vec3f(SHADOW_START), scene.light_delta, p));
    }
    if way > SHADOW_START + SHADOW_STEP {
        transmittance *= grid_transmittance(fma(vec3f(SHADOW_STEP), scene.light_delta, p));
    }
    return transmittance;
}
