use super::element::Bf16;
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
    f32: Vec<Vec<f32>>,
    bf16: Vec<Vec<Bf16>>,
}

impl Spare {
    /// A tensor with memory for `length` numbers.
    pub fn take(&mut self, is_halved: bool, length: usize) -> Stored {
        match is_halved {
            true => Stored::Bf16(Map { data: fitting(&mut self.bf16, length), ..Map::default() }),
            false => Stored::F32(Map { data: self.take_f32(length), ..Map::default() }),
        }
    }

    /// Memory for `length` numbers of a picture.
    pub fn take_f32(&mut self, length: usize) -> Vec<f32> {
        fitting(&mut self.f32, length)
    }

    /// Takes the memory of a tensor that is not needed any more.
    pub fn put(&mut self, stored: Stored) {
        match stored {
            Stored::F32(map) if map.data.capacity() > 0 => self.f32.push(map.data),
            Stored::Bf16(map) if map.data.capacity() > 0 => self.bf16.push(map.data),
            _ => {}
        }
    }
}

/// The smallest of `buffers` that has room for `length` numbers and is not far too large for them; else a new one.
fn fitting<T>(buffers: &mut Vec<Vec<T>>, length: usize) -> Vec<T> {
    let fits = |buffer: &Vec<T>| (length..=2 * length).contains(&buffer.capacity());
    let places = (0..buffers.len()).filter(|&i| fits(&buffers[i]));
    match places.min_by_key(|&i| buffers[i].capacity()) {
        Some(place) => buffers.swap_remove(place),
        None => Vec::with_capacity(length),
    }
}

/// Rows and columns of `size`, padded as `plan` wants them.
pub fn padded(plan: &Plan, size: FrameSize) -> [usize; 2] {
    let multiple = plan.multiple();
    [size.height, size.width].map(|side| (side as usize).next_multiple_of(multiple))
}
