//! Sharing of the window's graphics device with the renderer.

use eframe::egui::TextureId;
use eframe::egui::mutex::RwLock;
use eframe::egui_wgpu::{NativeAdapterSelectorMethod, RenderState, Renderer, WgpuConfiguration, WgpuSetup};
use eframe::wgpu;
use fovolnet::Device;
use fovolnet::gpu::{AdapterRequest, Checks, Gpu};
use std::fmt;
use std::sync::Arc;

/// Environment variable that forces sharing of the window's device with the renderer (`shared`) or separate devices
/// (`own`).
pub const SCREEN_VARIABLE: &str = "FOVOLNET_SCREEN";

/// Device shared by window and renderer, so that pictures never leave it. The window needs a
/// `Surface` of its own then.
///
/// Window and renderer wait for each other on a shared device. So only discrete cards are shared by default: their
/// frames are short, and copying through the host is slow for them. On other adapters the copy cannot be
/// avoided anyway.
#[derive(Clone)]
pub struct Screen {
    gpu: Gpu,
    renderer: Arc<RwLock<Renderer>>,
}

impl fmt::Debug for Screen {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Screen").field("gpu", &self.gpu).finish_non_exhaustive()
    }
}

impl Screen {
    /// Configures the window such that it may share its device: on the adapter of `device`, if that can draw the
    /// window. Dispatches have the check of `checks`.
    pub fn configure(device: &Device, checks: Checks, mut how: WgpuConfiguration) -> WgpuConfiguration {
        if let WgpuSetup::CreateNew(setup) = &mut how.wgpu_setup {
            setup.instance_descriptor.flags = checks.of_instance();
            setup.native_adapter_selector = Some(selector(device.request()));
            setup.device_descriptor = Arc::new(Gpu::descriptor);
        }
        how
    }

    /// Shared device of the window of `state`, if its adapter matches `device`. Shaders of pictures have these checks.
    pub fn of_window(state: &RenderState, device: &Device, checks: Checks) -> Option<Self> {
        let (request, info) = (device.request()?, state.adapter.get_info());
        let is_shared = match std::env::var(SCREEN_VARIABLE).as_deref() {
            Ok("shared") => true,
            Ok("own") => false,
            _ => info.device_type == wgpu::DeviceType::DiscreteGpu,
        };
        let gpu = Gpu::lent(&state.adapter, state.device.clone(), state.queue.clone());
        let gpu = gpu.with_checks(checks);
        (is_shared && request.takes(&info)).then(|| Self { gpu, renderer: Arc::clone(&state.renderer) })
    }

    /// The device.
    pub fn gpu(&self) -> &Gpu {
        &self.gpu
    }

    /// Registers `picture` for drawing, in place of `before`.
    pub fn show(&self, picture: &wgpu::Texture, before: Option<OnScreen>) -> OnScreen {
        let device = self.gpu.device();
        let view = picture.create_view(&wgpu::TextureViewDescriptor::default());
        let linear = wgpu::FilterMode::Linear;
        let mut renderer = self.renderer.write();
        match before {
            Some(shown) => {
                renderer.update_egui_texture_from_wgpu_texture(device, &view, linear, shown.id);
                shown
            }
            None => {
                let id = renderer.register_native_texture(device, &view, linear);
                OnScreen { id, renderer: Arc::clone(&self.renderer) }
            }
        }
    }
}

/// Selects the adapter for a window: the best of those `wanted`, else the best of all, that can draw on it.
fn selector(wanted: Option<AdapterRequest>) -> NativeAdapterSelectorMethod {
    Arc::new(move |adapters, surface| {
        let draws =
            |adapter: &&wgpu::Adapter| surface.is_none_or(|surface| adapter.is_surface_supported(surface));
        let able: Vec<&wgpu::Adapter> = adapters.iter().filter(draws).collect();
        let infos: Vec<wgpu::AdapterInfo> = able.iter().map(|adapter| adapter.get_info()).collect();
        let wanted = wanted.as_ref().and_then(|wanted| wanted.best(&infos));
        let best = wanted.or_else(|| AdapterRequest::Any.best(&infos));
        best.map(|i| able[i].clone()).ok_or_else(|| "no adapter can draw on this display".into())
    })
}

/// Picture in device memory that the window draws.
pub struct OnScreen {
    id: TextureId,
    renderer: Arc<RwLock<Renderer>>,
}

impl OnScreen {
    /// Texture id for drawing.
    pub fn id(&self) -> TextureId {
        self.id
    }
}

impl Drop for OnScreen {
    fn drop(&mut self) {
        self.renderer.write().free_texture(&self.id);
    }
}
