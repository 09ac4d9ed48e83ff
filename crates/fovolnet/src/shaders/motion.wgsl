// Where every pixel was in the last frame. Twin of src/motion.rs and of Reprojection::motion in fovol-core.

struct Reprojection {
    // What the other camera sees in the direction of pixel (0, 0), and what a pixel to the right and a pixel down add.
    base: array<vec4<f32>, 3>,
    // Those directions themselves.
    direction: array<vec4<f32>, 3>,
    // What being nearer adds.
    parallax: vec4<f32>,
    width: u32,
    height: u32,
    unused_0: u32,
    unused_1: u32,
}

@group(0) @binding(0) var<uniform> reprojection: Reprojection;
// Of the sampled pixels, one over their distance; 0 where nothing is known.
@group(0) @binding(1) var<storage, read> inverse_depths: array<f32>;
// The same as a sparse frame: its red, alpha 1 where known.
@group(0) @binding(2) var<storage, read_write> known: array<vec4<f32>>;
// That frame, filled.
@group(0) @binding(3) var<storage, read> filled: array<vec4<f32>>;
// The way in pixels, x right, y down.
@group(0) @binding(4) var<storage, read_write> motion: array<vec2<f32>>;

@compute @workgroup_size(8, 8)
fn know(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= reprojection.width || id.y >= reprojection.height {
        return;
    }
    let i = id.y * reprojection.width + id.x;
    let inverse = inverse_depths[i];
    known[i] = select(vec4(0.0), vec4(inverse, 0.0, 0.0, 1.0), inverse > 0.0);
}

fn at(v: array<vec4<f32>, 3>, x: f32, y: f32) -> vec3<f32> {
    return v[0].xyz + v[1].xyz * x + v[2].xyz * y;
}

@compute @workgroup_size(8, 8)
fn shift(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= reprojection.width || id.y >= reprojection.height {
        return;
    }
    let i = id.y * reprojection.width + id.x;
    let inverse = filled[i].x;
    if inverse <= 0.0 {
        motion[i] = vec2(0.0);
        return;
    }
    let pixel = vec2(f32(id.x), f32(id.y));
    let size = vec2(f32(reprojection.width), f32(reprojection.height));
    let away = length(at(reprojection.direction, pixel.x, pixel.y));
    let seen = at(reprojection.base, pixel.x, pixel.y) + reprojection.parallax.xyz * (inverse * away);
    let ahead = max(seen.x, 1e-6);
    motion[i] = vec2(seen.y / ahead + 1.0, 1.0 - seen.z / ahead) * 0.5 * size - 0.5 - pixel;
}
