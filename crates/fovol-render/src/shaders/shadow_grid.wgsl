// Transmittance towards the light at every voxel, swept through the volume slice by slice. Twin of cpu/light_sweep.rs.
//
// For each slice `cross` takes columns of light through it, and `keep` finds the light of its voxels from the columns around
// them. Four voxels along z share a texel.

/// A slice, and how columns cross it. Twin of `Slice` in gpu/shadow_grid.rs.
struct Slice {
    /// Whole voxels and rest of the columns' way, from row to row and along rows.
    whole: vec2i,
    part: vec2f,
    /// First column that is kept, and the number of columns, from row to row and along rows.
    first: vec2i,
    columns: vec2u,
    /// Rows of the slice and voxels of a row.
    size: vec2u,
    /// Voxel along the axis across the slices.
    voxel: u32,
    /// Axes across the slices, from row to row, and along rows.
    deep: u32,
    down: u32,
    along: u32,
    /// Primary steps from slice to slice.
    steps: f32,
    /// Where the first sample of a shadow ray lies, as a part of the way to the slice before.
    near: f32,
}

@group(1) @binding(0) var<uniform> slice: Slice;
/// Of each column the transmittance before the last slice, that of the last slice, and its entry in the transfer table. Where
/// there is more, entries of further volumes follow for all columns, and lengths of gradients.
@group(1) @binding(1) var<storage, read_write> columns: array<vec4f>;
/// Light that comes to each column in a slice. There is room for four slices, by their voxels along z.
@group(1) @binding(2) var<storage, read_write> lights: array<f32>;
/// rgba8unorm is the narrowest format that every device writes and filters. Channel c holds voxel 4k + c along z.
@group(1) @binding(3) var shadow_grid: texture_storage_3d<rgba8unorm, write>;
/// The four slices whose voxels share texels, where light crosses z; else the same slice four times.
@group(1) @binding(4) var<uniform> together: array<Slice, 4>;

/// Length of the first stretch of a shadow ray, in slices.
const FIRST_STRETCH: f32 = 1.5;

/// Whether columns have entries of further volumes, or lengths of gradients.
override MORE: bool = false;

fn number_of_columns() -> u32 {
    return slice.columns.x * slice.columns.y;
}

/// Place of the column that crosses slice `crossed` at or after voxel `at`, from row to row and along rows.
fn column_at(crossed: Slice, at: vec2i) -> u32 {
    let place = vec2u(at - crossed.whole - crossed.first);
    return place.x * crossed.columns.y + place.y;
}

fn is_inside(p: vec3f) -> bool {
    var inside = all(p >= scene.box_low) && all(p <= scene.box_high);
    for (var i = 0u; i < PLANES; i += 1u) {
        inside = inside && dot(scene.planes[i], vec4f(p, 1.0)) >= 0.0;
    }
    return inside;
}

/// Transmittance of `slices` slices at an entry of volume `n`, which may be that of NaN, and at a gradient of `length`.
fn through(n: u32, number: f32, length: f32, slices: f32) -> f32 {
    return passing_of(n, entry(number), length, slices * slice.steps);
}

/// Part of the way to the slice before, at which a shadow ray takes its first sample of volume `n`.
fn near_part(n: u32) -> f32 {
    return select(slice.near, floor(slice.near + 0.5), is_nearest_of(n));
}

/// Entry of volume `n` where a shadow ray takes its first sample, between entry `here` and the one in the slice before.
fn first_entry(n: u32, here: f32, beyond: f32) -> f32 {
    let last = f32(last_entry_of(n)) + 0.5;
    if has_gaps_of(n) && !is_nearest_of(n) && max(here, beyond) > last {
        return last + 0.5;
    }
    return mix(here, beyond, near_part(n));
}

@compute @workgroup_size(8, 8)
fn cross(@builtin(global_invocation_id) thread: vec3u) {
    // From voxel −1 on: columns before the first voxel lie beside it.
    let at = vec2i(thread.yx) - 1;
    if any(at >= vec2i(slice.size)) {
        return;
    }
    var p = vec3f(f32(slice.voxel));
    p[slice.down] = f32(at.x) + slice.part.x;
    p[slice.along] = f32(at.y) + slice.part.y;
    let i = column_at(slice, at);
    let before = columns[i];
    // Entries of further volumes, and lengths of gradients.
    let more = vec2u(i) + vec2u(1u, 2u) * number_of_columns();
    var entries = vec4f(before.z, 0.0, 0.0, 0.0);
    var lengths = vec4f(0.0);
    if MORE {
        entries = vec4f(before.z, columns[more.x].xyz);
        lengths = columns[more.y];
    }
    let is_first_lit = is_inside(p + slice.near * slice.steps * scene.light_delta);
    let is_lit = is_inside(p);
    var light = before.x;
    var now = 1.0;
    for (var n = 0u; n < VOLUMES; n += 1u) {
        let here = field_of(n, p);
        // A column that has crossed no slice has a negative entry.
        let beyond = select(entries[n], here, before.z < 0.0);
        let length = length_of(n, p);
        let length_beyond = select(lengths[n], length, before.z < 0.0);
        if is_first_lit {
            let near_length = mix(length, length_beyond, near_part(n));
            light *= through(n, first_entry(n, here, beyond), near_length, FIRST_STRETCH);
        }
        if is_lit {
            now *= through(n, here, length, 1.0);
        }
        entries[n] = here;
        lengths[n] = length;
    }
    columns[i] = vec4f(before.x * before.y, now, entries[0], 0.0);
    if MORE {
        columns[more.x] = vec4f(entries.yzw, 0.0);
        columns[more.y] = lengths;
    }
    lights[select(0u, slice.voxel % 4u, slice.deep == 2u) * number_of_columns() + i] = light;
}

/// Light of the voxel at `at` in slice `crossed`, which is kept at `plane`.
fn light_of(crossed: Slice, at: vec2i, plane: u32) -> f32 {
    let begin = plane * number_of_columns();
    let i = begin + column_at(crossed, at);
    // Columns before and after the voxel from row to row.
    let share = 1.0 - crossed.part;
    let up = i - crossed.columns.y;
    let before = mix(lights[up - 1u], lights[i - 1u], share.x);
    let after = mix(lights[up], lights[i], share.x);
    return mix(before, after, share.y);
}

/// Keeps four voxels along z: of the last four slices where light crosses z, else of four rows of this slice.
@compute @workgroup_size(8, 8)
fn keep(@builtin(global_invocation_id) thread: vec3u) {
    let is_across_z = slice.deep == 2u;
    let rows = select((slice.size.x + 3u) / 4u, slice.size.x, is_across_z);
    if thread.x >= slice.size.y || thread.y >= rows {
        return;
    }
    var light = vec4f(0.0);
    for (var c = 0u; c < 4u; c += 1u) {
        if is_across_z {
            light[c] = light_of(together[c], vec2i(thread.yx), c);
        } else {
            let row = min(4u * thread.y + c, slice.size.x - 1u);
            light[c] = light_of(slice, vec2i(vec2u(row, thread.x)), 0u);
        }
    }
    var texel = vec3u(slice.voxel);
    texel[slice.along] = thread.x;
    texel[slice.down] = thread.y;
    if is_across_z {
        texel.z = slice.voxel / 4u;
    }
    textureStore(shadow_grid, texel, light);
}
