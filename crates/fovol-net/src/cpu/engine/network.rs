mod running;

use crate::cpu::conv::pair::Pool;
use crate::cpu::engine::buffers::{Lifetimes, Spare};
use crate::cpu::engine::frames::{colours_of, crop, padded_pairs, weights_of};
use crate::cpu::engine::precision::{Choice, Precision};
use crate::cpu::engine::state::{State, padded};
use crate::cpu::history::points;
use crate::cpu::layers::reshape;
use crate::cpu::layers::{SAME, Step};
use crate::cpu::tensor::element::Element;
use crate::cpu::tensor::tensor_buf::TensorBuf;
use crate::cpu::tensor::{AnyTensor, with_tensor};
use crate::input::FrameInput;
use crate::plan::{Plan, TensorId};
use crate::schedule::{FusedStep, Schedule};
use crate::weights::Weights;
use crate::{Error, Result};
use fovol_core::memory::{Estimate, SMALLER_FRAMES};
use fovol_core::{Frame, FrameSize, keep_workers_spinning, stop};
use fovol_simd::{Bf16, Simd};
use rayon::prelude::*;
use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// A network with its weights, ready to run. Any number of sequences can share it.
#[derive(Debug)]
pub struct Network {
    plan: Plan,
    steps: Vec<Step>,
    schedule: Schedule,
    /// Whether each tensor is stored as bf16.
    halved: Vec<bool>,
    simd: Simd,
    precision: Precision,
    pool: Pool,
    id: u64,
}

/// Identifiers of networks, which tell their states apart.
static NEXT: AtomicU64 = AtomicU64::new(0);

impl Network {
    /// Prepares the network of `plan` with `weights` for `simd`. If `simd` does not have the precision, the next
    /// more exact one is used; see [`Self::precision`].
    ///
    /// # Errors
    /// Weights that do not fit the plan, or lack the ranges that the precision needs.
    pub fn new(plan: Plan, weights: &Weights, simd: Simd, precision: Precision) -> Result<Self> {
        let schedule = |plan: &Plan, halved: &[bool]| Schedule::new(plan, halved, |_| true);
        Self::scheduled(plan, weights, (simd, precision), schedule)
    }

    /// Prepares the network without fusion, so that every tensor of the plan is written and can be observed.
    ///
    /// # Errors
    /// Those of [`Self::new`].
    pub fn layer_by_layer(plan: Plan, weights: &Weights, simd: Simd, precision: Precision) -> Result<Self> {
        Self::scheduled(plan, weights, (simd, precision), |plan, _| Schedule::layer_by_layer(plan))
    }

    fn scheduled(
        plan: Plan,
        weights: &Weights,
        (simd, precision): (Simd, Precision),
        schedule: impl FnOnce(&Plan, &[bool]) -> Schedule,
    ) -> Result<Self> {
        weights.check(&plan)?;
        let precision = precision.on(simd);
        let choice = Choice::new(&plan, weights, precision, simd)?;
        let halved: Vec<bool> = (0..plan.tensors().len()).map(|at| choice.is_halved(TensorId(at))).collect();
        let schedule = schedule(&plan, &halved);
        let step = |number| Step::new((&plan, number), weights, simd, (&choice, &schedule));
        let steps = (0..plan.layers().len()).map(step).collect::<Result<_>>()?;
        let id = NEXT.fetch_add(1, Ordering::Relaxed);
        let pool = Pool::default();
        Ok(Self { plan, steps, schedule, halved, simd, precision, pool, id })
    }

    /// Plan of the network.
    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    /// Instruction set that the network runs on.
    pub fn simd(&self) -> Simd {
        self.simd
    }

    /// Precision in use on this processor; never [`Precision::Auto`].
    pub fn precision(&self) -> Precision {
        self.precision
    }

    /// Makes the state for the first frame of a sequence of frames of `size`.
    pub fn state(&self, size: FrameSize) -> State {
        State::new(&self.plan, size, &self.halved, Spare::new(&self.lifetimes(size)), self.id)
    }

    /// A new [`State`] like [`Self::state`], whose tensors are all allocated at once.
    ///
    /// # Errors
    /// Too little memory.
    pub fn try_state(&self, size: FrameSize) -> Result<State> {
        let lifetimes = self.lifetimes(size);
        let words: usize = lifetimes.words().iter().sum();
        Estimate::new(format!("the network on {size} pixels"))
            .with("its tensors", (words * size_of::<u32>()) as u64)
            .check(SMALLER_FRAMES)?;
        let mut spare = Spare::new(&lifetimes);
        spare.fill(&lifetimes)?;
        Ok(State::new(&self.plan, size, &self.halved, spare, self.id))
    }

    /// Returns the tensors in `state`, in the order of [`Plan::states`], pixel by pixel at the padded size.
    ///
    /// # Panics
    /// A state of another network.
    pub fn carried(&self, state: &State) -> Vec<AnyTensor> {
        assert_eq!(state.network, self.id, "the state is of this network");
        let ids = self.plan.states().iter().map(|state| state.previous);
        let pixels = |(id, stored): (TensorId, &AnyTensor)| match stored {
            AnyTensor::F32(map) if self.schedule.points.contains(&id) => AnyTensor::F32(points::pixels(map)),
            _ => stored.clone(),
        };
        ids.zip(&state.carried).map(pixels).collect()
    }

    /// Moves `state` to frames of `size`, in which pixel (x, y) is pixel (x, y) + `by` of the frames so far. Pixels
    /// that lay outside these take the nearest values.
    ///
    /// # Errors
    /// A state of another network, a `by` that is no multiple of [`Plan::multiple`], or too little memory.
    pub fn moved(&self, mut state: State, size: FrameSize, by: [i64; 2]) -> Result<State> {
        let multiple = self.plan.multiple() as i64;
        if state.network != self.id {
            return Err(Error::State("it belongs to another network; start one with this network".into()));
        }
        if by.iter().any(|way| way % multiple != 0) {
            let problem = format!("it cannot move by {}x{}; give multiples of {multiple}", by[0], by[1]);
            return Err(Error::State(problem));
        }
        let mut moved = if size == state.size { self.state(size) } else { self.try_state(size)? };
        if size == state.size {
            // At an unchanged size the buffers fit.
            std::mem::swap(&mut moved.spare, &mut state.spare);
        }
        let tensors = self.plan.states().iter().map(|state| state.previous);
        for ((id, from), to) in tensors.zip(&state.carried).zip(&mut moved.carried) {
            let by = by.map(|way| way >> self.plan.tensor(id).level);
            match (from, to) {
                (AnyTensor::F32(from), AnyTensor::F32(to)) if self.schedule.points.contains(&id) => {
                    points::shift(from, by, to);
                }
                (AnyTensor::F32(from), AnyTensor::F32(to)) => reshape::shift(from, by, to),
                (AnyTensor::Bf16(from), AnyTensor::Bf16(to)) => reshape::shift(from, by, to),
                _ => unreachable!("{SAME}"),
            }
        }
        state.carried.into_iter().for_each(|map| moved.spare.put(map));
        Ok(moved)
    }

    /// Reconstructs the full frame of `input`, with alpha 1 everywhere, and advances `state` to the next frame.
    ///
    /// Sampled colours are clamped to 0…1. Pixels with values that are not finite count as unsampled.
    ///
    /// # Errors
    /// A state of another network or size, and motion for another size.
    pub fn reconstruct(&self, input: &FrameInput<'_>, state: &mut State) -> Result<Frame> {
        self.observed(input, state, |_, _, _| {})
    }

    /// Reconstructs like [`Self::reconstruct`] and reports each step to `observe`. It gets the indices of the layers that
    /// ran together, the tensor that the last of them wrote, and their duration. The tensor is empty if the layers
    /// wrote only to the frame.
    ///
    /// # Errors
    /// Those of [`Self::reconstruct`].
    pub fn observed(
        &self,
        input: &FrameInput<'_>,
        state: &mut State,
        observe: impl FnMut(Range<usize>, &AnyTensor, Duration),
    ) -> Result<Frame> {
        self.check(input, state)?;
        let mut frame = Frame::new(state.size);
        keep_workers_spinning(|| {
            let tensors = self.load(input, state);
            self.run(tensors, state, &mut frame, observe);
        });
        Ok(frame)
    }

    /// # Errors
    /// A state of another network or of frames of another size than those of `input`, motion for another size.
    fn check(&self, input: &FrameInput<'_>, state: &State) -> Result<()> {
        let size = input.sparse.size();
        if state.network != self.id {
            return Err(Error::State("it belongs to another network; start one with this network".into()));
        }
        if state.size != size {
            let problem =
                format!("it is for frames of {}, not {size}; start another for this size", state.size);
            return Err(Error::State(problem));
        }
        if input.motion.is_some_and(|motion| motion.len() != size.pixels()) {
            return Err(Error::State(format!("the motion is not that of {size} pixels")));
        }
        Ok(())
    }

    /// Computes `frame` from the loaded `tensors`, and writes the next state to `state`.
    fn run(
        &self,
        mut tensors: Vec<AnyTensor>,
        state: &mut State,
        frame: &mut Frame,
        mut observe: impl FnMut(Range<usize>, &AnyTensor, Duration),
    ) {
        let mut is_shown = false;
        for unit in self.fused_steps(state.size) {
            stop::point();
            let started = Instant::now();
            let (layers, written, shows) = (unit.layers(), unit.written(&self.plan), self.shows(&unit));
            is_shown |= shows;
            match unit {
                FusedStep::One(number) => self.run_one(number, &mut tensors, state),
                FusedStep::Pair(number, pairing) => self.run_pair(number, pairing, &mut tensors, state),
                FusedStep::Points(number) => self.run_points(number, &mut tensors, state),
                FusedStep::Changes(layers) => self.run_changes(layers, &mut tensors, state),
                FusedStep::Filter { layers, changes } => {
                    let frame = shows.then_some(&mut *frame);
                    self.run_filter(layers.start, changes..layers.end, frame, (&mut tensors, state));
                }
            }
            observe(layers.clone(), &tensors[written], started.elapsed());
            for id in self.schedule.finished[layers].iter().flatten() {
                state.spare.put(std::mem::take(&mut tensors[id.index()]));
            }
        }
        if !is_shown {
            crop(tensors[self.schedule.shown.index()].picture(), frame);
        }
        self.carry(&mut tensors, state);
    }

    /// Steps that run one after the other for frames of `size`.
    fn fused_steps(&self, size: FrameSize) -> Vec<FusedStep> {
        self.schedule.fused_steps(&self.plan, |place| self.numbers(place, size))
    }

    /// Whether `unit` writes the frame itself: predicted kernels do if their picture is the one that is shown.
    fn shows(&self, unit: &FusedStep) -> bool {
        matches!(unit, FusedStep::Filter { .. }) && unit.written(&self.plan) == self.schedule.shown.index()
    }

    /// Records the lifetimes of tensors for a frame of `size`.
    fn lifetimes(&self, size: FrameSize) -> Lifetimes {
        let words = |place: usize| {
            let numbers = self.numbers(place, size);
            if self.halved[place] { TensorBuf::<Bf16>::words(numbers) } else { numbers }
        };
        let mut lifetimes = Lifetimes::new(self.plan.tensors().len());
        let inputs = self.plan.inputs();
        let pictures = [Some(inputs.colour), inputs.mask].into_iter().flatten();
        let loaded = pictures.filter(|_| self.schedule.sampled.is_none()).chain(inputs.motion);
        let previous = self.plan.states().iter().map(|state| state.previous);
        for id in loaded.chain(previous) {
            lifetimes.begin(id.index(), words(id.index()));
        }
        for unit in self.fused_steps(size) {
            lifetimes.go_on();
            let (layers, place) = (unit.layers(), unit.written(&self.plan));
            let is_shown_alone = self.shows(&unit) && !self.schedule.keeps_shown;
            match unit.written_over(&self.plan, &self.schedule) {
                Some(other) => lifetimes.take_over(place, other),
                None if is_shown_alone => {}
                None => lifetimes.begin(place, words(place)),
            }
            self.schedule.finished[layers].iter().flatten().for_each(|id| lifetimes.end(id.index()));
        }
        for (number, state) in self.plan.states().iter().enumerate() {
            match self.is_needed_again(number) {
                true => lifetimes.keep(state.previous.index()),
                false => lifetimes.take_turns(state.previous.index(), state.next.index()),
            }
        }
        lifetimes
    }

    /// Number of elements of tensor `place` for frames of `size`.
    fn numbers(&self, place: usize, size: FrameSize) -> usize {
        let tensor = &self.plan.tensors()[place];
        let [height, width] = padded(&self.plan, size);
        (height >> tensor.level) * (width >> tensor.level) * tensor.channels
    }

    /// Makes the list of tensors, with the inputs of this frame and the states of the last one in place.
    fn load(&self, input: &FrameInput<'_>, state: &mut State) -> Vec<AnyTensor> {
        let mut tensors = vec![AnyTensor::default(); self.plan.tensors().len()];
        let [height, width] = padded(&self.plan, state.size);
        let inputs = self.plan.inputs();
        state.samples.gather(input.sparse, [height, width]);
        if self.schedule.sampled.is_none() {
            self.load_pictures(state, &mut tensors);
        }
        let memory = &mut state.spare;
        if let Some(motion) = inputs.motion {
            let map = memory.map(motion.index());
            tensors[motion.index()] = padded_pairs(input.motion, map, state.size, [height, width]);
        }
        for (state, map) in self.plan.states().iter().zip(&mut state.carried) {
            tensors[state.previous.index()] = std::mem::take(map);
        }
        tensors
    }

    /// Writes the colours and the mask of the samples to `tensors`.
    fn load_pictures(&self, state: &mut State, tensors: &mut [AnyTensor]) {
        let inputs = self.plan.inputs();
        let colours = state.spare.map(inputs.colour.index());
        tensors[inputs.colour.index()] = colours_of(&state.samples, colours);
        if let Some(mask) = inputs.mask {
            let weights = state.spare.map(mask.index());
            tensors[mask.index()] = weights_of(&state.samples, weights);
        }
    }

    /// Moves the next state from `tensors` to `state`, and returns all other buffers to its pool.
    fn carry(&self, tensors: &mut [AnyTensor], state: &mut State) {
        for (place, kept) in self.plan.states().iter().enumerate() {
            let map = &mut tensors[kept.next.index()];
            // Values that are not finite would stay in a recurrent state forever, so they become 0.
            if !self.schedule.stays_finite[place] {
                with_tensor!(map, map => {
                    map.data.par_iter_mut().filter(|v| !v.to_f32().is_finite()).for_each(|v| *v = Element::from_f32(0.0));
                });
            }
            state.carried[place] = match self.is_needed_again(place) {
                true => state.spare.copy(map, kept.previous.index()),
                false => std::mem::take(map),
            };
        }
        tensors.iter_mut().for_each(|map| state.spare.put(std::mem::take(map)));
    }

    /// Whether a later state takes its next value from the tensor that state number `place` does.
    fn is_needed_again(&self, place: usize) -> bool {
        let states = self.plan.states();
        states[place + 1..].iter().any(|other| other.next == states[place].next)
    }
}
