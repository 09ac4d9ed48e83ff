use crate::cpu::engine::buffers::Spare;
use crate::cpu::fill::pyramid::Pyramid;
use crate::cpu::tensor::samples::Samples;
use crate::cpu::tensor::{AnyTensor, with_tensor};
use crate::plan::Plan;
use fovol_core::FrameSize;

/// State that one sequence carries from frame to frame, and memory for its frames.
///
/// A state belongs to one sequence of one network and frame size. Any number of states can use one
/// [`Network`](crate::cpu::Network).
#[derive(Debug, Clone)]
pub struct State {
    pub(super) size: FrameSize,
    /// State tensors in the order of the plan, at the padded size.
    pub(super) carried: Vec<AnyTensor>,
    pub(super) spare: Spare,
    pub(super) pyramid: Pyramid,
    /// Samples of the present frame, if layers read them as a list.
    pub(super) samples: Samples,
    /// Identifier of the network.
    pub(super) network: u64,
}

impl State {
    /// Makes a state of zeros for frames of `size`, in memory of `spare`. `halved` says which tensors are stored as
    /// bf16.
    pub(super) fn new(plan: &Plan, size: FrameSize, halved: &[bool], mut spare: Spare, network: u64) -> Self {
        let [height, width] = padded(plan, size);
        let carried = plan.states().iter().map(|state| {
            let (place, tensor) = (state.previous.index(), plan.tensor(state.previous));
            let shape = [height >> tensor.level, width >> tensor.level, tensor.channels];
            let mut stored = spare.take(halved[place], place);
            with_tensor!(&mut stored, map => {
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

    /// Size of the frames.
    pub fn size(&self) -> FrameSize {
        self.size
    }

    /// Resets the history, so that the next frame is treated as the first after a cut.
    pub fn reset(&mut self) {
        for stored in &mut self.carried {
            with_tensor!(stored, map => map.data.fill(Default::default()));
        }
    }
}

/// Rows and columns of `size`, padded to the multiple that `plan` needs.
pub fn padded(plan: &Plan, size: FrameSize) -> [usize; 2] {
    let multiple = plan.multiple();
    [size.height, size.width].map(|side| (side as usize).next_multiple_of(multiple))
}
