// Skips empty space. Twin of cpu/skip.rs.

/// Visibility of the space ahead of a point on a ray.
struct Ahead {
    /// Whether nothing is visible.
    empty: bool,
    /// Number of steps for which this holds, 1 or more.
    steps: f32,
}

/// Looks ahead of `p` along a ray with steps of 1/`inverse` voxels; `inverse` is 0 where the ray does not move. It finds a box
/// of empty cells around `p`, or the one visible cell that holds `p`.
fn look_ahead(p: vec3f, inverse: vec3f) -> Ahead {
    let cell = vec3i(clamp(p, vec3f(0.0), scene.last)) >> vec3u(scene.cell_shift);
    let distance = textureLoad(distances, cell, 0).x;
    let reach = vec3f(f32(max(distance, 1u)));
    let low = vec3f(cell);
    let face = select(low - reach + 1.0, low + reach, inverse > vec3f(0.0)) * f32(1u << scene.cell_shift);
    let steps = select((face - p) * inverse, vec3f(NEVER), inverse == vec3f(0.0));
    return Ahead(distance > 0u, max(ceil(min(steps.x, min(steps.y, steps.z))), 1.0));
}
