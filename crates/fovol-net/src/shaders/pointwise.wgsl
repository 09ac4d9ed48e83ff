// Pointwise layers. Twin of cpu/layers/pointwise.rs.

override FACTOR: f32;
override OFFSET: f32;
/// Second summand: none, a picture, or groups of four channels that are unfolded into 2×2 pixels.
override ADDED: u32;
/// Where sampled colours stay: nowhere, by a mask of its own, or by the mask in their fourth channel.
override BYPASSED: u32;
/// Whether the result is clamped to 0…1.
override CLAMPED: bool;

const PICTURE = 1u;
const FOLDED = 2u;
const MASKED = 1u;
const KNOWN = 2u;

@group(0) @binding(0) var<uniform> shape: Shape;
@group(0) @binding(1) var<storage, read> input: array<vec4f>;
@group(0) @binding(2) var<storage, read_write> changed: array<vec4f>;
@group(0) @binding(3) var<storage, read> more: array<vec4f>;
@group(0) @binding(4) var<storage, read> colours: array<vec4f>;
@group(0) @binding(5) var<storage, read> mask: array<vec4f>;
/// Shape of the frame.
@group(0) @binding(6) var<uniform> frame: Shape;
/// The frame, row by row.
@group(0) @binding(7) var<storage, read_write> shown: array<vec4f>;

/// Computes factor · x + offset.
@compute @workgroup_size(8, 8)
fn scale(@builtin(global_invocation_id) at: vec3u) {
    if is_inside(shape, at) {
        let i = place(shape, at.x, at.y, at.z);
        changed[i] = input[i] * FACTOR + OFFSET;
    }
}

/// Four channels of a pixel, from groups of four channels at half the resolution.
fn unfolded(at: vec3u) -> vec4f {
    let part = 2u * (at.y % 2u) + at.x % 2u;
    let size = vec2u(shape.width, shape.height) / 2u;
    let first = (4u * at.z * size.y + at.y / 2u) * size.x + at.x / 2u;
    let blocks = min(4u, shape.channels - 4u * at.z);
    var found = vec4f(0.0);
    for (var c = 0u; c < blocks; c += 1u) {
        found[c] = more[first + c * size.y * size.x][part];
    }
    return found;
}

/// x + more.
fn added(x: vec4f, at: vec3u) -> vec4f {
    switch ADDED {
        case PICTURE: { return x + more[place(shape, at.x, at.y, at.z)]; }
        case FOLDED: { return x + unfolded(at); }
        default: { return x; }
    }
}

/// mask · colour + (1 − mask) · x.
fn bypassed(x: vec4f, at: vec3u) -> vec4f {
    let i = place(shape, at.x, at.y, at.z);
    switch BYPASSED {
        case MASKED: {
            let m = mask[place(shape, at.x, at.y, 0u)].r;
            return m * colours[i] + (1.0 - m) * x;
        }
        case KNOWN: {
            let colour = colours[i];
            return colour.a * colour + (1.0 - colour.a) * x;
        }
        default: { return x; }
    }
}

/// The input with all changes, which is written too.
fn change_pixel(at: vec3u) -> vec4f {
    let i = place(shape, at.x, at.y, at.z);
    var x = bypassed(added(input[i], at), at);
    if CLAMPED {
        x = clamp(x, vec4f(0.0), vec4f(1.0));
    }
    changed[i] = x;
    return x;
}

/// Adds, bypasses and clamps.
@compute @workgroup_size(8, 8)
fn change(@builtin(global_invocation_id) at: vec3u) {
    if is_inside(shape, at) {
        _ = change_pixel(at);
    }
}

/// Adds, bypasses and clamps, and writes the top left of the result to the frame, clamped to 0…1 and opaque.
@compute @workgroup_size(8, 8)
fn change_and_show(@builtin(global_invocation_id) at: vec3u) {
    if !is_inside(shape, at) {
        return;
    }
    let x = change_pixel(at);
    if at.x < frame.width && at.y < frame.height && at.z == 0u {
        shown[at.y * frame.width + at.x] = vec4f(clamp(x.rgb, vec3f(0.0), vec3f(1.0)), 1.0);
    }
}
