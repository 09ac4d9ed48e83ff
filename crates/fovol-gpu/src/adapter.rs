//! Chooses and opens a GPU.

use crate::checks::Checks;
use crate::matrices::Matrices;
use crate::{Gpu, GpuError, Result};
use std::str::FromStr;

/// Environment variable that names an adapter where no flag does.
pub const ADAPTER_VARIABLE: &str = "FOVOLNET_GPU";

/// Optional features. A device is opened with those of them that its adapter offers.
const WELCOME: wgpu::Features = wgpu::Features::TIMESTAMP_QUERY
    .union(wgpu::Features::SHADER_F16)
    .union(wgpu::Features::SUBGROUP)
    .union(wgpu::Features::TEXTURE_FORMAT_16BIT_NORM)
    .union(wgpu::Features::FLOAT32_FILTERABLE)
    .union(wgpu::Features::PIPELINE_CACHE);

/// Choice of the adapter to open.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum AdapterRequest {
    /// The fastest GPU, never a software rasteriser.
    #[default]
    Hardware,
    /// The fastest GPU, or a software rasteriser where there is none; see [`Gpu::is_software`].
    Any,
    /// The fastest adapter whose name contains this text, case ignored. It may be a software rasteriser.
    Named(String),
}

impl FromStr for AdapterRequest {
    type Err = String;

    /// Parses `auto`, `gpu` or `gpu:NAME`, the values of `--device` that may mean a GPU.
    fn from_str(text: &str) -> std::result::Result<Self, String> {
        match text.split_once(':') {
            None if text == "auto" => Ok(Self::Hardware),
            None if text == "gpu" => Ok(Self::Any),
            Some(("gpu", name)) if !name.trim().is_empty() => Ok(Self::Named(name.trim().into())),
            _ => Err(format!("`{text}` is no GPU; use auto, gpu or gpu:NAME, as in gpu:nvidia")),
        }
    }
}

impl AdapterRequest {
    /// Returns this request, or the adapter that [`ADAPTER_VARIABLE`] names if this request names none.
    #[must_use]
    pub fn or_environment(self) -> Self {
        match std::env::var(ADAPTER_VARIABLE) {
            Ok(name) if !matches!(self, Self::Named(_)) && !name.trim().is_empty() => {
                Self::Named(name.trim().into())
            }
            _ => self,
        }
    }

    /// Returns the index of the best of `adapters` for this request. The first of equals wins.
    pub fn best(&self, adapters: &[wgpu::AdapterInfo]) -> Option<usize> {
        let suits = |i: &usize| self.suits(&adapters[*i].name, adapters[*i].device_type);
        // `max_by_key` returns the last of several equal maxima, so the order is reversed.
        (0..adapters.len()).rev().filter(|i| suits(i).is_some()).max_by_key(suits)
    }

    /// Whether the adapter of `info` fits this request.
    pub fn takes(&self, info: &wgpu::AdapterInfo) -> bool {
        self.suits(&info.name, info.device_type).is_some()
    }

    /// Rates an adapter by name and kind: larger is better, `None` does not fit.
    fn suits(&self, name: &str, kind: wgpu::DeviceType) -> Option<u8> {
        let speed = match kind {
            wgpu::DeviceType::DiscreteGpu => 4,
            wgpu::DeviceType::IntegratedGpu => 3,
            wgpu::DeviceType::VirtualGpu => 2,
            wgpu::DeviceType::Other => 1,
            wgpu::DeviceType::Cpu => 0,
        };
        match self {
            Self::Hardware => (speed > 0).then_some(speed),
            Self::Any => Some(speed),
            Self::Named(part) => name.to_lowercase().contains(&part.to_lowercase()).then_some(speed),
        }
    }
}

/// Lists the adapters of this machine, each with the cooperative matrices that it offers.
pub fn adapters() -> Vec<(wgpu::AdapterInfo, Option<Matrices>)> {
    found(Checks::default()).iter().map(|adapter| (adapter.get_info(), Matrices::of(adapter))).collect()
}

fn found(checks: Checks) -> Vec<wgpu::Adapter> {
    let descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
    let instance =
        wgpu::Instance::new(wgpu::InstanceDescriptor { flags: checks.of_instance(), ..descriptor });
    pollster::block_on(instance.enumerate_adapters(wgpu::Backends::PRIMARY))
}

impl Gpu {
    /// Opens the adapter of `request`, with its full limits and all optional features, and the checks of the environment
    /// ([`CHECKS_VARIABLE`](crate::CHECKS_VARIABLE)).
    ///
    /// # Errors
    /// [`GpuError::NoAdapter`] where none fits; its message lists the adapters. [`GpuError::Refused`] where the driver
    /// does not open it. [`GpuError::Checks`] for checks that do not exist.
    pub fn open(request: &AdapterRequest) -> Result<Self> {
        Self::open_with(request, Checks::of_environment()?)
    }

    /// Opens a device as [`Self::open`] does, with these checks.
    ///
    /// # Errors
    /// Those of [`Self::open`].
    pub fn open_with(request: &AdapterRequest, checks: Checks) -> Result<Self> {
        let adapter = best(request, checks)?;
        let (device, queue) = opened(&adapter, &Self::descriptor(&adapter))?;
        Ok(Self::owned(device, queue).with_matrices(Matrices::wanted_of(&adapter)).with_checks(checks))
    }

    /// Opens the adapter of `request` with the limits that every implementation of WebGPU has, and without optional
    /// features, and with all checks. Tests show with it that these suffice.
    ///
    /// # Errors
    /// Those of [`Self::open`].
    pub fn open_baseline(request: &AdapterRequest) -> Result<Self> {
        let limits = wgpu::Limits::default();
        let descriptor = wgpu::DeviceDescriptor { required_limits: limits, ..Default::default() };
        let (device, queue) = opened(&best(request, Checks::ALL)?, &descriptor)?;
        Ok(Self::shared(device, queue).with_checks(Checks::ALL))
    }

    /// Describes the device that this program wants of `adapter`: full limits and all optional features. For
    /// callers that open a device themselves and lend it; see [`Self::lent`].
    pub fn descriptor(adapter: &wgpu::Adapter) -> wgpu::DeviceDescriptor<'static> {
        let matrices = Matrices::wanted_of(adapter);
        wgpu::DeviceDescriptor {
            label: Some("fovolnet"),
            required_features: adapter.features() & WELCOME | Matrices::features(matrices),
            required_limits: adapter.limits(),
            experimental_features: Matrices::experiments(matrices),
            ..Default::default()
        }
    }

    /// Wraps a device of `adapter` that the caller, such as a window, opened with [`Self::descriptor`].
    pub fn lent(adapter: &wgpu::Adapter, device: wgpu::Device, queue: wgpu::Queue) -> Self {
        Self::shared(device, queue).with_matrices(Matrices::wanted_of(adapter))
    }
}

/// Finds the best adapter for `request`.
fn best(request: &AdapterRequest, checks: Checks) -> Result<wgpu::Adapter> {
    let mut all = found(checks);
    let infos: Vec<wgpu::AdapterInfo> = all.iter().map(wgpu::Adapter::get_info).collect();
    let best = request.best(&infos).ok_or_else(|| nothing_suits(&infos))?;
    Ok(all.swap_remove(best))
}

fn opened(
    adapter: &wgpu::Adapter,
    descriptor: &wgpu::DeviceDescriptor<'_>,
) -> Result<(wgpu::Device, wgpu::Queue)> {
    pollster::block_on(adapter.request_device(descriptor))
        .map_err(|e| GpuError::refused("opening a device", &e.to_string()))
}

fn nothing_suits(all: &[wgpu::AdapterInfo]) -> GpuError {
    let names: Vec<String> = all
        .iter()
        .map(|info| match info.device_type {
            wgpu::DeviceType::Cpu => format!("{} (software)", info.name),
            _ => info.name.clone(),
        })
        .collect();
    let (found, mend) = match names.is_empty() {
        true => ("no adapter was found".into(), "install a Vulkan driver, or use --device cpu"),
        false => (format!("there is {}", names.join(", ")), "use --device gpu:NAME or --device cpu"),
    };
    GpuError::NoAdapter { found, mend }
}

#[cfg(test)]
mod tests {
    use super::*;
    use wgpu::DeviceType::{Cpu, DiscreteGpu, IntegratedGpu};

    #[test]
    fn requests_read_as_written() {
        assert_eq!("auto".parse(), Ok(AdapterRequest::Hardware));
        assert_eq!("gpu".parse(), Ok(AdapterRequest::Any));
        assert_eq!("gpu: Radeon".parse(), Ok(AdapterRequest::Named("Radeon".into())));
        for bad in ["cpu", "gpu:", "GPU", "", "nvidia"] {
            assert!(bad.parse::<AdapterRequest>().is_err(), "{bad}");
        }
    }

    #[test]
    fn software_is_never_taken_silently() {
        assert_eq!(AdapterRequest::Hardware.suits("llvmpipe", Cpu), None);
        assert_eq!(AdapterRequest::Any.suits("llvmpipe", Cpu), Some(0));
        assert_eq!(AdapterRequest::Named("LLVM".into()).suits("llvmpipe", Cpu), Some(0));
        assert_eq!(AdapterRequest::Named("radeon".into()).suits("llvmpipe", Cpu), None);
        let hardware = AdapterRequest::Hardware;
        assert!(hardware.suits("a", DiscreteGpu) > hardware.suits("b", IntegratedGpu));
    }

    #[test]
    fn an_adapter_that_is_not_there_is_an_error_that_says_what_is() {
        let error = Gpu::open(&AdapterRequest::Named("no such adapter".into())).unwrap_err();
        assert!(error.to_string().starts_with("no GPU can be used: "), "{error}");
    }
}
