use tch::Tensor;

/// Inputs of a network for one frame of a batch of clips.
#[derive(Debug, Clone, Copy)]
pub struct Inputs<'a> {
    /// RGB in 0…1, 0 where unsampled: \[batch, 3, rows, columns\].
    pub colour: &'a Tensor,
    /// Sampling mask, 1 where sampled, else 0: \[batch, 1, rows, columns\]. Networks without a mask input ignore it.
    pub mask: Option<&'a Tensor>,
    /// Motion from each pixel to its position in the last frame, in pixels, x right, then y down: \[batch, 2, rows,
    /// columns\]. Networks without a motion input ignore it; for others `None` means no motion.
    pub motion: Option<&'a Tensor>,
}
