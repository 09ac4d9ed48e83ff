// From results of rays to the guide pixels of a level. Twin of `Passes` in src/guide/marched.rs.

/// Threads of a workgroup over a list, and workgroups along x.
const LIST_GROUP: u32 = 64;
const GROUPS_X: u32 = 1024;

@group(0) @binding(0) var<uniform> level: Level;
/// Pixels, x in the low and y in the high half, and their number.
@group(0) @binding(1) var<storage, read> list: array<u32>;
@group(0) @binding(2) var<storage, read> list_length: u32;
/// Results of their rays: colours and opacities; inverse distances and colours without shadows.
@group(0) @binding(3) var<storage, read> colours: array<vec4f>;
@group(0) @binding(4) var<storage, read> unshadowed: array<vec4f>;
/// Guide pixels of the level, row by row.
@group(0) @binding(5) var<storage, read_write> guide: array<vec4f>;
/// Inverse distances of the pixels of the frame.
@group(0) @binding(6) var<storage, read_write> inverse_depths: array<f32>;

/// Puts the results of pixels that the level has into its guide, and their inverse distances into the frame.
@compute @workgroup_size(LIST_GROUP)
fn put(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) thread: u32) {
    let i = (group.y * GROUPS_X + group.x) * LIST_GROUP + thread;
    if i >= list_length {
        return;
    }
    let pixel = vec2u(list[i] & 0xFFFFu, list[i] >> 16u);
    let way = pixel - level.first;
    let at = way / level.step;
    // Left of or above the level the difference wraps round to a large number.
    if any(way % level.step != vec2u(0u)) || any(at >= level.size) {
        return;
    }
    let ray = unshadowed[i];
    guide[at.y * level.size.x + at.x] = vec4f(ray.yzw, colours[i].a);
    inverse_depths[pixel.y * level.width + pixel.x] = ray.x;
}
