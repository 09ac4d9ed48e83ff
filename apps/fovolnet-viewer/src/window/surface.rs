//! Surface of a window whose device also makes pictures.

use crate::window::screen::Screen;
use anyhow::{Result, bail};
use eframe::egui::Context;
use eframe::egui_wgpu::SurfaceConfig;
use eframe::wgpu;
use fovolnet::gpu::{Gpu, Pause};
use std::fmt;
use std::sync::{Arc, Mutex, PoisonError};

/// Consecutive failing frames before the window gives up.
const TRIES: u32 = 20;

/// Gives a window access to a shared device.
///
/// A surface can only be configured while its device is idle. A resized window does so immediately, and fails if
/// pictures are being made. Then the surface keeps its old configuration for one frame. Before the next one,
/// rendering is paused and the surface configured again.
pub struct Surface {
    gpu: Gpu,
    fault: Arc<Mutex<Option<String>>>,
    pause: Option<Pause>,
    failed: u32,
}

impl Surface {
    /// Surface of the window of `context`, drawn by `screen`. From now on device errors are recorded; without this,
    /// wgpu would panic.
    pub fn of_window(screen: &Screen, context: &Context) -> Self {
        let gpu = screen.gpu().clone();
        let fault = Arc::<Mutex<Option<String>>>::default();
        let (kept, wake) = (Arc::clone(&fault), context.clone());
        // Errors in making pictures are caught there.
        gpu.device().on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            *kept.lock().unwrap_or_else(PoisonError::into_inner) = Some(fovolnet::one_line(&error));
            wake.request_repaint();
        }));
        Self { gpu, fault, pause: None, failed: 0 }
    }

    /// Lets the device work again; call before everything else in a frame.
    pub fn resume(&mut self) {
        self.pause = None;
    }

    /// Configures the surface again if the last frame failed. Call after everything in a frame that may wait for the
    /// device.
    ///
    /// # Errors
    /// The surface failed too often in a row.
    pub fn mend(&mut self, frame: &mut eframe::Frame, context: &Context) -> Result<()> {
        let fault = self.fault.lock().unwrap_or_else(PoisonError::into_inner).take();
        let (Some(fault), Some(config)) = (fault, frame.wgpu_surface_config()) else {
            self.failed = 0;
            return Ok(());
        };
        self.failed += 1;
        if self.failed > TRIES {
            bail!("the window cannot be drawn any more: {fault}");
        }
        self.pause = Some(self.gpu.pause());
        frame.set_wgpu_surface_config(other_words(config));
        context.request_repaint();
        Ok(())
    }
}

/// An equivalent but unequal configuration, since equal ones are not applied.
fn other_words(config: SurfaceConfig) -> SurfaceConfig {
    /// Latency that `None` stands for.
    const DEFAULT: u32 = 2;
    let desired_maximum_frame_latency = match config.desired_maximum_frame_latency {
        None => Some(DEFAULT),
        Some(_) => None,
    };
    SurfaceConfig { desired_maximum_frame_latency, ..config }
}

impl fmt::Debug for Surface {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Surface").field("gpu", &self.gpu).finish_non_exhaustive()
    }
}
