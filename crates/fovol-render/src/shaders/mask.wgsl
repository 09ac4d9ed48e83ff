// Which pixels are sampled. Twin of cpu/mask.rs.
//
// Densities are f64 in the specification. The host turns them into whole ranks, so only integers are compared here, and the
// bits equal those of the CPU.

/// For each pixel of the fovea the number of ranks below its density, row by row.
@group(0) @binding(3) var<storage, read> limits: array<u32>;
@group(0) @binding(4) var<storage, read_write> mask: array<u32>;

/// One word for each row of the workgroup.
var<workgroup> words: array<atomic<u32>, 8>;

/// The number of ranks below the density of `pixel`.
fn limit(pixel: vec2u) -> u32 {
    // Left of or above the fovea the difference wraps round to a large number.
    let at = pixel - settings.fovea_from;
    if any(at >= settings.fovea_size) {
        return settings.base_limit;
    }
    return limits[at.y * settings.fovea_size.x + at.x];
}

/// Decides 32 pixels of each of 8 rows.
@compute @workgroup_size(32, 8)
fn decide(
    @builtin(global_invocation_id) pixel: vec3u,
    @builtin(local_invocation_id) local: vec3u,
    @builtin(workgroup_id) group: vec3u,
) {
    if local.x == 0u {
        atomicStore(&words[local.y], 0u);
    }
    workgroupBarrier();
    let inside = pixel.x < extent.width && pixel.y < extent.height;
    if inside && rank(pixel.xy) < limit(pixel.xy) {
        atomicOr(&words[local.y], 1u << local.x);
    }
    workgroupBarrier();
    if local.x == 0u && pixel.y < extent.height {
        mask[pixel.y * words_per_row(extent) + group.x] = atomicLoad(&words[local.y]);
    }
}
