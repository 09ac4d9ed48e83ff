// Importance of samples for the next frame. Twin of src/guide/importance.rs, and of `Importance` in fovol-render.
//
// `blocks` sums pixels up, `errors` finds what is lost in each cell of 4×4 pixels, `blur` weighs it with its neighbours, and
// `relate` makes its mean 1.

/// Twin of `ImportanceSettings` in pipeline/gpu/guide/importance.rs.
struct ImportanceSettings {
    /// First column and row of the region, and its columns and rows.
    region_from: vec2u,
    region_size: vec2u,
    /// Columns of the frame.
    width: u32,
}

/// Whether light ratios are reconstructed, not colours.
override RATIOS: bool = false;

/// ε of light ratios.
const EPSILON: f32 = 0.02;
/// Share of the density that every place gets.
const FLOOR: f32 = 0.25;
/// Threads of the workgroup that finds the mean.
const THREADS: u32 = 256;

@group(0) @binding(0) var<uniform> settings: ImportanceSettings;
/// The reconstructed frame: colours, or light ratios.
@group(0) @binding(1) var<storage, read> frame: array<vec4f>;
/// Guide pixels of the region, row by row, where light ratios are reconstructed.
@group(0) @binding(2) var<storage, read> guide: array<vec4f>;
/// Means over 2×2 pixels of the frame's and of the guide's red, green and blue.
@group(0) @binding(3) var<storage, read_write> blocks: array<vec2f>;
/// Errors of the cells.
@group(0) @binding(4) var<storage, read_write> errors: array<f32>;
/// Importance of the cells.
@group(0) @binding(5) var<storage, read_write> importance: array<f32>;

fn number_of_blocks() -> vec2u {
    return (settings.region_size + 1u) / 2u;
}

fn number_of_cells() -> vec2u {
    return (settings.region_size + 3u) / 4u;
}

/// Sums of red, green and blue of a pixel of the region: of the frame and of the guide.
fn sums(at: vec2u) -> vec2f {
    let pixel = settings.region_from + at;
    let colour = frame[pixel.y * settings.width + pixel.x];
    var sums = vec2f(colour.r + colour.g + colour.b, 0.0);
    if RATIOS {
        let guide = guide[at.y * settings.region_size.x + at.x];
        sums.y = guide.r + guide.g + guide.b;
    }
    return sums;
}

@compute @workgroup_size(8, 8)
fn make_blocks(@builtin(global_invocation_id) at: vec3u) {
    let size = number_of_blocks();
    if any(at.xy >= size) {
        return;
    }
    let low = 2u * at.xy;
    let high = min(low + 1u, settings.region_size - 1u);
    let upper = sums(low) + sums(vec2u(high.x, low.y));
    blocks[at.y * size.x + at.x] = 0.25 * (upper + sums(vec2u(low.x, high.y)) + sums(high));
}

/// Error of block `at`: the slope of the colours, or the squared slope of the ratio times the guide that it scales.
fn error_of(place: vec2u) -> f32 {
    let size = number_of_blocks();
    let at = min(place, size - 1u);
    let low = max(at, vec2u(1u)) - 1u;
    let high = min(at + 1u, size - 1u);
    let across = blocks[at.y * size.x + high.x].x - blocks[at.y * size.x + low.x].x;
    let down = blocks[high.y * size.x + at.x].x - blocks[low.y * size.x + at.x].x;
    let squared = across * across + down * down;
    if RATIOS {
        let bright = blocks[at.y * size.x + at.x].y + 3.0 * EPSILON;
        return squared * bright * bright;
    }
    return sqrt(squared);
}

@compute @workgroup_size(8, 8)
fn make_errors(@builtin(global_invocation_id) at: vec3u) {
    let size = number_of_cells();
    if any(at.xy >= size) {
        return;
    }
    let low = 2u * at.xy;
    let upper = error_of(low) + error_of(low + vec2u(1u, 0u));
    errors[at.y * size.x + at.x] = 0.25 * (upper + error_of(low + vec2u(0u, 1u)) + error_of(low + 1u));
}

/// Number that the importance of a cell is proportional to; 0 where it is not finite.
@compute @workgroup_size(8, 8)
fn blur(@builtin(global_invocation_id) at: vec3u) {
    let size = number_of_cells();
    if any(at.xy >= size) {
        return;
    }
    var weights = array<f32, 3>(0.25, 0.5, 0.25);
    var sum = 0.0;
    for (var y = 0u; y < 3u; y += 1u) {
        for (var x = 0u; x < 3u; x += 1u) {
            let near = min(max(at.xy + vec2u(x, y), vec2u(1u)) - 1u, size - 1u);
            sum += weights[x] * weights[y] * errors[near.y * size.x + near.x];
        }
    }
    if RATIOS {
        // error^(9/16).
        let half = sqrt(sum);
        sum = half * sqrt(sqrt(sqrt(half)));
    }
    importance[at.y * size.x + at.x] = select(0.0, sum, sum >= 0.0 && sum < 3e38);
}

var<workgroup> totals: array<f32, THREADS>;

/// Scales the numbers so that their mean is 1, and raises the least ones, by one workgroup.
@compute @workgroup_size(THREADS)
fn relate(@builtin(local_invocation_index) thread: u32) {
    let size = number_of_cells();
    let number = size.x * size.y;
    var sum = 0.0;
    for (var i = thread; i < number; i += THREADS) {
        sum += importance[i];
    }
    totals[thread] = sum;
    for (var reach = THREADS / 2u; reach > 0u; reach /= 2u) {
        workgroupBarrier();
        if thread < reach {
            totals[thread] += totals[thread + reach];
        }
    }
    workgroupBarrier();
    let total = totals[0];
    let scale = select(0.0, f32(number) / total, total > 0.0);
    for (var i = thread; i < number; i += THREADS) {
        let relative = select(1.0, importance[i] * scale, scale > 0.0);
        importance[i] = FLOOR + (1.0 - FLOOR) * relative;
    }
}
