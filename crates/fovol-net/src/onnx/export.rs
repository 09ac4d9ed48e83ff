use super::graph::{GraphBuilder, integer, integers};
use super::model::{Dim, Entry, Graph, Model, ValueInfo};
use super::protobuf::Encode;
use crate::plan::{
    Activation, Bypass, Clamp, Conv, Layer, Norm, Padding, Parameter, Part, Plan, Read, Resize, Scale,
    TensorId,
};
use crate::{Error, Result, Weights};
use serde::Serialize;
use std::collections::HashMap;

/// Version of the file format that came with opset 17.
const IR_VERSION: i64 = 8;
const OPSET: i64 = 17;
/// Messages of Protocol Buffers are shorter than 2 GiB. 16 MiB of it are reserved for everything but weights.
const MOST_WEIGHTS: usize = (1 << 31) - (1 << 24);
/// ε of a normalisation, which keeps the divisor above zero.
const NORM_EPSILON: f32 = 1e-5;

/// Encodes `plan` with `weights` as an `.onnx` file that computes one frame of a sequence.
///
/// Inputs are `input` \[1, 3 or 4, H, W\], `motion` \[1, 2, H, W\] where the plan uses it, and `state.NAME`
/// \[1, c, H/s, W/s\]. Outputs are `output` \[1, 3, H, W\] in 0…1 and `next.NAME`. [The module](super) explains them.
/// Metadata properties are `fovolnet.multiple`, `fovolnet.states` and then `metadata`.
///
/// # Errors
/// Weights that do not fit the plan, or more than the format can hold.
pub fn export(plan: &Plan, weights: &Weights, metadata: &[(&str, String)]) -> Result<Vec<u8>> {
    Ok(model(plan, weights, metadata)?.to_bytes())
}

/// Builds the model, not yet encoded.
pub fn model(plan: &Plan, weights: &Weights, metadata: &[(&str, String)]) -> Result<Model> {
    weights.check(plan)?;
    let numbers: usize = plan.parameters().iter().map(Parameter::len).sum();
    if numbers.saturating_mul(size_of::<f32>()) > MOST_WEIGHTS {
        let problem = "the network has more weights than the 2 GiB of an ONNX file hold; use narrower layers";
        return Err(Error::Config(problem.into()));
    }
    let own = [("fovolnet.multiple", plan.multiple().to_string()), ("fovolnet.states", states(plan)?)];
    let entry = |(key, value): &(&str, String)| Entry { key: (*key).to_owned(), value: value.clone() };
    Ok(Model {
        ir_version: IR_VERSION,
        opset: OPSET,
        producer: ("fovolnet", env!("CARGO_PKG_VERSION")),
        graph: Exporter::new(plan, weights).run()?,
        metadata: own.iter().chain(metadata).map(entry).collect(),
    })
}

/// Lists the states of `plan` as JSON.
fn states(plan: &Plan) -> Result<String> {
    #[derive(Serialize)]
    struct State<'a> {
        name: &'a str,
        channels: usize,
        scale: usize,
    }
    let list: Vec<_> = plan
        .states()
        .iter()
        .map(|kept| {
            let tensor = plan.tensor(kept.previous);
            State { name: &kept.name, channels: tensor.channels, scale: 1 << tensor.level }
        })
        .collect();
    serde_json::to_string(&list).map_err(|error| Error::Config(error.to_string()))
}

/// Exporter of one plan, layer by layer.
pub(super) struct Exporter<'a> {
    pub plan: &'a Plan,
    weights: &'a Weights,
    pub graph: GraphBuilder,
    /// Name of the graph value of each tensor of the plan; empty until it is written.
    values: Vec<String>,
    /// For each level at which a tensor was warped, the grid of source positions that `GridSample` reads.
    pub grids: HashMap<u32, String>,
}

impl<'a> Exporter<'a> {
    fn new(plan: &'a Plan, weights: &'a Weights) -> Self {
        let states = plan.states().iter();
        let states =
            states.flat_map(|state| [format!("state.{}", state.name), format!("next.{}", state.name)]);
        let reserved = ["input", "motion", "output"].map(str::to_owned).into_iter().chain(states);
        let graph = GraphBuilder::new("fovolnet", reserved);
        Self {
            plan,
            weights,
            graph,
            values: vec![String::new(); plan.tensors().len()],
            grids: HashMap::new(),
        }
    }

    fn run(mut self) -> Result<Graph> {
        self.inputs();
        for layer in self.plan.layers() {
            let value = self.layer(layer)?;
            self.values[layer.output().index()] = value;
        }
        self.outputs();
        Ok(self.graph.finish())
    }

    /// Name of the graph value of tensor `id`.
    pub fn value(&self, id: TensorId) -> String {
        self.values[id.index()].clone()
    }

    /// Name of tensor `id` in the plan.
    pub fn name(&self, id: TensorId) -> &'a str {
        &self.plan.tensor(id).name
    }

    /// Describes an input or output with `channels` channels for each square of 2^`level` × 2^`level` pixels.
    fn info(name: &str, channels: usize, level: u32) -> ValueInfo {
        let side =
            |side: &str| Dim::Free(if level == 0 { side.into() } else { format!("{side}{}", 1 << level) });
        ValueInfo { name: name.into(), dims: vec![Dim::Fixed(1), Dim::Fixed(channels), side("H"), side("W")] }
    }

    fn inputs(&mut self) {
        let inputs = self.plan.inputs();
        let input = self.graph.input(Self::info("input", if inputs.mask.is_some() { 4 } else { 3 }, 0));
        self.values[inputs.colour.index()] = match inputs.mask {
            None => input,
            Some(mask) => {
                let names = ["colour".to_owned(), "mask".to_owned()];
                let mut parts = self.graph.split(&input, &[3, 1], &names);
                self.values[mask.index()] = parts.remove(1);
                parts.remove(0)
            }
        };
        if let Some(motion) = inputs.motion {
            self.values[motion.index()] = self.graph.input(Self::info("motion", 2, 0));
        }
        for state in self.plan.states() {
            let tensor = self.plan.tensor(state.previous);
            let info = Self::info(&format!("state.{}", state.name), tensor.channels, tensor.level);
            self.values[state.previous.index()] = self.graph.input(info);
        }
    }

    fn outputs(&mut self) {
        let (low, high) = (self.graph.scalar(0.0), self.graph.scalar(1.0));
        let picture = self.value(self.plan.output());
        self.graph.output(Self::info("output", 3, 0), "Clip", &[&picture, &low, &high]);
        for state in self.plan.states() {
            let tensor = self.plan.tensor(state.next);
            let info = Self::info(&format!("next.{}", state.name), tensor.channels, tensor.level);
            // A value of its own, because states can share a tensor or be an input of another layer.
            self.graph.output(info, "Identity", &[&self.value(state.next)]);
        }
    }

    fn layer(&mut self, layer: &Layer) -> Result<String> {
        Ok(match layer {
            Layer::Conv(layer) => self.conv(layer)?,
            Layer::Norm(layer) => self.norm(layer)?,
            Layer::Filter(layer) => self.filter(layer)?,
            Layer::Pool(layer) => self.graph.pooled(self.name(layer.output), &self.value(layer.input), 2),
            Layer::SpaceToDepth(layer) => {
                let channels = self.plan.tensor(layer.input).channels;
                self.graph.space_to_depth(self.name(layer.output), &self.value(layer.input), channels)
            }
            Layer::DepthToSpace(layer) => {
                self.graph.depth_to_space(self.name(layer.output), &self.value(layer.input))
            }
            Layer::Scale(layer) => self.scale(layer),
            Layer::Clamp(layer) => self.clamp(layer),
            Layer::Join(layer) => {
                let parts = [layer.colour, layer.weight].map(|id| self.value(id));
                self.graph.concatenated(self.name(layer.output), &parts)
            }
            Layer::Spread(layer) => self.spread(layer),
            Layer::Smooth(layer) => self.smooth(layer),
            Layer::Blend(layer) => self.blend(layer),
            Layer::HistoryConfidence(layer) => self.history_confidence(layer),
            Layer::Accumulate(layer) => self.accumulate(layer),
            Layer::Part(layer) => self.part(layer),
            Layer::Add(layer) => {
                let summands = [self.value(layer.input), self.value(layer.more)];
                self.graph.plain("Add", self.name(layer.output), &[&summands[0], &summands[1]])
            }
            Layer::Bypass(layer) => self.bypass(layer),
            Layer::Reproject(layer) => self.reproject(layer),
            Layer::Splat(layer) => self.splat(layer),
            Layer::Warp(layer) => self.warp(layer),
        })
    }

    /// Adds the learned array `name`, reshaped to `dims`.
    fn parameter(&mut self, name: &str, dims: &[usize]) -> Result<String> {
        let values = self.weights.values(name)?.to_vec();
        Ok(self.graph.parameter(name, dims, values))
    }

    /// Returns a tensor at the resolution at which `read` wants it.
    pub fn read(&mut self, read: Read) -> String {
        let value = self.value(read.tensor);
        let name = format!("{}.up", self.name(read.tensor));
        match read.resize {
            Resize::Same => value,
            Resize::Bilinear => self.graph.bilinear(&name, &value),
            Resize::Nearest => self.graph.nearest(&name, &value),
        }
    }

    fn conv(&mut self, conv: &Conv) -> Result<String> {
        let name = &conv.name;
        let inputs: Vec<String> = conv.inputs.iter().map(|&read| self.read(read)).collect();
        let channels = [
            self.plan.tensor(conv.output).channels,
            conv.inputs.iter().map(|read| self.plan.tensor(read.tensor).channels).sum(),
        ];
        let mut input = self.graph.concatenated(&format!("{name}.inputs"), &inputs);
        let mut border = (conv.size / 2) as i64;
        if conv.padding == Padding::Replicate && border > 0 {
            input = self.graph.padded(&format!("{name}.padded"), &input, "edge");
            border = 0;
        }
        let sum = self.learned_conv(name, &input, channels, [conv.size, conv.stride], border)?;
        Ok(self.activated(name, sum, conv.activation))
    }

    /// Adds a convolution with the parameters of `name`, and zeros in a `border` of this many pixels.
    pub fn learned_conv(
        &mut self,
        name: &str,
        input: &str,
        [outputs, inputs]: [usize; 2],
        [size, stride]: [usize; 2],
        border: i64,
    ) -> Result<String> {
        let weight = self.parameter(&format!("{name}.weight"), &[outputs, inputs, size, size])?;
        let bias = self.parameter(&format!("{name}.bias"), &[outputs])?;
        let attributes = vec![
            integers("kernel_shape", &[size as i64; 2]),
            integers("strides", &[stride as i64; 2]),
            integers("pads", &[border; 4]),
        ];
        Ok(self.graph.node("Conv", &format!("{name}.sum"), &[input, &weight, &bias], attributes))
    }

    fn activated(&mut self, name: &str, value: String, activation: Activation) -> String {
        match activation {
            Activation::None => value,
            Activation::Relu => self.graph.plain("Relu", name, &[&value]),
            Activation::Elu => self.graph.plain("Elu", name, &[&value]),
        }
    }

    /// Adds (x − mean) · weight / √(variance + ε) + bias. The mean is subtracted before squaring, so that the
    /// variance stays exact where the mean is large.
    fn norm(&mut self, norm: &Norm) -> Result<String> {
        let name = &norm.name;
        let channels = self.plan.tensor(norm.input).channels;
        let weight = self.parameter(&format!("{name}.weight"), &[channels, 1, 1])?;
        let bias = self.parameter(&format!("{name}.bias"), &[channels, 1, 1])?;
        let input = self.value(norm.input);
        let mean = self.mean(&format!("{name}.mean"), &input);
        let graph = &mut self.graph;
        let centred = graph.plain("Sub", &format!("{name}.centred"), &[&input, &mean]);
        let squares = graph.plain("Mul", &format!("{name}.squares"), &[&centred, &centred]);
        let variance = self.mean(&format!("{name}.variance"), &squares);
        let graph = &mut self.graph;
        let epsilon = graph.scalar(NORM_EPSILON);
        let variance = graph.plain("Add", &format!("{name}.variance"), &[&variance, &epsilon]);
        let deviation = graph.plain("Sqrt", &format!("{name}.deviation"), &[&variance]);
        let factor = graph.plain("Div", &format!("{name}.factor"), &[&weight, &deviation]);
        let scaled = graph.plain("Mul", &format!("{name}.scaled"), &[&centred, &factor]);
        let sum = graph.plain("Add", &format!("{name}.sum"), &[&scaled, &bias]);
        Ok(self.activated(name, sum, norm.activation))
    }

    /// Averages all numbers: rows first, then the means of rows. Short sums lose less precision.
    fn mean(&mut self, name: &str, input: &str) -> String {
        let mut reduced = |input: &str, axes: &[i64]| {
            let attributes = vec![integers("axes", axes), integer("keepdims", 1)];
            self.graph.node("ReduceMean", name, &[input], attributes)
        };
        let rows = reduced(input, &[3]);
        let channels = reduced(&rows, &[2]);
        reduced(&channels, &[1])
    }

    fn clamp(&mut self, &Clamp { input, output }: &Clamp) -> String {
        let [low, high] = [0.0, 1.0].map(|value| self.graph.scalar(value));
        self.graph.plain("Clip", self.name(output), &[&self.value(input), &low, &high])
    }

    fn part(&mut self, &Part { input, first, channels, output }: &Part) -> String {
        let wanted = (first..first + channels).map(|channel| channel as i64).collect::<Vec<_>>();
        let wanted = self.graph.indices(&wanted);
        let along = vec![integer("axis", 1)];
        self.graph.node("Gather", self.name(output), &[&self.value(input), &wanted], along)
    }

    fn scale(&mut self, &Scale { input, output, factor, offset }: &Scale) -> String {
        let (name, input) = (self.name(output), self.value(input));
        let (factor, offset) = (self.graph.scalar(factor), self.graph.scalar(offset));
        let product = self.graph.plain("Mul", name, &[&input, &factor]);
        self.graph.plain("Add", name, &[&product, &offset])
    }

    fn bypass(&mut self, &Bypass { colour, mask, input, output }: &Bypass) -> String {
        let name = self.name(output);
        let [colour, mask, input] = [colour, mask, input].map(|id| self.value(id));
        let sampled = self.graph.plain("Mul", &format!("{name}.sampled"), &[&mask, &colour]);
        let open = self.graph.complement(&format!("{name}.open"), &mask);
        let rest = self.graph.plain("Mul", &format!("{name}.rest"), &[&open, &input]);
        self.graph.plain("Add", name, &[&sampled, &rest])
    }
}
