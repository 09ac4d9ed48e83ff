use super::RandomWeights;

/// Weights of a network.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum WeightsChoice {
    /// Built-in weights of the method's usual network.
    #[default]
    Usual,
    /// Built-in weights by name, or a file as [`fovol_core::text_of_path`] writes it.
    Named(String),
    /// Random weights, to measure speed.
    Random(RandomWeights),
}
