use super::layer::{Activation, Filter, Normalisation, POINT, Read, Taps};
use super::{Plan, PlanBuilder, TensorId};
use serde::{Deserialize, Serialize};

/// Which picture of the last frame comes back in as input (ALGORITHMS §9.7).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Feedback {
    /// None.
    None,
    /// The direct prediction O_d, as in the paper.
    Direct,
    /// The output, cut to 0…1: then what is fed back cannot grow without end.
    Output,
}

/// Corrections beyond this change nothing that can be seen.
const MOST_CORRECTIONS: u32 = 8;

/// A U-Net whose decoders may be recurrent, which predicts the picture directly (D) and then filters it with
/// predicted kernels (K): FoVolNet, its relatives, and with `kernels` off what it was compared with.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct WNetConfig {
    /// Channels of the encoders, finest first; the last is the bottleneck.
    pub encoder: Vec<usize>,
    /// Channels of the decoders, finest first: one fewer than encoders.
    pub decoder: Vec<usize>,
    /// What comes back in.
    pub feedback: Feedback,
    /// Whether K follows D.
    pub kernels: bool,
    /// How its kernels are normalised.
    pub normalisation: Normalisation,
    /// Whether the U-Net works on 2×2 pixels as one with four times the channels.
    pub fold: bool,
    /// Whether the U-Net is told which pixels were sampled.
    pub mask: bool,
    /// Whether unsampled pixels are filled before.
    pub prefill: bool,
    /// Whether sampled pixels reach the output as they are.
    pub bypass: bool,
    /// What K's last kernel weighs of the last output.
    #[serde(default)]
    pub history: Option<Taps>,
    /// Whether what comes from the last frame is moved along the renderer's motion.
    pub reproject: bool,
    /// What K's last kernel weighs of the filled picture.
    #[serde(default)]
    pub filled: Option<Taps>,
    /// What K's only kernel weighs of the direct prediction, if it is to filter once, at the finest resolution. Without
    /// it K filters at every resolution, down and up again.
    #[serde(default)]
    pub flat: Option<Taps>,
    /// The weight that a sample keeps from frame to frame in the filled picture, 0…1: with 0 it is filled from the
    /// samples of its frame alone. The U-Net is then told these weights for the mask.
    #[serde(default)]
    pub accumulate: f32,
    /// Whether accumulated samples are points, moved whole and each with its place in its pixel, so that no picture of them
    /// is interpolated again and again; needs `reproject`.
    #[serde(default)]
    pub points: bool,
    /// What K's last kernel weighs of a second picture, filled from the samples of its frame alone, which the U-Net is
    /// shown too: what was accumulated is wrong where the motion is.
    #[serde(default)]
    pub fresh: Option<Taps>,
    /// Whether that second picture is corrected at most once, and read at half the resolution, at which it is spread, so that it
    /// is never written at the full one: by the U-Net as it is, by K bilinear, to which it is the same where nothing was
    /// sampled; needs `fold` and `bypass`.
    #[serde(default)]
    pub coarse: bool,
    /// Whether accumulated samples lose weight where those of the frame contradict them, as they do where the motion is
    /// wrong or something comes to light; needs `fresh`.
    #[serde(default)]
    pub doubt: bool,
    /// How often what is filled is smoothed and then corrected by what the samples differ from it.
    #[serde(default)]
    pub corrections: u32,
    /// Whether the direct prediction also reads the filled picture: then it can begin as that, and learn what to add.
    #[serde(default)]
    pub residual: bool,
    /// Whether what the U-Net predicts besides is added to what K makes: K alone can only average its images.
    #[serde(default)]
    pub addition: bool,
    /// Whether decoders read what they wrote for the last frame.
    #[serde(default = "yes")]
    pub recurrent: bool,
    /// Whether D predicts a picture. Without one, K's only kernel weighs the other pictures alone; kernels at every
    /// resolution filter what was sampled.
    #[serde(default = "yes")]
    pub direct: bool,
}

fn yes() -> bool {
    true
}

impl WNetConfig {
    /// Encoders 64-64-80-96 and decoders 80-64-64 (ALGORITHMS §1.2, paper widths).
    pub fn paper() -> Self {
        Self {
            encoder: vec![64, 64, 80, 96],
            decoder: vec![64, 64, 80],
            feedback: Feedback::Direct,
            kernels: true,
            normalisation: Normalisation::Squared,
            fold: false,
            mask: false,
            prefill: false,
            bypass: false,
            history: None,
            reproject: false,
            filled: None,
            flat: None,
            accumulate: 0.0,
            points: false,
            fresh: None,
            coarse: false,
            doubt: false,
            corrections: 0,
            residual: false,
            addition: false,
            recurrent: true,
            direct: true,
        }
    }

    /// The same with 32 channels in the last decoder (the release's "small").
    pub fn narrow() -> Self {
        Self { decoder: vec![32, 64, 80], ..Self::paper() }
    }

    /// Ours.
    pub fn fast() -> Self {
        Self {
            encoder: vec![16, 32, 48, 64],
            decoder: vec![16, 32, 48],
            feedback: Feedback::Output,
            kernels: true,
            normalisation: Normalisation::Squared,
            fold: true,
            mask: true,
            prefill: true,
            bypass: true,
            history: Some(Taps::Centre),
            reproject: true,
            filled: Some(Taps::Around),
            flat: Some(Taps::Centre),
            accumulate: 0.98,
            points: true,
            fresh: Some(Taps::Centre),
            coarse: true,
            doubt: true,
            corrections: 2,
            residual: false,
            addition: true,
            recurrent: false,
            direct: false,
        }
    }

    /// `temporal_unet` of the FoVolNet release, which the paper calls DeepFovea.
    pub fn deepfovea() -> Self {
        Self {
            encoder: vec![32, 64, 128, 128, 128],
            decoder: vec![32, 64, 128, 128],
            feedback: Feedback::None,
            kernels: false,
            ..Self::paper()
        }
    }

    /// Its plan.
    ///
    /// # Errors
    /// Widths that do not fit together.
    pub fn plan(&self) -> Result<Plan, String> {
        self.check()?;
        Ok(Walk { config: self, builder: PlanBuilder::new(), carried: Vec::new() }.run())
    }

    fn check(&self) -> Result<(), String> {
        let widths = self.encoder.iter().chain(&self.decoder);
        if self.encoder.len() < 2 || self.encoder.len() > 8 || self.decoder.len() + 1 != self.encoder.len() {
            return Err(format!(
                "{} encoders and {} decoders do not make a U-Net; give 2 to 8 encoders and one decoder fewer",
                self.encoder.len(),
                self.decoder.len()
            ));
        }
        if widths.clone().any(|&width| width == 0 || width > 4096) {
            return Err("a layer of the network has no channels or more than 4096".into());
        }
        let taps = [self.history, self.filled, self.flat, self.fresh];
        if taps.iter().any(Option::is_some) && !self.kernels {
            return Err(
                "taps for K need kernels; set `kernels`, or leave out `history`, `filled`, `flat` and `fresh`".into(),
            );
        }
        if self.filled.is_some() && !self.prefill {
            return Err("there is no filled picture to weigh; set `prefill`, or leave out `filled`".into());
        }
        if !(0.0..=1.0).contains(&self.accumulate) {
            return Err(format!("`accumulate` is {}, a weight; give 0 to 1", self.accumulate));
        }
        if self.accumulate > 0.0 && !self.prefill {
            return Err(
                "samples are accumulated to be filled; set `prefill`, or leave out `accumulate`".into()
            );
        }
        if self.points && (self.accumulate == 0.0 || !self.reproject) {
            return Err(
                "`points` are samples that are accumulated and moved; set `accumulate` and `reproject`, or leave out \
                        `points`"
                    .into(),
            );
        }
        if self.doubt && self.fresh.is_none() {
            return Err(
                "a fresh picture is needed to doubt the others; set `fresh`, or leave out `doubt`".into()
            );
        }
        if self.coarse && (self.fresh.is_none() || !self.fold || !self.bypass) {
            return Err(
                "`coarse` needs a `fresh` picture, `fold` and `bypass`; set these, or leave out `coarse`"
                    .into(),
            );
        }
        if self.corrections > MOST_CORRECTIONS {
            return Err(format!("`corrections` is {}; give 0 to {MOST_CORRECTIONS}", self.corrections));
        }
        if self.residual && !self.prefill {
            return Err("there is no filled picture to add to; set `prefill`, or leave out `residual`".into());
        }
        if self.addition && !self.kernels {
            return Err("there is nothing of K to add to; set `kernels`, or leave out `addition`".into());
        }
        if !self.direct && (!self.kernels || self.residual || self.feedback == Feedback::Direct) {
            return Err(
                "without a direct prediction there must be `kernels`, and neither `residual` nor direct \
                        `feedback`; set these, or leave out `direct`"
                    .into(),
            );
        }
        let weighs = [self.history, self.filled, self.fresh].iter().any(Option::is_some);
        if !self.direct && self.flat.is_some() && !weighs {
            return Err(
                "`flat` kernels need a picture to weigh; set `filled`, `fresh`, `history` or `direct`".into(),
            );
        }
        if self.fresh.is_some() && self.accumulate == 0.0 {
            return Err("every filled picture is fresh; set `accumulate`, or leave out `fresh`".into());
        }
        Ok(())
    }
}

/// The making of one plan.
struct Walk<'a> {
    config: &'a WNetConfig,
    builder: PlanBuilder,
    /// States, and what they become.
    carried: Vec<(TensorId, TensorId)>,
}

/// What the U-Net is given of the samples.
struct Filled {
    picture: TensorId,
    /// How far each pixel of it is known.
    weights: Option<TensorId>,
    /// The same from the samples of the frame alone.
    fresh: Option<Fresh>,
}

/// A picture of the samples of the frame alone.
#[derive(Clone, Copy)]
enum Fresh {
    /// At the full resolution.
    Whole(TensorId),
    /// At half of it.
    Coarse(TensorId),
}

impl Fresh {
    /// As K reads it.
    fn read(self) -> Read {
        match self {
            Self::Whole(picture) => Read::same(picture),
            Self::Coarse(picture) => Read::bilinear(picture),
        }
    }
}

/// Samples spread over the frame, at half the resolution.
#[derive(Clone, Copy)]
struct Spread {
    picture: TensorId,
    /// What the first correction began from.
    smooth: Option<TensorId>,
}

/// What D leaves to K.
struct Direct {
    /// What it predicts, if it does.
    picture: Option<TensorId>,
    /// Decoder outputs, finest first, then the bottleneck's.
    features: Vec<TensorId>,
}

impl Walk<'_> {
    fn run(mut self) -> Plan {
        let config = self.config;
        let colour = self.builder.colour();
        // First, so that the last picture's memory is free for what follows.
        let wants_last = config.history.is_some() || config.feedback != Feedback::None;
        let last = wants_last.then(|| self.builder.state("output", 3, 0));
        let history = last.map(|last| self.reprojected(last));
        let filled = if config.prefill { self.filled() } else { self.sparse() };
        let inputs = self.inputs(&filled, history);
        let direct = self.direct(&inputs);
        let [history, prefilled] = [history, Some(filled.picture)].map(|picture| picture.map(Read::same));
        let more = [
            (history, config.history),
            (prefilled, config.filled),
            (filled.fresh.map(Fresh::read), config.fresh),
        ];
        let more = more.into_iter().filter_map(|(picture, taps)| picture.zip(taps)).collect();
        let mut picture = match (direct.picture, config.flat) {
            (Some(picture), _) if !config.kernels => picture,
            (picture, Some(taps)) => {
                self.kernel(&direct.features, picture.map(|id| (Read::same(id), taps)), more)
            }
            // Without a direct prediction it is what was sampled that they filter.
            (picture, None) => self.kernels(picture.unwrap_or(filled.picture), &direct.features, &more),
        };
        if config.addition {
            let more = self.predicted("addition", &[Read::same(direct.features[0])], Activation::None);
            picture = self.builder.add(picture, more);
        }
        if config.bypass {
            picture = self.builder.bypass(colour, picture);
        }
        if let Some(last) = last {
            let next = match config.feedback {
                Feedback::Direct => direct.picture.expect("only a direct prediction can be fed back as one"),
                Feedback::Output => self.builder.clamp(picture),
                Feedback::None => picture,
            };
            self.carried.push((last, next));
        }
        for (previous, next) in self.carried {
            self.builder.keep(previous, next);
        }
        self.builder.finish(picture)
    }

    /// What the U-Net reads: of pictures of the frame's resolution pixels that are folded, then those that are coarse, so
    /// that all but these begin at an even channel.
    fn inputs(&mut self, filled: &Filled, history: Option<TensorId>) -> Vec<TensorId> {
        let history = history.filter(|_| self.config.feedback != Feedback::None);
        let (whole, coarse) = match filled.fresh {
            Some(Fresh::Whole(picture)) => (Some(picture), None),
            Some(Fresh::Coarse(picture)) => (None, Some(picture)),
            None => (None, None),
        };
        let pictures = [Some(filled.picture), filled.weights, whole, history];
        pictures.into_iter().flatten().map(|picture| self.folded(picture)).chain(coarse).collect()
    }

    fn folded(&mut self, picture: TensorId) -> TensorId {
        if self.config.fold { self.builder.space_to_depth(picture) } else { picture }
    }

    fn reprojected(&mut self, state: TensorId) -> TensorId {
        if self.config.reproject { self.builder.warp(state) } else { state }
    }

    /// What was sampled as it is.
    fn sparse(&mut self) -> Filled {
        let weights = self.config.mask.then(|| self.builder.mask());
        Filled { picture: self.builder.colour(), weights, fresh: None }
    }

    /// What was sampled, filled.
    fn filled(&mut self) -> Filled {
        let config = self.config;
        let [colour, mask] = [self.builder.colour(), self.builder.mask()];
        let known = self.builder.join(colour, mask);
        let corrections = if config.coarse { config.corrections.min(1) } else { config.corrections };
        let fresh = config.fresh.map(|_| self.spread(known, corrections));
        let mut samples = known;
        let mut weights = config.mask.then_some(mask);
        if config.accumulate > 0.0 {
            samples = self.accumulated(known, fresh.filter(|_| config.doubt));
            weights = weights.map(|_| self.builder.part(samples, 3, 1));
        }
        let spread = self.spread(samples, config.corrections);
        Filled {
            picture: self.builder.blend(samples, spread.picture),
            weights,
            fresh: fresh.map(|fresh| match config.coarse {
                false => Fresh::Whole(self.builder.blend(known, fresh.picture)),
                true => Fresh::Coarse(fresh.picture),
            }),
        }
    }

    /// `known` with what is left of earlier frames, which `fresh`, spread from it alone, may contradict.
    fn accumulated(&mut self, known: TensorId, fresh: Option<Spread>) -> TensorId {
        let points = self.config.points;
        let samples = match points {
            true => self.builder.state("samples", POINT, 0),
            false => self.builder.state_like("samples", known),
        };
        let before = if points { self.builder.reproject(samples) } else { self.reprojected(samples) };
        let share = fresh.map(|fresh| {
            let prior = self.spread(before, self.config.corrections.min(1)).picture;
            let smooth = fresh.smooth.unwrap_or_else(|| self.builder.smooth(fresh.picture));
            self.builder.doubt(known, prior, smooth)
        });
        let accumulated = self.builder.accumulate(known, before, share, self.config.accumulate);
        self.carried.push((samples, accumulated));
        if points { self.builder.splat(accumulated) } else { accumulated }
    }

    /// `known` over the whole frame.
    fn spread(&mut self, known: TensorId, corrections: u32) -> Spread {
        let mut picture = self.builder.spread(known, None);
        let mut first = None;
        for _ in 0..corrections {
            let smooth = self.builder.smooth(picture);
            first = first.or(Some(smooth));
            picture = self.builder.spread(known, Some(smooth));
        }
        Spread { picture, smooth: first }
    }

    /// D: the U-Net of `inputs`, the filled picture first, and the picture it predicts.
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
                inputs = vec![Read::same(self.builder.pool(output))];
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
        read.extend(config.residual.then_some(filled));
        let picture = config.direct.then(|| self.predicted("output", &read, Activation::Relu));
        Direct { picture, features }
    }

    /// The picture that a 1×1 convolution of `inputs` makes.
    fn predicted(&mut self, name: &str, inputs: &[Read], activation: Activation) -> TensorId {
        let channels = if self.config.fold { 12 } else { 3 };
        let picture = self.builder.conv(name, inputs, channels, 1, activation);
        if self.config.fold { self.builder.depth_to_space(picture) } else { picture }
    }

    /// Two 3×3 convolutions, each with ReLU.
    fn block(&mut self, name: &str, inputs: &[Read], width: usize) -> TensorId {
        let first = self.builder.conv(&format!("{name}.conv1"), inputs, width, 3, Activation::Relu);
        self.builder.conv(&format!("{name}.conv2"), &[Read::same(first)], width, 3, Activation::Relu)
    }

    /// K as one filter at the finest resolution: of the `direct` prediction, if there is one, and of the pictures `more`.
    fn kernel(
        &mut self,
        features: &[TensorId],
        direct: Option<(Read, Taps)>,
        more: Vec<(Read, Taps)>,
    ) -> TensorId {
        self.filter("kernel.only", features[0], 0, direct.into_iter().chain(more).collect())
    }

    /// K: QW-Net's filters of the direct prediction, down and up again (ALGORITHMS §1.1, §1.2). The last kernel also
    /// weighs the pictures `more`.
    fn kernels(&mut self, direct: TensorId, features: &[TensorId], more: &[(Read, Taps)]) -> TensorId {
        // The level of the picture has no features of its own where D works on folded pixels.
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
            image = if depth < deepest { self.builder.pool(filtered) } else { filtered };
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
        self.builder.filter(Filter {
            name: name.to_owned(),
            features,
            expand: if self.config.fold && depth == 0 { 2 } else { 1 },
            images,
            output: features,
            normalisation: self.config.normalisation,
        })
    }
}
