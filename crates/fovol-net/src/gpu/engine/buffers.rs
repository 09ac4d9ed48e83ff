//! Device memory for the frames of one state.

use super::frame::DeviceInput;
use super::memory::Memory;
use super::prepared::{Carried, Prepared, Step};
use crate::gpu::kernel::{Kernel, Operand};
use crate::gpu::tensor::{Place, Shape, Sizes};
use crate::plan::TensorId;
use fovol_gpu::binding::bind_group;
use fovol_gpu::{Gpu, GpuError};
use std::collections::{HashMap, HashSet};
use wgpu::BufferUsages;

/// Buffers of all operands of kernels.
pub struct Buffers {
    /// Buffers that tensors share.
    pieces: Vec<wgpu::Buffer>,
    piece_of: HashMap<TensorId, usize>,
    /// For each state of the plan, two buffers. If they are swapped, they alternate between the last frame and this
    /// one. Otherwise the first holds the state of the last frame, and the second serves the copy to the next one.
    carried: Vec<(Carried, [wgpu::Buffer; 2])>,
    /// Buffers of places that share no memory.
    own: HashMap<Place, wgpu::Buffer>,
    shapes: HashMap<Place, wgpu::Buffer>,
}

impl Buffers {
    /// Checks that all buffers for frames of `sizes` are within the device's limits.
    ///
    /// # Errors
    /// [`GpuError::Limit`], naming the first tensor that exceeds one.
    pub fn check(network: &Prepared, sizes: &Sizes<'_>) -> fovol_gpu::Result<()> {
        const MEND: &str = "give a smaller --size, --precision f16, or --device cpu";
        let limits = network.gpu.device().limits();
        let places = network.steps.iter().flat_map(|step| &step.kernel.operands).filter_map(Operand::place);
        for place in places {
            let check = |limit| GpuError::check_limit(sizes.name(place), sizes.bytes(place), limit, MEND);
            check(("maxStorageBufferBindingSize", limits.max_storage_buffer_binding_size))?;
            check(("maxBufferSize", limits.max_buffer_size))?;
        }
        Ok(())
    }

    /// Allocates memory for frames of `sizes`, all zero.
    pub fn new(network: &Prepared, sizes: &Sizes<'_>) -> Self {
        let gpu = &network.gpu;
        let kernels: Vec<&Kernel> = network.steps.iter().map(|step| &step.kernel).collect();
        let (apart, kept) = apart_and_kept(&network.carried);
        let bytes = |id: TensorId| sizes.bytes(Place::Tensor(id));
        let memory = Memory::new(&kernels, bytes, &apart, &kept);
        let pair = |carried: &Carried| {
            let buffer = || storage(gpu, "state", bytes(carried.previous));
            (*carried, [buffer(), buffer()])
        };
        let mut buffers = Self {
            pieces: memory.pieces.iter().map(|&bytes| storage(gpu, "tensors", bytes)).collect(),
            piece_of: memory.piece_of,
            carried: network.carried.iter().map(pair).collect(),
            own: HashMap::from([(Place::Frame, storage(gpu, "full frame", sizes.bytes(Place::Frame)))]),
            shapes: HashMap::new(),
        };
        let operands = kernels.iter().flat_map(|kernel| &kernel.operands);
        operands.for_each(|operand| buffers.make_room(gpu, operand, sizes));
        buffers
    }

    /// Allocates buffers that `operand` needs besides those of tensors.
    fn make_room(&mut self, gpu: &Gpu, operand: &Operand, sizes: &Sizes<'_>) {
        if let Operand::Shape(place) = *operand {
            self.shapes.entry(place).or_insert_with(|| uniform(gpu, sizes.shape(place)));
        }
        if let Some(place @ (Place::Level(_) | Place::Moments)) = operand.place() {
            self.own.entry(place).or_insert_with(|| storage(gpu, "scratch", sizes.bytes(place)));
        }
    }

    /// Reconstructed frame.
    pub fn frame(&self) -> &wgpu::Buffer {
        &self.own[&Place::Frame]
    }

    /// Total size of all buffers in bytes.
    pub fn bytes(&self) -> u64 {
        let carried = self.carried.iter().flat_map(|(_, buffers)| buffers);
        let all = self.pieces.iter().chain(carried).chain(self.own.values()).chain(self.shapes.values());
        all.map(wgpu::Buffer::size).sum()
    }

    /// Buffer of tensor `id`, in odd or in even frames.
    pub fn tensor(&self, id: TensorId, is_odd: bool) -> &wgpu::Buffer {
        let turn = usize::from(is_odd);
        for (carried, buffers) in &self.carried {
            if id == carried.previous {
                return &buffers[if carried.is_swapped { turn } else { 0 }];
            }
            if carried.is_swapped && id == carried.next {
                return &buffers[1 - turn];
            }
        }
        &self.pieces[self.piece_of[&id]]
    }

    /// State tensors of the last frame, as an odd or an even frame reads them.
    pub fn past(&self, is_odd: bool) -> impl Iterator<Item = &wgpu::Buffer> {
        self.carried.iter().map(move |(carried, _)| self.tensor(carried.previous, is_odd))
    }

    /// Copies states that are not swapped to where the next frame reads them.
    pub fn carry(&self, encoder: &mut wgpu::CommandEncoder, is_odd: bool) {
        let copied = || self.carried.iter().filter(|(carried, _)| !carried.is_swapped);
        for (carried, [_, on_the_way]) in copied() {
            let from = self.tensor(carried.next, is_odd);
            encoder.copy_buffer_to_buffer(from, 0, on_the_way, 0, Some(on_the_way.size()));
        }
        for (_, [to, on_the_way]) in copied() {
            encoder.copy_buffer_to_buffer(on_the_way, 0, to, 0, Some(to.size()));
        }
    }

    /// Bind group of `step` in an odd or an even frame. `given` is the frame's input, for steps that read it.
    pub fn bind(
        &self,
        gpu: &Gpu,
        step: &Step,
        given: Option<DeviceInput<'_>>,
        is_odd: bool,
    ) -> wgpu::BindGroup {
        let buffer = |operand: &Operand| match operand {
            Operand::Shape(place) => self.shapes[place].clone(),
            Operand::Uniform(buffer) | Operand::Learned(buffer) => buffer.clone(),
            Operand::Read(place) | Operand::Write(place) | Operand::Change(place) => match (place, given) {
                (Place::Tensor(id), _) => self.tensor(*id, is_odd).clone(),
                (Place::Sparse, Some(given)) => given.sparse.clone(),
                (Place::Motion, Some(DeviceInput { motion: Some(motion), .. })) => motion.clone(),
                (place, _) => self.own[place].clone(),
            },
        };
        let buffers: Vec<wgpu::Buffer> = step.kernel.operands.iter().map(buffer).collect();
        let resources: Vec<_> = buffers.iter().map(wgpu::Buffer::as_entire_binding).collect();
        bind_group(gpu, step.kernel.entry_point, &step.pipeline.layout, &resources)
    }
}

/// Tensors of `carried` that share no memory, and tensors that are needed after the frame.
fn apart_and_kept(carried: &[Carried]) -> (HashSet<TensorId>, HashSet<TensorId>) {
    let previous = carried.iter().map(|carried| carried.previous);
    let swapped = carried.iter().filter(|carried| carried.is_swapped).map(|carried| carried.next);
    let copied = carried.iter().filter(|carried| !carried.is_swapped).map(|carried| carried.next);
    (previous.chain(swapped).collect(), copied.collect())
}

fn storage(gpu: &Gpu, label: &str, bytes: u64) -> wgpu::Buffer {
    gpu.buffer(label, bytes, BufferUsages::STORAGE | BufferUsages::COPY_DST | BufferUsages::COPY_SRC)
}

fn uniform(gpu: &Gpu, shape: Shape) -> wgpu::Buffer {
    let buffer =
        gpu.buffer("shape", size_of::<Shape>() as u64, BufferUsages::UNIFORM | BufferUsages::COPY_DST);
    gpu.queue().write_buffer(&buffer, 0, bytemuck::bytes_of(&shape));
    buffer
}
