//! Marching of a guide on the device, level by level.

use super::level::Level;
use super::shader::{GUIDE, PUT};
use crate::guide::{BUDGETS, CONTRASTS, GuideGrid};
use crate::{Guide, Result};
use fovol_core::{FrameSize, ShadowMode};
use fovol_gpu::binding::{Slot, bind_group, bind_group_layout, compute_pipeline};
use fovol_gpu::{Gpu, read};
use fovol_render::gpu::{FrameBuffers, GuideList, GuideSamples, ListBuffers, Renderer};
use wgpu::BufferUsages;

/// Levels of a guide, the finest one last.
const LEVELS: usize = 3;
/// Numbers of the state; as in shaders/guide.wgsl.
const STATE: u64 = 3 + 256;
/// Offset of the number of marched pixels in the state, in numbers.
const MARCHED: usize = 1;

/// GPU twin of [`crate::guide::MarchedGuide`], for frames of one size.
#[derive(Debug)]
pub struct GuideMarch {
    gpu: Gpu,
    list: GuideList,
    /// The frame's samples with cached shadows, if the guide has them. A guide without shadows finds its own in the frame's.
    samples: Option<GuideSamples>,
    state: wgpu::Buffer,
    levels: [LevelPasses; LEVELS],
    begin: wgpu::ComputePipeline,
    between: wgpu::ComputePipeline,
    limit: wgpu::ComputePipeline,
    choose: wgpu::ComputePipeline,
    put: wgpu::ComputePipeline,
}

/// Buffers and bindings of one level.
#[derive(Debug)]
struct LevelPasses {
    uniforms: wgpu::Buffer,
    /// Its guide pixels, row by row.
    guide: wgpu::Buffer,
    level: wgpu::BindGroup,
    put_list: wgpu::BindGroup,
    put_samples: wgpu::BindGroup,
}

/// Most pixels of the list of a guide for frames of `size`: a quarter of a frame, or every pixel of a small region.
fn most_listed(size: FrameSize, is_full: bool) -> usize {
    let (width, height) = (size.width as usize, size.height as usize);
    let part = if is_full { width * height } else { (width + 3) * (height + 3) / 4 };
    part.max(16 * width.max(height)).min(width * height)
}

/// Most guide pixels of the levels of frames of `size`: every fourth column and row, every second, every one.
fn most_of_levels(size: FrameSize) -> [u64; LEVELS] {
    let every = size.pixels() as u64;
    let of = |step: u64| (u64::from(size.width) / step + 1) * (u64::from(size.height) / step + 1);
    [of(4), of(2), every].map(|most| most.min(every).max(1))
}

impl GuideMarch {
    /// Guides of this `kind` of the frames of `renderer` in `frames`.
    pub fn new(renderer: &Renderer, frames: &FrameBuffers, kind: Guide) -> Result<Self> {
        use Slot::{Read, Uniform, Write};
        let (gpu, size) = (renderer.gpu(), frames.size());
        let list = renderer.guide_list(frames, most_listed(size, kind == Guide::Full))?;
        let samples = (kind == Guide::Cached).then(|| renderer.guide_samples(frames)).transpose()?;
        let made = gpu.guarded("making room for guides", || {
            let storage = BufferUsages::STORAGE | BufferUsages::COPY_SRC | BufferUsages::COPY_DST;
            let state = gpu.buffer("guide state", 4 * STATE, storage);
            let contrasts = gpu.buffer("contrasts", 4 * size.pixels() as u64, storage);
            let guides = most_of_levels(size).map(|most| gpu.buffer("guide", 16 * most, storage));
            let layout =
                bind_group_layout(gpu, "guide", &[Uniform, Read, Write, Read, Write, Write, Write, Write]);
            let put_layout =
                bind_group_layout(gpu, "guide pixels", &[Uniform, Read, Read, Read, Read, Write, Write]);
            let levels = [0, 1, 2].map(|number: usize| {
                let usage = BufferUsages::UNIFORM | BufferUsages::COPY_DST;
                let uniforms = gpu.buffer("level", size_of::<Level>() as u64, usage);
                // The coarsest level is not interpolated: it reads any other one.
                let coarse = &guides[number.checked_sub(1).unwrap_or(LEVELS - 1)];
                let listed = list.listed();
                let bound = [
                    &uniforms,
                    coarse,
                    &guides[number],
                    frames.frame(),
                    &contrasts,
                    &state,
                    listed.pixels(),
                    listed.length(),
                ];
                let level = bind_group(gpu, "guide", &layout, &bound.map(wgpu::Buffer::as_entire_binding));
                let put = |listed: &ListBuffers, [colours, guide_colours]: [&wgpu::Buffer; 2]| {
                    let bound = [
                        &uniforms,
                        listed.pixels(),
                        listed.length(),
                        colours,
                        guide_colours,
                        &guides[number],
                        frames.inverse_depths(),
                    ];
                    bind_group(gpu, "guide pixels", &put_layout, &bound.map(wgpu::Buffer::as_entire_binding))
                };
                let put_list = put(listed, [listed.colours(), listed.unshadowed()]);
                let sampled = frames.listed();
                let results = samples.as_ref().map_or_else(
                    || [sampled.colours(), sampled.unshadowed()],
                    |samples| [samples.colours(), samples.guides()],
                );
                let put_samples = put(sampled, results);
                LevelPasses { level, put_list, put_samples, guide: guides[number].clone(), uniforms }
            });
            let pipeline = |entry_point| compute_pipeline(gpu, &GUIDE, entry_point, &[&layout], &[]);
            let [begin, between, limit, choose] = ["begin", "between", "limit", "choose"].map(pipeline);
            let put = compute_pipeline(gpu, &PUT, "put", &[&put_layout], &[]);
            Self { gpu: gpu.clone(), list, samples, state, levels, begin, between, limit, choose, put }
        })?;
        Ok(made)
    }

    /// Encodes the marching of the guide whose coarsest level is `grid` into `encoder`. The frame's samples are marched and
    /// scattered before.
    pub fn encode(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        renderer: &Renderer,
        frames: &FrameBuffers,
        grid: GuideGrid,
    ) {
        if let Some(samples) = &self.samples {
            renderer.encode_guide_samples(encoder, (samples, frames), self.shadows());
        }
        encoder.clear_buffer(&self.state, 0, None);
        encoder.clear_buffer(self.list.listed().length(), 0, None);
        let mut number = LEVELS - 1 - grid.step.ilog2() as usize;
        let level = Level::coarsest(&grid);
        self.set(number, &level);
        self.dispatch(encoder, number, &[(&self.begin, level.groups())]);
        self.march(encoder, renderer, frames, number, level.pixels());

        let known = level.pixels();
        let mut coarse = grid;
        for (contrast, budget) in CONTRASTS.into_iter().zip(BUDGETS) {
            let Some(fine) = coarse.finer() else { break };
            number += 1;
            let most = (budget * grid.region.pixels() as f32) as u32;
            let level = Level::finer(&coarse, &fine, ((contrast * 255.0) as u32, most));
            self.set(number, &level);
            let groups = level.groups();
            let passes = [(&self.between, groups), (&self.limit, [1, 1]), (&self.choose, groups)];
            self.dispatch(encoder, number, &passes);
            self.march(encoder, renderer, frames, number, level.most().saturating_sub(known));
            coarse = fine;
        }
    }

    fn shadows(&self) -> ShadowMode {
        if self.samples.is_some() { ShadowMode::Cached } else { ShadowMode::Off }
    }

    fn set(&self, number: usize, level: &Level) {
        self.gpu.queue().write_buffer(&self.levels[number].uniforms, 0, bytemuck::bytes_of(level));
    }

    /// Dispatches passes over level `number`.
    fn dispatch(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        number: usize,
        passes: &[(&wgpu::ComputePipeline, [u32; 2])],
    ) {
        let mut pass = self.gpu.pass(encoder);
        pass.set_bind_group(0, &self.levels[number].level, &[]);
        for (pipeline, [x, y]) in passes {
            pass.set_pipeline(pipeline);
            pass.dispatch_workgroups(*x, *y, 1);
        }
    }

    /// Marches the list, of at most `most` pixels, and puts its pixels and the frame's samples into level `number`.
    fn march(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        renderer: &Renderer,
        frames: &FrameBuffers,
        number: usize,
        most: u32,
    ) {
        renderer.encode_guide_list(encoder, &self.list, (most, self.shadows()));
        let mut pass = self.gpu.pass(encoder);
        pass.set_pipeline(&self.put);
        pass.set_bind_group(0, &self.levels[number].put_list, &[]);
        let [x, y, z] = ListBuffers::groups(most);
        pass.dispatch_workgroups(x, y, z);
        pass.set_bind_group(0, &self.levels[number].put_samples, &[]);
        pass.dispatch_workgroups_indirect(frames.listed().length(), ListBuffers::GROUPS_OFFSET);
    }

    /// Guide pixels of the finest level: those of the region, row by row, RGBA as f32.
    pub fn guide(&self) -> &wgpu::Buffer {
        &self.levels[LEVELS - 1].guide
    }

    /// Reads back how many pixels were marched for the last guide alone.
    pub fn read_marched(&self) -> Result<usize> {
        let state: Vec<u32> = read(&self.gpu, &self.state, STATE as usize)?;
        Ok(state[MARCHED] as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fovol_core::Region;

    #[test]
    fn there_is_room_for_every_list_and_level() {
        for (width, height) in [(1, 1), (16, 16), (17, 40), (640, 9), (83, 47), (1280, 720)] {
            let size = FrameSize { width, height };
            let regions = [(0, 0, width, height), (width / 3, height / 3, width - width / 3, height / 2)];
            for (x, y, width, height) in regions {
                let region = Region { x, y, size: FrameSize { width, height } };
                for index in 0..16 {
                    let mut grid = GuideGrid::coarsest(index, region, size);
                    let pixels = |grid: &GuideGrid| grid.size()[0] * grid.size()[1];
                    assert!(pixels(&grid) <= most_listed(size, false), "{size} {region:?}");
                    assert!((BUDGETS[1] * region.pixels() as f32) as usize <= most_listed(size, false));
                    loop {
                        let number = LEVELS - 1 - grid.step.ilog2() as usize;
                        assert!(pixels(&grid) as u64 <= most_of_levels(size)[number], "{size} {region:?}");
                        match grid.finer() {
                            Some(finer) => grid = finer,
                            None => break,
                        }
                    }
                }
            }
        }
    }
}
