use std::fmt;

/// A step of a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Stage {
    /// Which pixels are sampled.
    Mask,
    /// Their list.
    Compact,
    /// Their colours.
    March,
    /// The sparse frame.
    Scatter,
}

impl Stage {
    /// How many there are.
    pub(super) const COUNT: u32 = 4;
}

impl fmt::Display for Stage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Mask => "mask",
            Self::Compact => "compact",
            Self::March => "march",
            Self::Scatter => "scatter",
        })
    }
}
