//! Builds an ONNX graph, node by node, from the operators that networks need.

use super::model::{Attribute, AttributeValue, Graph, Node, Tensor, TensorData, ValueInfo};
use std::collections::HashSet;

/// A graph under construction. Values are known by unique names.
#[derive(Debug)]
pub struct GraphBuilder {
    graph: Graph,
    names: HashSet<String>,
}

/// Makes an integer attribute.
pub fn integer(name: &'static str, value: i64) -> Attribute {
    Attribute { name, value: AttributeValue::Integer(value) }
}

/// Makes an attribute that is a list of integers.
pub fn integers(name: &'static str, values: &[i64]) -> Attribute {
    Attribute { name, value: AttributeValue::Integers(values.to_vec()) }
}

/// Makes a string attribute.
pub fn text(name: &'static str, value: &'static str) -> Attribute {
    Attribute { name, value: AttributeValue::Text(value) }
}

impl GraphBuilder {
    /// Begins an empty graph. Inner values never get one of the `reserved` names.
    pub fn new(name: &str, reserved: impl IntoIterator<Item = String>) -> Self {
        let graph = Graph { name: name.to_owned(), ..Graph::default() };
        Self { graph, names: reserved.into_iter().collect() }
    }

    /// Completes the graph.
    pub fn finish(self) -> Graph {
        self.graph
    }

    /// Returns `name`, or `name` with a number if that is taken.
    fn fresh(&mut self, name: &str) -> String {
        let numbered = (1..).map(|number| format!("{name}.{number}"));
        let mut names = std::iter::once(name.to_owned()).chain(numbered);
        let free = names.find(|candidate| !self.names.contains(candidate)).unwrap_or_default();
        self.names.insert(free.clone());
        free
    }

    /// Adds an input of the graph. Its name must be reserved.
    pub fn input(&mut self, info: ValueInfo) -> String {
        let name = info.name.clone();
        self.graph.inputs.push(info);
        name
    }

    /// Adds `operator` of `inputs` as an output of the graph. Its name must be reserved.
    pub fn output(&mut self, info: ValueInfo, operator: &'static str, inputs: &[&str]) {
        let name = info.name.clone();
        self.graph.outputs.push(info);
        self.push(operator, inputs, vec![name], Vec::new());
    }

    /// Adds a tensor of learned numbers.
    pub fn parameter(&mut self, name: &str, dims: &[usize], values: Vec<f32>) -> String {
        let name = self.fresh(name);
        let tensor = Tensor { name: name.clone(), dims: dims.to_vec(), data: TensorData::Floats(values) };
        self.graph.initialisers.push(tensor);
        name
    }

    /// Adds a constant number.
    pub fn scalar(&mut self, value: f32) -> String {
        self.constant(&[], TensorData::Floats(vec![value]))
    }

    /// Adds a constant list of floats.
    pub fn floats(&mut self, values: &[f32]) -> String {
        self.constant(&[values.len()], TensorData::Floats(values.to_vec()))
    }

    /// Adds a constant list of indices or lengths.
    pub fn indices(&mut self, values: &[i64]) -> String {
        self.constant(&[values.len()], TensorData::Integers(values.to_vec()))
    }

    /// Adds a constant index.
    pub fn index(&mut self, value: i64) -> String {
        self.constant(&[], TensorData::Integers(vec![value]))
    }

    /// Adds a constant. Equal constants share one value.
    pub fn constant(&mut self, dims: &[usize], data: TensorData) -> String {
        let same = |tensor: &&Tensor| tensor.dims == dims && tensor.data == data;
        if let Some(tensor) = self.graph.initialisers.iter().find(same) {
            return tensor.name.clone();
        }
        let name = self.fresh("constant");
        self.graph.initialisers.push(Tensor { name: name.clone(), dims: dims.to_vec(), data });
        name
    }

    fn push(
        &mut self,
        operator: &'static str,
        inputs: &[&str],
        outputs: Vec<String>,
        attributes: Vec<Attribute>,
    ) {
        let name = format!("{operator}:{}", outputs[0]);
        let inputs = inputs.iter().map(|&input| input.to_owned()).collect();
        self.graph.nodes.push(Node { name, operator, inputs, outputs, attributes });
    }

    /// Adds a node and returns its output, named after `name`.
    pub fn node(
        &mut self,
        operator: &'static str,
        name: &str,
        inputs: &[&str],
        attributes: Vec<Attribute>,
    ) -> String {
        let output = self.fresh(name);
        self.push(operator, inputs, vec![output.clone()], attributes);
        output
    }

    /// Adds a node without attributes and returns its output.
    pub fn plain(&mut self, operator: &'static str, name: &str, inputs: &[&str]) -> String {
        self.node(operator, name, inputs, Vec::new())
    }

    /// Splits `input` along the channels: the first `sizes[0]`, the next `sizes[1]`, and so on, named after
    /// `names`.
    pub fn split(&mut self, input: &str, sizes: &[usize], names: &[String]) -> Vec<String> {
        let lengths = sizes.iter().map(|&size| size as i64).collect::<Vec<_>>();
        let lengths = self.indices(&lengths);
        let outputs: Vec<String> = names.iter().map(|name| self.fresh(name)).collect();
        self.push("Split", &[input, &lengths], outputs.clone(), vec![integer("axis", 1)]);
        outputs
    }

    /// Concatenates `inputs` along the channels.
    pub fn concatenated(&mut self, name: &str, inputs: &[String]) -> String {
        match inputs {
            [single] => single.clone(),
            _ => {
                let inputs: Vec<&str> = inputs.iter().map(String::as_str).collect();
                self.node("Concat", name, &inputs, vec![integer("axis", 1)])
            }
        }
    }

    /// Averages squares of `edge` × `edge` pixels.
    pub fn pooled(&mut self, name: &str, input: &str, edge: i64) -> String {
        let attributes = vec![integers("kernel_shape", &[edge; 2]), integers("strides", &[edge; 2])];
        self.node("AveragePool", name, &[input], attributes)
    }

    /// Doubles the resolution of `input`: bilinear between pixel centres, replicated at the border.
    pub fn bilinear(&mut self, name: &str, input: &str) -> String {
        self.bilinear_by(name, input, 2)
    }

    /// Multiplies the resolution of `input` by `factor`: bilinear between pixel centres, replicated at the border.
    pub fn bilinear_by(&mut self, name: &str, input: &str, factor: u32) -> String {
        let attributes = vec![text("mode", "linear"), text("coordinate_transformation_mode", "half_pixel")];
        self.resized(name, input, factor, attributes)
    }

    /// Doubles the resolution of `input` by nearest neighbour.
    pub fn nearest(&mut self, name: &str, input: &str) -> String {
        let attributes = vec![
            text("mode", "nearest"),
            text("coordinate_transformation_mode", "asymmetric"),
            text("nearest_mode", "floor"),
        ];
        self.resized(name, input, 2, attributes)
    }

    fn resized(&mut self, name: &str, input: &str, factor: u32, attributes: Vec<Attribute>) -> String {
        let scales = self.floats(&[1.0, 1.0, factor as f32, factor as f32]);
        self.node("Resize", name, &[input, "", &scales], attributes)
    }

    /// Pads `input` by one pixel: zeros in the mode `constant`, replicated in the mode `edge`.
    pub fn padded(&mut self, name: &str, input: &str, mode: &'static str) -> String {
        let widths = self.indices(&[0, 0, 1, 1, 0, 0, 1, 1]);
        self.node("Pad", name, &[input, &widths], vec![text("mode", mode)])
    }

    /// Computes 1 − `input`.
    pub fn complement(&mut self, name: &str, input: &str) -> String {
        let one = self.scalar(1.0);
        self.plain("Sub", name, &[&one, input])
    }

    /// Unfolds channels into 2×2 pixels: channel 4c + 2y + x goes to channel c of pixel (x, y) of the four.
    pub fn depth_to_space(&mut self, name: &str, input: &str) -> String {
        self.node("DepthToSpace", name, &[input], vec![integer("blocksize", 2), text("mode", "CRD")])
    }

    /// Folds 2×2 pixels into channels, the inverse of [`Self::depth_to_space`]: `channels` become four times as
    /// many.
    pub fn space_to_depth(&mut self, name: &str, input: &str, channels: usize) -> String {
        let folded = self.node("SpaceToDepth", name, &[input], vec![integer("blocksize", 2)]);
        // The operator orders channels by pixel first, (2y + x)·channels + c.
        let from = |at: usize| (at % 4 * channels + at / 4) as i64;
        let order = self.indices(&(0..4 * channels).map(from).collect::<Vec<_>>());
        self.node("Gather", name, &[&folded, &order], vec![integer("axis", 1)])
    }
}
