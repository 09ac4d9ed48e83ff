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
        let carried: Vec<Stored> = carried.collect();
        let used = carried.iter().map(bytes).sum();
        Self { size, carried, spare: Spare { used, ..Spare::default() }, network }
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

/// Buffers that are used again, as far as all together never take more memory than was needed at once.
#[derive(Debug, Clone, Default)]
pub(super) struct Spare {
    /// Those that came back last are at the end.
    buffers: Vec<Stored>,
    /// Bytes of the buffers in use.
    used: usize,
    /// The most they have been.
    most: usize,
}

impl Spare {
    /// A tensor with memory for `length` numbers.
    pub fn take(&mut self, is_halved: bool, length: usize) -> Stored {
        let found = match is_halved {
            true => self.fitting::<Bf16>(length).map(Bf16::stored),
            false => self.fitting::<f32>(length).map(f32::stored),
        };
        let stored = found.unwrap_or_else(|| self.added(is_halved, length));
        self.used += bytes(&stored);
        stored
    }

    /// Memory for `length` numbers of a picture.
    pub fn take_f32(&mut self, length: usize) -> Vec<f32> {
        f32::loaded(self.take(false, length)).data
    }

    /// A copy of `stored`.
    pub fn copy(&mut self, stored: &Stored) -> Stored {
        let length = with_map!(stored, map => map.data.len());
        let mut copy = self.take(Bf16::of(stored).is_some(), length);
        copy.clone_from(stored);
        copy
    }

    /// Takes the memory of a tensor that is not needed any more.
    pub fn put(&mut self, stored: Stored) {
        if bytes(&stored) > 0 {
            self.used -= bytes(&stored);
            self.buffers.push(stored);
        }
    }

    /// The smallest buffer that has room for `length` numbers; one that is far too large for them only if there would else
    /// be too many buffers.
    fn fitting<T: Element>(&mut self, length: usize) -> Option<Map<T>> {
        let room = self.most.saturating_sub(self.used) / size_of::<T>();
        let is_full = self.held() + length * size_of::<T>() > room * size_of::<T>();
        let most = if is_full { room.max(length) } else { length + length / 4 };
        let fits = |stored: &Stored| {
            let capacity = T::of(stored)?.data.capacity();
            (length..=most).contains(&capacity).then_some(capacity)
        };
        let places =
            self.buffers.iter().enumerate().filter_map(|(place, stored)| Some((fits(stored)?, place)));
        let (_, place) = places.min()?;
        Some(T::loaded(self.buffers.remove(place)))
    }

    fn held(&self) -> usize {
        self.buffers.iter().map(bytes).sum()
    }

    /// A new buffer, instead of others if there are too many: as little of them as possible.
    fn added(&mut self, is_halved: bool, length: usize) -> Stored {
        let needed = self.used + length * if is_halved { 2 } else { 4 };
        self.most = self.most.max(needed);
        loop {
            let Some(excess) = (needed + self.held()).checked_sub(self.most).filter(|&excess| excess > 0)
            else {
                break;
            };
            let order = |stored: &Stored| (bytes(stored) < excess, bytes(stored).abs_diff(excess));
            let places = (0..self.buffers.len()).min_by_key(|&place| order(&self.buffers[place]));
            let Some(place) = places else { break };
            self.buffers.remove(place);
        }
        match is_halved {
            true => Stored::Bf16(Map { data: Vec::with_capacity(length), ..Map::default() }),
            false => Stored::F32(Map { data: Vec::with_capacity(length), ..Map::default() }),
        }
    }
}

/// The memory of a tensor.
fn bytes(stored: &Stored) -> usize {
    match stored {
        Stored::F32(map) => map.data.capacity() * 4,
        Stored::Bf16(map) => map.data.capacity() * 2,
    }
}

/// Rows and columns of `size`, padded as `plan` wants them.
pub fn padded(plan: &Plan, size: FrameSize) -> [usize; 2] {
    let multiple = plan.multiple();
    [size.height, size.width].map(|side| (side as usize).next_multiple_of(multiple))
}
