// Point of the last frame that the motion leads to. Twin of cpu/history/points.rs. Needs `shape`, `points` and `motion`.

/// A point: its weighted colour, and its offset from the pixel's centre, right and down.
struct Point {
    known: vec4f,
    apart: vec2f,
}

fn is_pixel(at: vec2i) -> bool {
    return all(at >= vec2i(0)) && all(at < vec2i(i32(shape.width), i32(shape.height)));
}

/// Mean of the points within the square of a pixel's size around its place in the last frame, with their largest weight.
fn reprojected_point(at: vec2u) -> Point {
    let way = motion[at.y * shape.width + at.x].xy;
    // NaN also counts as leaving the frame.
    if !is_finite(way.x) || !is_finite(way.y) || any(abs(way) > vec2f(65536.0)) {
        return Point();
    }
    let whole = floor(way);
    let part = way - whole;
    let first = vec2i(at) + vec2i(whole);
    var sum = vec4f(0.0);
    var places = vec2f(0.0);
    var largest = 0.0;
    for (var corner = 0u; corner < 4u; corner += 1u) {
        let steps = vec2u(corner & 1u, corner >> 1u);
        let other = first + vec2i(steps);
        if !is_pixel(other) {
            continue;
        }
        let known = points[place(shape, u32(other.x), u32(other.y), 0u)];
        let apart = points[place(shape, u32(other.x), u32(other.y), 1u)].xy + (vec2f(steps) - part);
        if known.a > 0.0 && all(apart >= vec2f(-0.5)) && all(apart < vec2f(0.5)) {
            sum += known;
            places += known.a * apart;
            largest = max(largest, known.a);
        }
    }
    if largest > 0.0 {
        return Point(sum * (largest / sum.a), places / sum.a);
    }
    return Point();
}
