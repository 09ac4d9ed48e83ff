use super::Arrangement;
use crate::{Error, Result};
use fovolnet::io::atomic;
use safetensors::SafeTensors;
use safetensors::tensor::{Dtype, TensorView};
use std::collections::HashMap;
use std::fs;
use std::path::{Path, PathBuf};
use tch::{Device, Kind, Tensor};

/// Everything that a resumed run needs.
pub(super) struct Checkpoint {
    /// Steps done.
    pub step: u64,
    /// Hours of training so far.
    pub hours: f64,
    /// How threads shared the steps. Older checkpoints do not have it.
    pub arrangement: Option<Arrangement>,
    /// Weights and states of the optimiser and the average; f32 or i64.
    pub tensors: Vec<(String, Tensor)>,
}

impl Checkpoint {
    /// Path of the checkpoint of a run in `folder`.
    pub fn path(folder: &Path) -> PathBuf {
        folder.join("checkpoint.safetensors")
    }

    /// Writes the checkpoint atomically: the file is complete or absent.
    pub fn write(&self, folder: &Path) -> Result<()> {
        let path = Self::path(folder);
        let packed: Vec<(String, Dtype, Vec<usize>, Vec<u8>)> = self
            .tensors
            .iter()
            .map(|(name, tensor)| {
                let shape = tensor.size().iter().map(|&side| side as usize).collect();
                let (dtype, bytes) = bytes_of(tensor);
                (name.clone(), dtype, shape, bytes)
            })
            .collect();
        let views: Vec<(&str, TensorView<'_>)> = packed
            .iter()
            .map(|(name, dtype, shape, bytes)| {
                Ok((name.as_str(), TensorView::new(*dtype, shape.clone(), bytes)?))
            })
            .collect::<std::result::Result<_, safetensors::SafeTensorError>>()
            .map_err(|e| Error::Saved(e.to_string()))?;
        let facts = [("step", self.step.to_string()), ("hours", self.hours.to_string())];
        let arrangement = self.arrangement.map(|arrangement| ("arrangement", arrangement.to_string()));
        let facts = facts.into_iter().chain(arrangement);
        let facts: HashMap<String, String> = facts.map(|(name, value)| (name.into(), value)).collect();
        let bytes = safetensors::serialize(views, Some(facts)).map_err(|e| Error::Saved(e.to_string()))?;
        Ok(atomic::write_bytes(&path, &bytes)?)
    }

    /// Reads the checkpoint of the run in `folder`.
    pub fn read(folder: &Path) -> Result<Self> {
        let path = Self::path(folder);
        let bytes = fs::read(&path).map_err(|e| Error::file("read", &path, &e))?;
        let broken =
            |why: String| Error::Saved(format!("{}: {why}; begin again without --resume", path.display()));
        let (_, metadata) = SafeTensors::read_metadata(&bytes).map_err(|e| broken(e.to_string()))?;
        let told = |name: &str| metadata.metadata().as_ref().and_then(|facts| facts.get(name)).cloned();
        let fact = |name: &str| -> Result<String> {
            told(name).ok_or_else(|| broken(format!("it does not say its {name}")))
        };
        let step = fact("step")?.parse().map_err(|_| broken("its step is no number".into()))?;
        let hours = fact("hours")?.parse().map_err(|_| broken("its hours are no number".into()))?;
        let arrangement = told("arrangement").map(|text| text.parse());
        let arrangement = arrangement.transpose().map_err(broken)?;
        let tensors = SafeTensors::deserialize(&bytes).map_err(|e| broken(e.to_string()))?;
        let tensors = tensors.tensors().into_iter().map(|(name, view)| (name, tensor_of(&view))).collect();
        Ok(Self { step, hours, arrangement, tensors })
    }
}

fn bytes_of(tensor: &Tensor) -> (Dtype, Vec<u8>) {
    let flat = tensor.detach().to_device(Device::Cpu).contiguous().view([-1]);
    if tensor.kind() == Kind::Int64 {
        let mut values = vec![0i64; flat.numel()];
        flat.copy_data(&mut values, flat.numel());
        return (Dtype::I64, values.iter().flat_map(|v| v.to_le_bytes()).collect());
    }
    let flat = flat.to_kind(Kind::Float);
    let mut values = vec![0f32; flat.numel()];
    flat.copy_data(&mut values, flat.numel());
    (Dtype::F32, values.iter().flat_map(|v| v.to_le_bytes()).collect())
}

fn tensor_of(view: &TensorView<'_>) -> Tensor {
    let shape: Vec<i64> = view.shape().iter().map(|&side| side as i64).collect();
    let kind = if view.dtype() == Dtype::I64 { Kind::Int64 } else { Kind::Float };
    Tensor::from_data_size(view.data(), &shape, kind)
}
