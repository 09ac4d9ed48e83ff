// Levels of a guide, shared by the shaders that make it.

/// Level of a guide, and the coarser one before it. Twin of `Level` in pipeline/gpu/guide/level.rs.
struct Level {
    /// First column and row of the region, and its columns and rows.
    region_from: vec2u,
    region_size: vec2u,
    /// First column and row of the level in the frame, and the number of its columns and rows.
    first: vec2u,
    size: vec2u,
    /// The same of the coarser level.
    coarse_first: vec2u,
    coarse_size: vec2u,
    /// Whether the coarser level goes on with its first or last pixels beyond the region, in columns and in rows; else with 0.
    repeats_before: vec2u,
    repeats_after: vec2u,
    /// Columns of the frame.
    width: u32,
    /// Distance between the pixels of the level.
    step: u32,
    /// Least contrast of pixels that are marched, in bytes.
    least: u32,
    /// Most pixels that are known after this level.
    most: u32,
}
