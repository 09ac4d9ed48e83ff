use rayon::prelude::*;
use tch::{Device, Tensor};

/// One frame of a batch of clips.
///
/// A network learns either colours or light ratios. The picture of its output x is scale · x − offset: x itself for
/// colours, and (Û + ε)·ρ − ε for ratios.
#[derive(Debug)]
pub struct LessonFrame {
    /// Colours or ratios of the samples, 0 elsewhere: \[batch, 3, rows, columns\].
    pub colour: Tensor,
    /// 1 where `colour` is known: \[batch, 1, rows, columns\].
    pub mask: Tensor,
    /// Motion from each pixel to its previous position, from the depths of samples and guide: \[batch, 2, rows, columns\]
    /// in pixels.
    pub motion: Tensor,
    /// Motion from the depths of all pixels: \[batch, 2, rows, columns\] in pixels.
    pub true_motion: Tensor,
    /// Fully rendered frame: \[batch, 3, rows, columns\].
    pub target: Tensor,
    /// 1 where the target is known and shown as it is: \[batch, 1, rows, columns\].
    pub shown: Tensor,
    /// Factor of the network's output: \[batch, 3, rows, columns\].
    pub scale: Tensor,
    /// Offset that is subtracted then: \[batch, 1, 1, 1\].
    pub offset: Tensor,
}

impl LessonFrame {
    /// Picture of the network's output `output`, not clamped: \[batch, 3, rows, columns\].
    pub fn picture(&self, output: &Tensor) -> Tensor {
        self.target.where_self(&self.shown.gt(0.5), &(&self.scale * output - &self.offset))
    }

    /// Slice of `count` clips of the batch, from clip `first` on.
    #[must_use]
    pub fn clips(&self, first: i64, count: i64) -> Self {
        self.each(|tensor| tensor.narrow(0, first, count))
    }

    /// Copies the tensors to `device` asynchronously, after the work queued there.
    #[must_use]
    pub fn to_device(&self, device: Device) -> Self {
        self.each(|tensor| tensor.to_device_(device, tensor.kind(), true, false))
    }

    /// Moves the tensors to pinned memory if `device` is a GPU, so that copies overlap with computation.
    #[must_use]
    pub fn ready_for(&self, device: Device) -> Self {
        // `pin_memory` does this too, but warns for each tensor that its argument is deprecated.
        self.each(|tensor| match device.is_cuda() {
            true => tensor.internal_pin_memory(device),
            false => tensor.shallow_clone(),
        })
    }

    /// Joins frames of the same time step along the batch dimension.
    fn beside(frames: &[Self]) -> Self {
        Self::made(|part| Tensor::cat(&frames.iter().map(part).collect::<Vec<_>>(), 0))
    }

    fn each(&self, change: impl Fn(&Tensor) -> Tensor) -> Self {
        Self::made(|part| change(part(self)))
    }

    /// Makes each tensor from those of other frames, which a function picks from them.
    fn made(make: impl Fn(fn(&Self) -> &Tensor) -> Tensor) -> Self {
        Self {
            colour: make(|frame| &frame.colour),
            mask: make(|frame| &frame.mask),
            motion: make(|frame| &frame.motion),
            true_motion: make(|frame| &frame.true_motion),
            target: make(|frame| &frame.target),
            shown: make(|frame| &frame.shown),
            scale: make(|frame| &frame.scale),
            offset: make(|frame| &frame.offset),
        }
    }
}

/// Joins the frames of `single` clips as batches, up to the shortest length.
pub(super) fn batch(single: Vec<Vec<LessonFrame>>) -> Vec<LessonFrame> {
    let length = single.iter().map(Vec::len).min().unwrap_or(0);
    let mut moments: Vec<Vec<LessonFrame>> = (0..length).map(|_| Vec::new()).collect();
    for clip in single {
        moments.iter_mut().zip(clip).for_each(|(moment, frame)| moment.push(frame));
    }
    moments.into_par_iter().map(|frames| LessonFrame::beside(&frames)).collect()
}
