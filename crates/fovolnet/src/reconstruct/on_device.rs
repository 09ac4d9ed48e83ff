//! Reconstructions that run on a device.

use crate::{Guide, Reconstruction, RenderSettings, Sampling};
use fovol_net::gpu::Precision;
use fovol_net::{Fill, cpu};

/// Whether `settings` ask for a reconstruction that runs on the device.
pub fn reconstructs(settings: &RenderSettings) -> bool {
    // Frames with every pixel marched need no reconstruction. Guides with cached shadows are made on the CPU.
    settings.sampling != Sampling::Full
        && settings.guide_kind() != Guide::Cached
        && match settings.reconstruction {
            Reconstruction::None | Reconstruction::Fill(Fill::Linear) => false,
            Reconstruction::Fill(Fill::PullPush) => true,
            Reconstruction::WNet | Reconstruction::DeepFovea => device_precision(settings).is_some(),
        }
}

/// Precision of networks on the device; `None` if `settings` ask for one that only CPUs have.
pub fn device_precision(settings: &RenderSettings) -> Option<Precision> {
    match settings.precision {
        cpu::Precision::Auto => Some(Precision::Auto),
        cpu::Precision::F32 => Some(Precision::F32),
        cpu::Precision::F16 => Some(Precision::F16),
        cpu::Precision::Bf16 | cpu::Precision::Int8 | cpu::Precision::Mixed => None,
    }
}
