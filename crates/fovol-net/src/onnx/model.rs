//! Messages of ONNX files. Field numbers are those of `onnx.proto`.

use super::protobuf::{Encode, Message};

/// `ModelProto`: the whole file.
#[derive(Debug)]
pub struct Model {
    /// Version of the file format.
    pub ir_version: i64,
    /// Version of the operator set.
    pub opset: i64,
    /// Name and version of the program that wrote the file.
    pub producer: (&'static str, &'static str),
    /// The computation.
    pub graph: Graph,
    /// Metadata by name.
    pub metadata: Vec<Entry>,
}

/// `GraphProto`: nodes in the order of execution.
#[derive(Debug, Default)]
pub struct Graph {
    /// Name of the graph.
    pub name: String,
    /// Operations.
    pub nodes: Vec<Node>,
    /// Constant tensors.
    pub initialisers: Vec<Tensor>,
    /// Inputs of the graph.
    pub inputs: Vec<ValueInfo>,
    /// Outputs of the graph.
    pub outputs: Vec<ValueInfo>,
}

/// `NodeProto`: an operator applied to values.
#[derive(Debug)]
pub struct Node {
    /// Name of the node.
    pub name: String,
    /// Operator.
    pub operator: &'static str,
    /// Names of the input values. An empty name omits an optional input.
    pub inputs: Vec<String>,
    /// Names of the output values.
    pub outputs: Vec<String>,
    /// Attributes.
    pub attributes: Vec<Attribute>,
}

/// `AttributeProto`: a named constant of a node.
#[derive(Debug)]
pub struct Attribute {
    /// Name.
    pub name: &'static str,
    /// Value.
    pub value: AttributeValue,
}

/// The value of an [`Attribute`].
#[derive(Debug)]
pub enum AttributeValue {
    /// Integer.
    Integer(i64),
    /// String.
    Text(&'static str),
    /// List of integers.
    Integers(Vec<i64>),
}

/// `TensorProto`: a constant tensor.
#[derive(Debug)]
pub struct Tensor {
    /// Name of the value that it defines.
    pub name: String,
    /// Shape; empty for a scalar.
    pub dims: Vec<usize>,
    /// Elements.
    pub data: TensorData,
}

/// Elements of a [`Tensor`].
#[derive(Debug, Clone, PartialEq)]
pub enum TensorData {
    /// Floats (f32).
    Floats(Vec<f32>),
    /// Integers (i64), for shapes and indices.
    Integers(Vec<i64>),
}

/// `TensorProto.DataType`: element types.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DataType {
    /// Element type f32.
    Float = 1,
    /// Element type i64.
    Int64 = 7,
}

/// `ValueInfoProto`: a tensor of f32 that is an input or output of the graph.
#[derive(Debug)]
pub struct ValueInfo {
    /// Name.
    pub name: String,
    /// Shape.
    pub dims: Vec<Dim>,
}

/// `TensorShapeProto.Dimension`: one dimension of a shape.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Dim {
    /// Fixed length.
    Fixed(usize),
    /// Any length, with a symbolic name.
    Free(String),
}

/// `StringStringEntryProto`: an entry of the metadata.
#[derive(Debug)]
pub struct Entry {
    /// Name.
    pub key: String,
    /// Value.
    pub value: String,
}

/// A message whose only field, of this number, is another message.
struct Wrapped<'a, T>(u32, &'a T);

impl<T: Encode> Encode for Wrapped<'_, T> {
    fn encode(&self, message: &mut Message) {
        message.message(self.0, self.1);
    }
}

/// `OperatorSetIdProto` of the default domain.
struct OperatorSet(i64);

impl Encode for OperatorSet {
    fn encode(&self, message: &mut Message) {
        message.string(1, "");
        message.integer(2, self.0);
    }
}

impl Encode for Model {
    fn encode(&self, message: &mut Message) {
        message.integer(1, self.ir_version);
        message.string(2, self.producer.0);
        message.string(3, self.producer.1);
        message.message(7, &self.graph);
        message.message(8, &OperatorSet(self.opset));
        message.messages(14, &self.metadata);
    }
}

impl Encode for Graph {
    fn encode(&self, message: &mut Message) {
        message.messages(1, &self.nodes);
        message.string(2, &self.name);
        message.messages(5, &self.initialisers);
        message.messages(11, &self.inputs);
        message.messages(12, &self.outputs);
    }
}

impl Encode for Node {
    fn encode(&self, message: &mut Message) {
        self.inputs.iter().for_each(|input| message.string(1, input));
        self.outputs.iter().for_each(|output| message.string(2, output));
        message.string(3, &self.name);
        message.string(4, self.operator);
        message.messages(5, &self.attributes);
    }
}

impl Encode for Attribute {
    fn encode(&self, message: &mut Message) {
        message.string(1, self.name);
        // Field 20 is the type of the value.
        match &self.value {
            AttributeValue::Integer(value) => {
                message.integer(3, *value);
                message.integer(20, 2);
            }
            AttributeValue::Text(value) => {
                message.string(4, value);
                message.integer(20, 3);
            }
            AttributeValue::Integers(values) => {
                values.iter().for_each(|&value| message.integer(8, value));
                message.integer(20, 7);
            }
        }
    }
}

impl TensorData {
    fn data_type(&self) -> DataType {
        match self {
            Self::Floats(_) => DataType::Float,
            Self::Integers(_) => DataType::Int64,
        }
    }

    fn little_endian(&self) -> Vec<u8> {
        match self {
            Self::Floats(values) => values.iter().flat_map(|value| value.to_le_bytes()).collect(),
            Self::Integers(values) => values.iter().flat_map(|value| value.to_le_bytes()).collect(),
        }
    }
}

impl Encode for Tensor {
    fn encode(&self, message: &mut Message) {
        self.dims.iter().for_each(|&dim| message.integer(1, dim as i64));
        message.integer(2, self.data.data_type() as i64);
        message.string(8, &self.name);
        message.bytes(9, &self.data.little_endian());
    }
}

/// `TypeProto.Tensor` of f32.
struct TensorType<'a>(&'a [Dim]);

impl Encode for TensorType<'_> {
    fn encode(&self, message: &mut Message) {
        message.integer(1, DataType::Float as i64);
        message.message(2, &Shape(self.0));
    }
}

/// `TensorShapeProto`: a list of dimensions.
struct Shape<'a>(&'a [Dim]);

impl Encode for Shape<'_> {
    fn encode(&self, message: &mut Message) {
        message.messages(1, self.0);
    }
}

impl Encode for Dim {
    fn encode(&self, message: &mut Message) {
        match self {
            Self::Fixed(value) => message.integer(1, *value as i64),
            Self::Free(name) => message.string(2, name),
        }
    }
}

impl Encode for ValueInfo {
    fn encode(&self, message: &mut Message) {
        message.string(1, &self.name);
        message.message(2, &Wrapped(1, &TensorType(&self.dims)));
    }
}

impl Encode for Entry {
    fn encode(&self, message: &mut Message) {
        message.string(1, &self.key);
        message.string(2, &self.value);
    }
}
