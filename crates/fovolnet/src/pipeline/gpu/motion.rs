use super::depths::{DepthPasses, DeviceFrames};
use super::reprojection::ReprojectionUniforms;
use crate::Result;
use crate::motion::REMEMBERED;
use fovol_core::{Camera, FrameSize};
use fovol_gpu::binding::{Slot, bind_group, bind_group_layout, compute_pipeline};
use fovol_gpu::{Gpu, Shader, shader};
use std::collections::VecDeque;
use wgpu::BufferUsages;

/// Shader that weighs depth guesses and writes motion.
const MOTION: Shader = shader!("../../shaders/", "motion": "reprojection");

/// Edge of the workgroups in pixels, equal to the shaders'.
const GROUP: u32 = 8;

/// Edge of the tiles in which guesses are judged, in pixels; equal to that in shaders/motion.wgsl.
const TILE: u32 = crate::motion::TILE as u32;

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
    /// Cameras of the last frames and the numbers of their depths, oldest first.
    seen: VecDeque<(Camera, usize)>,
    /// Whether depths are known at so many pixels that nothing needs to be guessed.
    has_guide: bool,
    /// Whether the last encoded frame moves.
    moves: bool,
}

impl MotionPass {
    /// Motion of frames of `size` whose samples lie in `frames`. If they have a guide, their depths alone tell it.
    pub fn new(gpu: &Gpu, size: FrameSize, frames: DeviceFrames<'_>, has_guide: bool) -> Result<Self> {
        let made = gpu.guarded("making room for motion", || {
            let to_last = ReprojectionUniforms::buffer(gpu, 1);
            let depths = DepthPasses::new(gpu, size, (frames, &to_last), !has_guide);
            let storage = BufferUsages::STORAGE | BufferUsages::COPY_SRC | BufferUsages::COPY_DST;
            let motion = gpu.buffer("motion", 8 * size.pixels() as u64, storage);
            let read = [&to_last, &depths.near, &depths.seen, frames.sparse, frames.last];
            let belief = BeliefPasses::new(gpu, size, read, &motion);
            let (gpu, seen) = (gpu.clone(), VecDeque::new());
            Self { gpu, size, depths, belief, to_last, motion, seen, has_guide, moves: false }
        })?;
        Ok(made)
    }

    /// Encodes the motion of the frame in `frames`, seen by `camera`, into `encoder`, and remembers the frame's depths.
    /// Encode at most one frame in each submission.
    pub fn encode(&mut self, encoder: &mut wgpu::CommandEncoder, camera: &Camera, frames: DeviceFrames<'_>) {
        let last = self.seen.back().map(|(last, _)| *last).filter(|last| last != camera);
        self.moves = last.is_some();
        if let Some(last) = last {
            self.encode_motion(encoder, camera, &last);
        }
        self.remember(encoder, camera, frames.inverse_depths);
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

    fn encode_motion(&self, encoder: &mut wgpu::CommandEncoder, camera: &Camera, last: &Camera) {
        let Self { depths, belief, size, .. } = self;
        let to_last = ReprojectionUniforms::new(camera, last, *size);
        self.gpu.queue().write_buffer(&self.to_last, 0, bytemuck::bytes_of(&to_last));
        let mut earlier = vec![to_last; self.seen.len()];
        for (there, number) in &self.seen {
            earlier[*number] = ReprojectionUniforms::new(there, camera, *size);
        }
        depths.set_reprojections(&self.gpu, &earlier);

        let mut pass = self.gpu.pass(encoder);
        depths.dispatch(&mut pass, earlier.len());
        pass.set_bind_group(0, &belief.group, &[]);
        let guessed = [(&belief.judge, TILE), (&belief.believe, TILE * GROUP), (&belief.shift, GROUP)];
        let known = [(&belief.shift_near, GROUP)];
        for (pipeline, edge) in if self.has_guide { &known[..] } else { &guessed } {
            pass.set_pipeline(pipeline);
            pass.dispatch_workgroups(size.width.div_ceil(*edge), size.height.div_ceil(*edge), 1);
        }
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
        self.depths.remember(encoder, number, inverse_depths);
        self.seen.push_back((*camera, number));
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
    use wgpu::naga::valid::Capabilities;

    #[test]
    fn the_shader_is_valid() {
        MOTION.check(Capabilities::empty()).unwrap_or_else(|problem| panic!("{problem}"));
    }
}
