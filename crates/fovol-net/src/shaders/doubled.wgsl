// Pictures at twice their resolution. Twin of cpu/doubled.rs.

/// Two neighbours of a pixel in a picture of half the resolution, of which the first is weighed by ¾.
struct Halves {
    near: vec2u,
    far: vec2u,
}

/// Those of pixel `at` in `size` pixels, replicated at the border.
fn halves(at: vec2u, size: vec2u) -> Halves {
    let near = at / 2u;
    return Halves(near, select(max(near, vec2u(1u)) - 1u, min(near + 1u, size - 1u), at % 2u == vec2u(1u)));
}
