// The medium of rays where it is several volumes at the same points, or voxels that have colours. It replaces medium.wgsl.
// Twin of cpu/layered.rs.
//
// The first volume is that of `field`. The tables of all volumes lie one after the other.

/// Number of volumes, up to four.
override VOLUMES: u32 = 1;
/// Which volumes' voxels have colours, one bit each.
override COLOURED: u32 = 0;
/// Which volumes' colours are the bits of an f32, one bit each.
override COLOUR_FLOATS: u32 = 0;
/// Which further volumes' texels are the bits of an f32, one bit each.
override LAYER_FLOATS: u32 = 0;
/// Which volumes have voxels that are NaN, one bit each.
override LAYER_GAPS: u32 = 0;
/// Which volumes' values are those of the nearest voxel, one bit each.
override LAYER_NEAREST: u32 = 0;
/// Which volumes' opacities depend on the gradient, one bit each.
override THINNED: u32 = 0;

/// Numbers of a volume. Twin of `LayerNumbers` in gpu/layers.rs.
struct LayerNumbers {
    /// From stored colours to 0…1.
    colour_scale: vec3f,
    /// From stored values to entries of the volume's tables.
    scale: f32,
    /// Where its tables begin.
    table: u32,
    /// Entry of the largest value; after it comes that of NaN.
    last_entry: u32,
    /// Where the factors of its extinction by gradient begin in `extinction`, and their last index.
    factors: u32,
    last_factor: f32,
    /// From stored lengths of gradients to indices of the factors.
    length_scale: f32,
    /// The primary step in voxels.
    step: f32,
    unused_0: u32,
    unused_1: u32,
}

@group(0) @binding(9) var<uniform> layers: array<LayerNumbers, 4>;
/// Voxels of further volumes at the type they are stored in.
@group(0) @binding(10) var volume_1: texture_3d<u32>;
@group(0) @binding(11) var volume_2: texture_3d<u32>;
@group(0) @binding(12) var volume_3: texture_3d<u32>;
/// Red, green and blue of the voxels of each volume.
@group(0) @binding(13) var colours_0: texture_3d<u32>;
@group(0) @binding(14) var colours_1: texture_3d<u32>;
@group(0) @binding(15) var colours_2: texture_3d<u32>;
@group(0) @binding(16) var colours_3: texture_3d<u32>;
/// Lengths of the gradients of each volume.
@group(0) @binding(17) var lengths_0: texture_3d<u32>;
@group(0) @binding(18) var lengths_1: texture_3d<u32>;
@group(0) @binding(19) var lengths_2: texture_3d<u32>;
@group(0) @binding(20) var lengths_3: texture_3d<u32>;

/// Whether `bits` have that of volume `n`.
fn is_of(bits: u32, n: u32) -> bool {
    return (bits >> n & 1u) == 1u;
}

fn table_of(n: u32) -> u32 {
    return layers[n].table;
}

fn last_entry_of(n: u32) -> u32 {
    return layers[n].last_entry;
}

fn has_gaps_of(n: u32) -> bool {
    return is_of(LAYER_GAPS, n);
}

fn is_nearest_of(n: u32) -> bool {
    return is_of(LAYER_NEAREST, n);
}

/// Stored value of the voxel at `cell` of further volume `n`.
fn voxel_of(n: u32, cell: vec3i) -> f32 {
    var texel = 0u;
    switch n {
        case 1u: { texel = textureLoad(volume_1, cell, 0).x; }
        case 2u: { texel = textureLoad(volume_2, cell, 0).x; }
        default: { texel = textureLoad(volume_3, cell, 0).x; }
    }
    if is_of(LAYER_FLOATS, n) {
        return bitcast<f32>(texel);
    }
    return f32(texel);
}

/// Stored values of further volume `n` at (y, z), (y + 1, z), (y, z + 1) and (y + 1, z + 1) of the column at `cell`.
fn column_of(n: u32, cell: vec3i) -> vec4f {
    return vec4f(
        voxel_of(n, cell),
        voxel_of(n, cell + vec3i(0, 1, 0)),
        voxel_of(n, cell + vec3i(0, 0, 1)),
        voxel_of(n, cell + vec3i(0, 1, 1)),
    );
}

/// Value of volume `n` at `p` as a fractional entry of its tables, as `field` has it.
fn field_of(n: u32, p: vec3f) -> f32 {
    if n == 0u {
        return field(p);
    }
    let clamped = clamp(p, vec3f(0.0), scene.last);
    let gap = f32(last_entry_of(n) + 1u);
    if is_nearest_of(n) {
        let found = voxel_of(n, vec3i(clamped + 0.5));
        return select(found * layers[n].scale, gap, has_gaps_of(n) && found < 0.0);
    }
    let cell = vec3i(clamped);
    let f = clamped - vec3f(cell);
    let low = column_of(n, cell);
    let high = column_of(n, cell + vec3i(1, 0, 0));
    if has_gaps_of(n) && (any(low < vec4f(0.0)) || any(high < vec4f(0.0))) {
        return gap;
    }
    let along_x = fma(vec4f(f.x), high - low, low);
    let along_y = fma(vec2f(f.y), along_x.yw - along_x.xz, along_x.xz);
    return fma(f.z, along_y.y - along_y.x, along_y.x) * layers[n].scale;
}

/// Stored colours of the voxel at `cell` of volume `n`.
fn stored_colours(n: u32, cell: vec3i) -> vec3f {
    var texel = vec3u(0u);
    switch n {
        case 0u: { texel = textureLoad(colours_0, cell, 0).rgb; }
        case 1u: { texel = textureLoad(colours_1, cell, 0).rgb; }
        case 2u: { texel = textureLoad(colours_2, cell, 0).rgb; }
        default: { texel = textureLoad(colours_3, cell, 0).rgb; }
    }
    if is_of(COLOUR_FLOATS, n) {
        return bitcast<vec3f>(texel);
    }
    return vec3f(texel);
}

/// Stored colours of volume `n` between the voxel at `cell` and the next one along x.
fn colours_along_x(n: u32, cell: vec3i, part: f32) -> vec3f {
    return mix(stored_colours(n, cell), stored_colours(n, cell + vec3i(1, 0, 0)), part);
}

/// Trilinear colours of volume `n` at `p`, clamped to the edge.
fn colours_of(n: u32, p: vec3f) -> vec3f {
    let clamped = clamp(p, vec3f(0.0), scene.last);
    let cell = vec3i(clamped);
    let f = clamped - vec3f(cell);
    let before = mix(colours_along_x(n, cell, f.x), colours_along_x(n, cell + vec3i(0, 1, 0), f.x), f.y);
    let behind = cell + vec3i(0, 0, 1);
    let after = mix(colours_along_x(n, behind, f.x), colours_along_x(n, behind + vec3i(0, 1, 0), f.x), f.y);
    return mix(before, after, f.z) * layers[n].colour_scale;
}

/// Stored length of the gradient of volume `n` at the voxel of `cell`.
fn stored_length(n: u32, cell: vec3i) -> f32 {
    switch n {
        case 0u: { return f32(textureLoad(lengths_0, cell, 0).x); }
        case 1u: { return f32(textureLoad(lengths_1, cell, 0).x); }
        case 2u: { return f32(textureLoad(lengths_2, cell, 0).x); }
        default: { return f32(textureLoad(lengths_3, cell, 0).x); }
    }
}

/// Stored length of volume `n` between the voxel at `cell` and the next one along x.
fn length_along_x(n: u32, cell: vec3i, part: f32) -> f32 {
    return mix(stored_length(n, cell), stored_length(n, cell + vec3i(1, 0, 0)), part);
}

/// Length of the gradient of volume `n` at `p`, as an index of its factors. Twin of `Thinning` in cpu/thinning.rs.
fn length_of(n: u32, p: vec3f) -> f32 {
    if !is_of(THINNED, n) {
        return 0.0;
    }
    let clamped = clamp(p, vec3f(0.0), scene.last);
    var stored = 0.0;
    if is_nearest_of(n) {
        stored = stored_length(n, vec3i(clamped + 0.5));
    } else {
        let cell = vec3i(clamped);
        let f = clamped - vec3f(cell);
        let behind = cell + vec3i(0, 0, 1);
        let before = mix(length_along_x(n, cell, f.x), length_along_x(n, cell + vec3i(0, 1, 0), f.x), f.y);
        let after = mix(length_along_x(n, behind, f.x), length_along_x(n, behind + vec3i(0, 1, 0), f.x), f.y);
        stored = mix(before, after, f.z);
    }
    return min(stored * layers[n].length_scale, layers[n].last_factor);
}

/// Extinction of volume `n` at `entry` of its tables, at a gradient of `length`, on which that of NaN does not depend.
fn thinned(n: u32, entry: u32, length: f32) -> f32 {
    let whole = bitcast<f32>(extinction[table_of(n) + entry]);
    let factor = bitcast<f32>(extinction[layers[n].factors + u32(length + 0.5)]);
    return select(whole * factor, whole, entry > last_entry_of(n));
}

/// Extinction of volume `n` at `p`, where its tables have `entry`.
fn extinction_of(n: u32, p: vec3f, entry: u32) -> f32 {
    if is_of(THINNED, n) {
        return thinned(n, entry, length_of(n, p));
    }
    return bitcast<f32>(extinction[table_of(n) + entry]);
}

/// Transmittance of `steps` primary steps through matter of volume `n` with `extinction`.
fn passing(n: u32, extinction: f32, steps: f32) -> f32 {
    return exp(-extinction * steps * layers[n].step);
}

/// Transmittance of `steps` primary steps through volume `n` at `entry` of its tables, and at a gradient of `length`.
fn passing_of(n: u32, entry: u32, length: f32, steps: f32) -> f32 {
    if is_of(THINNED, n) {
        return passing(n, thinned(n, entry, length), steps);
    }
    return pow(1.0 - shadow_alpha[table_of(n) + entry], steps / SHADOW_STEP);
}

/// Packs a colour as the transfer table does.
fn packed_colour(rgb: vec3f) -> u32 {
    let fields = vec3u(min(rgb, vec3f(1.0)) * vec3f(2047.0, 2047.0, 1023.0) + 0.5);
    return fields.r | fields.g << 11u | fields.b << 22u;
}

/// Opacity and colour of all volumes at `p`: opacities add as extinctions, colours weigh by their extinction.
fn look_at(p: vec3f) -> vec2u {
    var clear = 1.0;
    var whole = 0.0;
    var sums = vec3f(0.0);
    for (var n = 0u; n < VOLUMES; n += 1u) {
        let at = entry(field_of(n, p));
        let looks = appearance[table_of(n) + at];
        let weight = extinction_of(n, p, at);
        if weight > 0.0 {
            var rgb = colour_of(looks.y);
            if is_of(COLOURED, n) {
                rgb = colours_of(n, p);
            }
            var alpha = bitcast<f32>(looks.x);
            if is_of(THINNED, n) {
                alpha = 1.0 - passing(n, weight, 1.0);
            }
            clear *= 1.0 - alpha;
            whole += weight;
            sums += weight * rgb;
        }
    }
    if whole == 0.0 {
        return vec2u(0u);
    }
    return vec2u(bitcast<u32>(1.0 - clear), packed_colour(sums / whole));
}

/// α of one shadow step through volume `n` at `p`.
fn own_shadow_alpha(n: u32, p: vec3f) -> f32 {
    let at = entry(field_of(n, p));
    if is_of(THINNED, n) {
        return 1.0 - passing(n, extinction_of(n, p, at), SHADOW_STEP);
    }
    return shadow_alpha[table_of(n) + at];
}

/// α of one shadow step through all volumes at `p`.
fn shadow_alpha_of(p: vec3f) -> f32 {
    var clear = 1.0;
    for (var n = 0u; n < VOLUMES; n += 1u) {
        clear *= 1.0 - own_shadow_alpha(n, p);
    }
    return 1.0 - clear;
}

/// |n·l| of volume `n`, as `facing` has it for one volume.
fn own_facing(n: u32, p: vec3f) -> f32 {
    let x = vec3f(1.0, 0.0, 0.0);
    let y = vec3f(0.0, 1.0, 0.0);
    let z = vec3f(0.0, 0.0, 1.0);
    let after = vec3f(field_of(n, p + x), field_of(n, p + y), field_of(n, p + z));
    let before = vec3f(field_of(n, p - x), field_of(n, p - y), field_of(n, p - z));
    if has_gaps_of(n) && any(max(after, before) > vec3f(f32(last_entry_of(n)) + 0.5)) {
        return 1.0;
    }
    let gradient = (after - before) * scene.to_voxels;
    let steepness = length(gradient);
    return select(1.0, abs(dot(gradient, scene.light_direction) / steepness), steepness > 0.0);
}

/// Mean of the volumes' own |n·l| at `p`, weighted by their extinction.
fn facing(p: vec3f) -> f32 {
    var whole = 0.0;
    var sum = 0.0;
    for (var n = 0u; n < VOLUMES; n += 1u) {
        let weight = extinction_of(n, p, entry(field_of(n, p)));
        if weight > 0.0 {
            whole += weight;
            sum += weight * own_facing(n, p);
        }
    }
    return select(1.0, sum / whole, whole > 0.0);
}
