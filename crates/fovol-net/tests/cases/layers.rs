//! Reads reference cases of single layers, which `tests/reference/network/make_cases.py` made with PyTorch in double
//! precision. The tests of the CPU engine and those of the trainer include this file.

use super::{Activation, Normalisation, Resize, Taps};
use safetensors::SafeTensors;
use serde_json::Value;

/// One layer: its description, inputs, weights and output.
pub struct Case<'a> {
    /// Name of the case.
    pub name: &'a str,
    /// Description: kind, sizes and so on.
    pub facts: &'a Value,
    file: &'a SafeTensors<'a>,
}

impl Case<'_> {
    /// Shape and values of a part: `in0`, `in1`…, `weight`, `bias` or `out`.
    pub fn values(&self, part: &str) -> Option<(Vec<usize>, Vec<f32>)> {
        let view = self.file.tensor(&format!("{}.{part}", self.name)).ok()?;
        let bytes = view.data().chunks_exact(4);
        Some((view.shape().to_vec(), bytes.map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect()))
    }

    pub fn word(&self, key: &str) -> &str {
        self.facts[key].as_str().unwrap()
    }

    pub fn number(&self, key: &str) -> usize {
        self.facts[key].as_u64().unwrap() as usize
    }

    pub fn activation(&self) -> Activation {
        match self.word("activation") {
            "none" => Activation::None,
            "relu" => Activation::Relu,
            "elu" => Activation::Elu,
            other => panic!("{other}"),
        }
    }

    pub fn normalisation(&self) -> Normalisation {
        if self.word("normalisation") == "squared" { Normalisation::Squared } else { Normalisation::Softmax }
    }

    /// How a convolution reads its inputs.
    pub fn resizes(&self) -> Vec<Resize> {
        self.list("resizes").iter().map(resize).collect()
    }

    /// How a filter reads and weighs its images.
    pub fn images(&self) -> Vec<(Resize, Taps)> {
        let taps = |word: &Value| if word == "around" { Taps::Around } else { Taps::Centre };
        self.list("images").iter().map(|pair| (resize(&pair[0]), taps(&pair[1]))).collect()
    }

    fn list(&self, key: &str) -> &[Value] {
        self.facts[key].as_array().unwrap()
    }
}

fn resize(word: &Value) -> Resize {
    match word.as_str() {
        Some("same") => Resize::Same,
        Some("bilinear") => Resize::Bilinear,
        Some("nearest") => Resize::Nearest,
        other => panic!("{other:?}"),
    }
}

/// Calls `check` with every case of `tests/reference/layers.safetensors`.
pub fn each_case(mut check: impl FnMut(&Case<'_>)) {
    let bytes = include_bytes!("../reference/layers.safetensors");
    let file = SafeTensors::deserialize(bytes).unwrap();
    let (_, header) = SafeTensors::read_metadata(bytes).unwrap();
    let layers = header.metadata().clone().unwrap();
    assert!(layers.len() > 30);
    for (name, facts) in &layers {
        let facts = serde_json::from_str(facts).unwrap();
        check(&Case { name, facts: &facts, file: &file });
    }
}
