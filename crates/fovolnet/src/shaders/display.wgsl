// A frame as a picture of 8 bits for a screen.

@group(0) @binding(0) var<storage, read> frame: array<vec4f>;
@group(0) @binding(1) var picture: texture_storage_2d<rgba8unorm, write>;

@compute @workgroup_size(8, 8)
fn show(@builtin(global_invocation_id) at: vec3u) {
    let size = textureDimensions(picture);
    if all(at.xy < size) {
        textureStore(picture, at.xy, vec4f(frame[at.y * size.x + at.x].rgb, 1.0));
    }
}
