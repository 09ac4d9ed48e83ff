// From packed samples to a sparse frame. Twin of cpu/scatter.rs.

@group(0) @binding(0) var<uniform> extent: Extent;
/// Pixels, packed.
@group(0) @binding(1) var<storage, read> list: array<u32>;
@group(0) @binding(2) var<storage, read> list_length: ListLength;
/// Results of their rays: colours and opacities; inverse distances and colours without shadows.
@group(0) @binding(3) var<storage, read> colours: array<vec4f>;
@group(0) @binding(4) var<storage, read> inverse_depths: array<vec4f>;
/// Frames row by row, cleared before: alpha is 1 where a pixel was sampled.
@group(0) @binding(5) var<storage, read_write> frame: array<vec4f>;
@group(0) @binding(6) var<storage, read_write> frame_inverse_depths: array<f32>;

/// Writes the samples where their pixels lie. Equal pixels have equal samples, so their order does not matter.
@compute @workgroup_size(LIST_GROUP)
fn scatter(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) thread: u32) {
    let i = list_position(group, thread);
    if i >= list_length.pixels {
        return;
    }
    let pixel = unpacked(list[i]);
    let at = pixel.y * extent.width + pixel.x;
    frame[at] = vec4f(colours[i].rgb, 1.0);
    frame_inverse_depths[at] = inverse_depths[i].x;
}
