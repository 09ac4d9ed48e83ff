//! Forward and backward pass of a batch of clips.

use super::TrainConfig;
use crate::Result;
use crate::lesson::LessonFrame;
use crate::loss::{Clip, Losses};
use crate::network::{Inputs, Network};
use std::ops::Range;
use tch::{Device, Tensor};

/// Loss terms by name.
pub(super) type TermValues = Vec<(&'static str, f64)>;

/// Everything that gradients are computed with.
pub(super) struct Backward<'a> {
    pub network: &'a Network,
    pub losses: &'a Losses,
    pub config: &'a TrainConfig,
    pub device: Device,
    /// Fraction of the whole step's clips that this batch has.
    pub share: f64,
    /// Clips computed at once; `None` means all.
    pub at_once: Option<usize>,
}

/// Frames of some clips and the results so far.
struct Passage {
    frames: Vec<LessonFrame>,
    references: Vec<Tensor>,
    motion: Vec<Tensor>,
    outputs: Vec<Tensor>,
    /// State for the next frame.
    state: Vec<Tensor>,
    /// Fraction of the batch that these clips are.
    share: f64,
}

impl Backward<'_> {
    /// Accumulates the gradients of the batch's mean loss, times its share, in the network's parameters. Returns the
    /// loss terms.
    pub fn run(&self, lesson: &[LessonFrame]) -> Result<TermValues> {
        let batch = lesson[0].colour.size()[0];
        let at_once = self.at_once.map_or(batch, |count| (count as i64).min(batch));
        let mut sums = TermValues::new();
        for first in (0..batch).step_by(at_once as usize) {
            let count = at_once.min(batch - first);
            let mut passage = self.passage(lesson, [first, count], batch);
            let length = lesson.len();
            for first in (0..length).step_by(self.config.truncate) {
                let part = first..(first + self.config.truncate).min(length);
                let terms = match self.config.recompute {
                    true => self.recomputed(&mut passage, part, length)?,
                    false => self.kept(&mut passage, part, length)?,
                };
                add(&mut sums, terms, passage.share);
            }
        }
        Ok(sums)
    }

    fn passage(&self, lesson: &[LessonFrame], [first, count]: [i64; 2], batch: i64) -> Passage {
        let frames: Vec<LessonFrame> =
            lesson.iter().map(|frame| frame.clips(first, count).to_device(self.device)).collect();
        let size = frames[0].colour.size();
        Passage {
            references: frames.iter().map(|frame| frame.target.shallow_clone()).collect(),
            motion: frames.iter().map(|frame| frame.true_motion.shallow_clone()).collect(),
            state: self.network.initial_state([size[0], size[2], size[3]]),
            outputs: Vec::new(),
            share: self.share * count as f64 / batch as f64,
            frames,
        }
    }

    /// Picture of `frame`, and the state for the next one.
    fn forward(&self, frame: &LessonFrame, state: Vec<Tensor>) -> Result<(Tensor, Vec<Tensor>)> {
        let motion = self.config.use_motion.then_some(&frame.motion);
        let inputs = Inputs { colour: &frame.colour, mask: Some(&frame.mask), motion };
        let (output, next) = self.network.forward(&inputs, state)?;
        Ok((frame.picture(&output), next))
    }

    /// Loss and gradients of the frames `part`; all activations are kept for the backward pass.
    fn kept(&self, passage: &mut Passage, part: Range<usize>, length: usize) -> Result<TermValues> {
        passage.outputs.iter_mut().for_each(|output| *output = output.detach());
        let mut state = passage.state.iter().map(Tensor::detach).collect();
        for frame in &passage.frames[part.clone()] {
            let (output, next) = self.forward(frame, state)?;
            passage.outputs.push(output);
            state = next;
        }
        passage.state = state;
        self.judged(passage, part, length)
    }

    /// Loss and gradients of the frames `part` with checkpointing: only states and outputs are kept, and the backward
    /// pass recomputes each frame.
    fn recomputed(&self, passage: &mut Passage, part: Range<usize>, length: usize) -> Result<TermValues> {
        let mut states = Vec::new();
        for frame in &passage.frames[part.clone()] {
            let state: Vec<Tensor> = passage.state.iter().map(Tensor::detach).collect();
            states.push(state.iter().map(Tensor::shallow_clone).collect::<Vec<_>>());
            let (output, next) = tch::no_grad(|| self.forward(frame, state))?;
            passage.outputs.push(output.detach().set_requires_grad(true));
            passage.state = next;
        }
        let terms = self.judged(passage, part.clone(), length)?;
        let mut slopes: Vec<Tensor> = Vec::new();
        for (i, state) in part.clone().zip(states).rev() {
            let state: Vec<Tensor> =
                state.iter().map(|tensor| tensor.detach().set_requires_grad(true)).collect();
            let given = state.iter().map(Tensor::shallow_clone).collect();
            let (output, next) = self.forward(&passage.frames[i], given)?;
            let mut sum = (output * passage.outputs[i].grad()).sum(None);
            for (next, slope) in next.iter().zip(&slopes).filter(|(next, _)| next.requires_grad()) {
                sum += (next * slope).sum(None);
            }
            sum.backward();
            slopes = state.iter().map(slope).collect();
        }
        passage.outputs[part].iter_mut().for_each(|output| *output = output.detach());
        Ok(terms)
    }

    /// Computes the loss of the frames `part` and its gradients.
    fn judged(&self, passage: &Passage, part: Range<usize>, length: usize) -> Result<TermValues> {
        let clip = Clip {
            outputs: &passage.outputs,
            references: &passage.references[..part.end],
            motion: Some(&passage.motion[..part.end]),
        };
        let terms = self.losses.frames(&clip, part, length)?;
        (&terms.total * passage.share).backward();
        Ok(terms.values().to_vec())
    }
}

/// Gradient of `tensor`, or zeros if nothing depends on it.
fn slope(tensor: &Tensor) -> Tensor {
    let gradient = tensor.grad();
    if gradient.defined() { gradient } else { tensor.zeros_like() }
}

/// Adds `share` times `terms` to `sums`.
pub(super) fn add(sums: &mut TermValues, terms: TermValues, share: f64) {
    for (i, (name, value)) in terms.into_iter().enumerate() {
        match sums.get_mut(i) {
            Some(sum) => sum.1 += value * share,
            None => sums.push((name, value * share)),
        }
    }
}
