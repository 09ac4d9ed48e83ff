use super::layers::{Layering, TEXTURES};
use super::volume_texture::TexelKind;
use fovol_core::{Integration, Interpolation, RayMode};
use fovol_gpu::Gpu;
use fovol_gpu::binding::{Slot, bind_group_layout};

/// The properties of a scene that are compiled into its shaders.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct SceneKind {
    /// The kind of the volume's texels.
    pub texels: TexelKind,
    /// Whether some voxels are NaN.
    pub gaps: bool,
    /// How many planes cut it.
    pub planes: u32,
    /// Whether rays skip empty space.
    pub skip: bool,
    /// Whether columns list the samples of shadow rays.
    pub columns: bool,
    /// How rays integrate.
    pub integration: Integration,
    /// How values between voxels are found.
    pub interpolation: Interpolation,
    /// Values along rays that pixels show.
    pub mode: ModeKind,
    /// Its volumes and their colours.
    pub layers: Layering,
}

/// Values along rays that pixels show, as in shaders/modes.wgsl.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum ModeKind {
    Composite,
    Mip,
    Minip,
    Average,
    Isosurface,
}

impl From<RayMode> for ModeKind {
    fn from(mode: RayMode) -> Self {
        match mode {
            RayMode::Composite => Self::Composite,
            RayMode::Mip => Self::Mip,
            RayMode::Minip => Self::Minip,
            RayMode::Average => Self::Average,
            RayMode::Isosurface(_) => Self::Isosurface,
        }
    }
}

impl SceneKind {
    /// Values of the shaders' `override` constants for such a scene.
    pub fn constants(self) -> Vec<(&'static str, f64)> {
        let number = |b: bool| f64::from(u8::from(b));
        let mut constants = vec![
            ("NEAREST", number(self.interpolation == Interpolation::Nearest)),
            ("SKIP", number(self.skip)),
            ("GAPS", number(self.gaps)),
            ("PLANES", self.planes.into()),
            ("COLUMNS", number(self.columns)),
        ];
        if let TexelKind::Stored { corners, floats } = self.texels {
            constants.extend([("CORNERS", number(corners)), ("FLOATS", number(floats))]);
        }
        constants.extend(self.layers.constants());
        constants
    }
}

/// The layout of the bind group of a scene with such texels and layers.
pub fn scene_layout(gpu: &Gpu, texels: TexelKind, layers: Layering) -> wgpu::BindGroupLayout {
    use Slot::{Filtered, Read, Sampler, Uniform, Whole};
    let volume = if texels == TexelKind::Filtered { Filtered } else { Whole };
    let mut slots = vec![Uniform, volume, Whole, Read, Read, Filtered, Sampler, Read, Whole];
    if layers.are_blended() {
        slots.push(Uniform);
        slots.extend([Whole; TEXTURES]);
    }
    bind_group_layout(gpu, "scene", &slots)
}
