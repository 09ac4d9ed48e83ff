use crate::{Device, Machine, Result};
use fovol_render::Filtering;
use fovol_render::cpu::{Simd, best_simd};

/// Settings that change the speed of rendering, not the picture.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct SpeedSettings {
    /// Number of threads [default: all cores]
    #[cfg_attr(feature = "clap", arg(long, value_name = "N"))]
    pub threads: Option<usize>,
    /// Device that computes the frames: auto, cpu, gpu, or gpu:NAME [default: auto]
    #[cfg_attr(feature = "clap", arg(long, value_name = "DEVICE"))]
    pub device: Option<Device>,
    /// Instruction set of the ray marcher, if it is another than that of the process ([`Simd::best`]).
    #[cfg_attr(feature = "clap", arg(skip))]
    pub simd: Option<Simd>,
    /// How a GPU interpolates voxels: exact, like a CPU, or hardware, by its samplers in steps of 1/256 [default:
    /// exact]
    #[cfg_attr(feature = "clap", arg(long, value_name = "HOW"))]
    pub filtering: Option<Filtering>,
    /// March through empty space instead of skipping it
    #[cfg_attr(feature = "clap", arg(long))]
    pub no_skip: bool,
}

impl SpeedSettings {
    /// Describes this machine as these settings use it.
    ///
    /// # Errors
    /// A requested GPU that cannot be used.
    pub fn machine(&self) -> Result<Machine> {
        let threads = self.threads.unwrap_or_else(rayon::current_num_threads);
        let machine = Machine::this(threads, self.simd());
        Ok(Machine { gpu: self.device().open()?.gpu_name(), ..machine })
    }

    /// Device to render on.
    pub fn device(&self) -> Device {
        self.device.clone().unwrap_or_default()
    }

    /// Instruction set of the ray marcher.
    pub fn simd(&self) -> Simd {
        self.simd.unwrap_or_else(best_simd)
    }
}
