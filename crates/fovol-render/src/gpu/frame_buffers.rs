use super::adaptive_mask::{AdaptiveBuffers, DeviceImportance};
use super::buffers::{Buffers, Extent, Groups, blocks};
use super::error::{Error, Result};
use super::list_buffers::{ListBuffers, ListLength};
use super::march_tuner::PlayedMarch;
use super::mask::MaskPass;
use super::mask_limits::{Limits, MaskSettings, MaskSource};
use super::stage::Stage;
use super::stages::Stages;
use super::texture::write_slices;
use super::view::{NoiseNumbers, View};
use crate::cpu::FewShadowRays;
use crate::scene::{RayResult, Segments};
use fovol_core::{Fovea, Frame, FrameSize, Pixel, RayBasis, SampleList, SampleMask};
use fovol_gpu::Gpu;
use fovol_gpu::GpuError;
use fovol_gpu::read;
use fovol_gpu::{PassTime, Timing};
use std::fmt;

/// Buffers on the device for frames of one size: mask, list, samples and the sparse frame.
///
/// Made by [`super::Renderer::frame_buffers`]. Frames that are in flight or in use at the same time need one each.
pub struct FrameBuffers {
    gpu: Gpu,
    pub(super) size: FrameSize,
    pub(super) buffers: Buffers,
    pub(super) groups: Groups,
    pub(super) timing: Timing<Stage>,
    /// The fovea and the number of ranks that the limits on the device were made from, and these limits.
    limits_of: Option<(Fovea, u32, Limits)>,
    /// Buffers of adaptive masks; made with the first one.
    pub(super) adaptive: Option<AdaptiveBuffers>,
    /// Whether the list lies tile by tile, as the device packs it.
    pub(super) is_tiled: bool,
    /// Whether results of lists go straight to the frame.
    pub(super) is_straight: bool,
    /// Shadow rays of each pixel of the next frames, if they are few, and what shaders need of their noise.
    few: Option<(u32, NoiseNumbers)>,
    /// How the last frame was marched, if that is tuned.
    pub(super) played: Option<PlayedMarch>,
}

impl fmt::Debug for FrameBuffers {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("FrameBuffers").field("size", &self.size).finish_non_exhaustive()
    }
}

impl FrameBuffers {
    pub(super) fn new(gpu: &Gpu, stages: &Stages, size: FrameSize) -> Result<Self> {
        check_size(gpu, size)?;
        let made = gpu.guarded("making room for a frame", || {
            let buffers = Buffers::new(gpu, size);
            let extent = Extent { width: size.width, height: size.height };
            gpu.queue().write_buffer(&buffers.extent, 0, bytemuck::bytes_of(&extent));
            let groups = stages.bind(gpu, &buffers);
            Self {
                gpu: gpu.clone(),
                size,
                buffers,
                groups,
                timing: Timing::new(gpu, Stage::COUNT),
                limits_of: None,
                adaptive: None,
                is_tiled: false,
                is_straight: false,
                few: None,
                played: None,
            }
        })?;
        Ok(made)
    }

    /// Width and height of the frames.
    pub fn size(&self) -> FrameSize {
        self.size
    }

    /// The sparse frame: width × height × RGBA as f32, row 0 on top.
    ///
    /// Alpha is 1 at sampled pixels; all other pixels are 0.
    pub fn frame(&self) -> &wgpu::Buffer {
        &self.buffers.frame.colours
    }

    /// The inverse depth of every pixel of the sparse frame, f32, in 1 over world units; see [`RayResult::depth`].
    ///
    /// It is 0 where nothing is visible and where the pixel was not sampled. Others may add those of more pixels.
    pub fn inverse_depths(&self) -> &wgpu::Buffer {
        &self.buffers.frame.inverse_depths
    }

    /// The last list of samples, and their results.
    pub fn listed(&self) -> &ListBuffers {
        &self.buffers.listed
    }

    /// When the steps of the last frame began and ended.
    pub fn timing(&self) -> &Timing<Stage> {
        &self.timing
    }

    /// Writes the results of the next lists straight to the sparse frame, which saves a command. [`Self::listed`] then has none, and
    /// [`Self::read_samples`] reads older ones.
    pub fn set_straight(&mut self, is_straight: bool) {
        self.is_straight = is_straight;
    }

    /// Places shadow rays of the next frames as `few` says, or one at every sample. Scenes without shadow rays do not change.
    pub fn set_few_shadow_rays(&mut self, few: Option<&FewShadowRays<'_>>) {
        self.few = few.map(|few| {
            if let Some(tile) = few.noise.tile() {
                write_slices(&self.gpu, &self.buffers.noise, 0, bytemuck::cast_slice(tile));
            }
            (few.per_pixel, NoiseNumbers::new(&few.noise))
        });
    }

    /// Shadow rays of each pixel of the next frame, if they are few.
    pub(super) fn few_shadow_rays(&self) -> Option<u32> {
        self.few.map(|(per_pixel, _)| per_pixel)
    }

    /// How the last frame was marched, for [`super::Renderer::learn_march_time`]; `None` where nothing is to be learned.
    pub fn played_march(&self) -> Option<PlayedMarch> {
        self.played
    }

    /// Uploads the camera of `rays`.
    pub(super) fn set_view(&self, rays: &RayBasis, segments: &Segments) {
        let noise = self.few.map_or(NoiseNumbers::NONE, |(_, noise)| noise);
        let view = View::new(rays, segments, noise);
        self.gpu.queue().write_buffer(&self.buffers.view, 0, bytemuck::bytes_of(&view));
    }

    /// Uploads the inputs of a mask: the noise of the frame, and the limits around the fovea where they changed.
    pub(super) fn set_mask(&mut self, source: &MaskSource<'_>, pass: &MaskPass) {
        let noise = source.noise.frame(source.frame);
        if let Some(tile) = noise.tile() {
            self.gpu.queue().write_buffer(&self.buffers.tile, 0, bytemuck::cast_slice(tile));
        }
        let limits = match self.limits_of.take() {
            Some((fovea, levels, limits)) if fovea == *source.fovea && levels == noise.levels() => limits,
            _ => self.renew_limits(Limits::new(source.fovea, self.size, noise.levels()), pass),
        };
        let settings = MaskSettings::new(&noise, &limits);
        self.gpu.queue().write_buffer(&self.buffers.mask_settings, 0, bytemuck::bytes_of(&settings));
        self.limits_of = Some((*source.fovea, noise.levels(), limits));
    }

    /// Takes the buffers of adaptive masks, with the inputs of a frame with this `importance`.
    pub(super) fn set_importance(
        &mut self,
        source: &MaskSource<'_>,
        importance: &DeviceImportance<'_>,
    ) -> AdaptiveBuffers {
        let adaptive = self.adaptive.take().unwrap_or_else(|| AdaptiveBuffers::new(&self.gpu, self.size));
        let levels = source.noise.frame(source.frame).levels();
        adaptive.set(&self.gpu, (source.fovea, self.size), levels, importance);
        adaptive
    }

    fn renew_limits(&mut self, limits: Limits, pass: &MaskPass) -> Limits {
        let bytes: &[u8] = bytemuck::cast_slice(limits.values());
        if bytes.len() as u64 > self.buffers.limits.size() {
            let usage = self.buffers.limits.usage();
            self.buffers.limits = self.gpu.buffer("limits", bytes.len() as u64, usage);
            self.groups.mask = pass.bind(&self.gpu, &self.buffers);
        }
        self.gpu.queue().write_buffer(&self.buffers.limits, 0, bytes);
        limits
    }

    /// Uploads a list of pixels.
    ///
    /// # Errors
    /// A list for another size, or with more pixels than a frame has.
    pub(super) fn set_list(&mut self, list: &SampleList) -> Result<()> {
        if list.size() != self.size {
            return Err(Error::Size { list: list.size(), frame: self.size });
        }
        let room = ("pixels of the frame", self.size.pixels() as u64);
        GpuError::check_limit("a list of pixels", list.len() as u64, room, "draw fewer positions")?;
        self.is_tiled = false;
        let packed: Vec<u32> = list.pixels().iter().map(|p| u32::from(p.y) << 16 | u32::from(p.x)).collect();
        let length = ListLength::of(packed.len() as u32);
        Ok(self.gpu.guarded("uploading a list", || {
            self.gpu.queue().write_buffer(&self.buffers.listed.pixels, 0, bytemuck::cast_slice(&packed));
            self.gpu.queue().write_buffer(&self.buffers.listed.length, 0, bytemuck::bytes_of(&length));
        })?)
    }

    /// Uploads a mask, in place of one that is decided on the device.
    #[cfg(test)]
    pub(super) fn set_decided_mask(&self, mask: &SampleMask) {
        self.gpu.queue().write_buffer(&self.buffers.mask, 0, bytemuck::cast_slice(mask.words()));
    }

    /// Reads the sparse frame back to the host.
    ///
    /// # Errors
    /// A device that is lost or has no memory left.
    pub fn read_frame(&self) -> Result<Frame> {
        let pixels = read(&self.gpu, &self.buffers.frame.colours, self.size.pixels())?;
        Ok(Frame::from_pixels(self.size, pixels)?)
    }

    /// Reads [`Self::inverse_depths`] back to the host.
    ///
    /// # Errors
    /// As [`Self::read_frame`].
    pub fn read_inverse_depths(&self) -> Result<Vec<f32>> {
        Ok(read(&self.gpu, &self.buffers.frame.inverse_depths, self.size.pixels())?)
    }

    /// Reads the mask of the last masked frame back to the host.
    ///
    /// # Errors
    /// As [`Self::read_frame`].
    pub fn read_mask(&self) -> Result<SampleMask> {
        let mut mask = SampleMask::none(self.size);
        let words: Vec<[u32; 2]> = read(&self.gpu, &self.buffers.mask, mask.words().len())?;
        for (word, [low, high]) in mask.words_mut().iter_mut().zip(words) {
            *word = u64::from(high) << 32 | u64::from(low);
        }
        Ok(mask)
    }

    /// Reads the last list of pixels back to the host: as it was given, or in raster order if it was found on the device.
    ///
    /// # Errors
    /// As [`Self::read_frame`].
    pub fn read_list(&self) -> Result<SampleList> {
        let mut packed = self.read_packed()?;
        if self.is_tiled {
            packed.sort_unstable();
        }
        let pixel = |bits: &u32| Pixel { x: *bits as u16, y: (bits >> 16) as u16 };
        Ok(SampleList::new(self.size, packed.iter().map(pixel).collect()))
    }

    /// Pixels of the last list as they lie on the device: y in the high half of each, x in the low one.
    fn read_packed(&self) -> Result<Vec<u32>> {
        Ok(read(&self.gpu, &self.buffers.listed.pixels, self.read_list_length()?)?)
    }

    /// Reads the samples of the last list back to the host, in the order of [`Self::read_list`].
    ///
    /// # Errors
    /// As [`Self::read_frame`].
    pub fn read_samples(&self) -> Result<Vec<RayResult>> {
        let count = self.read_list_length()?;
        let colours: Vec<[f32; 4]> = read(&self.gpu, &self.buffers.listed.results.colours, count)?;
        let others: Vec<[f32; 4]> = read(&self.gpu, &self.buffers.listed.results.inverse_depths, count)?;
        let marched = |([r, g, b, opacity], [inverse, unshadowed @ ..]): ([f32; 4], [f32; 4])| RayResult {
            colour: [r, g, b],
            unshadowed,
            opacity,
            depth: if inverse > 0.0 { 1.0 / inverse } else { f32::INFINITY },
        };
        let samples: Vec<RayResult> = colours.into_iter().zip(others).map(marched).collect();
        if !self.is_tiled {
            return Ok(samples);
        }
        let mut order: Vec<(u32, usize)> = self.read_packed()?.into_iter().zip(0..).collect();
        order.sort_unstable();
        Ok(order.into_iter().map(|(_, at)| samples[at]).collect())
    }

    /// Reads the length of the last list in pixels back to the host.
    ///
    /// # Errors
    /// As [`Self::read_frame`].
    pub fn read_list_length(&self) -> Result<usize> {
        let length: Vec<ListLength> = read(&self.gpu, &self.buffers.listed.length, 1)?;
        Ok(length.first().map_or(0, |length| length.pixels as usize).min(self.size.pixels()))
    }

    /// How long each step of the last frame took on the device; `None` where it has no timestamps.
    ///
    /// # Errors
    /// As [`Self::read_frame`].
    pub fn read_times(&self) -> Result<Option<Vec<PassTime<Stage>>>> {
        Ok(self.timing.read(&self.gpu)?)
    }
}

/// Checks that buffers of `size` fit the device.
///
/// # Errors
/// A buffer or a dispatch that exceeds the limits of the device.
fn check_size(gpu: &Gpu, size: FrameSize) -> fovol_gpu::Result<()> {
    const MEND: &str = "give a smaller --size, or --device cpu";
    let limits = gpu.device().limits();
    let what = || format!("a frame of {size}");
    let bytes = 16 * size.pixels() as u64;
    let binding = ("maxStorageBufferBindingSize", limits.max_storage_buffer_binding_size);
    GpuError::check_limit(what(), bytes, binding, MEND)?;
    GpuError::check_limit(what(), bytes, ("maxBufferSize", limits.max_buffer_size), MEND)?;
    let groups = ("maxComputeWorkgroupsPerDimension", limits.max_compute_workgroups_per_dimension.into());
    GpuError::check_limit(what(), blocks(size).into(), groups, MEND)
}
