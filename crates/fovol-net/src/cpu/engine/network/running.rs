//! Runs the steps of a network.

use super::Network;
use crate::cpu::conv::pair::Pair;
use crate::cpu::conv::patch::{Access, Source};
use crate::cpu::engine::state::State;
use crate::cpu::filter::Out;
use crate::cpu::layers::pointwise::{Change, change};
use crate::cpu::layers::{Given, Step, run, run_points};
use crate::cpu::tensor::samples::Samples;
use crate::cpu::tensor::{AnyTensor, with_tensor};
use crate::plan::{Add, Bypass, Layer, Read, Scale, TensorId};
use crate::schedule::{Derived, FusedStep, Pairing, is_input};
use fovol_core::Frame;
use std::ops::Range;

impl Network {
    /// Returns the buffer that `unit` changes in place: the tensor `from`, or a copy of it if a later layer reads
    /// it.
    fn begun(
        &self,
        unit: &FusedStep,
        from: TensorId,
        tensors: &mut [AnyTensor],
        state: &mut State,
    ) -> AnyTensor {
        match unit.written_over(&self.plan, &self.schedule) {
            Some(other) => std::mem::take(&mut tensors[other]),
            None => state.spare.copy(&tensors[from.index()], unit.written(&self.plan)),
        }
    }

    /// Runs layer `number` alone.
    pub(super) fn run_one(&self, number: usize, tensors: &mut [AnyTensor], state: &mut State) {
        let layer = &self.plan.layers()[number];
        let place = layer.output().index();
        let mut out = match layer.begins_as() {
            Some(from) => self.begun(&FusedStep::One(number), from, tensors, state),
            None => state.spare.take(self.halved[place], place),
        };
        match (layer, &self.steps[number]) {
            (Layer::Conv(conv), Step::Conv(prepared)) => {
                let sources = self.sources(&conv.inputs, self.given(tensors, &state.samples));
                with_tensor!(&mut out, out => prepared.run(&sources, out));
            }
            (layer, step) => {
                let given = self.given(tensors, &state.samples);
                run(layer, step, given, (self.plan.tensor(layer.output()), &mut state.pyramid), &mut out);
            }
        }
        tensors[place] = out;
    }

    /// Runs the predicted kernel in layer `number` and the pointwise `changes` that follow. The picture goes to
    /// `frame`, if given, and to a tensor if a layer reads it.
    pub(super) fn run_filter(
        &self,
        number: usize,
        changes: Range<usize>,
        frame: Option<&mut Frame>,
        (tensors, state): (&mut [AnyTensor], &mut State),
    ) {
        let layers = &self.plan.layers()[..changes.end];
        let (Layer::Filter(filter), Step::Filter(prepared)) = (&layers[number], &self.steps[number]) else {
            unreachable!("filters are prepared")
        };
        let place = layers.last().expect("there is the filter").output().index();
        let is_kept = frame.is_none() || self.schedule.keeps_shown;
        let mut picture = is_kept.then(|| state.spare.map(place));
        let images: Vec<_> = filter.images.iter().map(|(read, _)| *read).collect();
        let given = self.given(tensors, &state.samples);
        let images = self.sources(&images, given);
        let changes: Vec<_> = layers[changes].iter().map(|layer| self.change(layer, given)).collect();
        let out = Out { picture: picture.as_mut(), frame };
        prepared.run(&tensors[filter.features.index()], &images, &changes, out);
        tensors[place] = picture.map(AnyTensor::F32).unwrap_or_default();
    }

    /// Collects the inputs of layers.
    fn given<'a>(&self, tensors: &'a [AnyTensor], samples: &'a Samples) -> Given<'a> {
        Given { tensors, samples: self.schedule.sampled.map(|sampled| (sampled, samples)) }
    }

    /// Runs the convolutions in layers `number` and `number` + 1 together.
    pub(super) fn run_pair(
        &self,
        number: usize,
        pairing: Pairing,
        tensors: &mut [AnyTensor],
        state: &mut State,
    ) {
        let layers = &self.plan.layers()[number..number + 2];
        let [(Layer::Conv(reading), Step::Conv(first)), (Layer::Conv(writing), Step::Conv(second))] =
            [(&layers[0], &self.steps[number]), (&layers[1], &self.steps[number + 1])]
        else {
            unreachable!("pairs are convolutions")
        };
        let place = writing.output.index();
        let is_halved = self.halved[reading.output.index()];
        let pair = Pair { first, second, is_halved, pool: &self.pool };
        let mut out = match pairing.replaced {
            Some(replaced) => std::mem::take(&mut tensors[reading.inputs[replaced].tensor.index()]),
            None => state.spare.take(self.halved[place], place),
        };
        let sources = self.sources(&reading.inputs, self.given(tensors, &state.samples));
        with_tensor!(&mut out, out => match pairing.replaced {
            Some(replaced) => pair.run_in_place(&sources, replaced, out),
            None => pair.run(&sources, out),
        });
        tensors[place] = out;
    }

    /// Runs layers `number` and `number` + 1 together: one moves points, the other fades them and adds new ones.
    pub(super) fn run_points(&self, number: usize, tensors: &mut [AnyTensor], state: &mut State) {
        let [moving, fading] = [0, 1].map(|next| &self.plan.layers()[number + next]);
        let place = fading.output().index();
        let mut out = state.spare.take(self.halved[place], place);
        run_points(moving, fading, self.given(tensors, &state.samples), &mut out);
        tensors[place] = out;
    }

    /// Runs `layers`, all of which change one picture in place.
    pub(super) fn run_changes(&self, layers: Range<usize>, tensors: &mut [AnyTensor], state: &mut State) {
        let unit = FusedStep::Changes(layers.clone());
        let changed = self.plan.layers()[layers.start].changed().expect("the first layer changes a picture");
        let mut picture = self.begun(&unit, changed, tensors, state);
        let layers = &self.plan.layers()[layers];
        let given = self.given(tensors, &state.samples);
        let changes: Vec<Change<'_>> = layers.iter().map(|layer| self.change(layer, given)).collect();
        change(&changes, picture.picture_mut());
        tensors[unit.written(&self.plan)] = picture;
    }

    /// Returns the pointwise operation of `layer`.
    fn change<'a>(&self, layer: &Layer, given: Given<'a>) -> Change<'a> {
        let picture = |id: TensorId| given.picture(id);
        match *layer {
            Layer::Add(Add { more, .. }) => match self.schedule.derived[more.index()] {
                Some((folded, _)) => Change::AddUnfolded(picture(folded)),
                None => Change::Add(picture(more)),
            },
            Layer::Bypass(Bypass { colour, mask, .. }) => {
                match (self.schedule.known.filter(|_| is_input(&self.plan, colour, mask)), given.samples) {
                    (Some(_), Some((_, samples))) => Change::Sampled(samples),
                    (Some(known), None) => Change::Keep(picture(known)),
                    (None, _) => Change::Bypass { colour: picture(colour), mask: picture(mask) },
                }
            }
            Layer::Scale(Scale { factor, offset, .. }) => Change::Scale { factor, offset },
            Layer::Clamp(_) => Change::Clamp,
            Layer::Conv(_)
            | Layer::Norm(_)
            | Layer::Filter(_)
            | Layer::Pool(_)
            | Layer::SpaceToDepth(_)
            | Layer::DepthToSpace(_)
            | Layer::Join(_)
            | Layer::Spread(_)
            | Layer::Smooth(_)
            | Layer::Blend(_)
            | Layer::HistoryConfidence(_)
            | Layer::Accumulate(_)
            | Layer::Part(_)
            | Layer::Reproject(_)
            | Layer::Splat(_)
            | Layer::Warp(_) => unreachable!("other layers do more than change single numbers"),
        }
    }

    /// Returns the inputs of a convolution.
    fn sources<'a>(&self, reads: &[Read], Given { tensors, samples }: Given<'a>) -> Vec<Source<'a>> {
        let sampled = |id: TensorId| samples.filter(|(sampled, _)| *sampled == id);
        let source = |read: &Read| match (sampled(read.tensor), self.schedule.derived[read.tensor.index()]) {
            (Some((_, samples)), _) => Source::samples(samples),
            (None, Some((from, how))) => {
                let access = match how {
                    Derived::Pooled => Access::Pooled,
                    Derived::FoldedChannel(number) => Access::FoldedChannel(number),
                    _ => Access::Folded,
                };
                Source::read(&tensors[from.index()], access)
            }
            (None, None) => Source::new(&tensors[read.tensor.index()], read.resize),
        };
        reads.iter().map(source).collect()
    }
}
