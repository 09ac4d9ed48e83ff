// The trilinear field. Twin of cpu/field.rs.
//
// Voxels are loaded and interpolated here. field_filtered.wgsl leaves this to a sampler, whose weights are multiples of 1/256.
// Steep transfer functions make these steps visible.

/// Voxels at the type they are stored in.
@group(0) @binding(1) var volume: texture_3d<u32>;

/// Whether a texel also holds its neighbours along y and z. Two texels are then the eight corners of a cell.
override CORNERS: bool = false;
/// Whether texels are the bits of an f32.
override FLOATS: bool = false;

/// Stored values at (y, z), (y + 1, z), (y, z + 1) and (y + 1, z + 1) of the column at `cell`.
///
/// Loads beyond the last voxel return any voxel, which interpolation multiplies by 0.
fn column(cell: vec3i) -> vec4f {
    var texels = textureLoad(volume, cell, 0);
    if !CORNERS {
        texels.y = textureLoad(volume, cell + vec3i(0, 1, 0), 0).x;
        texels.z = textureLoad(volume, cell + vec3i(0, 0, 1), 0).x;
        texels.w = textureLoad(volume, cell + vec3i(0, 1, 1), 0).x;
    }
    if FLOATS {
        return bitcast<vec4f>(texels);
    }
    return vec4f(texels);
}

/// Value of the voxel nearest to `p`, as `field` has it.
fn nearest(p: vec3f) -> f32 {
    let found = column(vec3i(clamp(p, vec3f(0.0), scene.last) + 0.5)).x;
    if GAPS && found < 0.0 {
        return f32(scene.last_entry + 1u);
    }
    return found * scene.scale;
}

/// Trilinear value at `p`, clamped to the edge, as a fractional entry of the transfer table. It is the entry of NaN if one of
/// the eight voxels around `p` is NaN.
fn field(p: vec3f) -> f32 {
    if NEAREST {
        return nearest(p);
    }
    let clamped = clamp(p, vec3f(0.0), scene.last);
    let cell = vec3i(clamped);
    let f = clamped - vec3f(cell);
    let low = column(cell);
    let high = column(cell + vec3i(1, 0, 0));
    if GAPS && (any(low < vec4f(0.0)) || any(high < vec4f(0.0))) {
        return f32(scene.last_entry + 1u);
    }
    let along_x = fma(vec4f(f.x), high - low, low);
    let along_y = fma(vec2f(f.y), along_x.yw - along_x.xz, along_x.xz);
    return fma(f.z, along_y.y - along_y.x, along_y.x) * scene.scale;
}
