use std::fmt;

/// Duration of a layer on the device.
#[derive(Debug, Clone, PartialEq)]
pub struct LayerTime {
    /// Index in [`Plan::layers`](crate::plan::Plan::layers); `None` for work before and after all layers.
    pub layer: Option<usize>,
    /// Name of the layer, or its kind if it has none; `input` and `output` for work before and after all layers.
    pub name: String,
    /// Duration in milliseconds.
    pub ms: f64,
}

/// Part of a frame to which kernels belong.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stage {
    /// Loading of inputs.
    Input,
    /// A layer of the plan.
    Layer(usize),
    /// Clean-up of states, and the output.
    Output,
}

impl fmt::Display for Stage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Input => f.write_str("input"),
            Self::Layer(number) => write!(f, "layer {number}"),
            Self::Output => f.write_str("output"),
        }
    }
}
