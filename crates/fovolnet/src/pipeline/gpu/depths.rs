//! Distances of all pixels from those of samples.

use super::reprojection::ReprojectionUniforms;
use crate::motion::REMEMBERED;
use fovol_core::FrameSize;
use fovol_gpu::binding::{Slot, bind_group, bind_group_layout, compute_pipeline};
use fovol_gpu::{Gpu, Pass, Shader, shader};
use wgpu::BufferUsages;

/// Shader that moves depths of earlier samples to this frame.
const EARLIER: Shader = shader!("../../shaders/", "earlier_depths": "reprojection");

/// Shader that interpolates depths between samples.
const FILLED: Shader = shader!("../../shaders/", "filled_depths": "reprojection");

/// Edge of the workgroups of [`EARLIER`] in pixels.
const GROUP: u32 = 8;

/// Edge of the tiles of [`FILLED`] in pixels; level [`TILE_LEVEL`] has one pixel for each.
const TILE: u32 = 1 << TILE_LEVEL;
const TILE_LEVEL: u32 = 6;

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

/// Earlier samples, moved to the current frame.
#[derive(Debug)]
struct EarlierDepths {
    splat: wgpu::ComputePipeline,
    group: wgpu::BindGroup,
    /// Reprojections from earlier frames to the current one.
    uniforms: wgpu::Buffer,
    /// Inverse distances of samples of each earlier frame.
    inverse_depths: [wgpu::Buffer; REMEMBERED],
}

/// Passes that find the inverse distances of all pixels: from the samples of this frame, and from these with those of earlier
/// frames. Twin of [`fovol_net::FilledNumbers`] with what [`crate::motion::Depths`] knows.
#[derive(Debug)]
pub struct DepthPasses {
    size: FrameSize,
    earlier: Option<EarlierDepths>,
    pull: wgpu::ComputePipeline,
    turn: wgpu::ComputePipeline,
    push: wgpu::ComputePipeline,
    group: wgpu::BindGroup,
    /// Inverse distances from the samples of this frame: one f32 for each pixel.
    pub near: wgpu::Buffer,
    /// Inverse distances from the samples of this frame and of earlier ones.
    pub seen: wgpu::Buffer,
}

impl DepthPasses {
    /// Passes for frames of `size` whose samples lie in `frames`, reprojected to the last frame by the uniforms `to_last`. Earlier frames
    /// are used if `remembers`. Call it within [`Gpu::guarded`].
    pub fn new(
        gpu: &Gpu,
        size: FrameSize,
        (frames, to_last): (DeviceFrames<'_>, &wgpu::Buffer),
        remembers: bool,
    ) -> Self {
        let storage = BufferUsages::STORAGE | BufferUsages::COPY_SRC | BufferUsages::COPY_DST;
        let buffer = |label, bytes| gpu.buffer(label, bytes, storage);
        let bytes = 4 * size.pixels() as u64;
        let [near, seen] = ["near depths", "seen depths"].map(|label| buffer(label, bytes));
        let nearest = buffer("nearest depths", bytes);
        let levels = buffer("levels of depths", 16 * pixels_of_levels(size));

        let earlier = remembers.then(|| EarlierDepths::new(gpu, bytes, &nearest));
        let slots =
            [Slot::Uniform, Slot::Read, Slot::Write, Slot::Read, Slot::Write, Slot::Write, Slot::Write];
        let layout = bind_group_layout(gpu, "filled depths", &slots);
        let buffers = [to_last, frames.inverse_depths, &nearest, frames.sparse, &levels, &near, &seen];
        let group = bind_group(gpu, "filled depths", &layout, &buffers.map(wgpu::Buffer::as_entire_binding));
        let pipeline = |entry_point| compute_pipeline(gpu, &FILLED, entry_point, &[&layout], &[]);
        let [pull, turn, push] = ["pull", "turn", "push"].map(pipeline);
        Self { size, earlier, pull, turn, push, group, near, seen }
    }

    /// Writes the reprojections from earlier frames, numbered from 0 on, to the current one.
    pub fn set_reprojections(&self, gpu: &Gpu, reprojections: &[ReprojectionUniforms]) {
        if let Some(earlier) = &self.earlier {
            gpu.queue().write_buffer(&earlier.uniforms, 0, bytemuck::cast_slice(reprojections));
        }
    }

    /// Finds the distances of all pixels, by the samples of `remembered` earlier frames.
    pub fn dispatch(&self, pass: &mut Pass<'_>, remembered: usize) {
        let groups = |edge| [self.size.width, self.size.height].map(|side| side.div_ceil(edge));
        if let Some(earlier) = self.earlier.as_ref().filter(|_| remembered > 0) {
            let [columns, rows] = groups(GROUP);
            pass.set_pipeline(&earlier.splat);
            pass.set_bind_group(0, &earlier.group, &[]);
            pass.dispatch_workgroups(columns, rows, remembered as u32);
        }
        let [columns, rows] = groups(TILE);
        pass.set_bind_group(0, &self.group, &[]);
        for (pipeline, [columns, rows]) in
            [(&self.pull, [columns, rows]), (&self.turn, [1, 1]), (&self.push, [columns, rows])]
        {
            pass.set_pipeline(pipeline);
            pass.dispatch_workgroups(columns, rows, 1);
        }
    }

    /// Copies the depths of this frame's samples into those of the earlier frame `number`.
    pub fn remember(&self, encoder: &mut wgpu::CommandEncoder, number: usize, inverse_depths: &wgpu::Buffer) {
        if let Some(earlier) = &self.earlier {
            let kept = &earlier.inverse_depths[number];
            encoder.copy_buffer_to_buffer(inverse_depths, 0, kept, 0, kept.size());
        }
    }
}

impl EarlierDepths {
    /// Room for earlier frames of `bytes` each, whose nearest depths go to `nearest`.
    fn new(gpu: &Gpu, bytes: u64, nearest: &wgpu::Buffer) -> Self {
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_DST;
        let uniforms = ReprojectionUniforms::buffer(gpu, REMEMBERED);
        let inverse_depths = std::array::from_fn(|_| gpu.buffer("earlier depths", bytes, usage));
        let slots = [&[Slot::Uniform][..], &[Slot::Read; REMEMBERED], &[Slot::Write]].concat();
        let layout = bind_group_layout(gpu, "earlier depths", &slots);
        let buffers: Vec<_> = [&uniforms].into_iter().chain(&inverse_depths).chain([nearest]).collect();
        let bindings: Vec<_> = buffers.into_iter().map(wgpu::Buffer::as_entire_binding).collect();
        let group = bind_group(gpu, "earlier depths", &layout, &bindings);
        let splat = compute_pipeline(gpu, &EARLIER, "splat", &[&layout], &[]);
        Self { splat, group, uniforms, inverse_depths }
    }
}

/// Pixels of all levels from the first on, down to one pixel, and at least down to [`TILE_LEVEL`].
fn pixels_of_levels(size: FrameSize) -> u64 {
    let sides = [size.width, size.height];
    let last = sides.into_iter().max().map_or(0, |longest| longest.next_power_of_two().ilog2());
    let pixels =
        |level: u32| sides.map(|side| u64::from(side.div_ceil(1 << level))).into_iter().product::<u64>();
    (1..=last.max(TILE_LEVEL)).map(pixels).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use fovol_core::CameraPath;
    use fovol_gpu::{AdapterRequest, read};
    use fovol_net::FilledNumbers;
    use wgpu::naga::valid::Capabilities;

    #[test]
    fn the_shaders_are_valid() {
        for shader in [EARLIER, FILLED] {
            shader.check(Capabilities::empty()).unwrap_or_else(|problem| panic!("{problem}"));
        }
    }

    #[test]
    fn levels_end_with_one_pixel() {
        let pixels = |w, h| pixels_of_levels(FrameSize::new(w, h).unwrap());
        assert_eq!(pixels(1, 1), 6);
        assert_eq!(pixels(5, 3), 3 * 2 + 2 + 4);
        assert_eq!(pixels(65, 1), 33 + 17 + 9 + 5 + 3 + 2 + 1);
    }

    /// Both pictures of the passes, from these distances of which those of `samples` are samples.
    fn filled_by(gpu: &Gpu, size: FrameSize, known: &[f32], samples: &[bool]) -> [Vec<f32>; 2] {
        let sparse: Vec<[f32; 4]> =
            samples.iter().map(|is_sample| [0.0, 0.0, 0.0, f32::from(*is_sample)]).collect();
        let upload = |bytes| gpu.upload("input of a test", bytes).unwrap();
        let (inverse_depths, sparse) =
            (upload(bytemuck::cast_slice(known)), upload(bytemuck::cast_slice(&sparse)));
        let camera = CameraPath::Orbit.camera(0);
        let uniforms = ReprojectionUniforms::new(&camera, &camera, size);
        let frames = DeviceFrames { inverse_depths: &inverse_depths, sparse: &sparse, last: &sparse };
        let passes = gpu
            .guarded("a test", || {
                let to_last = ReprojectionUniforms::buffer(gpu, 1);
                gpu.queue().write_buffer(&to_last, 0, bytemuck::bytes_of(&uniforms));
                let passes = DepthPasses::new(gpu, size, (frames, &to_last), false);
                let mut encoder =
                    gpu.device().create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
                let mut pass = gpu.pass(&mut encoder);
                passes.dispatch(&mut pass, 0);
                drop(pass);
                gpu.enqueue([encoder.finish()]);
                passes
            })
            .unwrap();
        [&passes.near, &passes.seen].map(|buffer| read(gpu, buffer, size.pixels()).unwrap())
    }

    #[test]
    #[ignore = "needs an adapter: cargo test --release --workspace -- --ignored"]
    fn depths_are_filled_as_on_the_processor() {
        let gpu = Gpu::open(&AdapterRequest::Any.or_environment()).unwrap();
        for (w, h, few) in
            [(1, 1, 1), (5, 3, 4), (65, 1, 9), (64, 128, 30), (200, 333, 1000), (301, 70, 5), (40, 40, 9999)]
        {
            let size = FrameSize::new(w, h).unwrap();
            let random = |i: usize| (i as u32 ^ 0x5bd1).wrapping_mul(2_654_435_761) >> 8;
            let is = |i: usize, salt: usize| random(i + salt).is_multiple_of(few);
            let distance = |i: usize| if is(i, 1) { 0.1 + (random(i) % 100) as f32 / 50.0 } else { 0.0 };
            let known: Vec<f32> = (0..size.pixels()).map(distance).collect();
            let samples: Vec<bool> = (0..size.pixels()).map(|i| !is(i, 77)).collect();
            let of_samples = known.iter().zip(&samples).map(|(known, is)| if *is { *known } else { 0.0 });
            let expected = FilledNumbers::new(size, [known.clone(), of_samples.collect()]).pictures();
            for (found, expected) in filled_by(&gpu, size, &known, &samples).iter().zip(&expected) {
                let far = |(a, b): (&f32, &f32)| (a - b).abs();
                let most = found.iter().zip(expected).map(far).fold(0.0, f32::max);
                assert!(most < 1e-5, "{size}: {most}");
            }
        }
    }
}
