//! The surface of a window whose device makes pictures meanwhile.

use crate::screen::Screen;
use anyhow::{Result, bail};
use eframe::egui::Context;
use eframe::egui_wgpu::SurfaceConfig;
use eframe::wgpu;
use fovolnet::gpu::{Gpu, Pause};
use std::fmt;
use std::sync::{Arc, Mutex, PoisonError};

/// Frames in a row that may go wrong before a window gives up.
const TRIES: u32 = 20;

/// Gives a window its turn on a device that others use too.
///
/// A surface can be configured only while its device rests. A window that changes its size does so at once, and fails where
/// pictures are being made: the surface stays as it was, for one frame. For the next one the device is made to rest, and the
/// surface is configured again.
pub struct Surface {
    gpu: Gpu,
    fault: Arc<Mutex<Option<String>>>,
    pause: Option<Pause>,
    failed: u32,
}

impl Surface {
    /// That of the window of `context`, which `screen` is drawn by. What goes wrong with it is kept from now on, where wgpu
    /// would panic.
    pub fn of_window(screen: &Screen, context: &Context) -> Self {
        let gpu = screen.gpu().clone();
        let fault = Arc::<Mutex<Option<String>>>::default();
        let (kept, wake) = (Arc::clone(&fault), context.clone());
        // What goes wrong with pictures is caught where they are made.
        gpu.device().on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            *kept.lock().unwrap_or_else(PoisonError::into_inner) = Some(fovolnet::one_line(&error));
            wake.request_repaint();
        }));
        Self { gpu, fault, pause: None, failed: 0 }
    }

    /// Lets the device work again; to be called before anything of a frame.
    pub fn resume(&mut self) {
        self.pause = None;
    }

    /// Has the surface configured again before this frame is drawn if something went wrong with the last one; to be called
    /// after anything of a frame that may wait for the device.
    ///
    /// # Errors
    /// What goes wrong again and again.
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

/// The same configuration in other words: only what differs is configured.
fn other_words(config: SurfaceConfig) -> SurfaceConfig {
    /// What `None` stands for.
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
