// From pixels to the samples of their rays. Twin of scene/segment.rs.

/// The camera, as `RayBasis` has it. Twin of `View` in gpu/view.rs.
struct View {
    /// The eye in voxels.
    eye: vec3f,
    /// Directions in world space whose sum is the direction of a pixel. Parallel rays have the first as direction, and the
    /// others are between their origins.
    forward: vec3f,
    /// Whether rays are parallel.
    parallel: u32,
    /// To the right edge.
    right: vec3f,
    /// To the upper edge.
    up: vec3f,
    /// Seed of the frame's noise, low word first.
    noise_seed: vec2u,
    /// Whether its ranks are hashed from the seed rather than read from a tile.
    noise_hashed: u32,
    /// Number of its ranks.
    noise_levels: f32,
}

@group(1) @binding(0) var<uniform> extent: Extent;
@group(1) @binding(1) var<uniform> view: View;

/// The samples of one ray: sample k lies at `start + k·delta`.
struct Segment {
    start: vec3f,
    delta: vec3f,
    /// Number of samples.
    count: f32,
    /// Number of steps through the box, with a fraction.
    length: f32,
    /// The distance of the first sample from the eye in world units.
    distance: f32,
}

/// Fewest voxels per world unit at which a ray moves along an axis. Slower rays count as parallel to the face: they stay in
/// place along the whole box.
const PARALLEL: f32 = 1e-12;

/// The samples of the ray through the centre of `pixel`.
fn segment_of(pixel: vec2u) -> Segment {
    let at = (vec2f(pixel) + 0.5) / vec2f(f32(extent.width), f32(extent.height)) * 2.0 - 1.0;
    let sideways = view.right * at.x - view.up * at.y;
    let is_parallel = view.parallel != 0u;
    let eye = view.eye + select(vec3f(0.0), sideways * scene.to_voxels, is_parallel);
    let direction = select(normalize(view.forward + sideways), view.forward, is_parallel) * scene.to_voxels;
    let parallel = abs(direction) < vec3f(PARALLEL);
    let inverse = 1.0 / select(direction, vec3f(1.0), parallel);
    let a = (scene.box_low - eye) * inverse;
    let b = (scene.box_high - eye) * inverse;
    let outside = (eye < scene.box_low) | (eye > scene.box_high);
    let enters = select(min(a, b), vec3f(0.0), parallel);
    let leaves = select(max(a, b), select(vec3f(NEVER), vec3f(-1.0), outside), parallel);
    var near = max(max(enters.x, enters.y), max(enters.z, 0.0));
    var far = min(leaves.x, min(leaves.y, leaves.z));
    for (var i = 0u; i < PLANES; i += 1u) {
        let plane = scene.planes[i];
        let along = dot(plane.xyz, direction);
        let within = dot(plane, vec4f(eye, 1.0));
        let crossing = -within / select(along, 1.0, along == 0.0);
        near = select(near, max(near, crossing), along > 0.0);
        far = select(far, min(far, crossing), along < 0.0);
        far = select(far, -1.0, along == 0.0 && within < 0.0);
    }
    // Samples k with k + ½ < (far − near)/Δ; never more than on the diagonal, however far away the eye is.
    let most = ceil(length((scene.box_high - scene.box_low) / scene.to_voxels) / scene.delta);
    let length = select(0.0, min((far - near) / scene.delta, most), near < far);
    let count = select(0.0, clamp(ceil((far - near) / scene.delta - 0.5), 0.0, most), near < far);
    let distance = fma(0.5, scene.delta, near);
    return Segment(fma(direction, vec3f(distance), eye), direction * scene.delta, count, length, distance);
}

/// 1/`delta`, 0 where a ray does not move.
fn inverse_of(delta: vec3f) -> vec3f {
    let still = abs(delta) < vec3f(PARALLEL);
    return select(1.0 / select(delta, vec3f(1.0), still), vec3f(0.0), still);
}
