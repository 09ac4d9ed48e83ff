use super::element::{Bf16, Element};
use super::map::{Map, Stored, with_map};
use super::numbers::{Numbers, Words};
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
        Self {
            size,
            carried: carried.collect(),
            spare: Spare::default(),
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

    /// The carried tensors in the order of the plan's states, at the padded size.
    pub fn carried(&self) -> &[Stored] {
        &self.carried
    }
}

/// Buffers that are used again.
#[derive(Debug, Clone, Default)]
pub(super) struct Spare {
    buffers: Vec<Words>,
}

impl Spare {
    /// A tensor with memory for `length` numbers.
    pub fn take(&mut self, is_halved: bool, length: usize) -> Stored {
        match is_halved {
            true => Bf16::stored(Map { data: self.fitting(length), ..Map::default() }),
            false => f32::stored(self.take_picture(length)),
        }
    }

    /// A picture with memory for `length` numbers.
    pub fn take_picture(&mut self, length: usize) -> Map {
        Map { data: self.fitting(length), ..Map::default() }
    }

    /// A copy of a picture.
    pub fn copy(&mut self, stored: &Stored) -> Stored {
        let from = stored.picture();
        let mut copy = self.take_picture(from.data.len());
        copy.resize(stored.size());
        copy.data.copy_from_slice(&from.data);
        Stored::F32(copy)
    }

    /// Takes the memory of a tensor that is not needed any more.
    pub fn put(&mut self, stored: Stored) {
        let words = with_map!(stored, map => map.data.into_words());
        if words.capacity() > 0 {
            self.buffers.push(words);
        }
    }

    /// The smallest buffer that has room for `length` numbers; else a new one.
    fn fitting<T: Element>(&mut self, length: usize) -> Numbers<T> {
        let needed = Numbers::<T>::words(length);
        let fit = |words: &Words| (words.capacity() >= needed).then_some(words.capacity());
        let places = self.buffers.iter().enumerate().filter_map(|(place, words)| Some((fit(words)?, place)));
        Numbers::within(match places.min() {
            Some((_, place)) => self.buffers.swap_remove(place),
            None => Words::with_capacity(needed),
        })
    }
}

/// Rows and columns of `size`, padded as `plan` wants them.
pub fn padded(plan: &Plan, size: FrameSize) -> [usize; 2] {
    let multiple = plan.multiple();
    [size.height, size.width].map(|side| (side as usize).next_multiple_of(multiple))
}
