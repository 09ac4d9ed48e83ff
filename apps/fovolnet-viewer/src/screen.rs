//! The device that draws the window, where it makes the pictures too.

use eframe::egui::TextureId;
use eframe::egui::mutex::RwLock;
use eframe::egui_wgpu::{NativeAdapterSelectorMethod, RenderState, Renderer, WgpuConfiguration, WgpuSetup};
use eframe::wgpu;
use fovolnet::Device;
use fovolnet::gpu::{AdapterRequest, Gpu};
use std::fmt;
use std::sync::Arc;

/// The environment variable by which a window shares its device with the pictures (`shared`), or not (`own`).
pub const SCREEN_VARIABLE: &str = "FOVOLNET_SCREEN";

/// The device that draws the window and makes the pictures: these never leave it. The window needs a
/// [`Surface`](crate::surface::Surface) then.
///
/// Both wait for each other then. So only cards of their own are shared unless somebody says otherwise: they are done soon,
/// and the way through the host, which other adapters have before them anyway, is long for them.
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
    /// How a window is opened so that it may share its device: on the adapter of `device` where that can draw it.
    pub fn configure(device: &Device, mut how: WgpuConfiguration) -> WgpuConfiguration {
        if let WgpuSetup::CreateNew(setup) = &mut how.wgpu_setup {
            setup.native_adapter_selector = Some(selector(device.request()));
            setup.device_descriptor = Arc::new(Gpu::descriptor);
        }
        how
    }

    /// What the window of `state` shares, if it is drawn by what `device` means.
    pub fn of_window(state: &RenderState, device: &Device) -> Option<Self> {
        let (request, info) = (device.request()?, state.adapter.get_info());
        let is_shared = match std::env::var(SCREEN_VARIABLE).as_deref() {
            Ok("shared") => true,
            Ok("own") => false,
            _ => info.device_type == wgpu::DeviceType::DiscreteGpu,
        };
        let gpu = Gpu::lent(&state.adapter, state.device.clone(), state.queue.clone());
        (is_shared && request.takes(&info)).then(|| Self { gpu, renderer: Arc::clone(&state.renderer) })
    }

    /// The device.
    pub fn gpu(&self) -> &Gpu {
        &self.gpu
    }

    /// Shows `picture`, in place of what is shown by `before`.
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

/// The adapter for a window: of what is `wanted`, else of any, the best that can draw on it.
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

/// A picture of the device that the window draws.
pub struct OnScreen {
    id: TextureId,
    renderer: Arc<RwLock<Renderer>>,
}

impl OnScreen {
    /// What it is drawn by.
    pub fn id(&self) -> TextureId {
        self.id
    }
}

impl Drop for OnScreen {
    fn drop(&mut self) {
        self.renderer.write().free_texture(&self.id);
    }
}
