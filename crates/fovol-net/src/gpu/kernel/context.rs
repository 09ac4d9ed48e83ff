//! Data from which the kernels of layers are made.

use super::Operand;
use crate::gpu::tensor::Place;
use crate::plan::{Plan, TensorId};
use crate::schedule::{Schedule, is_input};
use crate::weights::Weights;
use crate::{Error, Result};
use bytemuck::Pod;
use fovol_gpu::{Gpu, Matrices};
use wgpu::BufferUsages;

/// Context for context kernels.
pub struct Context<'a> {
    pub gpu: &'a Gpu,
    pub plan: &'a Plan,
    pub weights: &'a Weights,
    /// Whether each tensor is stored as f16.
    pub halved: &'a [bool],
    pub schedule: &'a Schedule,
    /// Cooperative matrices that f16 products may use.
    pub matrices: Option<Matrices>,
}

impl Context<'_> {
    /// Place of a tensor. The joined input shares the place of the colours, whose fourth channel is the mask.
    pub fn place(&self, id: TensorId) -> Place {
        let is_known = Some(id) == self.schedule.known;
        Place::Tensor(if is_known { self.plan.inputs().colour } else { id })
    }

    /// Operand that reads tensor `id`.
    pub fn read(&self, id: TensorId) -> Operand {
        Operand::Read(self.place(id))
    }

    /// Source tensor of a tensor that is only a fold or unfold of another one, and never written.
    pub fn moved(&self, id: TensorId) -> Option<TensorId> {
        self.schedule.derived[id.index()].map(|(from, _)| from)
    }

    /// Whether these are the colours and the mask of the input.
    pub fn is_known(&self, colour: TensorId, mask: TensorId) -> bool {
        is_input(self.plan, colour, mask)
    }

    pub fn is_halved(&self, id: TensorId) -> bool {
        self.halved[id.index()]
    }

    pub fn channels(&self, id: TensorId) -> usize {
        self.plan.tensor(id).channels
    }

    /// Weights and biases of the layer `name`.
    pub fn parameters(&self, name: &str) -> Result<(&[f32], &[f32])> {
        let values = |part: &str| self.weights.values(&format!("{name}.{part}"));
        Ok((values("weight")?, values("bias")?))
    }

    /// Uploads `bytes` to a buffer.
    pub fn buffer(&self, label: &str, bytes: &[u8], usage: BufferUsages) -> wgpu::Buffer {
        let buffer = self.gpu.buffer(label, bytes.len() as u64, usage | BufferUsages::COPY_DST);
        self.gpu.queue().write_buffer(&buffer, 0, bytes);
        buffer
    }

    /// Uploads learned numbers.
    pub fn learned<T: Pod>(&self, label: &str, values: &[T]) -> Operand {
        Operand::Learned(self.buffer(label, bytemuck::cast_slice(values), BufferUsages::STORAGE))
    }
}

/// Error for a layer with more input tensors than a shader can bind.
pub fn too_many(name: &str, count: usize, most: usize) -> Error {
    Error::Config(format!(
        "`{name}` reads {count} tensors at once, and on a GPU {most} are the most; use --device cpu"
    ))
}
