//! Choice of the device that renders.

use crate::Result;
#[cfg(feature = "gpu")]
use fovol_gpu::{AdapterRequest, Gpu, GpuError};
use std::fmt;
use std::str::FromStr;

/// Device to render on, as requested.
#[derive(Debug, Clone, PartialEq, Eq, Default, Hash)]
pub enum Device {
    /// A GPU if there is one, else the CPU. Never a software implementation of a GPU.
    #[default]
    Auto,
    /// The CPU.
    Cpu,
    /// The fastest GPU, or the first whose name contains the text. Software implementations count only if named, or if
    /// there is nothing else.
    Gpu(Option<String>),
}

/// Opened device.
#[derive(Debug, Clone, Default)]
pub enum OpenDevice {
    /// The CPU.
    #[default]
    Cpu,
    /// A GPU.
    #[cfg(feature = "gpu")]
    Gpu(Gpu),
}

impl Device {
    /// Opens the device. For [`Self::Auto`] that is the CPU if no GPU is found.
    ///
    /// # Errors
    /// A requested GPU that does not exist or cannot be opened.
    #[cfg(feature = "gpu")]
    pub fn open(&self) -> Result<OpenDevice> {
        let Some(request) = self.request() else { return Ok(OpenDevice::Cpu) };
        match Gpu::open(&request) {
            Ok(gpu) => Ok(OpenDevice::Gpu(gpu)),
            Err(error @ GpuError::Checks(_)) => Err(error.into()),
            Err(_) if *self == Self::Auto && request == AdapterRequest::Hardware => Ok(OpenDevice::Cpu),
            Err(error) => Err(error.into()),
        }
    }

    /// Request for a GPU adapter; `None` for the CPU.
    #[cfg(feature = "gpu")]
    pub fn request(&self) -> Option<AdapterRequest> {
        match self {
            Self::Cpu => None,
            Self::Auto => Some(AdapterRequest::Hardware.or_environment()),
            Self::Gpu(None) => Some(AdapterRequest::Any.or_environment()),
            Self::Gpu(Some(name)) => Some(AdapterRequest::Named(name.clone())),
        }
    }

    /// Opens the CPU: this program was built without support for GPUs.
    ///
    /// # Errors
    /// A GPU was requested.
    #[cfg(not(feature = "gpu"))]
    pub fn open(&self) -> Result<OpenDevice> {
        match self {
            Self::Auto | Self::Cpu => Ok(OpenDevice::Cpu),
            Self::Gpu(_) => Err(crate::Error::Setting(
                "this program was built without graphics processors; build it with the feature `gpu`, or use \
                 --device cpu"
                    .into(),
            )),
        }
    }
}

impl OpenDevice {
    /// Name of the GPU; `None` for the CPU.
    pub fn gpu_name(&self) -> Option<String> {
        match self {
            Self::Cpu => None,
            #[cfg(feature = "gpu")]
            Self::Gpu(gpu) => Some(gpu.info().name),
        }
    }
}

impl FromStr for Device {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        match (text, text.strip_prefix("gpu:").map(str::trim)) {
            ("auto", _) => Ok(Self::Auto),
            ("cpu", _) => Ok(Self::Cpu),
            ("gpu", _) => Ok(Self::Gpu(None)),
            (_, Some(name)) if !name.is_empty() => Ok(Self::Gpu(Some(name.into()))),
            _ => Err(format!("`{text}` is no device; use auto, cpu, gpu, or gpu:NAME as in gpu:nvidia")),
        }
    }
}

impl fmt::Display for Device {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Auto => f.write_str("auto"),
            Self::Cpu => f.write_str("cpu"),
            Self::Gpu(None) => f.write_str("gpu"),
            Self::Gpu(Some(name)) => write!(f, "gpu:{name}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn devices_read_as_they_print() {
        for text in ["auto", "cpu", "gpu", "gpu:nvidia", "gpu:Radeon RX"] {
            assert_eq!(text.parse::<Device>().unwrap().to_string(), text);
        }
        for bad in ["", "gpu:", "gpu: ", "cuda", "CPU", "nvidia"] {
            assert!(bad.parse::<Device>().unwrap_err().contains("use auto, cpu"), "{bad}");
        }
    }
}
