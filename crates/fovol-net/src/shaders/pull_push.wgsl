// Pull-push: fills frames by averages over growing squares. Twin of fill/pull_push.rs.
//
// Levels lie one after the other in one buffer, each row by row, as premultiplied colours and weights.

/// Two neighbouring levels. Twin of `Levels` in gpu/fill/pull_push.rs.
struct Levels {
    fine_width: u32,
    fine_height: u32,
    coarse_width: u32,
    coarse_height: u32,
    /// Index of the first pixel of each level.
    fine_first: u32,
    coarse_first: u32,
    unused: vec2u,
}

@group(0) @binding(0) var<uniform> levels: Levels;
@group(0) @binding(1) var<storage, read_write> pixels: array<vec4f>;
/// Sparse frame, row by row; alpha is above ½ where a pixel was sampled.
@group(0) @binding(2) var<storage, read> sparse: array<vec4f>;
@group(0) @binding(3) var<storage, read_write> filled: array<vec4f>;

fn fine_place(x: u32, y: u32) -> u32 {
    return levels.fine_first + y * levels.fine_width + x;
}

fn coarse_place(x: u32, y: u32) -> u32 {
    return levels.coarse_first + y * levels.coarse_width + x;
}

fn is_fine(at: vec2u) -> bool {
    return at.x < levels.fine_width && at.y < levels.fine_height;
}

/// Loads the samples into the finest level.
@compute @workgroup_size(8, 8)
fn load(@builtin(global_invocation_id) at: vec3u) {
    if is_fine(at.xy) {
        let pixel = sparse[at.y * levels.fine_width + at.x];
        pixels[fine_place(at.x, at.y)] = select(vec4f(0.0), vec4f(pixel.rgb, 1.0), pixel.a > 0.5);
    }
}

/// Pixel of the fine level; zero beyond the border.
fn fine_or_nothing(x: u32, y: u32) -> vec4f {
    if is_fine(vec2u(x, y)) {
        return pixels[fine_place(x, y)];
    }
    return vec4f(0.0);
}

/// Pulls to half the size, rounded up: sums of 2×2 pixels, with the weight limited to 1.
@compute @workgroup_size(8, 8)
fn pull(@builtin(global_invocation_id) at: vec3u) {
    if at.x >= levels.coarse_width || at.y >= levels.coarse_height {
        return;
    }
    let x = 2u * at.x;
    let y = 2u * at.y;
    let sum = fine_or_nothing(x, y) + fine_or_nothing(x + 1u, y) + fine_or_nothing(x, y + 1u)
        + fine_or_nothing(x + 1u, y + 1u);
    pixels[coarse_place(at.x, at.y)] = sum / max(sum.a, 1.0);
}

/// Divides the single pixel of the coarsest level by its weight.
@compute @workgroup_size(1)
fn divide() {
    let i = levels.coarse_first;
    let pixel = pixels[i];
    if pixel.a > 0.0 {
        pixels[i] = pixel / pixel.a;
    } else {
        pixels[i] = vec4f(0.0, 0.0, 0.0, 1.0);
    }
}

/// The two coarse pixels around the centre of a fine pixel, and its position between them, 0…1.
struct Neighbours {
    first: u32,
    second: u32,
    part: f32,
}

fn neighbours(i: u32, count: u32) -> Neighbours {
    if i % 2u == 0u {
        return Neighbours(max(i / 2u, 1u) - 1u, i / 2u, 0.75);
    }
    return Neighbours(i / 2u, min(i / 2u + 1u, count - 1u), 0.25);
}

/// Pushes: blends every fine pixel with the bilinear value of the coarse level, by the weight that is missing to 1.
@compute @workgroup_size(8, 8)
fn push(@builtin(global_invocation_id) at: vec3u) {
    if !is_fine(at.xy) {
        return;
    }
    let i = fine_place(at.x, at.y);
    let pixel = pixels[i];
    if pixel.a >= 1.0 {
        return;
    }
    let x = neighbours(at.x, levels.coarse_width);
    let y = neighbours(at.y, levels.coarse_height);
    let a = pixels[coarse_place(x.first, y.first)].rgb;
    let b = pixels[coarse_place(x.second, y.first)].rgb;
    let c = pixels[coarse_place(x.first, y.second)].rgb;
    let d = pixels[coarse_place(x.second, y.second)].rgb;
    let top = a + x.part * (b - a);
    let low = c + x.part * (d - c);
    pixels[i] = vec4f(pixel.rgb + (1.0 - pixel.a) * (top + y.part * (low - top)), 1.0);
}

/// Writes the filled frame, with samples unchanged.
@compute @workgroup_size(8, 8)
fn finish(@builtin(global_invocation_id) at: vec3u) {
    if is_fine(at.xy) {
        let i = at.y * levels.fine_width + at.x;
        let sample = sparse[i];
        filled[i] = select(vec4f(pixels[fine_place(at.x, at.y)].rgb, 1.0), sample, sample.a > 0.5);
    }
}
