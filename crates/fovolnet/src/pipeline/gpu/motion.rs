use crate::Result;
use crate::motion::REMEMBERED;
use bytemuck::{Pod, Zeroable};
use fovol_core::{Camera, FrameSize, Reprojection};
use fovol_gpu::binding::{Slot, bind_group, bind_group_layout, compute_pipeline};
use fovol_gpu::{Gpu, Shader, shader};
use fovol_net::gpu::PullPush;
use std::collections::VecDeque;
use wgpu::BufferUsages;

/// Shader that reprojects depths of samples and interpolates them.
const DEPTHS: Shader = shader!("../../shaders/", "depths": "reprojection");

/// Shader that weighs depth guesses and writes motion.
const MOTION: Shader = shader!("../../shaders/", "motion": "reprojection");

/// Edge of the workgroups in pixels, equal to the shaders'.
const GROUP: u32 = 8;

/// Edge of the tiles in which guesses are judged, in pixels; equal to that in shaders/motion.wgsl.
const TILE: u32 = crate::motion::TILE as u32;

/// Uniforms of a reprojection. Twin of `Reprojection` in shaders/reprojection.wgsl.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct Uniforms {
    base: [[f32; 4]; 3],
    direction: [[f32; 4]; 3],
    parallax: [f32; 4],
    width: u32,
    height: u32,
    half_width: f32,
    half_height: f32,
}

impl Uniforms {
    fn new(from: &Camera, to: &Camera, size: FrameSize) -> Self {
        let reprojection = Reprojection::new(from, to, size);
        let [a, b, c, d, e, f, parallax] = reprojection.coefficients().map(|v| [v.x, v.y, v.z, 0.0]);
        let [half_width, half_height] = reprojection.half_extent();
        Self {
            base: [a, b, c],
            direction: [d, e, f],
            parallax,
            width: size.width,
            height: size.height,
            half_width,
            half_height,
        }
    }

    fn buffer(gpu: &Gpu) -> wgpu::Buffer {
        gpu.buffer("reprojection", size_of::<Self>() as u64, BufferUsages::UNIFORM | BufferUsages::COPY_DST)
    }
}

/// Buffers of a frame's samples and of the last full frame.
#[derive(Debug, Clone, Copy)]
pub struct DeviceFrames<'a> {
    /// Inverse distances of marched pixels, 0 elsewhere; f32.
    pub inverse_depths: &'a wgpu::Buffer,
    /// Sampled colours.
    pub sparse: &'a wgpu::Buffer,
    /// Last full frame; valid until the next one is made.
    pub last: &'a wgpu::Buffer,
}

/// Depths of an earlier frame.
#[derive(Debug)]
struct Remembered {
    inverse_depths: wgpu::Buffer,
    /// Reprojection from that frame to the current one.
    uniforms: wgpu::Buffer,
    group: wgpu::BindGroup,
}

/// Passes that interpolate depths between samples.
#[derive(Debug)]
struct DepthPasses {
    know: wgpu::ComputePipeline,
    splat: wgpu::ComputePipeline,
    know_all: wgpu::ComputePipeline,
    keep: wgpu::ComputePipeline,
    /// Bind groups for the samples of this frame alone, and for these with those of earlier frames.
    groups: [wgpu::BindGroup; 2],
    nearest: wgpu::Buffer,
    known: wgpu::Buffer,
    fill: PullPush,
}

/// Passes that weigh the depth guesses and write motion.
#[derive(Debug)]
struct BeliefPasses {
    judge: wgpu::ComputePipeline,
    believe: wgpu::ComputePipeline,
    shift: wgpu::ComputePipeline,
    /// Motion at the depths of this frame alone.
    shift_near: wgpu::ComputePipeline,
    group: wgpu::BindGroup,
}

/// GPU twin of [`crate::MotionFinder`], for frames of one size.
#[derive(Debug)]
pub struct MotionPass {
    gpu: Gpu,
    size: FrameSize,
    depths: DepthPasses,
    belief: BeliefPasses,
    to_last: wgpu::Buffer,
    motion: wgpu::Buffer,
    remembered: Vec<Remembered>,
    /// Cameras of the last frames and the indices of their depths in `remembered`, oldest first.
    seen: VecDeque<(Camera, usize)>,
    /// Whether depths are known at so many pixels that nothing needs to be guessed.
    has_guide: bool,
    /// Whether the last encoded frame moves.
    moves: bool,
}

impl MotionPass {
    /// Motion of frames of `size` whose samples lie in `frames`. If they have a guide, their depths alone tell it.
    pub fn new(gpu: &Gpu, size: FrameSize, frames: DeviceFrames<'_>, has_guide: bool) -> Result<Self> {
        let fill = PullPush::new(gpu, size)?;
        let made = gpu.guarded("making room for motion", || {
            let storage = BufferUsages::STORAGE | BufferUsages::COPY_SRC | BufferUsages::COPY_DST;
            let pixels = size.pixels() as u64;
            let buffer = |label, bytes: u64| gpu.buffer(label, bytes, storage);
            let to_last = Uniforms::buffer(gpu);
            let [near, seen] = ["near depths", "seen depths"].map(|label| buffer(label, 4 * pixels));
            let (nearest, known) =
                (buffer("nearest depths", 4 * pixels), buffer("known depths", 16 * pixels));
            let motion = buffer("motion", 8 * pixels);

            let slots =
                [Slot::Uniform, Slot::Read, Slot::Write, Slot::Read, Slot::Write, Slot::Read, Slot::Write];
            let layout = bind_group_layout(gpu, "depths", &slots);
            let bind = |uniforms: &wgpu::Buffer, inverse: &wgpu::Buffer, to: &wgpu::Buffer| {
                let buffers = [uniforms, inverse, &nearest, frames.sparse, &known, fill.frame_buffer(), to];
                bind_group(gpu, "depths", &layout, &buffers.map(wgpu::Buffer::as_entire_binding))
            };
            let groups = [&near, &seen].map(|to| bind(&to_last, frames.inverse_depths, to));
            let remembered = (0..if has_guide { 0 } else { REMEMBERED }).map(|_| {
                let (uniforms, inverse_depths) =
                    (Uniforms::buffer(gpu), buffer("earlier depths", 4 * pixels));
                Remembered { group: bind(&uniforms, &inverse_depths, &seen), uniforms, inverse_depths }
            });
            let remembered = remembered.collect();
            let pipeline = |entry_point| compute_pipeline(gpu, &DEPTHS, entry_point, &[&layout], &[]);
            let [know, splat, know_all, keep] = ["know", "splat", "know_all", "keep"].map(pipeline);
            let depths = DepthPasses { know, splat, know_all, keep, groups, nearest, known, fill };

            let belief =
                BeliefPasses::new(gpu, size, [&to_last, &near, &seen, frames.sparse, frames.last], &motion);
            let seen = VecDeque::new();
            Self {
                gpu: gpu.clone(),
                size,
                depths,
                belief,
                to_last,
                motion,
                remembered,
                seen,
                has_guide,
                moves: false,
            }
        })?;
        Ok(made)
    }

    /// Encodes the motion of the frame in `frames`, seen by `camera`, into `encoder`, and remembers the frame's depths.
    /// Encode at most one frame in each submission.
    pub fn encode(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        camera: &Camera,
        frames: DeviceFrames<'_>,
    ) -> Result<()> {
        let last = self.seen.back().map(|(last, _)| *last).filter(|last| last != camera);
        self.moves = last.is_some();
        if let Some(last) = last {
            self.encode_motion(encoder, camera, &last)?;
        }
        self.remember(encoder, camera, frames.inverse_depths);
        Ok(())
    }

    /// Motion of the last encoded frame: two f32 for each pixel, x right and y down, to its position in the frame before.
    /// `None` for the first frame, and if nothing moves.
    pub fn found(&self) -> Option<&wgpu::Buffer> {
        self.moves.then_some(&self.motion)
    }

    /// Forgets all earlier frames.
    pub fn reset(&mut self) {
        self.seen.clear();
    }

    fn encode_motion(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        camera: &Camera,
        last: &Camera,
    ) -> Result<()> {
        let Self { depths, belief, .. } = self;
        self.write(&self.to_last, &Uniforms::new(camera, last, self.size));
        let [near, seen] = &depths.groups;
        self.dispatch(encoder, &depths.know, near, GROUP);
        depths.fill.encode(encoder, &depths.known)?;
        self.dispatch(encoder, &depths.keep, near, GROUP);
        if self.has_guide {
            self.dispatch(encoder, &belief.shift_near, &belief.group, GROUP);
            return Ok(());
        }

        encoder.clear_buffer(&depths.nearest, 0, None);
        for (there, number) in &self.seen {
            let Remembered { uniforms, group, .. } = &self.remembered[*number];
            self.write(uniforms, &Uniforms::new(there, camera, self.size));
            self.dispatch(encoder, &depths.splat, group, GROUP);
        }
        self.dispatch(encoder, &depths.know_all, seen, GROUP);
        depths.fill.encode(encoder, &depths.known)?;
        self.dispatch(encoder, &depths.keep, seen, GROUP);

        self.dispatch(encoder, &belief.judge, &belief.group, TILE);
        self.dispatch(encoder, &belief.believe, &belief.group, TILE * GROUP);
        self.dispatch(encoder, &belief.shift, &belief.group, GROUP);
        Ok(())
    }

    fn remember(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        camera: &Camera,
        inverse_depths: &wgpu::Buffer,
    ) {
        if self.has_guide {
            self.seen.clear();
            self.seen.push_back((*camera, 0));
            return;
        }
        let number = match self.seen.len() {
            REMEMBERED => self.seen.pop_front().map_or(0, |(_, number)| number),
            free => free,
        };
        let bytes = 4 * self.size.pixels() as u64;
        encoder.copy_buffer_to_buffer(inverse_depths, 0, &self.remembered[number].inverse_depths, 0, bytes);
        self.seen.push_back((*camera, number));
    }

    fn write(&self, buffer: &wgpu::Buffer, uniforms: &Uniforms) {
        self.gpu.queue().write_buffer(buffer, 0, bytemuck::bytes_of(uniforms));
    }

    /// Dispatches one workgroup for every `edge` × `edge` pixels.
    fn dispatch(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        pipeline: &wgpu::ComputePipeline,
        group: &wgpu::BindGroup,
        edge: u32,
    ) {
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, group, &[]);
        pass.dispatch_workgroups(self.size.width.div_ceil(edge), self.size.height.div_ceil(edge), 1);
    }
}

impl BeliefPasses {
    /// Passes that read the buffers `from` and write to `motion`.
    fn new(gpu: &Gpu, size: FrameSize, from: [&wgpu::Buffer; 5], motion: &wgpu::Buffer) -> Self {
        let tiles = u64::from(size.width.div_ceil(TILE)) * u64::from(size.height.div_ceil(TILE));
        let bytes_of_errors = 4 * crate::motion::GUESSES as u64;
        let errors = gpu.buffer("errors of guesses", bytes_of_errors * tiles, BufferUsages::STORAGE);
        let beliefs = gpu.buffer("beliefs", 8 * tiles, BufferUsages::STORAGE);
        let (read, write) = ([Slot::Read; 4], [Slot::Write; 3]);
        let layout = bind_group_layout(gpu, "motion", &[&[Slot::Uniform], &read[..], &write[..]].concat());
        let buffers = [&from[..], &[&errors, &beliefs, motion]].concat();
        let bindings: Vec<_> = buffers.into_iter().map(wgpu::Buffer::as_entire_binding).collect();
        let group = bind_group(gpu, "motion", &layout, &bindings);
        let pipeline = |entry_point| compute_pipeline(gpu, &MOTION, entry_point, &[&layout], &[]);
        let [judge, believe, shift, shift_near] = ["judge", "believe", "shift", "shift_near"].map(pipeline);
        Self { judge, believe, shift, shift_near, group }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fovol_gpu::assert_twins;
    use wgpu::naga::valid::Capabilities;

    #[test]
    fn the_shaders_are_valid_and_read_the_same_struct() {
        for shader in [DEPTHS, MOTION] {
            shader.check(Capabilities::empty()).unwrap_or_else(|problem| panic!("{problem}"));
            assert_twins!(
                shader,
                "Reprojection",
                Uniforms { base, direction, parallax, width, height, half_width, half_height }
            );
        }
    }
}
