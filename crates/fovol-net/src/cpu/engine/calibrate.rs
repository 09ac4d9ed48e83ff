use crate::cpu::conv::patch::Source;
use crate::cpu::conv::{Distances, note_transformed};
use crate::cpu::engine::network::Network;
use crate::cpu::engine::precision::{Precision, transformed};
use crate::cpu::tensor::AnyTensor;
use crate::input::FrameInput;
use crate::plan::{Layer, Plan};
use crate::weights::Weights;
use crate::{Error, Result};
use fovol_simd::Simd;
use std::collections::BTreeMap;

/// Measures the ranges of activations of a network on `clips`, each of frames of one size, and stores them in
/// `weights`. int8 arithmetic derives its steps from these ranges.
///
/// # Errors
/// Weights that fit no network, and clips without frames or with frames of different sizes.
pub fn calibrate(weights: &mut Weights, clips: &[Vec<FrameInput<'_>>]) -> Result<()> {
    if clips.is_empty() || clips.iter().any(Vec::is_empty) {
        return Err(Error::Config("calibration needs at least one clip, and each a frame".into()));
    }
    let plan = weights.config.plan().map_err(Error::Config)?;
    let network = Network::layer_by_layer(plan, weights, Simd::best(), Precision::F32)?;
    let mut seen = Seen::new(&network);
    for clip in clips {
        let mut state = network.state(clip[0].sparse.size());
        for frame in clip {
            seen.begin(network.carried(&state));
            network.observed(frame, &mut state, |layers, out, _| {
                seen.note(layers.start, out);
            })?;
        }
    }
    weights.ranges = seen.ranges();
    Ok(())
}

/// Observations of a running network.
struct Seen<'a> {
    plan: &'a Plan,
    /// Tensors of this frame that have been written.
    now: Vec<Option<AnyTensor>>,
    /// Largest absolute value of each channel of each tensor.
    tensors: Vec<Vec<f32>>,
    /// For each 3×3 convolution, magnitudes of its transformed inputs.
    transformed: Vec<Distances>,
}

impl<'a> Seen<'a> {
    fn new(network: &'a Network) -> Self {
        let plan = network.plan();
        let mut tensors: Vec<Vec<f32>> =
            plan.tensors().iter().map(|tensor| vec![0.0; tensor.channels]).collect();
        let inputs = plan.inputs();
        for id in [Some(inputs.colour), inputs.mask].into_iter().flatten() {
            tensors[id.index()].fill(1.0);
        }
        Self { plan, now: Vec::new(), tensors, transformed: vec![Distances::default(); plan.layers().len()] }
    }

    /// Begins a frame with these states.
    fn begin(&mut self, carried: Vec<AnyTensor>) {
        self.now = vec![None; self.tensors.len()];
        for (state, map) in self.plan.states().iter().zip(carried) {
            self.now[state.previous.index()] = Some(map);
        }
    }

    /// Observes the output of layer `number`.
    fn note(&mut self, number: usize, out: &AnyTensor) {
        let layer = &self.plan.layers()[number];
        let (place, out) = (layer.output().index(), out.to_f32());
        for pixel in out.data.chunks_exact(out.channels) {
            self.tensors[place].iter_mut().zip(pixel).for_each(|(most, v)| *most = most.max(v.abs()));
        }
        if let Layer::Conv(conv) = layer
            && conv.size == 3
            && conv.stride == 1
        {
            let stored = conv.inputs.iter().map(|read| self.now[read.tensor.index()].as_ref());
            let sources =
                conv.inputs.iter().zip(stored).map(|(read, map)| Some(Source::new(map?, read.resize)));
            if let Some(sources) = sources.collect::<Option<Vec<_>>>() {
                note_transformed(&sources, conv.padding, &mut self.transformed[number]);
            }
        }
        self.now[place] = Some(AnyTensor::F32(out));
    }

    /// Ranges of the channels of tensors, under the names of tensors, and ranges of transformed inputs, under names
    /// derived from those of convolutions.
    fn ranges(mut self) -> BTreeMap<String, Vec<f32>> {
        for state in self.plan.states() {
            self.tensors[state.previous.index()] = self.tensors[state.next.index()].clone();
        }
        let mut ranges: BTreeMap<String, Vec<f32>> = BTreeMap::new();
        for (tensor, most) in self.plan.tensors().iter().zip(&self.tensors) {
            ranges.insert(tensor.name.clone(), most.clone());
        }
        for (layer, distances) in self.plan.layers().iter().zip(&self.transformed) {
            let Layer::Conv(conv) = layer else { continue };
            let inputs = conv.inputs.iter().map(|read| self.tensors[read.tensor.index()].len()).sum();
            if !distances.is_empty() {
                ranges.insert(transformed(&conv.name), distances.reach(inputs));
            }
        }
        ranges
    }
}
