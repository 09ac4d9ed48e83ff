use super::buffers::Spare;
use super::map::{Stored, with_map};
use super::pyramid::Pyramid;
use super::samples::Samples;
use crate::plan::Plan;
use fovol_core::FrameSize;

/// What one clip carries from frame to frame, and the memory that its frames are made in.
///
/// A state belongs to one clip of one network and size; any number of them can use the same [`super::Network`].
#[derive(Debug, Clone)]
pub struct State {
    pub(super) size: FrameSize,
    /// States in the order of the plan, at the padded size.
    pub(super) carried: Vec<Stored>,
    pub(super) spare: Spare,
    pub(super) pyramid: Pyramid,
    /// Those of the frame that is made, where they are not wanted as pictures.
    pub(super) samples: Samples,
    /// Which network it belongs to.
    pub(super) network: u64,
}

impl State {
    /// Zeros for a clip of frames of `size` in the memory of `spare`; `halved` says of each tensor whether its numbers take
    /// two bytes.
    pub(super) fn new(plan: &Plan, size: FrameSize, halved: &[bool], mut spare: Spare, network: u64) -> Self {
        let [height, width] = padded(plan, size);
        let carried = plan.states().iter().map(|state| {
            let (place, tensor) = (state.previous.index(), plan.tensor(state.previous));
            let shape = [height >> tensor.level, width >> tensor.level, tensor.channels];
            let mut stored = spare.take(halved[place], place);
            with_map!(&mut stored, map => {
                map.resize(shape);
                map.data.fill(Default::default());
            });
            stored
        });
        Self {
            size,
            carried: carried.collect(),
            spare,
            pyramid: Pyramid::default(),
            samples: Samples::default(),
            network,
        }
    }

    /// The size of the clip's frames.
    pub fn size(&self) -> FrameSize {
        self.size
    }

    /// Forgets the past: the next frame is treated as the first of a clip, as after a cut.
    pub fn reset(&mut self) {
        for stored in &mut self.carried {
            with_map!(stored, map => map.data.fill(Default::default()));
        }
    }
}

/// Rows and columns of `size`, padded as `plan` wants them.
pub fn padded(plan: &Plan, size: FrameSize) -> [usize; 2] {
    let multiple = plan.multiple();
    [size.height, size.width].map(|side| (side as usize).next_multiple_of(multiple))
}
