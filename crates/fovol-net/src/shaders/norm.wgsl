// Normalisation over all channels and pixels of a frame. Twin of cpu/norm.rs.
//
// Threads compute mean and sum of squared deviations of their elements. Pairs of these are merged (Chan, Golub and
// LeVeque 1979), which avoids the cancellation of two large sums.

/// Number of the activation, see `activated`.
override ACTIVATION: u32;
/// Whether input and output are f16, one bit each.
override HALVES: u32;

const THREADS = 256u;
/// Number of workgroups that read the tensor, as in gpu/tensor/layout.rs.
const GROUPS = 64u;
/// ε that is added to the variance.
const EPSILON = 1e-5;

/// Count and mean of some numbers, and the sum of their squared deviations from the mean.
struct Moments {
    count: f32,
    mean: f32,
    squares: f32,
    unused: f32,
}

@group(0) @binding(0) var<uniform> shape: Shape;
@group(0) @binding(1) var<storage, read> tensor: array<vec2u>;
/// Moments of each workgroup. After `merge` the first entry has the moments of all.
@group(0) @binding(2) var<storage, read_write> moments: array<Moments>;
@group(0) @binding(3) var<storage, read> weights: array<vec4f>;
@group(0) @binding(4) var<storage, read> biases: array<vec4f>;
@group(0) @binding(5) var<storage, read_write> result: array<vec2u>;

var<workgroup> parts: array<Moments, THREADS>;

fn merged(a: Moments, b: Moments) -> Moments {
    let count = a.count + b.count;
    if count == 0.0 {
        return a;
    }
    let share = b.count / count;
    let apart = b.mean - a.mean;
    return Moments(count, a.mean + apart * share, a.squares + b.squares + apart * apart * a.count * share, 0.0);
}

/// Merges the moments of all threads. All threads of a workgroup must call it.
fn merged_parts(thread: u32, part: Moments) -> Moments {
    parts[thread] = part;
    for (var reach = THREADS / 2u; reach > 0u; reach /= 2u) {
        workgroupBarrier();
        if thread < reach {
            parts[thread] = merged(parts[thread], parts[thread + reach]);
        }
    }
    workgroupBarrier();
    return parts[0];
}

fn number(i: u32) -> vec4f {
    if extractBits(HALVES, 0u, 1u) == 1u {
        return from_halves(tensor[i]);
    }
    return bitcast<vec4f>(vec4u(tensor[2u * i], tensor[2u * i + 1u]));
}

/// Moments of the first `count` of four numbers.
fn moments_of(numbers: vec4f, count: u32) -> Moments {
    let is_counted = vec4u(0u, 1u, 2u, 3u) < vec4u(count);
    let counted = select(vec4f(0.0), numbers, is_counted);
    let mean = dot(counted, vec4f(1.0)) / f32(count);
    let apart = select(vec4f(0.0), numbers - mean, is_counted);
    return Moments(f32(count), mean, dot(apart, apart), 0.0);
}

@compute @workgroup_size(THREADS)
fn measure(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) thread: u32) {
    let pixels = shape.width * shape.height;
    var part = Moments();
    for (var i = group.x * THREADS + thread; i < pixels * shape.blocks; i += GROUPS * THREADS) {
        let left = shape.channels - 4u * (i / pixels);
        part = merged(part, moments_of(number(i), min(left, 4u)));
    }
    let all = merged_parts(thread, part);
    if thread == 0u {
        moments[group.x] = all;
    }
}

/// Merges the moments of all workgroups, in one workgroup.
@compute @workgroup_size(THREADS)
fn merge(@builtin(local_invocation_index) thread: u32) {
    var part = Moments();
    if thread < GROUPS {
        part = moments[thread];
    }
    let all = merged_parts(thread, part);
    if thread == 0u {
        moments[0] = all;
    }
}

@compute @workgroup_size(8, 8)
fn normalise(@builtin(global_invocation_id) at: vec3u) {
    if !is_inside(shape, at) {
        return;
    }
    let all = moments[0];
    let factor = weights[at.z] * inverseSqrt(all.squares / all.count + EPSILON);
    let i = place(shape, at.x, at.y, at.z);
    let value = activated((number(i) - all.mean) * factor + biases[at.z], ACTIVATION);
    if extractBits(HALVES, 1u, 1u) == 1u {
        result[i] = to_halves(value);
    } else {
        let words = bitcast<vec4u>(value);
        result[2u * i] = words.xy;
        result[2u * i + 1u] = words.zw;
    }
}
