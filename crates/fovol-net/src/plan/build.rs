use super::layer::{Activation, Conv, Filter, Layer, Norm, POINT, Padding, Read, Resize};
use super::{Inputs, Plan, StateTensor, Tensor, TensorId};

/// What spreads pixels halves the resolution no more often.
const MOST_HALVINGS: u32 = 5;
/// Doubt is about squares of 2 to the power of this.
const DOUBT_LEVEL: u32 = 3;

/// Makes a [`Plan`] layer by layer, and sees that shapes fit.
///
/// # Panics
/// Its methods panic on layers whose inputs have different resolutions: configurations are checked before.
#[derive(Debug)]
pub struct PlanBuilder {
    plan: Plan,
}

impl Default for PlanBuilder {
    fn default() -> Self {
        Self::new()
    }
}

impl PlanBuilder {
    /// A plan with a colour input and no layers.
    pub fn new() -> Self {
        let colour = TensorId(0);
        let plan = Plan {
            tensors: vec![Tensor { name: "input".into(), channels: 3, level: 0 }],
            layers: Vec::new(),
            states: Vec::new(),
            inputs: Inputs { colour, mask: None, motion: None },
            output: colour,
        };
        Self { plan }
    }

    /// The colour input.
    pub fn colour(&self) -> TensorId {
        self.plan.inputs.colour
    }

    /// The mask input, which the network has from now on.
    pub fn mask(&mut self) -> TensorId {
        if self.plan.inputs.mask.is_none() {
            self.plan.inputs.mask = Some(self.tensor("mask", 1, 0));
        }
        self.plan.inputs.mask.unwrap_or(TensorId(0))
    }

    /// The motion input, which the network has from now on.
    pub fn motion(&mut self) -> TensorId {
        if self.plan.inputs.motion.is_none() {
            self.plan.inputs.motion = Some(self.tensor("motion", 2, 0));
        }
        self.plan.inputs.motion.unwrap_or(TensorId(0))
    }

    fn tensor(&mut self, name: &str, channels: usize, level: u32) -> TensorId {
        self.plan.tensors.push(Tensor { name: name.to_owned(), channels, level });
        TensorId(self.plan.tensors.len() - 1)
    }

    fn channels(&self, id: TensorId) -> usize {
        self.plan.tensors[id.0].channels
    }

    fn level(&self, id: TensorId) -> u32 {
        self.plan.tensors[id.0].level
    }

    /// The level that `read` gives.
    fn level_of(&self, read: Read) -> u32 {
        match read.resize {
            Resize::Same => self.level(read.tensor),
            Resize::Bilinear | Resize::Nearest => self.level(read.tensor) - 1,
        }
    }

    /// A state of the last frame; [`Self::keep`] says what the next one is.
    pub fn state(&mut self, name: &str, channels: usize, level: u32) -> TensorId {
        let previous = self.tensor(&format!("state.{name}"), channels, level);
        self.plan.states.push(StateTensor { name: name.to_owned(), previous, next: previous });
        previous
    }

    /// A state of the shape of `tensor`.
    pub fn state_like(&mut self, name: &str, tensor: TensorId) -> TensorId {
        self.state(name, self.channels(tensor), self.level(tensor))
    }

    /// Makes `next` what the state `previous` is in the next frame.
    pub fn keep(&mut self, previous: TensorId, next: TensorId) {
        let shape = |id: TensorId| (self.channels(id), self.level(id));
        assert_eq!(shape(previous), shape(next), "a state keeps its shape");
        for state in self.plan.states.iter_mut().filter(|state| state.previous == previous) {
            state.next = next;
        }
    }

    /// A convolution of `size` (1 or 3) over `inputs`, padded with zeros.
    pub fn conv(
        &mut self,
        name: &str,
        inputs: &[Read],
        channels: usize,
        size: usize,
        activation: Activation,
    ) -> TensorId {
        let level = self.level_of(inputs[0]);
        let output = self.tensor(name, channels, level);
        self.push_conv(Conv {
            name: name.to_owned(),
            inputs: inputs.to_vec(),
            output,
            size,
            stride: 1,
            padding: Padding::Zero,
            activation,
        })
    }

    /// A 3×3 convolution with replicated border, of `stride` 1 or 2.
    pub fn replicating_conv(
        &mut self,
        name: &str,
        inputs: &[Read],
        channels: usize,
        stride: usize,
        activation: Activation,
    ) -> TensorId {
        let level = self.level_of(inputs[0]) + (stride == 2) as u32;
        let output = self.tensor(name, channels, level);
        self.push_conv(Conv {
            name: name.to_owned(),
            inputs: inputs.to_vec(),
            output,
            size: 3,
            stride,
            padding: Padding::Replicate,
            activation,
        })
    }

    fn push_conv(&mut self, conv: Conv) -> TensorId {
        let level = self.level_of(conv.inputs[0]);
        assert!(conv.inputs.iter().all(|&read| self.level_of(read) == level), "inputs differ in resolution");
        self.push(Layer::Conv(conv))
    }

    fn push(&mut self, layer: Layer) -> TensorId {
        let output = layer.output();
        self.plan.layers.push(layer);
        output
    }

    /// A normalisation of `input` over the frame.
    pub fn norm(&mut self, name: &str, input: TensorId, activation: Activation) -> TensorId {
        let output = self.tensor(name, self.channels(input), self.level(input));
        self.push(Layer::Norm(Norm { name: name.to_owned(), input, output, activation }))
    }

    /// A predicted kernel: `filter` with whatever `output`.
    pub fn filter(&mut self, filter: Filter) -> TensorId {
        let first = filter.images[0].0;
        let level = self.level_of(first);
        assert!(
            filter.images.iter().all(|&(read, _)| self.level_of(read) == level),
            "images differ in resolution"
        );
        assert_eq!(self.level(filter.features), level + (filter.expand == 2) as u32, "features do not fit");
        let output = self.tensor(&filter.name, self.channels(first.tensor), level);
        self.push(Layer::Filter(Filter { output, ..filter }))
    }

    /// The mean of 2×2 pixels.
    pub fn pool(&mut self, input: TensorId) -> TensorId {
        let name = format!("{}.pooled", self.plan.tensors[input.0].name);
        let output = self.tensor(&name, self.channels(input), self.level(input) + 1);
        self.push(Layer::Pool { input, output })
    }

    /// Pixels to channels.
    pub fn space_to_depth(&mut self, input: TensorId) -> TensorId {
        let name = format!("{}.folded", self.plan.tensors[input.0].name);
        let output = self.tensor(&name, 4 * self.channels(input), self.level(input) + 1);
        self.push(Layer::SpaceToDepth { input, output })
    }

    /// Channels to pixels.
    pub fn depth_to_space(&mut self, input: TensorId) -> TensorId {
        let name = format!("{}.unfolded", self.plan.tensors[input.0].name);
        let output = self.tensor(&name, self.channels(input) / 4, self.level(input) - 1);
        self.push(Layer::DepthToSpace { input, output })
    }

    /// `factor` · `input` + `offset`.
    pub fn scale(&mut self, input: TensorId, factor: f32, offset: f32) -> TensorId {
        let name = format!("{}.scaled", self.plan.tensors[input.0].name);
        let output = self.tensor(&name, self.channels(input), self.level(input));
        self.push(Layer::Scale { input, output, factor, offset })
    }

    /// `input`, cut to 0…1.
    pub fn clamp(&mut self, input: TensorId) -> TensorId {
        let name = format!("{}.clamped", self.plan.tensors[input.0].name);
        let output = self.tensor(&name, self.channels(input), self.level(input));
        self.push(Layer::Clamp { input, output })
    }

    /// `colour` times `weight`, and `weight`: what the layers that fill take.
    pub fn join(&mut self, colour: TensorId, weight: TensorId) -> TensorId {
        let name = format!("{}.joined", self.plan.tensors[colour.0].name);
        let output = self.tensor(&name, 4, self.level(colour));
        self.push(Layer::Join { colour, weight, output })
    }

    /// `known` spread over the frame at half the resolution, as a correction of `base` where there is one.
    pub fn spread(&mut self, known: TensorId, base: Option<TensorId>) -> TensorId {
        let name = format!("{}.spread", self.plan.tensors[known.0].name);
        let output = self.tensor(&name, 3, 1);
        // How often frames can be halved is known at the end.
        self.push(Layer::Spread { known, base, levels: 0, output })
    }

    /// `input`, smoothed.
    pub fn smooth(&mut self, input: TensorId) -> TensorId {
        let name = format!("{}.smooth", self.plan.tensors[input.0].name);
        let output = self.tensor(&name, self.channels(input), self.level(input));
        self.push(Layer::Smooth { input, output })
    }

    /// `known`, and `base` of half the resolution elsewhere.
    pub fn blend(&mut self, known: TensorId, base: TensorId) -> TensorId {
        let name = format!("{}.filled", self.plan.tensors[known.0].name);
        let output = self.tensor(&name, 3, 0);
        self.push(Layer::Blend { known, base, output })
    }

    /// How far `prior` is believed where samples are `known` and give `fresh`.
    pub fn doubt(&mut self, known: TensorId, prior: TensorId, fresh: TensorId) -> TensorId {
        let output = self.tensor("believed", 1, 0);
        self.push(Layer::Doubt { known, prior, fresh, levels: 0, output })
    }

    /// `known`, and elsewhere as far as `share` lets it count what was known `before`, times `fade`.
    pub fn accumulate(
        &mut self,
        known: TensorId,
        before: TensorId,
        share: Option<TensorId>,
        fade: f32,
    ) -> TensorId {
        let name = format!("{}.accumulated", self.plan.tensors[known.0].name);
        let output = self.tensor(&name, self.channels(before), 0);
        self.push(Layer::Accumulate { known, before, share, fade, output })
    }

    /// `channels` channels of `input` from number `first` on.
    pub fn part(&mut self, input: TensorId, first: usize, channels: usize) -> TensorId {
        assert!(first + channels <= self.channels(input), "there are not so many channels");
        let name = format!("{}.part", self.plan.tensors[input.0].name);
        let output = self.tensor(&name, channels, self.level(input));
        self.push(Layer::Part { input, first, output })
    }

    /// `input` + `more`.
    pub fn add(&mut self, input: TensorId, more: TensorId) -> TensorId {
        let (channels, level) = (self.channels(input), self.level(input));
        assert_eq!((channels, level), (self.channels(more), self.level(more)), "sums have one shape");
        let name = format!("{}.corrected", self.plan.tensors[input.0].name);
        let output = self.tensor(&name, channels, level);
        self.push(Layer::Add { input, more, output })
    }

    /// `colour` where sampled, `input` elsewhere.
    pub fn bypass(&mut self, colour: TensorId, input: TensorId) -> TensorId {
        let mask = self.mask();
        let name = format!("{}.bypassed", self.plan.tensors[input.0].name);
        let output = self.tensor(&name, self.channels(input), self.level(input));
        self.push(Layer::Bypass { colour, mask, input, output })
    }

    /// The points of `input` where the motion takes them.
    pub fn reproject(&mut self, input: TensorId) -> TensorId {
        assert_eq!((self.channels(input), self.level(input)), (POINT, 0), "points are of the frame's pixels");
        let motion = self.motion();
        let name = format!("{}.reprojected", self.plan.tensors[input.0].name);
        let output = self.tensor(&name, POINT, 0);
        self.push(Layer::Reproject { input, motion, output })
    }

    /// What the points of `input` tell of the centres of pixels.
    pub fn splat(&mut self, input: TensorId) -> TensorId {
        assert_eq!((self.channels(input), self.level(input)), (POINT, 0), "points are of the frame's pixels");
        let name = format!("{}.splatted", self.plan.tensors[input.0].name);
        let output = self.tensor(&name, 4, 0);
        self.push(Layer::Splat { input, output })
    }

    /// `input` moved along the motion.
    pub fn warp(&mut self, input: TensorId) -> TensorId {
        let motion = self.motion();
        let name = format!("{}.warped", self.plan.tensors[input.0].name);
        let output = self.tensor(&name, self.channels(input), self.level(input));
        self.push(Layer::Warp { input, motion, output })
    }

    /// The plan that shows `output`.
    pub fn finish(mut self, output: TensorId) -> Plan {
        assert_eq!((self.channels(output), self.level(output)), (3, 0), "the output is a picture");
        self.plan.output = output;
        let most = self.plan.multiple().ilog2();
        for layer in &mut self.plan.layers {
            match layer {
                Layer::Spread { levels, .. } => *levels = most.min(MOST_HALVINGS),
                Layer::Doubt { levels, output, .. } => {
                    *levels = most.min(MOST_HALVINGS);
                    self.plan.tensors[output.0].level = most.min(DOUBT_LEVEL);
                }
                _ => {}
            }
        }
        self.plan
    }
}
