//! Frames that stay on the device, for display.

use super::part::{Part, add_stage};
use crate::Result;
use crate::pipeline::frames::DoneFrame;
use crate::pipeline::timings::Timings;
use fovol_core::FrameSize;
use fovol_gpu::binding::{Slot, bind_group, bind_group_layout, compute_pipeline};
use fovol_gpu::{Arrival, Gpu, Landing, Shader, Timing, shader};
use fovol_render::gpu::{FrameBuffers, PlayedMarch, Stage};
use std::collections::VecDeque;
use std::fmt;
use std::time::Instant;

/// Shader that converts a full frame to a picture.
const DISPLAY: Shader = shader!("../../shaders/", "display":);
/// Edge of the workgroups in pixels, equal to the shader's.
const GROUP: u32 = 8;
/// Frames in flight: while the device renders one, the host prepares the next.
const FLIGHTS: usize = 2;
/// Number of pictures: one for each frame in flight, and one on the screen.
const PICTURES: usize = FLIGHTS + 1;
/// Most timed stages of a sparse frame.
const STAGES: usize = 4;
/// Most timed parts of the reconstruction.
const PARTS: usize = Part::COUNT as usize;
/// Number of 8-byte values read back for a frame: the length of its list, and two timestamps each for all stages, all
/// parts and the display.
const FACTS: usize = 1 + 2 * (STAGES + PARTS + 1);
/// Offset of the timestamps in bytes.
const TIMES: u64 = 8;
/// Bytes of the timestamps of `steps` steps.
const fn of(steps: usize) -> u64 {
    16 * steps as u64
}

/// Converts frames to pictures for a screen, with up to two frames in flight.
#[derive(Debug)]
pub struct Display {
    gpu: Gpu,
    size: FrameSize,
    layout: wgpu::BindGroupLayout,
    pipeline: wgpu::ComputePipeline,
    pictures: Vec<wgpu::Texture>,
    /// Index of the next picture to write.
    next: usize,
    timing: Timing<Showing>,
    flights: VecDeque<Flight>,
    /// Read-back buffers of finished frames, for reuse.
    landings: Vec<Landing>,
    /// How finished frames were marched, and the milliseconds of that.
    played: Vec<(PlayedMarch, f64)>,
}

/// Timed step that converts a frame to a picture.
#[derive(Debug, Clone, Copy)]
struct Showing;

impl fmt::Display for Showing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("display")
    }
}

/// Frame whose commands have been encoded.
pub struct Encoded {
    /// Its picture, once submitted.
    pub picture: wgpu::Texture,
    landing: Landing,
    timed: Timed,
}

/// Steps of a frame that have timestamps.
#[derive(Debug)]
struct Timed {
    stages: Vec<Stage>,
    parts: Vec<Part>,
    played: Option<PlayedMarch>,
}

/// Frame in flight.
#[derive(Debug)]
struct Flight {
    index: u32,
    /// Number of samples, if the host knows it.
    samples: Option<usize>,
    timed: Timed,
    submitted: Instant,
    arrival: Arrival,
}

impl Display {
    /// Display of frames of `size`.
    pub fn new(gpu: &Gpu, size: FrameSize) -> Result<Self> {
        let made = gpu.guarded("making room for pictures", || {
            let layout = bind_group_layout(gpu, "display", &[Slot::Read, Slot::Picture]);
            Self {
                gpu: gpu.clone(),
                size,
                pipeline: compute_pipeline(gpu, &DISPLAY, "show", &[&layout], &[]),
                layout,
                pictures: (0..PICTURES).map(|_| picture(gpu, size)).collect(),
                next: 0,
                timing: Timing::new(gpu, 1),
                flights: VecDeque::new(),
                landings: Vec::new(),
                played: Vec::new(),
            }
        })?;
        Ok(made)
    }

    /// Waits until another frame may be submitted; returns the frame that finished meanwhile.
    pub fn make_way(&mut self) -> Result<Option<DoneFrame>> {
        if self.flights.len() < FLIGHTS { Ok(None) } else { self.land() }
    }

    /// Waits for the oldest frame in flight, if there is one.
    pub fn land(&mut self) -> Result<Option<DoneFrame>> {
        let Some(flight) = self.flights.pop_front() else { return Ok(None) };
        let (facts, landing) = flight.arrival.take::<u64>()?;
        self.landings.push(landing);
        let times = facts[1..].as_chunks::<2>().0;
        let ms = |[from, to]: [u64; 2]| self.gpu.ms_between(from, to);
        let Timed { stages, parts, played } = &flight.timed;
        let mut timings = Timings::default();
        stages.iter().zip(times).for_each(|(stage, time)| add_stage(&mut timings, *stage, ms(*time)));
        let march = stages.iter().zip(times).find(|(stage, _)| **stage == Stage::March);
        let march_ms = march.map(|(_, time)| ms(*time));
        self.played.extend(played.zip(march_ms));
        parts.iter().zip(&times[STAGES..]).for_each(|(part, time)| part.add(&mut timings, ms(*time)));
        timings.total = match stages.is_empty() {
            true => flight.submitted.elapsed().as_secs_f64() * 1e3,
            false => ms([times[0][0], times[STAGES + PARTS][1]]),
        };
        // The shader counts in 32 bits; the upper half of this value is another number.
        let samples = flight.samples.unwrap_or((facts[0] & u64::from(u32::MAX)) as usize);
        Ok(Some(DoneFrame { index: flight.index, samples: samples.min(self.size.pixels()), timings }))
    }

    /// Takes how the frames that have finished were marched, and the milliseconds of that.
    pub fn take_played(&mut self) -> impl Iterator<Item = (PlayedMarch, f64)> {
        std::mem::take(&mut self.played).into_iter()
    }

    /// Encodes the conversion of `frame` to a picture, and the read-back of its sample count and timestamps. `buffers`
    /// and `parts` hold the count and the timestamps of its stages.
    pub fn encode(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        frame: &wgpu::Buffer,
        (buffers, parts): (&FrameBuffers, &Timing<Part>),
    ) -> Result<Encoded> {
        let landing = match self.landings.pop() {
            Some(landing) => landing,
            None => Landing::new(&self.gpu, 8 * FACTS as u64)?,
        };
        let picture = self.pictures[self.next].clone();
        self.next = (self.next + 1) % PICTURES;
        let timed = self.gpu.guarded("encoding a picture", || {
            let view = picture.create_view(&wgpu::TextureViewDescriptor::default());
            let resources = [frame.as_entire_binding(), wgpu::BindingResource::TextureView(&view)];
            let group = bind_group(&self.gpu, "display", &self.layout, &resources);
            self.timing.begin();
            let mut pass = self.timing.pass(encoder, Showing);
            pass.set_pipeline(&self.pipeline);
            pass.set_bind_group(0, &group, &[]);
            pass.dispatch_workgroups(self.size.width.div_ceil(GROUP), self.size.height.div_ceil(GROUP), 1);
            drop(pass);
            self.timing.end(encoder);
            let facts = landing.buffer();
            encoder.copy_buffer_to_buffer(buffers.listed().length(), 0, facts, 0, Some(8));
            self.timing.copy(encoder, facts, TIMES + of(STAGES + PARTS));
            Timed {
                stages: buffers.timing().copy(encoder, facts, TIMES),
                parts: parts.copy(encoder, facts, TIMES + of(STAGES)),
                played: buffers.played_march(),
            }
        })?;
        Ok(Encoded { picture, landing, timed })
    }

    /// Registers frame `index` as in flight, after `encoded` was submitted. `samples` is the number of its samples, if
    /// the host knows it.
    pub fn take_off(
        &mut self,
        index: u32,
        samples: Option<usize>,
        encoded: Encoded,
        submission: wgpu::SubmissionIndex,
    ) -> Result<wgpu::Texture> {
        let Encoded { picture, landing, timed } = encoded;
        let (submitted, arrival) = (Instant::now(), landing.fetch(submission)?);
        self.flights.push_back(Flight { index, samples, timed, submitted, arrival });
        Ok(picture)
    }
}

/// Texture that a shader writes and a screen shows.
fn picture(gpu: &Gpu, size: FrameSize) -> wgpu::Texture {
    gpu.device().create_texture(&wgpu::TextureDescriptor {
        label: Some("picture"),
        size: wgpu::Extent3d { width: size.width, height: size.height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba8Unorm,
        usage: wgpu::TextureUsages::STORAGE_BINDING
            | wgpu::TextureUsages::TEXTURE_BINDING
            | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shader_is_valid() {
        DISPLAY.check(wgpu::naga::valid::Capabilities::empty()).unwrap_or_else(|problem| panic!("{problem}"));
    }
}
