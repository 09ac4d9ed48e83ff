// Which pixels are sampled. Twin of cpu/mask.rs.
//
// Densities are f64 in the specification. The host turns them into whole ranks, so only integers are compared here, and the
// bits equal those of the CPU.

/// One frame's mask. Twin of `MaskSettings` in gpu/mask_limits.rs.
struct MaskSettings {
    /// The number of ranks below the density outside the fovea.
    base_limit: u32,
    /// Whether ranks are hashed from the seed rather than read from the tile.
    hashed: u32,
    /// The first column and row of the fovea.
    fovea_from: vec2u,
    /// Its columns and rows.
    fovea_size: vec2u,
    /// The seed of the frame, low word first.
    seed: vec2u,
}

/// The edge in pixels of the tile that repeats over the frame.
const TILE: u32 = 128;

@group(0) @binding(0) var<uniform> extent: Extent;
@group(0) @binding(1) var<uniform> settings: MaskSettings;
/// The ranks of one frame, row by row.
@group(0) @binding(2) var<storage, read> tile: array<u32>;
/// For each pixel of the fovea the number of ranks below its density, row by row.
@group(0) @binding(3) var<storage, read> limits: array<u32>;
@group(0) @binding(4) var<storage, read_write> mask: array<u32>;

/// One word for each row of the workgroup.
var<workgroup> words: array<atomic<u32>, 8>;

/// The rank of `pixel`.
fn rank(pixel: vec2u) -> u32 {
    if settings.hashed != 0u {
        // The upper 20 of 64 bits.
        return hash(settings.seed, pixel).y >> 12u;
    }
    let at = pixel % TILE;
    return tile[at.y * TILE + at.x];
}

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
    let inside = pixel.x < extent.width && pixel.y < extent.height;
    if inside && rank(pixel.xy) < limit(pixel.xy) {
        atomicOr(&words[local.y], 1u << local.x);
    }
    workgroupBarrier();
    if local.x == 0u && pixel.y < extent.height {
        mask[pixel.y * words_per_row(extent) + group.x] = atomicLoad(&words[local.y]);
    }
}
