use super::light_columns::ColumnNumbers;
use bytemuck::{Pod, Zeroable};
use fovol_core::ClipPlanes;

/// Uniforms of a scene. Twin of `Scene` in shaders/scene.wgsl.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct SceneNumbers {
    pub last: [f32; 3],
    pub delta: f32,
    pub to_voxels: [f32; 3],
    pub scale: f32,
    pub background: [f32; 3],
    pub ambient: f32,
    pub light_delta: [f32; 3],
    pub cell_shift: u32,
    pub light_exit: [f32; 3],
    pub extinction_unit: f32,
    pub light_inverse: [f32; 3],
    pub last_entry: u32,
    pub light_direction: [f32; 3],
    pub bin_bits: u32,
    pub box_low: [f32; 3],
    pub iso: f32,
    pub box_high: [f32; 3],
    pub unused: u32,
    pub planes: [[f32; 4]; ClipPlanes::MOST],
    pub light_planes: [[f32; 4]; ClipPlanes::MOST],
    pub columns: ColumnNumbers,
}

/// Steps to planes that light never crosses.
pub const FAR: f32 = 1e30;

/// `planes`, and up to the most that there may be others with the constant `otherwise`.
pub fn padded(planes: impl Iterator<Item = [f32; 4]>, otherwise: f32) -> [[f32; 4]; ClipPlanes::MOST] {
    let mut all = [[0.0, 0.0, 0.0, otherwise]; ClipPlanes::MOST];
    all.iter_mut().zip(planes).for_each(|(to, plane)| *to = plane);
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::shader::{MARCH, MARCH_FILTERED, MARCH_LAYERED};
    use fovol_gpu::assert_twins;

    #[test]
    fn shaders_read_the_same_struct() {
        for shader in [MARCH, MARCH_FILTERED, MARCH_LAYERED] {
            assert_twins!(
                shader,
                "Scene",
                SceneNumbers {
                    last,
                    delta,
                    to_voxels,
                    scale,
                    background,
                    ambient,
                    light_delta,
                    cell_shift,
                    light_exit,
                    extinction_unit,
                    light_inverse,
                    last_entry,
                    light_direction,
                    bin_bits,
                    box_low,
                    iso,
                    box_high,
                    unused,
                    planes,
                    light_planes,
                    columns
                }
            );
        }
    }
}
