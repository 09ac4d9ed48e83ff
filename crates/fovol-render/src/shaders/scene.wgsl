// Volume, light and tables that rays need. Twin of `SceneNumbers` in gpu/scene.rs, which fills it in.
//
// Positions are voxel-centre coordinates (voxel i at i), distances along rays are world units.

/// Columns of space along the light direction, cut into slabs of one shadow step. Twin of `ColumnNumbers` in
/// gpu/light_columns.rs.
struct LightColumns {
    /// The axis along which light travels most voxels, and the two that follow it in turn.
    axes: vec3u,
    /// Where the first slab starts on the first of them, in voxels.
    origin: f32,
    /// Voxels along the other axes for each slab.
    shear: vec2f,
    /// Where the first columns start along these, in voxels.
    low: vec2f,
    /// The last column along each of these.
    last: vec2f,
    /// Slabs of a voxel, negative where light comes from below.
    slabs: f32,
    /// Columns of a voxel.
    density: f32,
}

struct Scene {
    /// The last voxel along each axis.
    last: vec3f,
    /// The sampling distance in world units.
    delta: f32,
    /// From world units to voxels.
    to_voxels: vec3f,
    /// From stored values to entries of the transfer table.
    scale: f32,
    /// Colour of the background.
    background: vec3f,
    /// The share of light that reaches every sample.
    ambient: f32,
    /// One primary step towards the light, in voxels.
    light_delta: vec3f,
    /// log2 of the edge of a macrocell in voxels.
    cell_shift: u32,
    /// The faces of the box that the light comes through.
    light_exit: vec3f,
    /// Extinction of one step that the integer 1 in a sum of extinctions stands for.
    extinction_unit: f32,
    /// 1/light_delta; 0 where the light is parallel to a face.
    light_inverse: vec3f,
    /// The entry of the largest value in the transfer table; after it comes that of NaN.
    last_entry: u32,
    /// The unit vector towards the light in world space.
    light_direction: vec3f,
    /// log2 of the transfer table's entries in a bin that colours are tabulated for.
    bin_bits: u32,
    /// The lowest corner of the part that is not cut off.
    box_low: vec3f,
    /// The value of the isosurface as an entry of the transfer table, with a fraction.
    iso: f32,
    /// The highest corner of that part.
    box_high: vec3f,
    unused: u32,
    /// Each plane's weights of x, y, z in voxels and a constant, whose sum is 0 or more on the side that is kept.
    planes: array<vec4f, 6>,
    /// The same for the number of primary steps along the light direction to each plane that light comes through.
    light_planes: array<vec4f, 6>,
    columns: LightColumns,
}

/// Whether rays jump over empty space.
override SKIP: bool = false;
/// How many planes cut the volume. A constant, since some drivers compile a shader for every command if a uniform limits
/// its loop.
override PLANES: u32 = 0;
/// Whether some voxels are NaN. They are stored as a large negative number.
override GAPS: bool = false;

/// Whether values are those of the nearest voxel rather than trilinear.
override NEAREST: bool = false;

/// Number of steps to the end of the box along an axis that a ray does not move on.
const NEVER: f32 = 1e30;

@group(0) @binding(0) var<uniform> scene: Scene;
/// Distance of each macrocell from anything visible; see skip.wgsl.
@group(0) @binding(2) var distances: texture_3d<u32>;
/// For every entry of the transfer table the bits of opacity for one step, and the colour: red 11 bits,
/// green 11 bits, blue 10 bits, red lowest.
@group(0) @binding(3) var<storage, read> appearance: array<vec2u>;
/// For every entry of the transfer table the opacity for one shadow step.
@group(0) @binding(4) var<storage, read> shadow_alpha: array<f32>;
@group(0) @binding(6) var linear: sampler;
/// Tables of fine integration; see fine.wgsl. With several volumes the bits of the extinction of every entry; see layers.wgsl.
@group(0) @binding(7) var<storage, read> extinction: array<u32>;

/// The entry of the transfer table nearest to `value`.
fn entry(value: f32) -> u32 {
    return u32(value + 0.5);
}

/// Unpacks a colour of the transfer table.
fn colour_of(bits: u32) -> vec3f {
    let fields = vec3u(bits & 0x7FFu, bits >> 11u & 0x7FFu, bits >> 22u);
    return vec3f(fields) * vec3f(1.0 / 2047.0, 1.0 / 2047.0, 1.0 / 1023.0);
}
