use crate::plan::{Layer, Plan, Pool, TensorId, Warp};
use fovol_gpu::Gpu;
use std::fmt;
use std::str::FromStr;

/// Precision of a network's arithmetic on a device. Sums are always f32.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Precision {
    /// [`Self::F16`] if the device has f16 arithmetic, else [`Self::F32`].
    #[default]
    Auto,
    /// f32 throughout.
    F32,
    /// Wide tensors are stored as f16, on any device, which halves memory and traffic. Products use cooperative
    /// matrices where [`Gpu::matrices`] are available.
    F16,
}

/// Fewest channels of a wide tensor. Tensors with fewer are pictures and stay f32.
const WIDE: usize = 16;

impl Precision {
    /// All precisions.
    pub const ALL: [Self; 3] = [Self::Auto, Self::F32, Self::F16];

    /// Name in flags and files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::F32 => "f32",
            Self::F16 => "f16",
        }
    }

    /// Precision in use on the device of `gpu`; never [`Self::Auto`].
    #[must_use]
    pub fn on(self, gpu: &Gpu) -> Self {
        match self {
            Self::Auto if gpu.device().features().contains(wgpu::Features::SHADER_F16) => Self::F16,
            Self::Auto => Self::F32,
            other => other,
        }
    }
}

impl fmt::Display for Precision {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Precision {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let found = Self::ALL.into_iter().find(|precision| precision.name() == text);
        found.ok_or_else(|| format!("`{text}` is no precision; use {}", Self::ALL.map(Self::name).join(", ")))
    }
}

/// Finds the tensors of `plan` that are stored as f16: wide ones that only layers with many products read and
/// write.
pub fn halved(plan: &Plan, precision: Precision) -> Vec<bool> {
    let wide = |tensor: &crate::plan::TensorSpec| precision == Precision::F16 && tensor.channels >= WIDE;
    let mut halved: Vec<bool> = plan.tensors().iter().map(wide).collect();
    for layer in plan.layers() {
        layer_pictures(layer).for_each(|id| halved[id.index()] = false);
    }
    // Inputs and outputs of layers that only move values have one storage type, as have states and their next
    // values.
    for _ in 0..=plan.tensors().len() {
        let before = halved.clone();
        let alike = plan.layers().iter().filter_map(|layer| match layer {
            Layer::Pool(Pool { input, output }) | Layer::Warp(Warp { input, output, .. }) => {
                Some((*input, *output))
            }
            _ => None,
        });
        let states = plan.states().iter().map(|state| (state.previous, state.next));
        for (a, b) in alike.chain(states) {
            let both = halved[a.index()] && halved[b.index()];
            (halved[a.index()], halved[b.index()]) = (both, both);
        }
        if halved == before {
            break;
        }
    }
    halved
}

/// Tensors of `layer` that have to be f32 at any width.
fn layer_pictures(layer: &Layer) -> impl Iterator<Item = TensorId> {
    let all = || layer.inputs().into_iter().chain([layer.output()]);
    let pictures: Vec<TensorId> = match layer {
        Layer::Conv(_) | Layer::Norm(_) | Layer::Pool(_) => Vec::new(),
        Layer::Warp(Warp { motion, .. }) => vec![*motion],
        Layer::Filter(filter) => all().filter(|id| *id != filter.features).collect(),
        _ => all().collect(),
    };
    pictures.into_iter()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::Named;

    #[test]
    fn precisions_read_as_written() {
        for precision in Precision::ALL {
            assert_eq!(precision.to_string().parse(), Ok(precision));
        }
        assert!("bf16".parse::<Precision>().is_err());
    }

    #[test]
    fn features_are_halved_and_pictures_are_not() {
        for named in Named::ALL {
            let plan = named.config().plan().unwrap();
            assert!(halved(&plan, Precision::F32).iter().all(|halved| !halved));
            let halved = halved(&plan, Precision::F16);
            for (tensor, halved) in plan.tensors().iter().zip(&halved) {
                assert_eq!(*halved, tensor.channels >= WIDE, "{named} {}", tensor.name);
            }
        }
    }
}
