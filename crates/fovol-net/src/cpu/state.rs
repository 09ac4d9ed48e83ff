use super::map::Map;
use crate::plan::Plan;
use fovol_core::FrameSize;

/// What one clip carries from frame to frame, and the memory that its frames are made in.
///
/// A state belongs to one clip of one network and size; any number of them can use the same [`super::Network`].
#[derive(Debug, Clone)]
pub struct State {
    pub(super) size: FrameSize,
    /// States in the order of the plan, at the padded size.
    pub(super) carried: Vec<Map>,
    /// Buffers that are used again.
    pub(super) spare: Vec<Vec<f32>>,
    /// Which network it belongs to.
    pub(super) network: u64,
}

impl State {
    /// Zeros for a clip of frames of `size`.
    pub(super) fn new(plan: &Plan, size: FrameSize, network: u64) -> Self {
        let [height, width] = padded(plan, size);
        let carried = plan.states().iter().map(|state| {
            let tensor = plan.tensor(state.previous);
            Map::zeros(height >> tensor.level, width >> tensor.level, tensor.channels)
        });
        Self { size, carried: carried.collect(), spare: Vec::new(), network }
    }

    /// The size of the clip's frames.
    pub fn size(&self) -> FrameSize {
        self.size
    }

    /// Forgets the past: the next frame is treated as the first of a clip, as after a cut.
    pub fn reset(&mut self) {
        self.carried.iter_mut().for_each(|map| map.data.fill(0.0));
    }

    /// The carried tensors in the order of the plan's states: \[row\]\[column\]\[channel\] at the padded size.
    pub fn carried(&self) -> &[Map] {
        &self.carried
    }
}

/// Rows and columns of `size`, padded as `plan` wants them.
pub fn padded(plan: &Plan, size: FrameSize) -> [usize; 2] {
    let multiple = plan.multiple();
    [size.height, size.width].map(|side| (side as usize).next_multiple_of(multiple))
}
