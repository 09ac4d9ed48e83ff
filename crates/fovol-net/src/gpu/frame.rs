use super::kernel::{Groups, Kernel, Operand, flag};
use super::shader::{FRAME, KEEP};
use super::tensor::Place;
use crate::plan::TensorId;

/// What a network is given for one frame that lies on its device.
#[derive(Debug, Clone, Copy)]
pub struct DeviceInput<'a> {
    /// The sparse frame: width × height × RGBA as f32, row 0 on top; alpha is 1 where a pixel was sampled. To be bound as
    /// storage.
    pub sparse: &'a wgpu::Buffer,
    /// For each pixel the way (x right, y down, in pixels, two f32) to where it was in the last frame; networks that do not
    /// use motion ignore it, for others none means stillness. To be bound as storage.
    pub motion: Option<&'a wgpu::Buffer>,
}

/// The kernel that brings what is given, as `entry_point` has it, to the padded tensor `to`.
fn load(entry_point: &'static str, from: Place, to: TensorId) -> Kernel {
    let to = Place::Tensor(to);
    Kernel {
        shader: FRAME,
        entry_point,
        constants: Vec::new(),
        operands: vec![
            Operand::Shape(Place::Frame),
            Operand::Shape(to),
            Operand::Read(from),
            Operand::Write(to),
        ],
        groups: Groups::of(to),
    }
}

/// Colours, and which of them are known as a fourth channel.
pub fn load_colour(to: TensorId) -> Kernel {
    load("load_colour", Place::Sparse, to)
}

/// Which pixels are known.
pub fn load_mask(to: TensorId) -> Kernel {
    load("load_mask", Place::Sparse, to)
}

/// Where pixels were.
pub fn load_motion(to: TensorId) -> Kernel {
    load("load_motion", Place::Motion, to)
}

/// The kernel that makes a frame of the output of a network.
pub fn show(output: Place) -> Kernel {
    Kernel {
        shader: FRAME,
        entry_point: "show",
        constants: Vec::new(),
        operands: vec![
            Operand::Shape(Place::Frame),
            Operand::Shape(output),
            Operand::Read(output),
            Operand::Write(Place::Frame),
        ],
        groups: Groups::of(Place::Frame),
    }
}

/// The kernel that takes numbers out of what is kept for the next frame that are not finite.
pub fn keep(kept: Place, is_halved: bool) -> Kernel {
    Kernel {
        shader: KEEP,
        entry_point: "keep",
        constants: vec![("HALVED", flag(is_halved))],
        operands: vec![Operand::Shape(kept), Operand::Change(kept)],
        groups: Groups::of(kept),
    }
}
