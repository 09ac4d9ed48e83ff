use super::cpu::CpuMarcher;
#[cfg(feature = "gpu")]
use super::gpu::{GpuMarcher, reconstructs};
use super::sampled::{HostReconstruction, Sampled, Sampler};
use super::view::View;
#[cfg(feature = "gpu")]
use crate::Device;
use crate::{OpenDevice, RenderSettings, Result, SpeedSettings};
use fovol_core::{Camera, SampleList, Scene};
use fovol_render::cpu::{RenderOptions, best_simd};
use fovol_render::scene::RayResult;

/// Ray marcher on the CPU or the GPU.
#[derive(Debug)]
pub(super) enum Marcher {
    Cpu(Box<CpuMarcher>),
    #[cfg(feature = "gpu")]
    Gpu(Box<GpuMarcher>),
}

impl Marcher {
    /// Marcher on `device`, and notes for the user.
    pub fn new(
        device: &OpenDevice,
        scene: &Scene,
        settings: &RenderSettings,
        speed: &SpeedSettings,
    ) -> Result<(Self, Vec<String>)> {
        match device {
            OpenDevice::Cpu => Ok((Self::on_cpu(scene, settings, speed)?, Vec::new())),
            #[cfg(feature = "gpu")]
            OpenDevice::Gpu(gpu) => Self::on_gpu(gpu, scene, settings, speed),
        }
    }

    #[cfg(feature = "gpu")]
    fn on_gpu(
        gpu: &fovol_gpu::Gpu,
        scene: &Scene,
        settings: &RenderSettings,
        speed: &SpeedSettings,
    ) -> Result<(Self, Vec<String>)> {
        let is_required = matches!(speed.device, Some(Device::Gpu(_)));
        let slow = || {
            let name = gpu.info().name;
            format!(
                "{name} is a program on the processor, slower than --device cpu; it is good for tests only"
            )
        };
        match GpuMarcher::new(gpu, scene, settings, speed) {
            Err(error) if !is_required && error.is_of_gpu() => {
                let note = format!("rendering on the processor: {error}");
                Ok((Self::on_cpu(scene, settings, speed)?, vec![note]))
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
                Ok((Self::Gpu(Box::new(marcher)), notes))
            }
        }
    }

    fn on_cpu(scene: &Scene, settings: &RenderSettings, speed: &SpeedSettings) -> Result<Self> {
        let options =
            RenderOptions { simd: speed.simd.unwrap_or_else(best_simd), skip_empty: !speed.no_skip };
        Ok(Self::Cpu(Box::new(CpuMarcher::new(scene, options, Sampler::new(settings))?)))
    }

    pub fn gpu_name(&self) -> Option<String> {
        match self {
            Self::Cpu(_) => None,
            #[cfg(feature = "gpu")]
            Self::Gpu(marcher) => Some(marcher.gpu().info().name),
        }
    }

    /// Reconstruction on the host for `settings`; one that does nothing if the marcher reconstructs on the device.
    pub fn host_reconstruction(&self, settings: &RenderSettings) -> Result<HostReconstruction> {
        match self {
            Self::Cpu(_) => HostReconstruction::new(settings),
            #[cfg(feature = "gpu")]
            Self::Gpu(_) if reconstructs(settings) => Ok(HostReconstruction::nothing()),
            #[cfg(feature = "gpu")]
            Self::Gpu(_) => HostReconstruction::new(settings),
        }
    }

    /// Replaces the scene and the settings; the volume stays the same.
    pub fn change(
        &mut self,
        scene: &Scene,
        settings: &RenderSettings,
        reconstructs_alike: bool,
    ) -> Result<()> {
        #[cfg(not(feature = "gpu"))]
        let _ = reconstructs_alike;
        match self {
            Self::Cpu(marcher) => marcher.change(scene, settings),
            #[cfg(feature = "gpu")]
            Self::Gpu(marcher) => marcher.change(scene, settings, reconstructs_alike),
        }
    }

    pub fn march_list(&mut self, camera: &Camera, list: &SampleList) -> Result<Vec<RayResult>> {
        match self {
            Self::Cpu(marcher) => Ok(marcher.march_list(camera, list)),
            #[cfg(feature = "gpu")]
            Self::Gpu(marcher) => marcher.march_list(camera, list),
        }
    }

    pub fn reset(&mut self) {
        match self {
            Self::Cpu(_) => {}
            #[cfg(feature = "gpu")]
            Self::Gpu(marcher) => marcher.reset(),
        }
    }

    pub fn sample(&mut self, view: &View) -> Result<Sampled> {
        match self {
            Self::Cpu(marcher) => Ok(marcher.sample(view)),
            #[cfg(feature = "gpu")]
            Self::Gpu(marcher) => marcher.sample(view),
        }
    }
}
