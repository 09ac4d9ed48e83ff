use std::fmt;

/// How long a layer took on the device.
#[derive(Debug, Clone, PartialEq)]
pub struct LayerTime {
    /// Its place in [`Plan::layers`](crate::plan::Plan::layers); none for what comes before and after all layers.
    pub layer: Option<usize>,
    /// The layer's name, or its kind where it has none; `input` and `output` for what comes before and after all layers.
    pub name: String,
    /// Milliseconds.
    pub ms: f64,
}

/// What kernels belong to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stage {
    /// What is given.
    Input,
    /// A layer of the plan.
    Layer(usize),
    /// What is kept and shown.
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
