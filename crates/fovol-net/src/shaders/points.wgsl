// Points: samples of earlier frames, each with its offset within its pixel. Twin of cpu/history/points.rs.
//
// The first block of a point has its weighted colour. The second begins with its offset from the pixel's centre,
// right and down.

@group(0) @binding(0) var<uniform> shape: Shape;
@group(0) @binding(1) var<storage, read> points: array<vec4f>;
@group(0) @binding(2) var<storage, read> motion: array<vec4f>;
@group(0) @binding(3) var<storage, read_write> reprojected: array<vec4f>;

@group(0) @binding(2) var<storage, read_write> splatted: array<vec4f>;

@compute @workgroup_size(8, 8)
fn reproject(@builtin(global_invocation_id) at: vec3u) {
    if at.x >= shape.width || at.y >= shape.height {
        return;
    }
    let point = reprojected_point(at.xy);
    reprojected[place(shape, at.x, at.y, 0u)] = point.known;
    reprojected[place(shape, at.x, at.y, 1u)] = vec4f(point.apart, 0.0, 0.0);
}

@compute @workgroup_size(8, 8)
fn splat(@builtin(global_invocation_id) at: vec3u) {
    if !is_inside(shape, at) {
        return;
    }
    var sum = vec4f(0.0);
    var shares = 0.0;
    for (var i = 0; i < 9; i += 1) {
        let step = vec2i(i % 3 - 1, i / 3 - 1);
        let other = vec2i(at.xy) + step;
        if !is_pixel(other) {
            continue;
        }
        let known = points[place(shape, u32(other.x), u32(other.y), 0u)];
        if known.a <= 0.0 {
            continue;
        }
        let apart = points[place(shape, u32(other.x), u32(other.y), 1u)].xy + vec2f(step);
        let near = max(vec2f(1.0) - abs(apart), vec2f(0.0));
        let share = near.x * near.y;
        sum += share * known;
        shares += share;
    }
    splatted[place(shape, at.x, at.y, 0u)] = sum / max(shares, 1.0);
}
