// Which pixels are sampled where densities follow importance. Twin of cpu/adaptive_mask.rs.
//
// Three passes: `weigh` finds the key of each pixel, the least density that samples it, and counts keys; `limit` finds the key
// below which as many lie as the fixed mask has samples; `choose` takes the pixels below it.

/// Where samples are taken. Twin of `AdaptiveSettings` in gpu/adaptive_mask.rs.
struct AdaptiveSettings {
    /// First column and row of the region.
    region_from: vec2u,
    /// Its columns and rows.
    region_size: vec2u,
    /// First column and row of the region with importance, and its columns and rows.
    known_from: vec2u,
    known_size: vec2u,
    /// Columns of its cells.
    columns: u32,
    /// One over the number of ranks.
    scale: f32,
}

/// Edge of a cell in pixels.
const CELL: u32 = 4;
/// Exponent of the least key that is told apart from 0, its place in the bits of numbers, and bins for each doubling.
const LEAST: u32 = 114;
const BITS: u32 = 9;
const FIRST_BIN: u32 = LEAST << BITS;
const BINS: u32 = 20u << BITS;
/// Bins of each thread of the workgroup that looks for the limit.
const BINS_OF_THREAD: u32 = BINS / BLOCK;
/// Places in `counts`: samples of the fixed mask, bits of the limit, and the bins.
const BUDGET: u32 = 0;
const LIMIT: u32 = 1;
const COUNTS: u32 = 2;
const INFINITE: u32 = 0x7f7fffffu;

/// Falloff of the fovea for each column, then for each row.
@group(0) @binding(3) var<storage, read> falloffs: array<f32>;
/// The fixed mask; then the adaptive one.
@group(0) @binding(4) var<storage, read_write> mask: array<u32>;
/// Importance of the cells, row by row.
@group(0) @binding(5) var<storage, read> importance: array<f32>;
@group(0) @binding(6) var<storage, read_write> keys: array<f32>;
@group(0) @binding(7) var<storage, read_write> counts: array<atomic<u32>>;
@group(0) @binding(8) var<uniform> adaptive: AdaptiveSettings;

/// Samples of the fixed mask and keys of the lowest bin, of a workgroup: many threads would wait for each other at the counts of
/// all.
var<workgroup> sampled: atomic<u32>;
var<workgroup> lowest: atomic<u32>;
/// One word for each row of the workgroup.
var<workgroup> words: array<atomic<u32>, 8>;

fn is_in_region(pixel: vec2u) -> bool {
    // Left of or above the region the difference wraps round to a large number.
    return all(pixel - adaptive.region_from < adaptive.region_size);
}

fn inverse_importance(pixel: vec2u) -> f32 {
    let at = pixel - adaptive.known_from;
    if any(at >= adaptive.known_size) {
        return 1.0;
    }
    let cell = at / CELL;
    return 1.0 / importance[cell.y * adaptive.columns + cell.x];
}

/// The least density λ with which `pixel` is sampled.
fn key_of(pixel: vec2u) -> f32 {
    let inverse = inverse_importance(pixel);
    let seen = falloffs[pixel.x] * falloffs[extent.width + pixel.y];
    let noise = (f32(rank(pixel)) + 0.5) * adaptive.scale;
    return max(noise - seen, 0.0) * inverse / max(1.0 - seen, 1.17549435e-38);
}

fn bin_of(key: f32) -> u32 {
    let at = max(bitcast<u32>(key) >> (23u - BITS), FIRST_BIN) - FIRST_BIN;
    return min(at, BINS - 1u);
}

/// Bits of the lower end of bin number `at`.
fn lower_end(at: u32) -> u32 {
    return (FIRST_BIN + at) << (23u - BITS);
}

@compute @workgroup_size(32, 8)
fn weigh(@builtin(global_invocation_id) pixel: vec3u, @builtin(local_invocation_index) thread: u32) {
    if thread == 0u {
        atomicStore(&sampled, 0u);
        atomicStore(&lowest, 0u);
    }
    workgroupBarrier();
    if pixel.x < extent.width && pixel.y < extent.height && is_in_region(pixel.xy) {
        let word = mask[pixel.y * words_per_row(extent) + pixel.x / 32u];
        if (word >> (pixel.x % 32u) & 1u) != 0u {
            atomicAdd(&sampled, 1u);
        }
        let key = key_of(pixel.xy);
        keys[pixel.y * extent.width + pixel.x] = key;
        let bin = bin_of(key);
        if bin == 0u {
            atomicAdd(&lowest, 1u);
        } else {
            atomicAdd(&counts[COUNTS + bin], 1u);
        }
    }
    workgroupBarrier();
    if thread == 0u {
        atomicAdd(&counts[BUDGET], atomicLoad(&sampled));
        atomicAdd(&counts[COUNTS], atomicLoad(&lowest));
    }
}

/// Finds the limit, by one workgroup: the nearer end of the bin in which the budget is reached.
@compute @workgroup_size(BLOCK)
fn limit(@builtin(local_invocation_index) thread: u32) {
    let budget = atomicLoad(&counts[BUDGET]);
    let first = thread * BINS_OF_THREAD;
    var sum = 0u;
    for (var i = 0u; i < BINS_OF_THREAD; i += 1u) {
        sum += atomicLoad(&counts[COUNTS + first + i]);
    }
    let reached = inclusive_sum(thread, sum);
    var below = reached - sum;
    let is_reached_here = reached >= budget && (below < budget || (thread == 0u && budget == 0u));
    if is_reached_here {
        for (var i = 0u; i < BINS_OF_THREAD; i += 1u) {
            let together = below + atomicLoad(&counts[COUNTS + first + i]);
            if together >= budget {
                let leaves_out = budget - below < together - budget;
                atomicStore(&counts[LIMIT], lower_end(first + select(i + 1u, i, leaves_out)));
                break;
            }
            below = together;
        }
    } else if thread == BLOCK - 1u && reached < budget {
        atomicStore(&counts[LIMIT], INFINITE);
    }
}

/// Decides 32 pixels of each of 8 rows.
@compute @workgroup_size(32, 8)
fn choose(
    @builtin(global_invocation_id) pixel: vec3u,
    @builtin(local_invocation_id) local: vec3u,
    @builtin(workgroup_id) group: vec3u,
) {
    if local.x == 0u {
        atomicStore(&words[local.y], 0u);
    }
    workgroupBarrier();
    let inside = pixel.x < extent.width && pixel.y < extent.height && is_in_region(pixel.xy);
    if inside && keys[pixel.y * extent.width + pixel.x] < bitcast<f32>(atomicLoad(&counts[LIMIT])) {
        atomicOr(&words[local.y], 1u << local.x);
    }
    workgroupBarrier();
    if local.x == 0u && pixel.y < extent.height {
        mask[pixel.y * words_per_row(extent) + group.x] = atomicLoad(&words[local.y]);
    }
}
