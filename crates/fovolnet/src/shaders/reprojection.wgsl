// Where the pixels of one frame were in another, by the cameras of both. Twin of fovol-core/src/reprojection.rs.

struct Reprojection {
    // Direction of pixel (0, 0) in the axes of the other camera, and the change by a pixel to the right and a pixel down.
    base: array<vec4f, 3>,
    // Direction of pixel (0, 0) in world space, and its change by a pixel to the right and a pixel down.
    direction: array<vec4f, 3>,
    // Change per unit of inverse distance, or of distance with parallel rays, which w = 1 stands for.
    parallax: vec4f,
    width: u32,
    height: u32,
    // Half the width and half the height that the other camera sees at distance 1.
    half_width: f32,
    half_height: f32,
}

// Shaders declare `reprojection`, the one that functions use.

fn is_inside(at: vec2u) -> bool {
    return at.x < reprojection.width && at.y < reprojection.height;
}

fn at_pixel(v: array<vec4f, 3>, pixel: vec2f) -> vec3f {
    return v[0].xyz + v[1].xyz * pixel.x + v[2].xyz * pixel.y;
}

// Functions select by it and never branch, since some drivers compile a shader for every command if a uniform decides a
// branch.
fn is_parallel() -> bool {
    return reprojection.parallax.w != 0.0;
}

/// Inverse distance from this camera's eye, times the length of the direction. With parallel rays the distance, 1 for what is
/// infinitely far away.
fn nearness(pixel: vec2f, inverse: f32) -> f32 {
    let distance = select(1.0, 1.0 / inverse, inverse > 0.0);
    return select(inverse * length(at_pixel(reprojection.direction, pixel)), distance, is_parallel());
}

/// Position of the point in the axes of the other camera, times the inverse distance.
fn seen_from_there(pixel: vec2f, inverse: f32) -> vec3f {
    return at_pixel(reprojection.base, pixel) + reprojection.parallax.xyz * nearness(pixel, inverse);
}

/// Pixel of the other frame at that position.
fn place_of(seen: vec3f) -> vec2f {
    let size = vec2f(f32(reprojection.width), f32(reprojection.height));
    let ahead = select(max(seen.x, 1e-6), 1.0, is_parallel());
    return vec2f(seen.y / ahead + 1.0, 1.0 - seen.z / ahead) * 0.5 * size - 0.5;
}

/// Inverse distance from the other camera of the point that `pixel` shows at `seen`.
fn inverse_from_there(pixel: vec2f, inverse: f32, seen: vec3f) -> f32 {
    let away = length(vec3f(seen.x, seen.y * reprojection.half_width, seen.z * reprojection.half_height));
    return select(nearness(pixel, inverse) / away, 1.0 / seen.x, is_parallel());
}

/// Offset from `pixel` to the position of the same point in the other frame.
fn way(pixel: vec2f, inverse: f32) -> vec2f {
    return place_of(seen_from_there(pixel, inverse)) - pixel;
}
