use crate::checks::Checks;
use crate::gate::{Gate, Pause};
use crate::matrices::Matrices;
use crate::pass::{Commands, Counters, Pass};
use crate::pipeline_cache::PipelineCache;
use crate::{GpuError, Result};
use std::fmt;
use std::sync::{Arc, Mutex, PoisonError};

/// A device and its queue, shared by renderer, network and viewer. Clones refer to one device.
#[derive(Clone)]
pub struct Gpu {
    device: wgpu::Device,
    queue: wgpu::Queue,
    /// The first fault: loss of the device, or an error outside [`Gpu::guarded`]. Only recorded for devices opened
    /// here.
    fault: Arc<Mutex<Option<String>>>,
    /// Pipelines compiled in this run or an earlier one.
    compiled: Option<Arc<PipelineCache>>,
    matrices: Option<Matrices>,
    checks: Checks,
    gate: Arc<Gate>,
    counters: Arc<Counters>,
}

impl Gpu {
    /// Wraps a device that the caller opened and lends. Its limits are those that it was opened with.
    pub fn shared(device: wgpu::Device, queue: wgpu::Queue) -> Self {
        let compiled = PipelineCache::of_user(&device).map(Arc::new);
        let (fault, gate, counters) = (Arc::default(), Arc::default(), Arc::default());
        Self { device, queue, fault, compiled, matrices: None, checks: Checks::default(), gate, counters }
    }

    /// Sets the cooperative matrices that shaders may use. The device must have been opened with
    /// [`Matrices::features`] of them.
    #[must_use]
    pub fn with_matrices(self, matrices: Option<Matrices>) -> Self {
        Self { matrices, ..self }
    }

    /// Sets the checks of shaders that are compiled from now on. Whether dispatches are checked was decided when the device's instance
    /// was made.
    #[must_use]
    pub fn with_checks(self, checks: Checks) -> Self {
        Self { checks, ..self }
    }

    /// Wraps a device that was opened for this program. Its faults are recorded, where wgpu would panic.
    pub(crate) fn owned(device: wgpu::Device, queue: wgpu::Queue) -> Self {
        let gpu = Self::shared(device, queue);
        let (lost, uncaptured) = (gpu.fault.clone(), gpu.fault.clone());
        gpu.device.set_device_lost_callback(move |reason, message| {
            keep(&lost, format!("{reason:?} {message}").trim().to_string());
        });
        gpu.device
            .on_uncaptured_error(Arc::new(move |error: wgpu::Error| keep(&uncaptured, error.to_string())));
        gpu
    }

    /// The wgpu device.
    pub fn device(&self) -> &wgpu::Device {
        &self.device
    }

    /// The wgpu queue, for writes. Commands go through [`Self::submit`] and [`Self::enqueue`] instead.
    pub fn queue(&self) -> &wgpu::Queue {
        &self.queue
    }

    /// The cooperative matrices that shaders may use, if any.
    pub fn matrices(&self) -> Option<Matrices> {
        self.matrices
    }

    /// The checks of shaders.
    pub fn checks(&self) -> Checks {
        self.checks
    }

    /// Begins a compute pass in `encoder`. Its commands count in [`Self::commands`].
    pub fn pass<'a>(&self, encoder: &'a mut wgpu::CommandEncoder) -> Pass<'a> {
        Pass::begin(&self.counters, encoder, &wgpu::ComputePassDescriptor::default())
    }

    /// Commands that were recorded since the device was opened.
    pub fn commands(&self) -> Commands {
        self.counters.commands()
    }

    /// Counters of the commands that were recorded.
    pub(crate) fn counters(&self) -> &Arc<Counters> {
        &self.counters
    }

    /// The pipeline cache to create pipelines with, if the device has one.
    pub(crate) fn compiled(&self) -> Option<&wgpu::PipelineCache> {
        self.compiled.as_deref().map(PipelineCache::get)
    }

    /// Warning for the user: the file of compiled pipelines was damaged.
    pub fn note(&self) -> Option<&str> {
        self.compiled.as_deref().and_then(PipelineCache::note)
    }

    /// Name, kind and driver of the adapter.
    pub fn info(&self) -> wgpu::AdapterInfo {
        self.device.adapter_info()
    }

    /// Whether the adapter is a software rasteriser. Applications warn about it.
    pub fn is_software(&self) -> bool {
        self.info().device_type == wgpu::DeviceType::Cpu
    }

    /// Runs `work`, and returns errors of the device that it causes.
    ///
    /// # Errors
    /// [`GpuError::OutOfMemory`] or [`GpuError::Refused`]; both name the operation `doing`.
    pub fn guarded<T>(&self, doing: &'static str, work: impl FnOnce() -> T) -> Result<T> {
        let filters =
            [wgpu::ErrorFilter::OutOfMemory, wgpu::ErrorFilter::Validation, wgpu::ErrorFilter::Internal];
        let scopes = filters.map(|filter| self.device.push_error_scope(filter));
        let done = work();
        // Error scopes form a stack, so the last one is popped first.
        let mut found = Ok(done);
        for scope in scopes.into_iter().rev() {
            found = match pollster::block_on(scope.pop()) {
                None => found,
                Some(wgpu::Error::OutOfMemory { .. }) => Err(GpuError::OutOfMemory { doing }),
                Some(error) => Err(GpuError::refused(doing, &error.to_string())),
            };
        }
        found
    }

    /// Encodes commands with `encode` and submits them. Returns once they are submitted; [`Self::wait_for`] waits
    /// for their end.
    ///
    /// # Errors
    /// Errors of `encode`; [`GpuError::OutOfMemory`] or [`GpuError::Refused`], which name the operation `doing`.
    pub fn submit<T, E: From<GpuError>>(
        &self,
        doing: &'static str,
        encode: impl FnOnce(&mut wgpu::CommandEncoder) -> std::result::Result<T, E>,
    ) -> std::result::Result<(T, wgpu::SubmissionIndex), E> {
        self.guarded(doing, || {
            let descriptor = wgpu::CommandEncoderDescriptor { label: Some(doing) };
            let mut encoder = self.device.create_command_encoder(&descriptor);
            let done = encode(&mut encoder)?;
            Ok((done, self.enqueue([encoder.finish()])))
        })?
    }

    /// Submits `commands`, after earlier writes to the queue. Waits while there is a [`Pause`].
    pub fn enqueue(&self, commands: impl IntoIterator<Item = wgpu::CommandBuffer>) -> wgpu::SubmissionIndex {
        self.gate.pass(|| self.queue.submit(commands))
    }

    /// Blocks submissions by all clones of this device until the returned guard is dropped. Work that was already
    /// submitted goes on.
    ///
    /// A window cannot be reconfigured while another thread submits to its device; this gives it a turn.
    pub fn pause(&self) -> Pause {
        Pause::of(&self.gate)
    }

    /// Makes a storage buffer with the contents `bytes`.
    ///
    /// # Errors
    /// [`GpuError::OutOfMemory`] or [`GpuError::Refused`].
    pub fn upload(&self, label: &str, bytes: &[u8]) -> Result<wgpu::Buffer> {
        self.guarded("uploading", || {
            let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST;
            let buffer = self.buffer(label, bytes.len() as u64, usage);
            self.queue.write_buffer(&buffer, 0, bytes);
            buffer
        })
    }

    /// Makes the error for a device that was lost during the operation `doing`.
    pub fn lost(&self, doing: &'static str) -> GpuError {
        let fault = self.fault.lock().unwrap_or_else(PoisonError::into_inner);
        let message = fault.clone().unwrap_or_else(|| "it answers no more".into());
        GpuError::Lost { doing, message }
    }

    /// Makes a buffer of `size` bytes. `label` is its name in debugging tools. Call it within [`Self::guarded`].
    pub fn buffer(&self, label: &str, size: u64, usage: wgpu::BufferUsages) -> wgpu::Buffer {
        self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(label),
            size,
            usage,
            mapped_at_creation: false,
        })
    }

    /// Converts two timestamps to the milliseconds between them; 0 if the counter restarted.
    pub fn ms_between(&self, from: u64, to: u64) -> f64 {
        // Counters may start anew between two passes.
        to.saturating_sub(from) as f64 * f64::from(self.queue.get_timestamp_period()) * 1e-6
    }

    /// Waits until the device has finished all submissions.
    ///
    /// # Errors
    /// [`GpuError::Lost`] where the device is gone.
    pub fn wait(&self) -> Result<()> {
        self.poll(wgpu::PollType::wait_indefinitely())
    }

    /// Waits until `submission` is done. Later submissions may still run.
    ///
    /// # Errors
    /// [`GpuError::Lost`] where the device is gone.
    pub fn wait_for(&self, submission: wgpu::SubmissionIndex) -> Result<()> {
        self.poll(wgpu::PollType::Wait { submission_index: Some(submission), timeout: None })
    }

    fn poll(&self, how: wgpu::PollType) -> Result<()> {
        // wgpu 30 panics in `poll` when the driver reports a loss. Here a loss is an ordinary error.
        let polled = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| self.device.poll(how)));
        match polled {
            Ok(Ok(_)) => Ok(()),
            Ok(Err(_)) | Err(_) => Err(self.lost("waiting for it")),
        }
    }
}

/// Records the first fault. Later ones are its consequences.
fn keep(fault: &Mutex<Option<String>>, message: String) {
    fault.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(message);
}

impl fmt::Debug for Gpu {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let info = self.info();
        f.debug_struct("Gpu")
            .field("name", &info.name)
            .field("backend", &info.backend)
            .finish_non_exhaustive()
    }
}
