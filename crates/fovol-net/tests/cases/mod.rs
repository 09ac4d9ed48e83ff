//! Reads reference cases of whole networks, which `tests/reference/network/make_cases.py` made with PyTorch in
//! double precision.

use fovol_core::{Frame, FrameSize};
use safetensors::SafeTensors;
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// Inputs and outputs of a network, frame by frame.
pub struct Case {
    bytes: Vec<u8>,
    pub facts: HashMap<String, String>,
}

impl Case {
    pub fn read(path: &Path) -> Self {
        let bytes = std::fs::read(path).unwrap();
        let (_, header) = SafeTensors::read_metadata(&bytes).unwrap();
        let facts = header.metadata().clone().unwrap_or_default();
        Self { bytes, facts }
    }

    pub fn number(&self, key: &str) -> u32 {
        self.facts[key].parse().unwrap()
    }

    /// Returns an array, if the case has it.
    pub fn values(&self, name: &str) -> Option<Vec<f32>> {
        let file = SafeTensors::deserialize(&self.bytes).unwrap();
        let view = file.tensor(name).ok()?;
        Some(view.data().chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect())
    }
}

/// Lists the files of all cases.
pub fn cases() -> Vec<PathBuf> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/reference");
    let files = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut cases: Vec<PathBuf> = files
        .filter(|path| path.file_stem().is_some_and(|stem| stem.to_string_lossy().contains('x')))
        .collect();
    cases.retain(|path| path.extension().is_some_and(|e| e == "safetensors"));
    cases.sort();
    cases
}

/// Makes a frame of planes \[3\]\[rows\]\[columns\] and a mask.
pub fn frame(size: FrameSize, planes: &[f32], mask: &[f32]) -> Frame {
    let n = size.pixels();
    let pixels = (0..n).map(|i| [planes[i], planes[n + i], planes[2 * n + i], mask[i]]).collect();
    Frame::from_pixels(size, pixels).unwrap()
}

/// Largest difference, relative to the largest expected value.
pub fn difference(found: &[f32], expected: &[f32]) -> f32 {
    assert_eq!(found.len(), expected.len());
    let most = expected.iter().fold(1e-6f32, |most, v| most.max(v.abs()));
    found.iter().zip(expected).fold(0.0f32, |worst, (a, b)| worst.max((a - b).abs())) / most
}
