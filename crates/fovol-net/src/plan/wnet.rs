use super::layer::{Activation, Filter, Normalisation, Read, Taps};
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
    /// The output.
    Output,
}

/// A U-Net whose decoders are recurrent, which predicts the picture directly (D) and then filters it with
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
    /// Whether unsampled pixels are filled by pull-push before.
    pub prefill: bool,
    /// Whether sampled pixels reach the output as they are.
    pub bypass: bool,
    /// Whether K's last kernel also weighs the last output.
    pub history: bool,
    /// Whether what comes from the last frame is moved along the renderer's motion.
    pub reproject: bool,
    /// Whether K's last kernel also weighs the filled picture.
    #[serde(default)]
    pub filled: bool,
    /// Whether K filters at every resolution, down and up again, or once at the finest.
    #[serde(default = "yes")]
    pub pyramid: bool,
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
            history: false,
            reproject: false,
            filled: false,
            pyramid: true,
        }
    }

    /// The same with 32 channels in the last decoder (the release's "small").
    pub fn narrow() -> Self {
        Self { decoder: vec![32, 64, 80], ..Self::paper() }
    }

    /// Ours.
    pub fn fast() -> Self {
        Self {
            encoder: vec![32, 48, 64, 80],
            decoder: vec![32, 48, 64],
            feedback: Feedback::Output,
            kernels: true,
            normalisation: Normalisation::Squared,
            fold: true,
            mask: true,
            prefill: true,
            bypass: true,
            history: true,
            reproject: true,
            filled: true,
            pyramid: false,
        }
    }

    /// The smallest of ours.
    pub fn tiny() -> Self {
        Self { encoder: vec![16, 32, 48, 64], decoder: vec![16, 32, 48], ..Self::fast() }
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
        if (self.history || self.filled) && !self.kernels {
            return Err("taps for K need kernels; set `kernels`, or leave out `history` and `filled`".into());
        }
        if self.filled && !self.prefill {
            return Err("there is no filled picture to weigh; set `prefill`, or leave out `filled`".into());
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

/// What D leaves to K.
struct Direct {
    picture: TensorId,
    /// Decoder outputs, finest first, then the bottleneck's.
    features: Vec<TensorId>,
}

impl Walk<'_> {
    fn run(mut self) -> Plan {
        let config = self.config;
        let colour = self.builder.colour();
        let filled = if config.prefill { self.builder.pull_push() } else { colour };
        let wants_last = config.history || config.feedback != Feedback::None;
        let last = wants_last.then(|| self.builder.state("output", 3, 0));
        let history = last.map(|last| self.reprojected(last));
        let direct = self.direct(filled, history.filter(|_| config.feedback != Feedback::None));
        let mut picture = direct.picture;
        if config.kernels {
            let more = [history.filter(|_| config.history), Some(filled).filter(|_| config.filled)];
            let more: Vec<TensorId> = more.into_iter().flatten().collect();
            picture = self.kernels(&direct, &more);
        }
        if config.bypass {
            picture = self.builder.bypass(colour, picture);
        }
        if let Some(last) = last {
            let is_direct = config.feedback == Feedback::Direct;
            self.carried.push((last, if is_direct { direct.picture } else { picture }));
        }
        for (previous, next) in self.carried {
            self.builder.keep(previous, next);
        }
        self.builder.finish(picture)
    }

    fn reprojected(&mut self, state: TensorId) -> TensorId {
        if self.config.reproject { self.builder.warp(state) } else { state }
    }

    /// What the first encoder reads.
    fn input(&mut self, filled: TensorId, history: Option<TensorId>) -> Vec<Read> {
        let mask = self.config.mask.then(|| self.builder.mask());
        let tensors: Vec<TensorId> = [Some(filled), mask, history].into_iter().flatten().collect();
        let fold = |tensor| if self.config.fold { self.builder.space_to_depth(tensor) } else { tensor };
        tensors.into_iter().map(fold).map(Read::same).collect()
    }

    /// D: the U-Net and the picture it predicts.
    fn direct(&mut self, filled: TensorId, history: Option<TensorId>) -> Direct {
        let config = self.config;
        let mut inputs = self.input(filled, history);
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
            let state = self.builder.state(&name, width, level);
            let hidden = self.reprojected(state);
            let below = Read::bilinear(features[0]);
            let output = self.block(&name, &[Read::same(skips[depth]), below, Read::same(hidden)], width);
            self.carried.push((state, output));
            features.insert(0, output);
        }
        let channels = if config.fold { 12 } else { 3 };
        let mut picture =
            self.builder.conv("output", &[Read::same(features[0])], channels, 1, Activation::Relu);
        if config.fold {
            picture = self.builder.depth_to_space(picture);
        }
        Direct { picture, features }
    }

    /// Two 3×3 convolutions, each with ReLU.
    fn block(&mut self, name: &str, inputs: &[Read], width: usize) -> TensorId {
        let first = self.builder.conv(&format!("{name}.conv1"), inputs, width, 3, Activation::Relu);
        self.builder.conv(&format!("{name}.conv2"), &[Read::same(first)], width, 3, Activation::Relu)
    }

    /// K: QW-Net's filters, down and up again (ALGORITHMS §1.1, §1.2), or one at the finest resolution alone. The
    /// last kernel also weighs the pictures `more`.
    fn kernels(&mut self, direct: &Direct, more: &[TensorId]) -> TensorId {
        // The level of the picture has no features of its own where D works on folded pixels.
        let mut features = direct.features.clone();
        if self.config.fold {
            features.insert(0, features[0]);
        }
        let around = |&picture: &TensorId| (Read::same(picture), Taps::Around);
        if !self.config.pyramid {
            let images = std::iter::once(&direct.picture).chain(more).map(around).collect();
            return self.filter("kernel.only", features[0], 0, images);
        }
        let deepest = features.len() - 1;
        let mut image = direct.picture;
        let mut skips = Vec::new();
        for (depth, &feature) in features.iter().enumerate() {
            let name = if depth == deepest { "kernel.bottom".into() } else { format!("kernel.down.{depth}") };
            let filtered = self.filter(&name, feature, depth, vec![around(&image)]);
            skips.push(filtered);
            image = if depth < deepest { self.builder.pool(filtered) } else { filtered };
        }
        for depth in (0..deepest).rev() {
            let mut images =
                vec![(Read::bilinear(image), Taps::Around), (Read::same(skips[depth]), Taps::Centre)];
            if depth == 0 {
                images.extend(more.iter().map(around));
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
