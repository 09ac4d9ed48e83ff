use super::element::{Bf16, Element};
use super::map::{Map, Stored, with_map};
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
    /// Which network it belongs to.
    pub(super) network: u64,
}

impl State {
    /// Zeros for a clip of frames of `size`; `halved` says of each tensor whether its numbers take two bytes.
    pub(super) fn new(plan: &Plan, size: FrameSize, halved: &[bool], network: u64) -> Self {
        let [height, width] = padded(plan, size);
        let carried = plan.states().iter().map(|state| {
            let tensor = plan.tensor(state.previous);
            let (height, width) = (height >> tensor.level, width >> tensor.level);
            match halved[state.previous.index()] {
                true => Stored::Bf16(Map::zeros(height, width, tensor.channels)),
                false => Stored::F32(Map::zeros(height, width, tensor.channels)),
            }
        });
        Self { size, carried: carried.collect(), spare: Spare::default(), network }
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

    /// The carried tensors in the order of the plan's states, at the padded size.
    pub fn carried(&self) -> &[Stored] {
        &self.carried
    }
}

/// Buffers that are used again.
#[derive(Debug, Clone, Default)]
pub(super) struct Spare {
    buffers: Vec<Stored>,
}

impl Spare {
    /// A tensor with memory for `length` numbers.
    pub fn take(&mut self, is_halved: bool, length: usize) -> Stored {
        match is_halved {
            true => Bf16::stored(Map { data: self.fitting(length), ..Map::default() }),
            false => f32::stored(Map { data: self.fitting(length), ..Map::default() }),
        }
    }

    /// Memory for `length` numbers of a picture.
    pub fn take_f32(&mut self, length: usize) -> Vec<f32> {
        self.fitting(length)
    }

    /// Takes the memory of a tensor that is not needed any more.
    pub fn put(&mut self, stored: Stored) {
        if with_map!(&stored, map => map.data.capacity()) > 0 {
            self.buffers.push(stored);
        }
    }

    /// The smallest buffer that has room for `length` numbers and is not far too large for them; else a new one.
    fn fitting<T: Element>(&mut self, length: usize) -> Vec<T> {
        let fits = |stored: &Stored| {
            let capacity = T::of(stored)?.data.capacity();
            (length..=2 * length).contains(&capacity).then_some(capacity)
        };
        let places =
            self.buffers.iter().enumerate().filter_map(|(place, stored)| Some((fits(stored)?, place)));
        match places.min() {
            Some((_, place)) => T::loaded(self.buffers.swap_remove(place)).data,
            None => Vec::with_capacity(length),
        }
    }
}

/// Rows and columns of `size`, padded as `plan` wants them.
pub fn padded(plan: &Plan, size: FrameSize) -> [usize; 2] {
    let multiple = plan.multiple();
    [size.height, size.width].map(|side| (side as usize).next_multiple_of(multiple))
}
