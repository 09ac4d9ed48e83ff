//! Makes GPU kernels from the layers of a plan.

use super::kernel::{Kernel, Operand};
use super::tensor::Place;
use super::{accumulate, conv, filter, norm, points, pointwise, pyramid, reshape, spread, warp};
use crate::plan::{Layer, Plan, TensorId};
use crate::schedule::{Schedule, is_input};
use crate::weights::Weights;
use crate::{Error, Result};
use bytemuck::Pod;
use fovol_gpu::{Gpu, Matrices};
use wgpu::BufferUsages;

/// Context for making kernels.
pub struct Making<'a> {
    pub gpu: &'a Gpu,
    pub plan: &'a Plan,
    pub weights: &'a Weights,
    /// Whether each tensor is stored as f16.
    pub halved: &'a [bool],
    pub schedule: &'a Schedule,
    /// Cooperative matrices that f16 products may use.
    pub matrices: Option<Matrices>,
}

impl Making<'_> {
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

    /// Makes the kernels of `layer`, in order; none if its output is never written.
    ///
    /// # Errors
    /// Weights that are missing, and layers with more input tensors than shaders can bind.
    pub fn kernels(&self, layer: &Layer) -> Result<Vec<Kernel>> {
        let output = layer.output();
        if self.moved(output).is_some() || Some(output) == self.schedule.known {
            return Ok(Vec::new());
        }
        Ok(match layer {
            Layer::Conv(layer) => vec![conv::kernel(self, layer)?],
            Layer::Filter(layer) => vec![filter::kernel(self, layer)?],
            Layer::Norm(layer) => norm::kernels(self, layer)?,
            Layer::Pool { .. }
            | Layer::SpaceToDepth { .. }
            | Layer::DepthToSpace { .. }
            | Layer::Join { .. }
            | Layer::Part { .. } => reshape::kernel(self, layer).into_iter().collect(),
            Layer::Scale { .. } | Layer::Clamp { .. } | Layer::Add { .. } | Layer::Bypass { .. } => {
                pointwise::kernel(self, layer).into_iter().collect()
            }
            Layer::Spread { known, base, levels, .. } => {
                pyramid::spread(self, *known, *base, *levels, output)
            }
            Layer::Doubt { known, prior, fresh, levels, .. } => {
                pyramid::doubt(self, *known, [*prior, *fresh], *levels, output)
            }
            Layer::Smooth { input, .. } => vec![spread::smooth(self, *input, output)],
            Layer::Blend { known, base, .. } => vec![spread::blend(self, *known, *base, output)],
            Layer::Accumulate { known, before, share, fade, .. } => {
                vec![accumulate::kernel(self, *known, (*before, *share), *fade, output)]
            }
            Layer::Reproject { input, motion, .. } => vec![points::reproject(self, *input, *motion, output)],
            Layer::Splat { input, .. } => vec![points::splat(self, *input, output)],
            Layer::Warp { input, motion, .. } => vec![warp::kernel(self, *input, *motion, output)],
        })
    }
}

/// Error for a layer with more input tensors than a shader can bind.
pub fn too_many(name: &str, count: usize, most: usize) -> Error {
    Error::Config(format!(
        "`{name}` reads {count} tensors at once, and on a GPU {most} are the most; use --device cpu"
    ))
}
