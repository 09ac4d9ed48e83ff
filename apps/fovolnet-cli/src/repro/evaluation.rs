use super::data_set::DataSet;
use fovolnet::core::{CameraPath, FrameSize, Integration};
use fovolnet::{Density, Device, Guide, Machine, RenderSettings, Sampling, SpeedSettings};
use std::path::PathBuf;

/// Volumes, frames and machine of the evaluation.
#[derive(Clone)]
pub struct Evaluation {
    pub data_sets: Vec<DataSet>,
    pub frames: u32,
    pub size: FrameSize,
    pub speed: SpeedSettings,
    pub machine: Machine,
    /// Folder of the sections' folders.
    pub output: PathBuf,
    /// File with times of VTK.
    pub vtk: Option<PathBuf>,
    /// File with the results of training without parts of the method.
    pub ablations: Option<PathBuf>,
}

/// Sampling (P_b, σ) of the paper's figures.
pub const SPARSE: [f64; 2] = [0.03, 0.02];
/// Sampling (P_b, σ) of the paper's denser setting.
pub const DENSE: [f64; 2] = [0.07, 0.06];
/// Number of frames of the paper's fly-throughs.
pub const FLY_THROUGH: u32 = 500;

impl Evaluation {
    /// Frame numbers of a fly-through.
    pub fn flight(&self) -> impl Iterator<Item = u32> + use<> {
        let frames = self.frames;
        (0..frames).map(move |i| i * FLY_THROUGH / frames)
    }

    /// Settings of a fly-through of `data` with the sampling (P_b, σ).
    pub fn settings(&self, data: &DataSet, [pb, sigma]: [f64; 2]) -> RenderSettings {
        RenderSettings {
            size: self.size,
            camera: CameraPath::Flythrough.into(),
            transfer_function: data.transfer.clone(),
            sampling: Sampling::Compact,
            pb,
            sigma,
            // The paper marches separate samples.
            integration: Integration::Plain,
            // The paper reconstructs colours.
            guide: Guide::None.into(),
            density: Density::Fixed.into(),
            ..RenderSettings::default()
        }
    }

    /// The evaluation on each device, with a suffix for names of files: on the requested device, or by default on the
    /// best GPU and then on the CPU.
    pub fn on_each_device(&self) -> Vec<(&'static str, Self)> {
        let mut each = vec![("", self.clone())];
        let any = matches!(self.speed.device, None | Some(Device::Auto));
        if any && self.machine.gpu.is_some() {
            let speed = SpeedSettings { device: Some(Device::Cpu), ..self.speed.clone() };
            let machine = Machine { gpu: None, ..self.machine.clone() };
            each.push(("_cpu", Self { speed, machine, ..self.clone() }));
        }
        each
    }

    /// Name of the device that renders.
    pub fn device(&self) -> &str {
        self.machine.gpu.as_deref().unwrap_or(&self.machine.cpu)
    }

    /// Data set of a figure of the paper: the one whose name begins with `name`, else the first.
    pub fn shown(&self, name: &str) -> &DataSet {
        self.data_sets.iter().find(|data| data.name.starts_with(name)).unwrap_or(&self.data_sets[0])
    }
}
