use crate::gpu::kernel::shader::PULL_PUSH;
use crate::{Error, Result};
use bytemuck::{Pod, Zeroable};
use fovol_core::{Frame, FrameSize, SparseFrame};
use fovol_gpu::binding::{Slot, bind_group, bind_group_layout, compute_pipeline};
use fovol_gpu::{Gpu, GpuError, read};
use std::fmt;
use wgpu::BufferUsages;

/// Two neighbouring levels. Twin of `Levels` in shaders/pull_push.wgsl.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct Levels {
    fine_width: u32,
    fine_height: u32,
    coarse_width: u32,
    coarse_height: u32,
    fine_first: u32,
    coarse_first: u32,
    unused: [u32; 2],
}

/// A step of pull-push, in the order of a frame.
#[derive(Debug)]
struct Step {
    pipeline: wgpu::ComputePipeline,
    /// Index of its pair of levels.
    levels: usize,
    /// Number of threads along x and y.
    threads: [u32; 2],
}

/// Pipelines, in the order of use.
struct Pipelines {
    layout: wgpu::BindGroupLayout,
    load: wgpu::ComputePipeline,
    pull: wgpu::ComputePipeline,
    divide: wgpu::ComputePipeline,
    push: wgpu::ComputePipeline,
    finish: wgpu::ComputePipeline,
}

/// [`crate::Fill::PullPush`] on a device, for frames of one size.
///
/// Unsampled pixels become averages over growing squares. Sampled pixels (alpha above ½) keep their colours
/// exactly. A frame without samples becomes opaque black.
pub struct PullPush {
    gpu: Gpu,
    size: FrameSize,
    layout: wgpu::BindGroupLayout,
    steps: Vec<Step>,
    /// Sizes of each pair of neighbouring levels.
    levels: Vec<wgpu::Buffer>,
    pixels: wgpu::Buffer,
    filled: wgpu::Buffer,
}

impl fmt::Debug for PullPush {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("PullPush").field("size", &self.size).finish_non_exhaustive()
    }
}

impl PullPush {
    /// Prepares pull-push for frames of `size` on the device of `gpu`.
    ///
    /// # Errors
    /// A size that exceeds the device's limits or memory.
    pub fn new(gpu: &Gpu, size: FrameSize) -> Result<Self> {
        let sizes = sizes(size);
        let pixels: u64 = sizes.iter().map(|[width, height]| u64::from(width * height)).sum();
        check_size(gpu, size, 16 * pixels)?;
        let made = gpu.guarded("making room to fill frames", || {
            let pipelines = Pipelines::new(gpu);
            let storage = BufferUsages::STORAGE | BufferUsages::COPY_SRC | BufferUsages::COPY_DST;
            Self {
                gpu: gpu.clone(),
                size,
                steps: pipelines.steps(&sizes),
                layout: pipelines.layout,
                levels: pairs(&sizes).iter().map(|pair| uniform(gpu, pair)).collect(),
                pixels: gpu.buffer("levels", 16 * pixels, storage),
                filled: gpu.buffer("filled frame", 16 * size.pixels() as u64, storage),
            }
        })?;
        Ok(made)
    }

    /// Size of the frames.
    pub fn size(&self) -> FrameSize {
        self.size
    }

    /// Buffer of the filled frame: width × height × RGBA as f32, top row first. Alpha is 1 for filled pixels, and
    /// unchanged for samples. All frames use this buffer.
    pub fn frame_buffer(&self) -> &wgpu::Buffer {
        &self.filled
    }

    /// Records pull-push of `sparse` in `encoder`. `sparse` is laid out like [`Self::frame_buffer`] and has the
    /// usage `STORAGE`. The three channels may be colours, depths or other values.
    ///
    /// # Errors
    /// A buffer that is too small; a device that is lost or has no memory left.
    pub fn encode(&self, encoder: &mut wgpu::CommandEncoder, sparse: &wgpu::Buffer) -> Result<()> {
        let needed = 16 * self.size.pixels() as u64;
        if sparse.size() < needed {
            let problem = format!("frames of {} have {needed} bytes, not {}", self.size, sparse.size());
            return Err(Error::State(problem));
        }
        self.gpu.guarded("encoding the filling of a frame", || {
            let groups: Vec<wgpu::BindGroup> = (0..self.levels.len()).map(|i| self.bind(i, sparse)).collect();
            let mut pass = self.gpu.pass(encoder);
            for step in &self.steps {
                pass.set_pipeline(&step.pipeline);
                pass.set_bind_group(0, &groups[step.levels], &[]);
                pass.dispatch_workgroups(step.threads[0].div_ceil(8), step.threads[1].div_ceil(8), 1);
            }
        })?;
        Ok(())
    }

    fn bind(&self, pair: usize, sparse: &wgpu::Buffer) -> wgpu::BindGroup {
        let buffers = [&self.levels[pair], &self.pixels, sparse, &self.filled];
        bind_group(&self.gpu, "pull-push", &self.layout, &buffers.map(wgpu::Buffer::as_entire_binding))
    }

    /// Fills `sparse`, samples of the host, on the device.
    ///
    /// # Errors
    /// A frame of another size; a device that is lost or has no memory left.
    pub fn reconstruct(&self, sparse: &SparseFrame) -> Result<Frame> {
        if sparse.size() != self.size {
            let problem = format!("it fills frames of {}, not {}; make another", self.size, sparse.size());
            return Err(Error::State(problem));
        }
        self.gpu.guarded("filling a frame", || {
            let picture = sparse.to_frame();
            let bytes: &[u8] = bytemuck::cast_slice(picture.pixels());
            let usage = BufferUsages::STORAGE | BufferUsages::COPY_DST;
            let upload = self.gpu.buffer("sparse frame", bytes.len() as u64, usage);
            self.gpu.queue().write_buffer(&upload, 0, bytes);
            let descriptor = wgpu::CommandEncoderDescriptor { label: Some("filling") };
            let mut encoder = self.gpu.device().create_command_encoder(&descriptor);
            self.encode(&mut encoder, &upload)?;
            self.gpu.enqueue([encoder.finish()]);
            Ok::<_, Error>(())
        })??;
        let pixels = read(&self.gpu, &self.filled, self.size.pixels())?;
        Ok(Frame::from_pixels(self.size, pixels)?)
    }
}

impl Pipelines {
    fn new(gpu: &Gpu) -> Self {
        let slots = [Slot::Uniform, Slot::Write, Slot::Read, Slot::Write];
        let layout = bind_group_layout(gpu, "pull-push", &slots);
        let pipeline = |entry_point| compute_pipeline(gpu, &PULL_PUSH, entry_point, &[&layout], &[]);
        let [load, pull, divide, push, finish] = ["load", "pull", "divide", "push", "finish"].map(pipeline);
        Self { layout, load, pull, divide, push, finish }
    }

    /// Lists the steps for levels of these sizes.
    fn steps(&self, sizes: &[[u32; 2]]) -> Vec<Step> {
        let step = |pipeline: &wgpu::ComputePipeline, levels: usize, threads: [u32; 2]| Step {
            pipeline: pipeline.clone(),
            levels,
            threads,
        };
        let last = sizes.len() - 1;
        let mut steps = vec![step(&self.load, 0, sizes[0])];
        steps.extend((0..last).map(|i| step(&self.pull, i, sizes[i + 1])));
        steps.push(step(&self.divide, last.saturating_sub(1), [1, 1]));
        steps.extend((0..last).rev().map(|i| step(&self.push, i, sizes[i])));
        steps.push(step(&self.finish, 0, sizes[0]));
        steps
    }
}

/// Widths and heights of all levels: each half of the one before, rounded up, down to one pixel.
fn sizes(size: FrameSize) -> Vec<[u32; 2]> {
    let mut sizes = vec![[size.width, size.height]];
    while let Some(&[width, height]) = sizes.last().filter(|last| **last != [1, 1]) {
        sizes.push([width.div_ceil(2), height.div_ceil(2)]);
    }
    sizes
}

/// Pairs every level with the next one. A single level is paired with itself.
fn pairs(sizes: &[[u32; 2]]) -> Vec<Levels> {
    let mut first = 0;
    let pair = |i: usize| {
        let [[fine_width, fine_height], [coarse_width, coarse_height]] =
            [sizes[i], sizes[(i + 1).min(sizes.len() - 1)]];
        let fine_first = first;
        let coarse_first = if i + 1 < sizes.len() { first + fine_width * fine_height } else { first };
        first = coarse_first;
        Levels {
            fine_width,
            fine_height,
            coarse_width,
            coarse_height,
            fine_first,
            coarse_first,
            unused: [0; 2],
        }
    };
    (0..(sizes.len() - 1).max(1)).map(pair).collect()
}

fn uniform(gpu: &Gpu, levels: &Levels) -> wgpu::Buffer {
    let usage = BufferUsages::UNIFORM | BufferUsages::COPY_DST;
    let buffer = gpu.buffer("levels", size_of::<Levels>() as u64, usage);
    gpu.queue().write_buffer(&buffer, 0, bytemuck::bytes_of(levels));
    buffer
}

/// Checks that `bytes` for frames of `size` are within the device's limits.
fn check_size(gpu: &Gpu, size: FrameSize, bytes: u64) -> fovol_gpu::Result<()> {
    const MEND: &str = "give a smaller --size, or --device cpu";
    let limits = gpu.device().limits();
    let what = || format!("filling a frame of {size}");
    let binding = ("maxStorageBufferBindingSize", limits.max_storage_buffer_binding_size);
    GpuError::check_limit(what(), bytes, binding, MEND)?;
    GpuError::check_limit(what(), bytes, ("maxBufferSize", limits.max_buffer_size), MEND)
}

#[cfg(test)]
mod tests {
    use super::*;
    use fovol_gpu::assert_twins;

    #[test]
    fn shaders_read_the_same_struct() {
        assert_twins!(
            PULL_PUSH,
            "Levels",
            Levels { fine_width, fine_height, coarse_width, coarse_height, fine_first, coarse_first, unused }
        );
    }

    #[test]
    fn levels_lie_one_after_the_other() {
        let sizes = sizes(FrameSize::new(5, 3).unwrap());
        assert_eq!(sizes, [[5, 3], [3, 2], [2, 1], [1, 1]]);
        let firsts: Vec<[u32; 2]> = pairs(&sizes).iter().map(|p| [p.fine_first, p.coarse_first]).collect();
        assert_eq!(firsts, [[0, 15], [15, 21], [21, 23]]);
        let one = pairs(&[[1, 1]]);
        assert_eq!((one.len(), one[0].coarse_first), (1, 0));
    }
}
