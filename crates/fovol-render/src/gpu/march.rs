use super::buffers::Buffers;
use super::layers::Layering;
use super::list_buffers::{GroupSize, ListBuffers, Shaded};
use super::march_tuner::{MarchTuner, PlayedMarch, Tuned};
use super::march_variant::{Pixels, Variant};
use super::scene::DeviceScene;
use super::scene_kind::{ModeKind, scene_layout};
use super::shader::{
    MARCH, MARCH_FILTERED, MARCH_LAYERED, POOL, POOL_FILTERED, POOL_FINE, POOL_FINE_FILTERED,
};
use super::strategy::MarchStrategy;
use super::volume_texture::TexelKind;
use fovol_core::{FrameSize, Integration, ShadowMode, SurfaceShading};
use fovol_gpu::binding::{Slot, bind_group, bind_group_layout, compute_pipeline};
use fovol_gpu::{Choices, Gpu, Pass};
use std::collections::HashMap;
use std::sync::{Mutex, PoisonError};

/// Edge of the squares of pixels that march a frame; as in shaders/march.wgsl and pool.wgsl.
const TILE: u32 = 8;

/// The pipelines that march rays, compiled when they are first needed.
#[derive(Debug)]
pub struct MarchPass {
    scene_layout: wgpu::BindGroupLayout,
    layout: wgpu::BindGroupLayout,
    strategy: MarchStrategy,
    /// Chooses the strategy instead, where it helps.
    tuner: Option<MarchTuner>,
    pipelines: Mutex<HashMap<(Variant, MarchStrategy), wgpu::ComputePipeline>>,
}

impl MarchPass {
    /// The pass on the device of `gpu`, for volumes of such texels and layers.
    pub fn new(gpu: &Gpu, texels: TexelKind, layers: Layering) -> Self {
        use Slot::{Read, Uniform, Whole, Write};
        let slots = [Uniform, Uniform, Read, Read, Read, Write, Write, Whole];
        Self {
            scene_layout: scene_layout(gpu, texels, layers),
            layout: bind_group_layout(gpu, "march", &slots),
            strategy: MarchStrategy::usual(gpu.info().device_type),
            tuner: MarchTuner::helps(gpu).then(|| MarchTuner::new(gpu, Choices::of_user())),
            pipelines: Mutex::default(),
        }
    }

    /// How threads share the work where it is not tuned.
    pub fn strategy(&self) -> MarchStrategy {
        self.strategy
    }

    /// Shares the work of the next frames so, without tuning.
    pub fn set_strategy(&mut self, strategy: MarchStrategy) {
        self.strategy = strategy;
        self.tuner = None;
    }

    /// Tries every way to share the work in the next frames, but for what `choices` knows.
    pub fn tune(&mut self, gpu: &Gpu, choices: Choices) {
        self.tuner = Some(MarchTuner::new(gpu, choices));
    }

    /// Learns that a frame was marched in `ms` milliseconds.
    pub fn learn(&self, played: PlayedMarch, ms: f64) {
        if let Some(tuner) = &self.tuner {
            tuner.learn(played, ms);
        }
    }

    /// Binds mask and `listed` as input, and `to` as output.
    pub fn bind(&self, gpu: &Gpu, buffers: &Buffers, listed: &ListBuffers, to: &Shaded) -> wgpu::BindGroup {
        let noise = buffers.noise.create_view(&wgpu::TextureViewDescriptor::default());
        let buffers = [
            &buffers.extent,
            &buffers.view,
            &listed.pixels,
            &listed.length,
            &buffers.mask,
            &to.colours,
            &to.inverse_depths,
        ];
        let mut resources = buffers.map(wgpu::Buffer::as_entire_binding).to_vec();
        resources.push(wgpu::BindingResource::TextureView(&noise));
        bind_group(gpu, "march", &self.layout, &resources)
    }

    /// Prepares to march the list of `buffers`, with `few` shadow rays if there are to be few. Results go to the frame if they go
    /// straight, else to the list.
    pub fn list<'a>(
        &self,
        gpu: &Gpu,
        scene: &'a DeviceScene,
        (buffers, few): (&'a Buffers, Option<u32>),
        is_straight: bool,
    ) -> March<'a> {
        let pixels = if is_straight { Pixels::Straight } else { Pixels::List };
        let how = (pixels, scene.shading().shadows, few);
        self.listed(gpu, scene, buffers, how, Some(buffers.pixels))
    }

    /// Prepares to march the list of `buffers` with `shadows`.
    pub fn samples_with<'a>(
        &self,
        gpu: &Gpu,
        scene: &'a DeviceScene,
        (buffers, shadows): (&'a Buffers, ShadowMode),
    ) -> March<'a> {
        self.listed(gpu, scene, buffers, (Pixels::List, shadows, None), None)
    }

    fn listed<'a>(
        &self,
        gpu: &Gpu,
        scene: &'a DeviceScene,
        buffers: &'a Buffers,
        how: (Pixels, ShadowMode, Option<u32>),
        frame_pixels: Option<usize>,
    ) -> March<'a> {
        self.march(gpu, scene, how, frame_pixels, |size| {
            Groups::Listed(&buffers.listed.length, size.unwrap_or(GroupSize::SixtyFour).offset())
        })
    }

    /// Prepares to march a list of at most `most` pixels with `shadows`.
    pub fn guide_list<'a>(
        &self,
        gpu: &Gpu,
        scene: &'a DeviceScene,
        (most, shadows): (u32, ShadowMode),
    ) -> March<'a> {
        self.march(gpu, scene, (Pixels::List, shadows, None), None, |size| {
            Groups::Number(size.unwrap_or(GroupSize::SixtyFour).groups(most))
        })
    }

    /// Prepares to march a frame of `size`, with `few` shadow rays if there are to be few: all pixels, or the pixels of the mask where `masked`.
    pub fn frame<'a>(
        &self,
        gpu: &Gpu,
        scene: &'a DeviceScene,
        (size, few): (FrameSize, Option<u32>),
        masked: bool,
    ) -> March<'a> {
        let pixels = if masked { Pixels::Masked } else { Pixels::All };
        self.march(gpu, scene, (pixels, scene.shading().shadows, few), Some(size.pixels()), |group| {
            // The groups of one square of pixels lie beside each other, eight in a row.
            let parts = group.map_or(1, |group| TILE * TILE / group.pixels());
            let columns = parts.min(TILE);
            let rows = parts / columns;
            Groups::Number([size.width.div_ceil(TILE) * columns, size.height.div_ceil(TILE) * rows, 1])
        })
    }

    /// Prepares to march `pixels` with `shadows`, and with `few` shadow rays if there are to be few, in a frame of
    /// `frame_pixels` if that is timed. `groups` gives the workgroups where each has so many rays, or where each
    /// thread has one.
    fn march<'a>(
        &self,
        gpu: &Gpu,
        scene: &'a DeviceScene,
        (pixels, shadows, few): (Pixels, ShadowMode, Option<u32>),
        frame_pixels: Option<usize>,
        groups: impl FnOnce(Option<GroupSize>) -> Groups<'a>,
    ) -> March<'a> {
        let kind = scene.kind();
        let is_composite = kind.mode == ModeKind::Composite;
        let few = few.filter(|_| shadows == ShadowMode::On && is_composite).unwrap_or(0);
        let surface = scene.shading().surface;
        let variant = Variant { pixels, scene: kind, shadows, surface, few };
        let tuned = frame_pixels.map(|pixels| Tuned { variant, pixels: pixels.max(1).ilog2() });
        let (strategy, played) = match (&self.tuner, tuned) {
            // Few shadow rays leave pools nothing to share, and neither do rays without or with one. Pools know one volume only.
            _ if few > 0 || !is_composite || kind.layers.are_blended() => (MarchStrategy::Rays, None),
            (Some(tuner), Some(tuned)) => {
                let strategy = tuner.next(tuned);
                (strategy, Some(PlayedMarch { tuned, strategy }))
            }
            _ => (self.strategy, None),
        };
        let mut pipelines = self.pipelines.lock().unwrap_or_else(PoisonError::into_inner);
        let anew = || self.compiled(gpu, variant, strategy);
        let pipeline = pipelines.entry((variant, strategy)).or_insert_with(anew).clone();
        let groups = groups(match strategy {
            MarchStrategy::Rays => None,
            MarchStrategy::Pool(pool) => Some(pool.group_size()),
        });
        March { pipeline, scene: scene.group(), groups, played }
    }

    fn compiled(&self, gpu: &Gpu, variant: Variant, strategy: MarchStrategy) -> wgpu::ComputePipeline {
        let shadows = match variant.shadows {
            ShadowMode::Off => 0.0,
            ShadowMode::On => 1.0,
            ShadowMode::Cached => 2.0,
        };
        let number = |b: bool| f64::from(u8::from(b));
        let mut constants = variant.scene.constants();
        // Two loads under way at once help hardware; programs on the processor take them one after the other.
        constants.push(("PAIRS", number(!gpu.is_software())));
        constants.push(("SHADOWS", shadows));
        constants.push(("GRADIENT", number(variant.surface == SurfaceShading::Gradient)));
        constants.push(("GUIDE", number(variant.pixels == Pixels::List)));
        constants.push(("REJECT", number(variant.pixels == Pixels::Masked)));
        constants.push(("STRAIGHT", number(variant.pixels == Pixels::Straight)));
        let is_list = matches!(variant.pixels, Pixels::List | Pixels::Straight);
        let is_filtered = variant.scene.texels == TexelKind::Filtered;
        let (shader, entry_point) = match strategy {
            MarchStrategy::Rays => {
                constants.push(("FINE", number(variant.scene.integration == Integration::Fine)));
                constants.push(("FEW", variant.few.into()));
                constants.push(("MODE", f64::from(variant.scene.mode as u8)));
                let shader = match is_filtered {
                    _ if variant.scene.layers.are_blended() => MARCH_LAYERED,
                    true => MARCH_FILTERED,
                    false => MARCH,
                };
                (shader, if is_list { "march_list" } else { "march_frame" })
            }
            MarchStrategy::Pool(pool) => {
                constants.extend(pool.constants(variant.scene.integration));
                let shader = match (variant.scene.integration, is_filtered) {
                    (Integration::Plain, false) => POOL,
                    (Integration::Plain, true) => POOL_FILTERED,
                    (Integration::Fine, false) => POOL_FINE,
                    (Integration::Fine, true) => POOL_FINE_FILTERED,
                };
                (shader, if is_list { "pool_list" } else { "pool_frame" })
            }
        };
        compute_pipeline(gpu, &shader, entry_point, &[&self.scene_layout, &self.layout], &constants)
    }
}

/// A dispatch that is ready to go.
pub struct March<'a> {
    pipeline: wgpu::ComputePipeline,
    scene: &'a wgpu::BindGroup,
    groups: Groups<'a>,
    /// How the frame is marched, if that is tuned.
    pub played: Option<PlayedMarch>,
}

/// The workgroups of a dispatch.
enum Groups<'a> {
    /// Read from this buffer, at this place in bytes.
    Listed(&'a wgpu::Buffer, u64),
    /// Numbers along x, y and z.
    Number([u32; 3]),
}

impl March<'_> {
    /// Marches into the outputs of `group`.
    pub fn dispatch(&self, pass: &mut Pass<'_>, group: &wgpu::BindGroup) {
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, self.scene, &[]);
        pass.set_bind_group(1, group, &[]);
        match self.groups {
            Groups::Listed(length, at) => pass.dispatch_workgroups_indirect(length, at),
            Groups::Number([x, y, z]) => pass.dispatch_workgroups(x, y, z),
        }
    }
}
