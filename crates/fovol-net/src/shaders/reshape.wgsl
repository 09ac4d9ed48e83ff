// Layers that reorder elements. Twin of cpu/layers/reshape.rs.

@group(0) @binding(0) var<uniform> shape: Shape;
@group(0) @binding(1) var<storage, read> input: array<vec4f>;
@group(0) @binding(2) var<storage, read_write> output: array<vec4f>;
@group(0) @binding(3) var<storage, read> weight: array<vec4f>;

/// First channel of a part.
override FIRST: u32;

/// Folds 2×2 pixels into channels: 4c + 2y + x.
@compute @workgroup_size(8, 8)
fn space_to_depth(@builtin(global_invocation_id) at: vec3u) {
    if !is_inside(shape, at) {
        return;
    }
    let block = at.z / 4u;
    let c = at.z % 4u;
    let above = (block * 2u * shape.height + 2u * at.y) * 2u * shape.width + 2u * at.x;
    let below = above + 2u * shape.width;
    output[place(shape, at.x, at.y, at.z)] =
        vec4f(input[above][c], input[above + 1u][c], input[below][c], input[below + 1u][c]);
}

/// Unfolds channels into 2×2 pixels, the inverse of `space_to_depth`.
@compute @workgroup_size(8, 8)
fn depth_to_space(@builtin(global_invocation_id) at: vec3u) {
    if !is_inside(shape, at) {
        return;
    }
    let size = vec2u(shape.width, shape.height) / 2u;
    let part = 2u * (at.y % 2u) + at.x % 2u;
    let first = (4u * at.z * size.y + at.y / 2u) * size.x + at.x / 2u;
    let count = min(4u, shape.channels - 4u * at.z);
    var unfolded = vec4f(0.0);
    for (var c = 0u; c < count; c += 1u) {
        unfolded[c] = input[first + c * size.y * size.x][part];
    }
    output[place(shape, at.x, at.y, at.z)] = unfolded;
}

/// Appends weights to colours as a fourth channel.
@compute @workgroup_size(8, 8)
fn join(@builtin(global_invocation_id) at: vec3u) {
    if is_inside(shape, at) {
        let i = place(shape, at.x, at.y, 0u);
        output[i] = vec4f(input[i].rgb, weight[i].r);
    }
}

/// Copies channels from the first one on.
@compute @workgroup_size(8, 8)
fn part(@builtin(global_invocation_id) at: vec3u) {
    if !is_inside(shape, at) {
        return;
    }
    let count = min(4u, shape.channels - 4u * at.z);
    var found = vec4f(0.0);
    for (var i = 0u; i < count; i += 1u) {
        let c = FIRST + 4u * at.z + i;
        found[i] = input[place(shape, at.x, at.y, c / 4u)][c % 4u];
    }
    output[place(shape, at.x, at.y, at.z)] = found;
}
