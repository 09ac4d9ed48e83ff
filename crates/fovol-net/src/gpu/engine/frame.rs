use crate::gpu::kernel::shader::{FRAME, KEEP};
use crate::gpu::kernel::{Groups, Kernel, Operand, flag};
use crate::gpu::tensor::Place;
use crate::plan::TensorId;

/// Input of a network for one frame on its device.
#[derive(Debug, Clone, Copy)]
pub struct DeviceInput<'a> {
    /// Sparse frame: width × height × RGBA as f32, top row first; alpha is 1 where a pixel was sampled. The usage
    /// must include `STORAGE`.
    pub sparse: &'a wgpu::Buffer,
    /// Motion: for each pixel the way to its position in the last frame, x right, y down, in pixels, as two f32.
    /// Networks that do not use motion ignore it; for others `None` means no motion. The usage must include
    /// `STORAGE`.
    pub motion: Option<&'a wgpu::Buffer>,
}

/// Makes a kernel that copies the input `from` to the padded tensor `to`.
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

/// Makes the kernel that loads colours and, as a fourth channel, the sample mask.
pub fn load_colour(to: TensorId) -> Kernel {
    load("load_colour", Place::Sparse, to)
}

/// Makes the kernel that loads the sample mask.
pub fn load_mask(to: TensorId) -> Kernel {
    load("load_mask", Place::Sparse, to)
}

/// Makes the kernel that loads the motion.
pub fn load_motion(to: TensorId) -> Kernel {
    load("load_motion", Place::Motion, to)
}

/// Makes the kernel that writes the output of a network to the frame.
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

/// Makes the kernel that replaces values of a state that are not finite by 0.
pub fn keep(kept: Place, is_halved: bool) -> Kernel {
    Kernel {
        shader: KEEP,
        entry_point: "keep",
        constants: vec![("HALVED", flag(is_halved))],
        operands: vec![Operand::Shape(kept), Operand::Change(kept)],
        groups: Groups::of(kept),
    }
}
