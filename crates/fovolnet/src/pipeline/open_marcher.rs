use super::cpu::CpuMarcher;
#[cfg(feature = "gpu")]
use super::gpu::GpuMarcher;
use super::marcher::Marcher;
use super::sampled::Sampler;
#[cfg(feature = "gpu")]
use crate::Device;
use crate::{OpenDevice, RenderSettings, Result, SpeedSettings};
use fovol_core::Scene;
use fovol_render::cpu::RenderOptions;

/// Opens the marcher of `scene` on `device`; also returns notes for the user.
pub fn open_marcher(
    device: &OpenDevice,
    scene: &Scene,
    settings: &RenderSettings,
    speed: &SpeedSettings,
) -> Result<(Box<dyn Marcher>, Vec<String>)> {
    match device {
        OpenDevice::Cpu => Ok((on_cpu(scene, settings, speed)?, Vec::new())),
        #[cfg(feature = "gpu")]
        OpenDevice::Gpu(gpu) => on_gpu(gpu, scene, settings, speed),
    }
}

fn on_cpu(scene: &Scene, settings: &RenderSettings, speed: &SpeedSettings) -> Result<Box<dyn Marcher>> {
    let options = RenderOptions { simd: speed.simd(), skip_empty: !speed.no_skip };
    Ok(Box::new(CpuMarcher::new(scene, options, Sampler::new(settings))?))
}

/// Opens the marcher on `gpu`, or on the CPU if the GPU fails and was not requested.
#[cfg(feature = "gpu")]
fn on_gpu(
    gpu: &fovol_gpu::Gpu,
    scene: &Scene,
    settings: &RenderSettings,
    speed: &SpeedSettings,
) -> Result<(Box<dyn Marcher>, Vec<String>)> {
    let is_required = matches!(speed.device, Some(Device::Gpu(_)));
    let slow = || {
        let name = gpu.info().name;
        format!("{name} is a program on the processor, slower than --device cpu; it is good for tests only")
    };
    match GpuMarcher::new(gpu, scene, settings, speed) {
        Err(error) if !is_required && error.is_of_gpu() => {
            let note = format!("rendering on the processor: {error}");
            Ok((on_cpu(scene, settings, speed)?, vec![note]))
        }
        marcher => {
            let marcher = marcher?;
            let mut notes: Vec<String> = gpu.is_software().then(slow).into_iter().collect();
            notes.extend(gpu.note().map(str::to_owned));
            if speed.filtering.is_some_and(|wanted| wanted != marcher.filtering()) {
                notes.push(format!(
                    "voxels are interpolated exactly: samplers of {} do not filter their type",
                    gpu.info().name
                ));
            }
            Ok((Box::new(marcher), notes))
        }
    }
}
