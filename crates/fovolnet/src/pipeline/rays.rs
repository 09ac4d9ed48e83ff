use crate::{OpenDevice, Result};
use fovol_core::{Camera, FrameSize, SampleList, Scene};
use fovol_render::cpu::{RenderOptions, Renderer};
#[cfg(feature = "gpu")]
use fovol_render::gpu;
use fovol_render::scene::RayResult;

/// Marches single rays of a scene on the CPU or a GPU, and returns their full results instead of a picture.
///
/// ```
/// use fovolnet::core::{CameraPath, FrameSize, Pixel, SampleList};
/// use fovolnet::{OpenDevice, Rays, RenderSettings, VolumeSettings, open_volume, scene};
///
/// let volume = open_volume("head", &VolumeSettings { dims: Some([24; 3]), ..Default::default() })?;
/// let size = FrameSize::new(64, 48)?;
/// let mut rays = Rays::new(&scene(&volume, &RenderSettings::default())?, size, &OpenDevice::Cpu)?;
/// let list = SampleList::new(size, vec![Pixel { x: 32, y: 24 }]);
/// let marched = rays.march(&CameraPath::Orbit.camera(0), &list)?;
/// assert!(marched[0].depth > 0.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Rays(Place);

#[derive(Debug)]
enum Place {
    Cpu(Box<Renderer>),
    #[cfg(feature = "gpu")]
    Gpu(Box<gpu::Renderer>, Box<gpu::FrameBuffers>),
}

impl Rays {
    /// Prepares `scene` for rays of frames of `size`.
    ///
    /// # Errors
    /// Invalid numbers in the scene; a volume or a size that the GPU does not support.
    pub fn new(scene: &Scene, size: FrameSize, device: &OpenDevice) -> Result<Self> {
        #[cfg(not(feature = "gpu"))]
        let _ = size;
        Ok(Self(match device {
            OpenDevice::Cpu => Place::Cpu(Box::new(Renderer::new(scene, RenderOptions::default())?)),
            #[cfg(feature = "gpu")]
            OpenDevice::Gpu(gpu) => {
                let renderer = gpu::Renderer::new(gpu, scene)?;
                let buffers = renderer.frame_buffers(size)?;
                Place::Gpu(Box::new(renderer), Box::new(buffers))
            }
        }))
    }

    /// Name of the GPU that marches the rays, if one does.
    pub fn gpu_name(&self) -> Option<String> {
        match &self.0 {
            Place::Cpu(_) => None,
            #[cfg(feature = "gpu")]
            Place::Gpu(renderer, _) => Some(renderer.gpu().info().name),
        }
    }

    /// Marches the pixels of `list`; results are in list order.
    ///
    /// # Errors
    /// A list for frames of another size, a lost GPU.
    pub fn march(&mut self, camera: &Camera, list: &SampleList) -> Result<Vec<RayResult>> {
        match &mut self.0 {
            Place::Cpu(renderer) => Ok(renderer.march_list(camera, list).0),
            #[cfg(feature = "gpu")]
            Place::Gpu(renderer, buffers) => {
                renderer.render(buffers, camera, gpu::Sampling::List(list))?;
                Ok(buffers.read_samples()?)
            }
        }
    }
}
