// Pictures at twice their resolution, bilinear. Twin of cpu/fill/doubled.rs.

/// Indices of the four pixels of a picture of half the resolution around pixel `at`, replicated at the border, the
/// nearest first. `size` is the size of that picture.
fn pixels_around(at: vec2u, size: vec2u) -> vec4u {
    let near = at / 2u;
    let far = select(max(near, vec2u(1u)) - 1u, min(near + 1u, size - 1u), at % 2u == vec2u(1u));
    return vec4u(
        near.y * size.x + near.x,
        near.y * size.x + far.x,
        far.y * size.x + near.x,
        far.y * size.x + far.x,
    );
}

/// Interpolates between the values of these four pixels.
fn between(a: vec4f, b: vec4f, c: vec4f, d: vec4f) -> vec4f {
    return 0.75 * (0.75 * a + 0.25 * b) + 0.25 * (0.75 * c + 0.25 * d);
}
