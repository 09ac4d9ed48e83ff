/// Result of one step.
pub(crate) struct Taken {
    /// The terms of the loss.
    pub terms: Vec<(&'static str, f64)>,
    /// Norm of the gradients before clipping.
    pub norm: f64,
}
