//! The messages of ONNX files that exports use; numbers of fields are those of `onnx.proto`.

use super::protobuf::{Encode, Message};

/// `ModelProto`: the whole file.
#[derive(Debug)]
pub struct Model {
    /// The version of the file format.
    pub ir_version: i64,
    /// The version of the operators.
    pub opset: i64,
    /// What wrote it.
    pub producer: (&'static str, &'static str),
    /// What it computes.
    pub graph: Graph,
    /// Facts by name.
    pub metadata: Vec<Entry>,
}

/// `GraphProto`: nodes in the order of their execution.
#[derive(Debug, Default)]
pub struct Graph {
    /// What it is called.
    pub name: String,
    /// The operations.
    pub nodes: Vec<Node>,
    /// Constant tensors.
    pub initialisers: Vec<Tensor>,
    /// What is given.
    pub inputs: Vec<ValueInfo>,
    /// What results.
    pub outputs: Vec<ValueInfo>,
}

/// `NodeProto`: an operator that is applied to values.
#[derive(Debug)]
pub struct Node {
    /// What it is called.
    pub name: String,
    /// The operator.
    pub operator: &'static str,
    /// Values that it reads; empty names stand for what is left out.
    pub inputs: Vec<String>,
    /// Values that it writes.
    pub outputs: Vec<String>,
    /// What is fixed about it.
    pub attributes: Vec<Attribute>,
}

/// `AttributeProto`.
#[derive(Debug)]
pub struct Attribute {
    /// Its name.
    pub name: &'static str,
    /// Its value.
    pub value: AttributeValue,
}

/// The value of an [`Attribute`].
#[derive(Debug)]
pub enum AttributeValue {
    /// A number.
    Integer(i64),
    /// A word.
    Text(&'static str),
    /// Several numbers.
    Integers(Vec<i64>),
}

/// `TensorProto`.
#[derive(Debug)]
pub struct Tensor {
    /// The value that it gives.
    pub name: String,
    /// Its shape; empty for a scalar.
    pub dims: Vec<usize>,
    /// Its numbers.
    pub data: TensorData,
}

/// The numbers of a [`Tensor`].
#[derive(Debug, Clone, PartialEq)]
pub enum TensorData {
    /// f32.
    Floats(Vec<f32>),
    /// i64, for shapes and indices.
    Integers(Vec<i64>),
}

/// `TensorProto.DataType`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DataType {
    /// f32.
    Float = 1,
    /// i64.
    Int64 = 7,
}

/// `ValueInfoProto`: a tensor of f32 that goes in or out.
#[derive(Debug)]
pub struct ValueInfo {
    /// Its name.
    pub name: String,
    /// Its shape.
    pub dims: Vec<Dim>,
}

/// `TensorShapeProto.Dimension`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Dim {
    /// Always this.
    Fixed(usize),
    /// Whatever is given, by name.
    Free(String),
}

/// `StringStringEntryProto`.
#[derive(Debug)]
pub struct Entry {
    /// Its name.
    pub key: String,
    /// Its value.
    pub value: String,
}

/// A message whose only field is another.
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
        // Field 20 is the kind of the value.
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

/// `TensorShapeProto`.
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
