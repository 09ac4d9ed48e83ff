use super::layer::{Activation, Conv, Filter, Layer, Norm, POINT, Padding, Read, Resize};
use super::{Inputs, Plan, StateTensor, TensorId, TensorSpec};

/// Upper limit of the halvings in layers that spread samples.
const MOST_HALVINGS: u32 = 5;
/// Level of the confidence map: one value for a square of 2³ × 2³ pixels.
const DOUBT_LEVEL: u32 = 3;

/// Builds a [`Plan`] layer by layer and checks that shapes fit.
///
/// # Panics
/// Methods panic if inputs of a layer differ in resolution: configurations are checked beforehand.
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
    /// Begins a plan with a colour input and no layers.
    pub fn new() -> Self {
        let colour = TensorId(0);
        let plan = Plan {
            tensors: vec![TensorSpec { name: "input".into(), channels: 3, level: 0 }],
            layers: Vec::new(),
            states: Vec::new(),
            inputs: Inputs { colour, mask: None, motion: None },
            output: colour,
        };
        Self { plan }
    }

    /// Returns the colour input.
    pub fn colour(&self) -> TensorId {
        self.plan.inputs.colour
    }

    /// Returns the mask input, and adds it to the plan if needed.
    pub fn mask(&mut self) -> TensorId {
        if self.plan.inputs.mask.is_none() {
            self.plan.inputs.mask = Some(self.tensor("mask", 1, 0));
        }
        self.plan.inputs.mask.unwrap_or(TensorId(0))
    }

    /// Returns the motion input, and adds it to the plan if needed.
    pub fn motion(&mut self) -> TensorId {
        if self.plan.inputs.motion.is_none() {
            self.plan.inputs.motion = Some(self.tensor("motion", 2, 0));
        }
        self.plan.inputs.motion.unwrap_or(TensorId(0))
    }

    fn tensor(&mut self, name: &str, channels: usize, level: u32) -> TensorId {
        self.plan.tensors.push(TensorSpec { name: name.to_owned(), channels, level });
        TensorId(self.plan.tensors.len() - 1)
    }

    fn channels(&self, id: TensorId) -> usize {
        self.plan.tensors[id.0].channels
    }

    fn level(&self, id: TensorId) -> u32 {
        self.plan.tensors[id.0].level
    }

    /// Returns the level at which `read` delivers its tensor.
    fn level_of(&self, read: Read) -> u32 {
        match read.resize {
            Resize::Same => self.level(read.tensor),
            Resize::Bilinear | Resize::Nearest => self.level(read.tensor) - 1,
        }
    }

    /// Adds a state, as the last frame left it. [`Self::keep`] sets its next value.
    pub fn state(&mut self, name: &str, channels: usize, level: u32) -> TensorId {
        let previous = self.tensor(&format!("state.{name}"), channels, level);
        self.plan.states.push(StateTensor { name: name.to_owned(), previous, next: previous });
        previous
    }

    /// Adds a state with the shape of `tensor`.
    pub fn state_like(&mut self, name: &str, tensor: TensorId) -> TensorId {
        self.state(name, self.channels(tensor), self.level(tensor))
    }

    /// Makes `next` the value of the state `previous` in the next frame.
    pub fn keep(&mut self, previous: TensorId, next: TensorId) {
        let shape = |id: TensorId| (self.channels(id), self.level(id));
        assert_eq!(shape(previous), shape(next), "a state keeps its shape");
        for state in self.plan.states.iter_mut().filter(|state| state.previous == previous) {
            state.next = next;
        }
    }

    /// Adds a convolution over `inputs` with a window of `size` (1 or 3), padded with zeros.
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

    /// Adds a 3×3 convolution with replicated border and a `stride` of 1 or 2.
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

    /// Adds a group normalisation of `input` with one group.
    pub fn norm(&mut self, name: &str, input: TensorId, activation: Activation) -> TensorId {
        let output = self.tensor(name, self.channels(input), self.level(input));
        self.push(Layer::Norm(Norm { name: name.to_owned(), input, output, activation }))
    }

    /// Adds a predicted kernel. `filter.output` is ignored and set.
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

    /// Adds an average of 2×2 pixels.
    pub fn pool(&mut self, input: TensorId) -> TensorId {
        let name = format!("{}.pooled", self.plan.tensors[input.0].name);
        let output = self.tensor(&name, self.channels(input), self.level(input) + 1);
        self.push(Layer::Pool { input, output })
    }

    /// Adds a fold of 2×2 pixels into channels.
    pub fn space_to_depth(&mut self, input: TensorId) -> TensorId {
        let name = format!("{}.folded", self.plan.tensors[input.0].name);
        let output = self.tensor(&name, 4 * self.channels(input), self.level(input) + 1);
        self.push(Layer::SpaceToDepth { input, output })
    }

    /// Adds the inverse of [`Self::space_to_depth`].
    pub fn depth_to_space(&mut self, input: TensorId) -> TensorId {
        let name = format!("{}.unfolded", self.plan.tensors[input.0].name);
        let output = self.tensor(&name, self.channels(input) / 4, self.level(input) - 1);
        self.push(Layer::DepthToSpace { input, output })
    }

    /// Adds the layer `factor` · `input` + `offset`.
    pub fn scale(&mut self, input: TensorId, factor: f32, offset: f32) -> TensorId {
        let name = format!("{}.scaled", self.plan.tensors[input.0].name);
        let output = self.tensor(&name, self.channels(input), self.level(input));
        self.push(Layer::Scale { input, output, factor, offset })
    }

    /// Adds a layer that clamps `input` to 0…1.
    pub fn clamp(&mut self, input: TensorId) -> TensorId {
        let name = format!("{}.clamped", self.plan.tensors[input.0].name);
        let output = self.tensor(&name, self.channels(input), self.level(input));
        self.push(Layer::Clamp { input, output })
    }

    /// Adds a layer that premultiplies `colour` with `weight` and appends `weight`, as the filling layers read it.
    pub fn join(&mut self, colour: TensorId, weight: TensorId) -> TensorId {
        let name = format!("{}.joined", self.plan.tensors[colour.0].name);
        let output = self.tensor(&name, 4, self.level(colour));
        self.push(Layer::Join { colour, weight, output })
    }

    /// Adds a layer that spreads `known` over the frame at half the resolution. With `base` it spreads the
    /// residuals of `base` at the samples and adds them to `base`.
    pub fn spread(&mut self, known: TensorId, base: Option<TensorId>) -> TensorId {
        let name = format!("{}.spread", self.plan.tensors[known.0].name);
        let output = self.tensor(&name, 3, 1);
        // The number of levels is only known once the plan is complete; `finish` sets it.
        self.push(Layer::Spread { known, base, levels: 0, output })
    }

    /// Adds a smoothing of `input`.
    pub fn smooth(&mut self, input: TensorId) -> TensorId {
        let name = format!("{}.smooth", self.plan.tensors[input.0].name);
        let output = self.tensor(&name, self.channels(input), self.level(input));
        self.push(Layer::Smooth { input, output })
    }

    /// Adds a layer that fills `known` from `base`, a picture of half the resolution.
    pub fn blend(&mut self, known: TensorId, base: TensorId) -> TensorId {
        let name = format!("{}.filled", self.plan.tensors[known.0].name);
        let output = self.tensor(&name, 3, 0);
        self.push(Layer::Blend { known, base, output })
    }

    /// Adds a layer that rates how far the reprojected picture `prior` can be trusted, given the samples `known`
    /// and their fill `fresh`.
    pub fn doubt(&mut self, known: TensorId, prior: TensorId, fresh: TensorId) -> TensorId {
        let output = self.tensor("believed", 1, 0);
        self.push(Layer::Doubt { known, prior, fresh, levels: 0, output })
    }

    /// Adds a layer that keeps `known` and fills its gaps from `before`, the weighted pixels of earlier frames,
    /// with their weights multiplied by `fade` and `share`.
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

    /// Adds a layer that copies `channels` channels of `input`, from channel `first` on.
    pub fn part(&mut self, input: TensorId, first: usize, channels: usize) -> TensorId {
        assert!(first + channels <= self.channels(input), "there are not so many channels");
        let name = format!("{}.part", self.plan.tensors[input.0].name);
        let output = self.tensor(&name, channels, self.level(input));
        self.push(Layer::Part { input, first, output })
    }

    /// Adds the sum of `input` and `more`.
    pub fn add(&mut self, input: TensorId, more: TensorId) -> TensorId {
        let (channels, level) = (self.channels(input), self.level(input));
        assert_eq!((channels, level), (self.channels(more), self.level(more)), "sums have one shape");
        let name = format!("{}.corrected", self.plan.tensors[input.0].name);
        let output = self.tensor(&name, channels, level);
        self.push(Layer::Add { input, more, output })
    }

    /// Adds a layer that takes `colour` where sampled and `input` elsewhere.
    pub fn bypass(&mut self, colour: TensorId, input: TensorId) -> TensorId {
        let mask = self.mask();
        let name = format!("{}.bypassed", self.plan.tensors[input.0].name);
        let output = self.tensor(&name, self.channels(input), self.level(input));
        self.push(Layer::Bypass { colour, mask, input, output })
    }

    /// Adds a layer that moves the points of `input` along the motion.
    pub fn reproject(&mut self, input: TensorId) -> TensorId {
        assert_eq!((self.channels(input), self.level(input)), (POINT, 0), "points are of the frame's pixels");
        let motion = self.motion();
        let name = format!("{}.reprojected", self.plan.tensors[input.0].name);
        let output = self.tensor(&name, POINT, 0);
        self.push(Layer::Reproject { input, motion, output })
    }

    /// Adds a layer that resamples the points of `input` at pixel centres.
    pub fn splat(&mut self, input: TensorId) -> TensorId {
        assert_eq!((self.channels(input), self.level(input)), (POINT, 0), "points are of the frame's pixels");
        let name = format!("{}.splatted", self.plan.tensors[input.0].name);
        let output = self.tensor(&name, 4, 0);
        self.push(Layer::Splat { input, output })
    }

    /// Adds a layer that moves `input` along the motion.
    pub fn warp(&mut self, input: TensorId) -> TensorId {
        let motion = self.motion();
        let name = format!("{}.warped", self.plan.tensors[input.0].name);
        let output = self.tensor(&name, self.channels(input), self.level(input));
        self.push(Layer::Warp { input, motion, output })
    }

    /// Completes the plan, with `output` as the reconstructed picture.
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
