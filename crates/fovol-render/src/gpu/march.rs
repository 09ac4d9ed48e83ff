use super::buffers::Buffers;
use super::list_buffers::{GROUPS_OFFSET, ListBuffers, Shaded};
use super::scene::DeviceScene;
use super::scene_kind::{SceneKind, scene_layout};
use super::shader::{MARCH, MARCH_FILTERED};
use super::volume_texture::TexelKind;
use fovol_core::{FrameSize, Integration, ShadowMode, SurfaceShading};
use fovol_gpu::Gpu;
use fovol_gpu::binding::{Slot, bind_group, bind_group_layout, compute_pipeline};
use std::collections::HashMap;
use std::sync::{Mutex, PoisonError};

/// Edge of the workgroups that march a frame, in pixels; as in shaders/march.wgsl.
const TILE: u32 = 8;

/// Which pixels a dispatch marches.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
enum Pixels {
    List,
    All,
    Masked,
}

/// The key of a compiled pipeline: every property that its shader is specialised for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
struct Variant {
    pixels: Pixels,
    scene: SceneKind,
    shadows: ShadowMode,
    surface: SurfaceShading,
}

/// The pipelines that march rays, compiled when they are first needed.
#[derive(Debug)]
pub struct MarchPass {
    scene_layout: wgpu::BindGroupLayout,
    layout: wgpu::BindGroupLayout,
    pipelines: Mutex<HashMap<Variant, wgpu::ComputePipeline>>,
}

impl MarchPass {
    /// The pass on the device of `gpu`, for volumes of such texels.
    pub fn new(gpu: &Gpu, texels: TexelKind) -> Self {
        use Slot::{Read, Uniform, Write};
        let slots = [Uniform, Uniform, Read, Read, Read, Write, Write];
        Self {
            scene_layout: scene_layout(gpu, texels),
            layout: bind_group_layout(gpu, "march", &slots),
            pipelines: Mutex::default(),
        }
    }

    /// Binds mask and `listed` as input, and `to` as output.
    pub fn bind(&self, gpu: &Gpu, buffers: &Buffers, listed: &ListBuffers, to: &Shaded) -> wgpu::BindGroup {
        let buffers = [
            &buffers.extent,
            &buffers.view,
            &listed.pixels,
            &listed.length,
            &buffers.mask,
            &to.colours,
            &to.inverse_depths,
        ];
        bind_group(gpu, "march", &self.layout, &buffers.map(wgpu::Buffer::as_entire_binding))
    }

    /// Prepares to march a list; `length` is the buffer of its length.
    pub fn list<'a>(&self, gpu: &Gpu, scene: &'a DeviceScene, length: &'a wgpu::Buffer) -> March<'a> {
        March {
            pipeline: self.pipeline(gpu, scene, Pixels::List, scene.shading().shadows),
            scene: scene.group(),
            threads: Threads::Listed(length),
        }
    }

    /// Prepares to march a list of at most `most` pixels without shadows.
    pub fn list_without_shadows<'a>(&self, gpu: &Gpu, scene: &'a DeviceScene, most: u32) -> March<'a> {
        March {
            pipeline: self.pipeline(gpu, scene, Pixels::List, ShadowMode::Off),
            scene: scene.group(),
            threads: Threads::AtMost(most),
        }
    }

    /// Prepares to march a frame of `size`: all pixels, or the pixels of the mask where `masked`.
    pub fn frame<'a>(&self, gpu: &Gpu, scene: &'a DeviceScene, size: FrameSize, masked: bool) -> March<'a> {
        let pixels = if masked { Pixels::Masked } else { Pixels::All };
        March {
            pipeline: self.pipeline(gpu, scene, pixels, scene.shading().shadows),
            scene: scene.group(),
            threads: Threads::Pixels(size),
        }
    }

    fn pipeline(
        &self,
        gpu: &Gpu,
        scene: &DeviceScene,
        pixels: Pixels,
        shadows: ShadowMode,
    ) -> wgpu::ComputePipeline {
        let variant = Variant { pixels, scene: scene.kind(), shadows, surface: scene.shading().surface };
        let mut pipelines = self.pipelines.lock().unwrap_or_else(PoisonError::into_inner);
        pipelines.entry(variant).or_insert_with(|| self.compiled(gpu, variant)).clone()
    }

    fn compiled(&self, gpu: &Gpu, variant: Variant) -> wgpu::ComputePipeline {
        let shadows = match variant.shadows {
            ShadowMode::Off => 0.0,
            ShadowMode::On => 1.0,
            ShadowMode::Cached => 2.0,
        };
        let number = |b: bool| f64::from(u8::from(b));
        let mut constants = variant.scene.constants();
        constants.push(("SHADOWS", shadows));
        constants.push(("FINE", number(variant.scene.integration == Integration::Fine)));
        constants.push(("GRADIENT", number(variant.surface == SurfaceShading::Gradient)));
        constants.push(("GUIDE", number(variant.pixels == Pixels::List)));
        constants.push(("REJECT", number(variant.pixels == Pixels::Masked)));
        let entry_point = if variant.pixels == Pixels::List { "march_list" } else { "march_frame" };
        let shader = if variant.scene.texels == TexelKind::Filtered { MARCH_FILTERED } else { MARCH };
        compute_pipeline(gpu, &shader, entry_point, &[&self.scene_layout, &self.layout], &constants)
    }
}

/// A dispatch that is ready to go.
pub struct March<'a> {
    pipeline: wgpu::ComputePipeline,
    scene: &'a wgpu::BindGroup,
    threads: Threads<'a>,
}

/// The threads of a dispatch.
enum Threads<'a> {
    /// One for each pixel of a list; the buffer holds its length.
    Listed(&'a wgpu::Buffer),
    /// At least one for each pixel of a list of at most this length.
    AtMost(u32),
    /// One for each pixel of a frame.
    Pixels(FrameSize),
}

impl March<'_> {
    /// Marches into the outputs of `group`.
    pub fn dispatch(&self, pass: &mut wgpu::ComputePass<'_>, group: &wgpu::BindGroup) {
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, self.scene, &[]);
        pass.set_bind_group(1, group, &[]);
        match self.threads {
            Threads::Listed(length) => pass.dispatch_workgroups_indirect(length, GROUPS_OFFSET),
            Threads::AtMost(most) => {
                let [x, y, z] = ListBuffers::groups(most);
                pass.dispatch_workgroups(x, y, z);
            }
            Threads::Pixels(size) => {
                pass.dispatch_workgroups(size.width.div_ceil(TILE), size.height.div_ceil(TILE), 1);
            }
        }
    }
}
