// Transmittance towards the light at half resolution. Twin of cpu/shadow_grid.rs.

/// The slices of one dispatch. Twin of `Slab` in gpu/shadow_grid.rs.
struct Slab {
    /// Voxels along x and y, and the slice after the last.
    end: vec3u,
    /// The first slice.
    first: u32,
}

@group(1) @binding(0) var<uniform> slab: Slab;
/// Red holds the transmittance. rgba8unorm is the narrowest format that every device writes and filters.
@group(1) @binding(1) var shadow_grid: texture_storage_3d<rgba8unorm, write>;

/// Finds the transmittance of a slab. Voxel i lies at the common corner of the volume's voxels 2i and 2i + 1, or at the nearest
/// point of the part that is not cut off.
@compute @workgroup_size(4, 4, 4)
fn fill_shadow_grid(@builtin(global_invocation_id) thread: vec3u) {
    let voxel = thread + vec3u(0u, 0u, slab.first);
    if any(voxel >= slab.end) {
        return;
    }
    let light = transmittance(clamp(2.0 * vec3f(voxel) + 0.5, scene.box_low, scene.box_high));
    textureStore(shadow_grid, voxel, vec4f(light, 0.0, 0.0, 1.0));
}
