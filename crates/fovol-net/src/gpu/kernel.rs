//! What a layer has a device do, before it is known for which frames.

use super::tensor::{Place, Sizes};
use fovol_gpu::Shader;
use fovol_gpu::binding::Slot;

/// One thing that a shader is given.
#[derive(Debug, Clone)]
pub enum Operand {
    /// The shape of something.
    Shape(Place),
    /// Something to read.
    Read(Place),
    /// Something to write as a whole.
    Write(Place),
    /// Something to change.
    Change(Place),
    /// A few numbers that are the same for all frames.
    Uniform(wgpu::Buffer),
    /// Learned numbers.
    Learned(wgpu::Buffer),
}

impl Operand {
    /// How shaders bind it.
    pub fn slot(&self) -> Slot {
        match self {
            Self::Shape(_) | Self::Uniform(_) => Slot::Uniform,
            Self::Read(_) | Self::Learned(_) => Slot::Read,
            Self::Write(_) | Self::Change(_) => Slot::Write,
        }
    }

    /// What it reads or writes.
    pub fn place(&self) -> Option<Place> {
        match self {
            Self::Read(place) | Self::Write(place) | Self::Change(place) => Some(*place),
            Self::Shape(_) | Self::Uniform(_) | Self::Learned(_) => None,
        }
    }
}

/// For what there are workgroups.
#[derive(Debug, Clone, Copy)]
pub enum Groups {
    /// For each box of this many columns, rows and blocks of something.
    Over(Place, [u32; 3]),
    /// So many.
    Count(u32),
}

impl Groups {
    /// For 8×8 pixels of each block.
    pub fn of(place: Place) -> Self {
        Self::Over(place, [8, 8, 1])
    }

    /// How many there are along each axis.
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

/// An entry point of a shader with what it is given, at bindings 0, 1, 2…
#[derive(Debug, Clone)]
pub struct Kernel {
    pub shader: Shader,
    pub entry_point: &'static str,
    /// Values of its `override` constants.
    pub constants: Vec<(&'static str, f64)>,
    pub operands: Vec<Operand>,
    pub groups: Groups,
}

/// A yes or no as the value of a constant.
pub fn flag(is_set: bool) -> f64 {
    f64::from(u8::from(is_set))
}

/// Yeses and noes as the bits of a constant, the first one lowest.
pub fn bits(are_set: &[bool]) -> f64 {
    are_set.iter().rev().fold(0.0, |all, is_set| 2.0 * all + flag(*is_set))
}
