// Ranks of the noise of one frame. Twin of `FrameNoise` in noise/mod.rs.

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

/// The rank of `pixel`.
fn rank(pixel: vec2u) -> u32 {
    if settings.hashed != 0u {
        // The upper 20 of 64 bits.
        return hash(settings.seed, pixel).y >> 12u;
    }
    let at = pixel % TILE;
    return tile[at.y * TILE + at.x];
}
