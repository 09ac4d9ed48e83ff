use super::buffers::Buffers;
use super::frame::DeviceInput;
use super::prepared::{Prepared, Step};
use super::timing::{LayerTime, Stage};
use crate::gpu::tensor::{Place, Sizes};
use crate::input::FrameInput;
use crate::{Error, Result};
use fovol_core::{Frame, FrameSize};
use fovol_gpu::{Pass, Timing, read};
use std::fmt;
use std::sync::Arc;
use wgpu::BufferUsages;

/// State that one sequence carries from frame to frame on a device, and memory for its frames.
///
/// A state belongs to one sequence of one network and frame size. Any number of states can use one
/// [`super::Network`].
pub struct State {
    network: Arc<Prepared>,
    size: FrameSize,
    buffers: Buffers,
    /// Bind groups of each step, in even and in odd frames; `None` for steps that read the frame's input.
    groups: Vec<Option<[wgpu::BindGroup; 2]>>,
    /// Whether the next frame is odd.
    is_odd: bool,
    /// Whether the states are cleared before the next frame.
    is_reset: bool,
    timing: Option<Timing<Stage>>,
    /// Upload buffers for sparse frames and motion from the host.
    uploads: Option<[wgpu::Buffer; 2]>,
}

impl fmt::Debug for State {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("State")
            .field("size", &self.size)
            .field("bytes", &self.bytes())
            .finish_non_exhaustive()
    }
}

impl State {
    pub(super) fn new(network: &Arc<Prepared>, size: FrameSize) -> Result<Self> {
        let gpu = &network.gpu;
        let sizes = Sizes::new(&network.plan, &network.halved, size);
        Buffers::check(network, &sizes)?;
        let (buffers, groups) = gpu.guarded("making room for the frames of a network", || {
            let buffers = Buffers::new(network, &sizes);
            let bind = |step: &Step| [false, true].map(|is_odd| buffers.bind(gpu, step, None, is_odd));
            let groups = network.steps.iter().map(|step| given(step).is_none().then(|| bind(step)));
            let groups = groups.collect();
            (buffers, groups)
        })?;
        Ok(Self {
            network: Arc::clone(network),
            size,
            buffers,
            groups,
            is_odd: false,
            is_reset: false,
            timing: None,
            uploads: None,
        })
    }

    pub(super) fn is_of(&self, network: &Arc<Prepared>) -> bool {
        Arc::ptr_eq(&self.network, network)
    }

    /// Size of the frames.
    pub fn size(&self) -> FrameSize {
        self.size
    }

    /// Size of its device memory in bytes.
    pub fn bytes(&self) -> u64 {
        self.buffers.bytes()
    }

    /// Buffer of the reconstructed frame: width × height × RGBA as f32 in 0…1, top row first, alpha 1 everywhere.
    /// All frames use this buffer.
    pub fn frame_buffer(&self) -> &wgpu::Buffer {
        self.buffers.frame()
    }

    /// Reads [`Self::frame_buffer`] back to the host.
    ///
    /// # Errors
    /// A device that is lost or has no memory left.
    pub fn read_frame(&self) -> Result<Frame> {
        let pixels = read(&self.network.gpu, self.buffers.frame(), self.size.pixels())?;
        Ok(Frame::from_pixels(self.size, pixels)?)
    }

    /// Resets the history, so that the next frame is treated as the first after a cut.
    pub fn reset(&mut self) {
        self.is_reset = true;
    }

    /// Switches the timing of layers on or off; it is off at first. With timing each layer is a pass of its own,
    /// which costs time.
    pub fn set_timed(&mut self, is_timed: bool) {
        let passes = self.network.steps.chunk_by(|a, b| a.stage == b.stage).count();
        self.timing = is_timed.then(|| Timing::new(&self.network.gpu, passes as u32));
    }

    /// Reads the durations of the layers of the last frame, in order. `None` if it was not timed, or the device has
    /// no timestamps.
    ///
    /// # Errors
    /// Those of [`Self::read_frame`].
    pub fn read_times(&self) -> Result<Option<Vec<LayerTime>>> {
        let Some(timing) = &self.timing else { return Ok(None) };
        let name = |stage: Stage| match stage {
            Stage::Layer(number) => self.network.plan.layers()[number].name().to_owned(),
            other => other.to_string(),
        };
        let times = timing.read(&self.network.gpu)?;
        let layer = |stage: Stage| match stage {
            Stage::Layer(number) => Some(number),
            Stage::Input | Stage::Output => None,
        };
        let time = |time: fovol_gpu::PassTime<Stage>| LayerTime {
            layer: layer(time.stage),
            name: name(time.stage),
            ms: time.ms,
        };
        Ok(times.map(|times| times.into_iter().map(time).collect()))
    }

    /// Records the commands of a frame in `encoder`.
    pub(super) fn encode(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        input: DeviceInput<'_>,
    ) -> Result<()> {
        self.check(input)?;
        let network = Arc::clone(&self.network);
        network.gpu.guarded("encoding a frame", || {
            self.prepare(encoder, input);
            let groups: Vec<_> = network.steps.iter().map(|step| self.bind_given(step, input)).collect();
            let sizes = Sizes::new(&network.plan, &network.halved, self.size);
            let mut timing = self.timing.take();
            match &mut timing {
                None => {
                    let mut pass = network.gpu.pass(encoder);
                    self.dispatch(&mut pass, 0..network.steps.len(), &groups, &sizes);
                }
                Some(timing) => {
                    timing.begin();
                    let mut first = 0;
                    for steps in network.steps.chunk_by(|a, b| a.stage == b.stage) {
                        let mut pass = timing.pass(encoder, steps[0].stage);
                        self.dispatch(&mut pass, first..first + steps.len(), &groups, &sizes);
                        first += steps.len();
                    }
                    timing.end(encoder);
                }
            }
            self.timing = timing;
            self.buffers.carry(encoder, self.is_odd);
            self.is_odd = !self.is_odd;
        })?;
        Ok(())
    }

    /// Clears states after a reset, and the motion if none is given.
    fn prepare(&mut self, encoder: &mut wgpu::CommandEncoder, input: DeviceInput<'_>) {
        if std::mem::take(&mut self.is_reset) {
            self.buffers.past(self.is_odd).for_each(|past| encoder.clear_buffer(past, 0, None));
        }
        let has_motion = self.network.steps.iter().any(|step| given(step) == Some(Place::Motion));
        if let (true, None, Some(motion)) = (has_motion, input.motion, self.network.plan.inputs().motion) {
            encoder.clear_buffer(self.buffers.tensor(motion, self.is_odd), 0, None);
        }
    }

    /// Makes the bind group of `step` if it reads an input that is given.
    fn bind_given(&self, step: &Step, input: DeviceInput<'_>) -> Option<wgpu::BindGroup> {
        let is_there = match given(step)? {
            Place::Motion => input.motion.is_some(),
            _ => true,
        };
        is_there.then(|| self.buffers.bind(&self.network.gpu, step, Some(input), self.is_odd))
    }

    /// Records some of the steps. `given` has the bind groups of steps that read the frame's input.
    fn dispatch(
        &self,
        pass: &mut Pass<'_>,
        steps: std::ops::Range<usize>,
        given: &[Option<wgpu::BindGroup>],
        sizes: &Sizes<'_>,
    ) {
        for number in steps {
            let made = self.groups[number].as_ref().map(|groups| &groups[usize::from(self.is_odd)]);
            let Some(group) = made.or(given[number].as_ref()) else { continue };
            let step = &self.network.steps[number];
            let [x, y, z] = step.kernel.groups.count(sizes);
            pass.set_pipeline(&step.pipeline.pipeline);
            pass.set_bind_group(0, group, &[]);
            pass.dispatch_workgroups(x, y, z);
        }
    }

    /// Checks that the buffers of `input` are large enough for frames of this size.
    fn check(&self, input: DeviceInput<'_>) -> Result<()> {
        let pixels = self.size.pixels() as u64;
        let given = [("sparse frame", Some(input.sparse), 16), ("motion", input.motion, 8)];
        for (what, buffer, bytes) in given {
            let Some(buffer) = buffer.filter(|buffer| buffer.size() < bytes * pixels) else { continue };
            return Err(Error::State(format!(
                "it is for frames of {}, and the {what} has {} bytes, not {}; start another for its size",
                self.size,
                buffer.size(),
                bytes * pixels
            )));
        }
        Ok(())
    }

    /// Reconstructs the full frame of `input`.
    pub(super) fn reconstruct(&mut self, input: &FrameInput<'_>) -> Result<Frame> {
        let size = input.sparse.size();
        if self.size != size {
            let problem =
                format!("it is for frames of {}, not {size}; start another for this size", self.size);
            return Err(Error::State(problem));
        }
        if input.motion.is_some_and(|motion| motion.len() != size.pixels()) {
            return Err(Error::State(format!("the motion is not that of {size} pixels")));
        }
        let network = Arc::clone(&self.network);
        let [sparse, motion] = self.uploads()?;
        network.gpu.guarded("reconstructing a frame", || {
            let picture = input.sparse.to_frame();
            network.gpu.queue().write_buffer(&sparse, 0, bytemuck::cast_slice(picture.pixels()));
            if let Some(values) = input.motion {
                network.gpu.queue().write_buffer(&motion, 0, bytemuck::cast_slice(values));
            }
            let descriptor = wgpu::CommandEncoderDescriptor { label: Some("reconstruction") };
            let mut encoder = network.gpu.device().create_command_encoder(&descriptor);
            let input = DeviceInput { sparse: &sparse, motion: input.motion.map(|_| &motion) };
            self.encode(&mut encoder, input)?;
            network.gpu.enqueue([encoder.finish()]);
            Ok::<_, Error>(())
        })??;
        self.read_frame()
    }

    /// Returns the upload buffers for frames of the host, and allocates them on first use.
    fn uploads(&mut self) -> fovol_gpu::Result<[wgpu::Buffer; 2]> {
        if let Some(uploads) = &self.uploads {
            return Ok(uploads.clone());
        }
        let gpu = &self.network.gpu;
        let pixels = self.size.pixels() as u64;
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_DST;
        let made = gpu.guarded("making room for frames of the host", || {
            [("sparse frame", 16), ("motion", 8)]
                .map(|(label, bytes)| gpu.buffer(label, bytes * pixels, usage))
        })?;
        Ok(self.uploads.insert(made).clone())
    }
}

/// Input of the frame that `step` reads, if any.
fn given(step: &Step) -> Option<Place> {
    let places = step.kernel.operands.iter().filter_map(|operand| operand.place());
    places.into_iter().find(|place| matches!(place, Place::Sparse | Place::Motion))
}
