//! Memory layout of tensors on a device. shaders/tensor.wgsl describes it.

use crate::plan::{Plan, TensorId};
use bytemuck::{Pod, Zeroable};
use fovol_core::FrameSize;

/// Channels of a block.
pub const BLOCK: usize = 4;

/// Number of workgroups that read a tensor for its moments, as in shaders/norm.wgsl.
pub const MOMENT_GROUPS: u32 = 64;

/// Size of a tensor, as shaders read it. Twin of `Shape` in shaders/tensor.wgsl.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Pod, Zeroable)]
#[repr(C)]
pub struct Shape {
    pub width: u32,
    pub height: u32,
    pub blocks: u32,
    pub channels: u32,
}

impl Shape {
    /// Number of elements, including padding of the last block.
    pub fn numbers(&self) -> u64 {
        u64::from(self.width) * u64::from(self.height) * u64::from(self.blocks) * BLOCK as u64
    }
}

/// A memory location that kernels read or write.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Place {
    /// A tensor of the plan.
    Tensor(TensorId),
    /// A level of the pull-push pyramid, at 2^level times lower resolution than the frame.
    Level(u32),
    /// Mean and sum of squares of a tensor that is being normalised.
    Moments,
    /// Sparse frame from the caller: RGBA row by row, not padded.
    Sparse,
    /// Motion from the caller: two numbers for each pixel, not padded.
    Motion,
    /// Reconstructed frame: RGBA row by row, not padded.
    Frame,
}

/// Sizes of all places for frames of one size.
#[derive(Debug, Clone, Copy)]
pub struct Sizes<'a> {
    plan: &'a Plan,
    halved: &'a [bool],
    size: FrameSize,
}

impl<'a> Sizes<'a> {
    /// Sizes for frames of `size` and the tensors of `plan`. `halved` says which tensors are stored as f16.
    pub fn new(plan: &'a Plan, halved: &'a [bool], size: FrameSize) -> Self {
        Self { plan, halved, size }
    }

    /// Shape of the contents of `place`.
    pub fn shape(&self, place: Place) -> Shape {
        let multiple = self.plan.multiple() as u32;
        let at = |level: u32, channels: usize| Shape {
            width: self.size.width.next_multiple_of(multiple) >> level,
            height: self.size.height.next_multiple_of(multiple) >> level,
            blocks: channels.div_ceil(BLOCK) as u32,
            channels: channels as u32,
        };
        match place {
            Place::Tensor(id) => at(self.plan.tensor(id).level, self.plan.tensor(id).channels),
            Place::Level(level) => at(level, BLOCK),
            Place::Moments => Shape { width: MOMENT_GROUPS, height: 1, blocks: 1, channels: 4 },
            Place::Sparse | Place::Motion | Place::Frame => {
                Shape { width: self.size.width, height: self.size.height, blocks: 1, channels: 4 }
            }
        }
    }

    /// Name for error messages.
    pub fn name(&self, place: Place) -> String {
        match place {
            Place::Tensor(id) => format!("tensor {} of frames of {}", self.plan.tensor(id).name, self.size),
            _ => format!("a frame of {}", self.size),
        }
    }

    /// Size in bytes.
    pub fn bytes(&self, place: Place) -> u64 {
        match place {
            Place::Tensor(id) if self.halved[id.index()] => 2 * self.shape(place).numbers(),
            Place::Motion => 2 * self.shape(place).numbers(),
            _ => 4 * self.shape(place).numbers(),
        }
    }
}

/// Pads `values` with zeros to whole blocks.
pub fn padded(values: &[f32]) -> Vec<f32> {
    let mut padded = values.to_vec();
    padded.resize(values.len().next_multiple_of(BLOCK), 0.0);
    padded
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::kernel::shader;
    use crate::plan::Named;
    use fovol_gpu::assert_twins;

    #[test]
    fn shaders_read_the_same_struct() {
        for shader in [shader::FRAME, shader::CONV, shader::FILTER, shader::NORM, shader::PYRAMID] {
            assert_twins!(shader, "Shape", Shape { width, height, blocks, channels });
        }
    }

    #[test]
    fn frames_are_padded_and_channels_lie_in_fours() {
        let plan = Named::WNetFast.config().plan().unwrap();
        let halved = vec![false; plan.tensors().len()];
        let sizes = Sizes::new(&plan, &halved, FrameSize::new(37, 16).unwrap());
        let shape = sizes.shape(Place::Tensor(plan.output()));
        assert_eq!(shape, Shape { width: 48, height: 16, blocks: 1, channels: 3 });
        assert_eq!(sizes.bytes(Place::Tensor(plan.output())), 48 * 16 * 16);
        assert_eq!(sizes.shape(Place::Level(2)), Shape { width: 12, height: 4, blocks: 1, channels: 4 });
    }
}
