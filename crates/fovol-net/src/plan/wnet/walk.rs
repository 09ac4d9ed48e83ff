//! Builds the layers of W-shaped networks, in the order in which they run.

use super::options::{Accumulation, Feedback, Fill, Filtering, Kernels, Prediction, WNetOptions};
use crate::plan::build::PlanBuilder;
use crate::plan::definition::Plan;
use crate::plan::layers::{
    Accumulate, Activation, Add, Blend, Bypass, Clamp, Conv, DepthToSpace, Filter, HistoryConfidence, Join,
    POINT, Part, Pool, Read, Reproject, Smooth, SpaceToDepth, Splat, Spread, Taps, Warp,
};
use crate::plan::tensor::TensorId;

/// Builder of one plan.
pub(super) struct Walk<'a> {
    config: &'a WNetOptions,
    builder: PlanBuilder,
    /// Pairs of states: the tensor of the last frame, and the tensor that replaces it.
    carried: Vec<(TensorId, TensorId)>,
}

/// Picture of the samples that the U-Net reads.
struct Filled {
    picture: TensorId,
    /// Weight of each pixel of the picture, 0…1.
    weights: Option<TensorId>,
    /// Picture filled from the samples of this frame alone, at half the resolution if it is coarse.
    fresh: Option<TensorId>,
}

/// Samples spread over the frame, at half the resolution.
#[derive(Clone, Copy)]
struct SpreadSamples {
    picture: TensorId,
    /// Smoothed picture from which the first correction began.
    smooth: Option<TensorId>,
}

/// Output of D that K reads.
struct Direct {
    /// Predicted picture, if D predicts one.
    picture: Option<TensorId>,
    /// Outputs of the decoders, finest first, then of the bottleneck.
    features: Vec<TensorId>,
}

impl<'a> Walk<'a> {
    /// Begins the plan of `config`, which must have been checked.
    pub(super) fn new(config: &'a WNetOptions) -> Self {
        Self { config, builder: PlanBuilder::new(), carried: Vec::new() }
    }

    /// Builds the plan.
    pub(super) fn run(mut self) -> Plan {
        let config = self.config;
        let colour = self.builder.colour();
        // The last picture comes first, so that its memory is free for later layers.
        let last = config.reads_last().then(|| self.builder.state("output", 3, 0));
        let history = last.map(|last| self.reprojected(last));
        let filled = match config.fill {
            Some(fill) => self.filled(fill, history),
            None => self.sparse(),
        };
        let inputs = self.inputs(&filled, history);
        let direct = self.direct(&inputs);
        let mut picture = match config.prediction {
            Prediction::Direct(_) => direct.picture.expect("D predicts the output"),
            Prediction::Kernels(kernels) => self.filtered(kernels, &direct, &filled, history),
        };
        if config.bypass {
            let mask = self.builder.mask();
            picture = self.builder.add(Bypass::new(colour, mask, picture));
        }
        if let Some(last) = last {
            let next = match config.feedback {
                Feedback::Direct => direct.picture.expect("only a direct prediction can be fed back as one"),
                Feedback::Output => self.builder.add(Clamp::new(picture)),
                Feedback::None => picture,
            };
            self.carried.push((last, next));
        }
        for (previous, next) in self.carried {
            self.builder.keep(previous, next);
        }
        self.builder.finish(picture)
    }

    /// Builds K: filters pictures, and adds one if the kernels have an addition.
    fn filtered(
        &mut self,
        kernels: Kernels,
        direct: &Direct,
        filled: &Filled,
        history: Option<TensorId>,
    ) -> TensorId {
        let read = if self.is_coarse() { Read::bilinear } else { Read::same };
        let more = [
            (history.map(Read::same), kernels.history),
            (Some(Read::same(filled.picture)), kernels.filled),
            (filled.fresh.map(read), self.config.fresh().map(|fresh| fresh.taps)),
        ];
        let more = more.into_iter().filter_map(|(picture, taps)| picture.zip(taps)).collect();
        let picture = match kernels.filtering {
            Filtering::Once { direct: weighed } => {
                let weighed = direct.picture.map(Read::same).zip(weighed.map(|(_, taps)| taps));
                self.kernel(&direct.features, weighed, more)
            }
            Filtering::EveryLevel { .. } => {
                self.kernels(direct.picture.unwrap_or(filled.picture), &direct.features, &more)
            }
        };
        if !kernels.addition {
            return picture;
        }
        let addend = self.predicted("addition", &[Read::same(direct.features[0])], Activation::None);
        self.builder.add(Add::new(picture, addend))
    }

    /// Whether the picture of the samples of one frame stays at half the resolution.
    fn is_coarse(&self) -> bool {
        self.config.fresh().is_some_and(|fresh| fresh.coarse)
    }

    /// Returns the inputs of the U-Net: pictures of full resolution, folded, then those of half the resolution. In
    /// this order all but the last begin at an even channel.
    fn inputs(&mut self, filled: &Filled, history: Option<TensorId>) -> Vec<TensorId> {
        let history = history.filter(|_| self.config.feedback != Feedback::None);
        let (whole, coarse) = if self.is_coarse() { (None, filled.fresh) } else { (filled.fresh, None) };
        let pictures = [Some(filled.picture), filled.weights, whole, history];
        pictures.into_iter().flatten().map(|picture| self.folded(picture)).chain(coarse).collect()
    }

    fn folded(&mut self, picture: TensorId) -> TensorId {
        if self.config.fold { self.builder.add(SpaceToDepth::new(picture)) } else { picture }
    }

    fn reprojected(&mut self, state: TensorId) -> TensorId {
        if !self.config.reproject {
            return state;
        }
        let motion = self.builder.motion();
        self.builder.add(Warp::new(state, motion))
    }

    /// Uses the sampled pixels unfilled.
    fn sparse(&mut self) -> Filled {
        let weights = self.config.mask.then(|| self.builder.mask());
        Filled { picture: self.builder.colour(), weights, fresh: None }
    }

    /// Fills unsampled pixels. `history` is the reprojected last picture.
    fn filled(&mut self, fill: Fill, history: Option<TensorId>) -> Filled {
        let [colour, mask] = [self.builder.colour(), self.builder.mask()];
        let known = self.builder.add(Join::new(colour, mask));
        let fresh = self.config.fresh().map(|fresh| {
            let corrections = if fresh.coarse { fill.corrections.min(1) } else { fill.corrections };
            (fresh, self.spread(known, corrections))
        });
        let mut samples = known;
        let mut weights = self.config.mask.then_some(mask);
        if let Some(accumulation) = fill.accumulation {
            let compared = fresh.filter(|(fresh, _)| fresh.history_confidence);
            let compared = compared.map(|(_, spread)| spread).zip(history);
            samples = self.accumulated(accumulation, known, compared);
            weights = weights.map(|_| self.builder.add(Part::new(samples, 3, 1)));
        }
        let spread = self.spread(samples, fill.corrections);
        Filled {
            picture: self.builder.add(Blend::new(samples, spread.picture)),
            weights,
            fresh: fresh.map(|(fresh, spread)| match fresh.coarse {
                false => self.builder.add(Blend::new(known, spread.picture)),
                true => spread.picture,
            }),
        }
    }

    /// Adds the samples of earlier frames to `known`. `compared` has a fill of this frame and the reprojected last
    /// picture: earlier samples lose weight where the last picture predicts `known` worse than the fill does.
    fn accumulated(
        &mut self,
        Accumulation { weight, points, .. }: Accumulation,
        known: TensorId,
        compared: Option<(SpreadSamples, TensorId)>,
    ) -> TensorId {
        let samples = match points {
            true => self.builder.state("samples", POINT, 0),
            false => self.builder.state_like("samples", known),
        };
        let share = compared.map(|(fresh, prior)| {
            let smooth = fresh.smooth.unwrap_or_else(|| self.builder.add(Smooth::new(fresh.picture)));
            self.builder.add(HistoryConfidence::new(known, prior, smooth))
        });
        // Reprojection comes late because the layers above read the same pictures, which are still in the cache.
        let before = if points {
            let motion = self.builder.motion();
            self.builder.add(Reproject::new(samples, motion))
        } else {
            self.reprojected(samples)
        };
        let accumulated = self.builder.add(Accumulate::new(known, before, share, weight));
        self.carried.push((samples, accumulated));
        if points { self.builder.add(Splat::new(accumulated)) } else { accumulated }
    }

    /// Spreads `known` over the frame at half the resolution, with `corrections` corrections.
    fn spread(&mut self, known: TensorId, corrections: u32) -> SpreadSamples {
        let mut picture = self.builder.add(Spread::new(known, None));
        let mut first = None;
        for _ in 0..corrections {
            let smooth = self.builder.add(Smooth::new(picture));
            first = first.or(Some(smooth));
            picture = self.builder.add(Spread::new(known, Some(smooth)));
        }
        SpreadSamples { picture, smooth: first }
    }

    /// Builds D: the U-Net of `inputs`, of which the filled picture is the first, and the picture that it predicts.
    fn direct(&mut self, inputs: &[TensorId]) -> Direct {
        let config = self.config;
        let mut inputs: Vec<Read> = inputs.iter().copied().map(Read::same).collect();
        let filled = inputs[0];
        let mut skips = Vec::new();
        for (depth, &width) in config.encoder.iter().enumerate() {
            let name = format!("encoder.{depth}");
            let output = self.block(&name, &inputs, width);
            skips.push(output);
            if depth + 1 < config.encoder.len() {
                inputs = vec![Read::same(self.builder.add(Pool::new(output)))];
            }
        }
        let mut features = vec![skips[skips.len() - 1]];
        for depth in (0..config.decoder.len()).rev() {
            let name = format!("decoder.{depth}");
            let width = config.decoder[depth];
            let level = depth as u32 + u32::from(config.fold);
            let mut read = vec![Read::same(skips[depth]), Read::bilinear(features[0])];
            let state = config.recurrent.then(|| self.builder.state(&name, width, level));
            if let Some(state) = state {
                read.push(Read::same(self.reprojected(state)));
            }
            let output = self.block(&name, &read, width);
            self.carried.extend(state.map(|state| (state, output)));
            features.insert(0, output);
        }
        let mut read = vec![Read::same(features[0])];
        let settings = config.direct();
        read.extend(settings.filter(|direct| direct.residual).map(|_| filled));
        let picture = settings.map(|_| self.predicted("output", &read, Activation::Relu));
        Direct { picture, features }
    }

    /// Predicts a picture from `inputs` by a 1×1 convolution.
    fn predicted(&mut self, name: &str, inputs: &[Read], activation: Activation) -> TensorId {
        let channels = if self.config.fold { 12 } else { 3 };
        let picture = self.builder.add(Conv::new(name, inputs, channels, 1, activation));
        if self.config.fold { self.builder.add(DepthToSpace::new(picture)) } else { picture }
    }

    /// Two 3×3 convolutions, each followed by ReLU.
    fn block(&mut self, name: &str, inputs: &[Read], width: usize) -> TensorId {
        let first = self.builder.add(Conv::new(format!("{name}.conv1"), inputs, width, 3, Activation::Relu));
        self.builder.add(Conv::new(format!("{name}.conv2"), &[Read::same(first)], width, 3, Activation::Relu))
    }

    /// Builds K as one kernel at the finest resolution. It weighs the `direct` prediction, if there is one, and the
    /// pictures `more`.
    fn kernel(
        &mut self,
        features: &[TensorId],
        direct: Option<(Read, Taps)>,
        more: Vec<(Read, Taps)>,
    ) -> TensorId {
        self.filter("kernel.only", features[0], 0, direct.into_iter().chain(more).collect())
    }

    /// Builds K as QW-Net's kernels, down and up again: docs/guide/src/internals/algorithm.md, section 4.2. The
    /// last kernel also weighs the pictures `more`.
    fn kernels(&mut self, direct: TensorId, features: &[TensorId], more: &[(Read, Taps)]) -> TensorId {
        // With folded pixels D has no features of full resolution; those of half the resolution serve there too.
        let mut features = features.to_vec();
        if self.config.fold {
            features.insert(0, features[0]);
        }
        let deepest = features.len() - 1;
        let mut image = direct;
        let mut skips = Vec::new();
        for (depth, &feature) in features.iter().enumerate() {
            let name = if depth == deepest { "kernel.bottom".into() } else { format!("kernel.down.{depth}") };
            let filtered = self.filter(&name, feature, depth, vec![(Read::same(image), Taps::Around)]);
            skips.push(filtered);
            image = if depth < deepest { self.builder.add(Pool::new(filtered)) } else { filtered };
        }
        for depth in (0..deepest).rev() {
            let mut images =
                vec![(Read::bilinear(image), Taps::Around), (Read::same(skips[depth]), Taps::Centre)];
            if depth == 0 {
                images.extend(more);
            }
            image = self.filter(&format!("kernel.up.{depth}"), features[depth], depth, images);
        }
        image
    }

    fn filter(
        &mut self,
        name: &str,
        features: TensorId,
        depth: usize,
        images: Vec<(Read, Taps)>,
    ) -> TensorId {
        let kernels = self.config.kernels().expect("only kernels filter");
        self.builder.add(Filter {
            name: name.to_owned(),
            features,
            expand: if self.config.fold && depth == 0 { 2 } else { 1 },
            images,
            output: TensorId::UNSET,
            normalisation: kernels.normalisation,
        })
    }
}
