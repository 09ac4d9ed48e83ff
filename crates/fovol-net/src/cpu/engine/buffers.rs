//! Memory planning for tensors: tensors that are never alive at the same time share a buffer.
//!
//! The sizes of buffers are planned once per frame size, from the lifetimes of tensors. A tensor then takes any
//! free buffer of its planned size.

use crate::cpu::tensor::element::Element;
use crate::cpu::tensor::page_buf::PageBuf;
use crate::cpu::tensor::tensor_buf::TensorBuf;
use crate::cpu::tensor::{AnyTensor, Tensor, with_tensor};
use fovol_core::memory::Shortage;

/// Lifetimes and sizes of tensors, recorded by a dry run of one frame.
#[derive(Debug)]
pub struct Lifetimes {
    /// Lifetime of each tensor that has memory of its own.
    spans: Vec<Option<Span>>,
    /// For each tensor, the tensor whose buffer it uses.
    owners: Vec<usize>,
    /// For each tensor, the last tensor that uses its buffer.
    holders: Vec<usize>,
    /// Pairs of tensors that swap buffers from frame to frame.
    alike: Vec<[usize; 2]>,
    now: usize,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Span {
    words: usize,
    first: usize,
    last: usize,
}

impl Span {
    fn meets(self, other: Self) -> bool {
        self.first <= other.last && other.first <= self.last
    }
}

impl Lifetimes {
    /// Begins with `count` tensors, none of which is alive.
    pub fn new(count: usize) -> Self {
        let each = || (0..count).collect();
        Self { spans: vec![None; count], owners: each(), holders: each(), alike: Vec::new(), now: 0 }
    }

    /// Advances time by one step.
    pub fn go_on(&mut self) {
        self.now += 1;
    }

    /// Begins the life of tensor `place`, which takes `words` words. It stays alive to the end unless [`Self::end`]
    /// is called.
    pub fn begin(&mut self, place: usize, words: usize) {
        self.spans[place] = Some(Span { words, first: self.now, last: usize::MAX });
    }

    /// Tensor `place` takes over the buffer of tensor `other`, whose life ends.
    pub fn take_over(&mut self, place: usize, other: usize) {
        let owner = self.owners[other];
        (self.owners[place], self.holders[owner]) = (owner, place);
    }

    /// Ends the life of tensor `place` after the present step.
    pub fn end(&mut self, place: usize) {
        let owner = self.owners[place];
        if self.holders[owner] == place {
            self.spans[owner].iter_mut().for_each(|span| span.last = self.now);
        }
    }

    /// Reserves the buffer of tensor `place` for the whole frame.
    pub fn keep(&mut self, place: usize) {
        self.spans[place].iter_mut().for_each(|span| (span.first, span.last) = (0, usize::MAX));
    }

    /// Records that tensor `previous` gets the buffer of tensor `next` in the next frame, so both need one size.
    pub fn take_turns(&mut self, previous: usize, next: usize) {
        self.alike.push([previous, next].map(|place| self.owners[place]));
    }

    /// Plans the buffer size of each tensor, in words. The largest tensors choose first; each takes the smallest
    /// buffer that is free during its life, or a new one.
    fn capacities(&self) -> Vec<usize> {
        let buffers = self.buffers();
        let words = |owner: &usize| buffers.chosen[*owner].map_or(0, |buffer| buffers.all[buffer].0);
        self.owners.iter().map(words).collect()
    }

    /// The words of each buffer.
    pub fn words(&self) -> Vec<usize> {
        self.buffers().all.into_iter().map(|(words, _)| words).collect()
    }

    /// The largest tensors choose first; each takes the smallest buffer that is free as long as it is there, or a new one.
    fn buffers(&self) -> Buffers {
        let mut owners: Vec<usize> =
            (0..self.spans.len()).filter(|&place| self.spans[place].is_some()).collect();
        owners.sort_by_key(|&place| std::cmp::Reverse(self.spans[place].map(|span| span.words)));
        let mut buffers = Buffers { all: Vec::new(), chosen: vec![None; self.spans.len()] };
        for place in owners {
            let other = self.alike.iter().find_map(|&[a, b]| match place {
                _ if a == place => Some(b),
                _ if b == place => Some(a),
                _ => None,
            });
            let together = [Some(place), other.filter(|&other| other != place)];
            let spans = together.into_iter().flatten().filter_map(|place| Some((place, self.spans[place]?)));
            let spans: Vec<(usize, Span)> =
                spans.filter(|&(place, _)| buffers.chosen[place].is_none()).collect();
            buffers.choose(&spans);
        }
        buffers
    }
}

/// Buffers during planning.
struct Buffers {
    /// Size in words and occupied times of each buffer, the largest first.
    all: Vec<(usize, Vec<Span>)>,
    /// Chosen buffer of each tensor.
    chosen: Vec<Option<usize>>,
}

impl Buffers {
    /// Gives `tensors`, which have equal sizes, buffers of one size. They may share a buffer if their lifetimes do
    /// not overlap.
    fn choose(&mut self, tensors: &[(usize, Span)]) {
        let mut sizes: Vec<usize> = self.all.iter().map(|buffer| buffer.0).collect();
        sizes.dedup();
        if sizes.into_iter().rev().any(|words| self.has_chosen(tensors, words)) {
            return;
        }
        for &(_, span) in tensors {
            let words = span.words;
            self.all.push((words, Vec::new()));
            if self.has_chosen(tensors, words) {
                return;
            }
        }
    }

    /// Gives `tensors` buffers of `words` words that are free during their lives. Returns false if there are not
    /// enough.
    fn has_chosen(&mut self, tensors: &[(usize, Span)], words: usize) -> bool {
        let Some((&(place, span), rest)) = tensors.split_first() else { return true };
        let is_free = |(size, spans): &(usize, Vec<Span>)| {
            *size == words && !spans.iter().any(|other| other.meets(span))
        };
        let Some(buffer) = self.all.iter().rposition(is_free) else { return false };
        self.all[buffer].1.push(span);
        let has_chosen = self.has_chosen(rest, words);
        match has_chosen {
            true => self.chosen[place] = Some(buffer),
            false => drop(self.all[buffer].1.pop()),
        }
        has_chosen
    }
}

/// Pool of buffers for the tensors of a frame.
#[derive(Debug)]
pub struct Spare {
    /// Planned buffer size of each tensor, in words.
    capacities: Vec<usize>,
    free: Vec<PageBuf>,
}

impl Clone for Spare {
    /// Clones the plan only. The clone allocates buffers when they are needed.
    fn clone(&self) -> Self {
        Self { capacities: self.capacities.clone(), free: Vec::new() }
    }
}

impl Spare {
    /// Makes a pool for tensors with these `lifetimes`.
    pub fn new(lifetimes: &Lifetimes) -> Self {
        Self { capacities: lifetimes.capacities(), free: Vec::new() }
    }

    /// Allocates all buffers now, instead of on demand.
    ///
    /// # Errors
    /// Too little memory.
    pub fn fill(&mut self, lifetimes: &Lifetimes) -> Result<(), Shortage> {
        self.free = lifetimes.words().into_iter().map(PageBuf::try_zeros).collect::<Result<_, _>>()?;
        Ok(())
    }

    /// Takes memory for tensor `place`. Its shape and contents are undefined.
    pub fn take(&mut self, is_halved: bool, place: usize) -> AnyTensor {
        match is_halved {
            true => AnyTensor::Bf16(self.map(place)),
            false => AnyTensor::F32(self.map(place)),
        }
    }

    /// Copies `stored` into memory for tensor `place`.
    pub fn copy(&mut self, stored: &AnyTensor, place: usize) -> AnyTensor {
        fn copied<T: Element>(from: &Tensor<T>, mut copy: Tensor<T>) -> AnyTensor {
            copy.resize([from.height, from.width, from.channels]);
            copy.data.copy_from_slice(&from.data);
            T::stored(copy)
        }
        with_tensor!(stored, map => copied(map, self.map(place)))
    }

    /// Takes memory for tensor `place` as a map. Its shape and contents are undefined.
    pub fn map<T: Element>(&mut self, place: usize) -> Tensor<T> {
        let capacity = self.capacities[place];
        let free = self.free.iter().position(|words| words.len() == capacity);
        let words = free.map_or_else(|| PageBuf::zeros(capacity), |at| self.free.swap_remove(at));
        Tensor { data: TensorBuf::within(words), ..Tensor::default() }
    }

    /// Returns the memory of a tensor that is not needed any more.
    pub fn put(&mut self, stored: AnyTensor) {
        let words = with_tensor!(stored, map => map.data.into_words());
        // Memory from elsewhere, such as that of cloned states, has no planned size and is freed.
        if self.capacities.contains(&words.len()) && !words.is_empty() {
            self.free.push(words);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Records a chain of layers. Each reads the output of the layer before and of some older one.
    fn chain(layers: &[(usize, usize)]) -> Lifetimes {
        let mut lifetimes = Lifetimes::new(layers.len());
        let last_read = |place: usize| {
            let reads = |(now, &(_, back)): (usize, &(usize, usize))| {
                now > place && (now == place + 1 || now - place == back)
            };
            (0..layers.len()).zip(layers).filter(|at| reads(*at)).map(|(now, _)| now).max()
        };
        for (now, &(words, _)) in layers.iter().enumerate() {
            lifetimes.begin(now, words);
            (0..now).filter(|&place| last_read(place) == Some(now)).for_each(|place| lifetimes.end(place));
            lifetimes.go_on();
        }
        lifetimes
    }

    proptest! {
        #[test]
        fn who_is_there_has_room_and_buffers_are_never_more_than_planned(
            layers in prop::collection::vec((1usize..100, 1usize..8), 1..30),
        ) {
            let lifetimes = chain(&layers);
            let mut spare = Spare::new(&lifetimes);
            let planned = lifetimes.words().len();
            let mut made = 0;
            let mut first = 0;
            for frame in 0..3 {
                let mut there: Vec<Option<AnyTensor>> = layers.iter().map(|_| None).collect();
                for (now, &(words, _)) in layers.iter().enumerate() {
                    made += usize::from(!spare.free.iter().any(|f| f.len() == spare.capacities[now]));
                    let mut map = spare.map::<f32>(now);
                    prop_assert!(spare.capacities[now] >= words);
                    map.resize([1, 1, words]);
                    there[now] = Some(AnyTensor::F32(map));
                    for place in 0..=now {
                        if lifetimes.spans[place].is_some_and(|span| span.last == now) {
                            spare.put(there[place].take().unwrap());
                        }
                    }
                }
                there.into_iter().flatten().for_each(|stored| spare.put(stored));
                if frame == 0 {
                    first = made;
                }
            }
            prop_assert_eq!(made, first, "later frames need no new memory");
            prop_assert_eq!(made, planned);
            let total: usize = spare.free.iter().map(|words| words.len()).sum();
            prop_assert!(total <= layers.iter().map(|layer| layer.0).sum());
        }
    }

    #[test]
    fn what_is_written_over_is_there_as_long_as_what_takes_its_place() {
        let mut lifetimes = Lifetimes::new(4);
        lifetimes.begin(0, 10);
        lifetimes.go_on();
        lifetimes.take_over(1, 0);
        lifetimes.end(0);
        lifetimes.go_on();
        lifetimes.begin(2, 10);
        lifetimes.end(1);
        lifetimes.go_on();
        lifetimes.begin(3, 4);
        let meet = |a: usize, b: usize| lifetimes.spans[a].unwrap().meets(lifetimes.spans[b].unwrap());
        assert!(meet(0, 2) && !meet(0, 3));
        assert_eq!(lifetimes.capacities(), [10, 10, 10, 10], "the small one has the buffer of the first");
    }

    #[test]
    fn tensors_that_take_turns_have_buffers_of_one_size() {
        let mut lifetimes = Lifetimes::new(4);
        lifetimes.begin(0, 5);
        lifetimes.end(0);
        lifetimes.go_on();
        lifetimes.begin(1, 8);
        lifetimes.end(1);
        lifetimes.go_on();
        lifetimes.begin(2, 5);
        lifetimes.begin(3, 6);
        assert_eq!(lifetimes.capacities(), [8, 8, 5, 8]);
        lifetimes.take_turns(0, 2);
        assert_eq!(lifetimes.capacities(), [5, 8, 5, 8]);
    }
}
