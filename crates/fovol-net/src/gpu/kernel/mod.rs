//! Kernels: the work of a layer on a device, before the frame size is known.

mod constants;
mod context;
mod pipelines;
pub mod shader;

pub use constants::{activation_number, bits, flag, resize_number};
pub use context::{Context, too_many};
pub use pipelines::{Pipeline, Pipelines};

use super::tensor::{Place, Sizes};
use fovol_gpu::Shader;
use fovol_gpu::binding::Slot;

/// A resource that a kernel binds.
#[derive(Debug, Clone)]
pub enum Operand {
    /// Shape of a place.
    Shape(Place),
    /// Place that the kernel reads.
    Read(Place),
    /// Place that the kernel writes as a whole.
    Write(Place),
    /// Place that the kernel reads and writes.
    Change(Place),
    /// Constants in a uniform buffer, for all frames.
    Uniform(wgpu::Buffer),
    /// Learned numbers.
    Learned(wgpu::Buffer),
}

impl Operand {
    /// Type of the binding.
    pub fn slot(&self) -> Slot {
        match self {
            Self::Shape(_) | Self::Uniform(_) => Slot::Uniform,
            Self::Read(_) | Self::Learned(_) => Slot::Read,
            Self::Write(_) | Self::Change(_) => Slot::Write,
        }
    }

    /// Place that the kernel reads or writes, if any.
    pub fn place(&self) -> Option<Place> {
        match self {
            Self::Read(place) | Self::Write(place) | Self::Change(place) => Some(*place),
            Self::Shape(_) | Self::Uniform(_) | Self::Learned(_) => None,
        }
    }
}

/// Number of workgroups.
#[derive(Debug, Clone, Copy)]
pub enum Groups {
    /// One for each box of this many columns, rows and blocks of a place.
    Over(Place, [u32; 3]),
    /// A fixed number.
    Count(u32),
}

impl Groups {
    /// One workgroup for 8×8 pixels of each block of `place`.
    pub fn of(place: Place) -> Self {
        Self::Over(place, [8, 8, 1])
    }

    /// Number of workgroups along each axis.
    pub fn count(&self, sizes: &Sizes<'_>) -> [u32; 3] {
        match *self {
            Self::Count(count) => [count, 1, 1],
            Self::Over(place, [x, y, z]) => {
                let shape = sizes.shape(place);
                [shape.width.div_ceil(x), shape.height.div_ceil(y), shape.blocks.div_ceil(z)]
            }
        }
    }
}

/// An entry point of a shader with its operands, at bindings 0, 1, 2…
#[derive(Debug, Clone)]
pub struct Kernel {
    pub shader: Shader,
    pub entry_point: &'static str,
    /// Values of its `override` constants.
    pub constants: Vec<(&'static str, f64)>,
    pub operands: Vec<Operand>,
    pub groups: Groups,
}
