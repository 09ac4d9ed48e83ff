use crate::gate::{Gate, Pause};
use crate::matrices::Matrices;
use crate::pipeline_cache::PipelineCache;
use crate::{GpuError, Result};
use std::fmt;
use std::sync::{Arc, Mutex, PoisonError};

/// A device and its queue, to be shared between renderer, network and viewer. Clones are the same device.
#[derive(Clone)]
pub struct Gpu {
    device: wgpu::Device,
    queue: wgpu::Queue,
    /// Why the device was lost, and what went wrong outside any [`Gpu::guarded`]; known for devices opened here.
    fault: Arc<Mutex<Option<String>>>,
    /// What has been compiled, in this run or an earlier one.
    compiled: Option<Arc<PipelineCache>>,
    matrices: Option<Matrices>,
    gate: Arc<Gate>,
}

impl Gpu {
    /// A device that someone else opened and lends. Its limits are those that it was opened with.
    pub fn shared(device: wgpu::Device, queue: wgpu::Queue) -> Self {
        let compiled = PipelineCache::of_user(&device).map(Arc::new);
        Self { device, queue, fault: Arc::default(), compiled, matrices: None, gate: Arc::default() }
    }

    /// This device, for which shaders may use cooperative matrices of this kind; `None` for none. It has to have been opened
    /// with [`Matrices::features`].
    #[must_use]
    pub fn with_matrices(self, matrices: Option<Matrices>) -> Self {
        Self { matrices, ..self }
    }

    /// A device that is opened for this program: what goes wrong with it is kept, where wgpu would panic.
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

    /// The device.
    pub fn device(&self) -> &wgpu::Device {
        &self.device
    }

    /// Its queue, to write with: what the device is to do goes through [`Self::submit`] and [`Self::enqueue`].
    pub fn queue(&self) -> &wgpu::Queue {
        &self.queue
    }

    /// The cooperative matrices that shaders may use.
    pub fn matrices(&self) -> Option<Matrices> {
        self.matrices
    }

    /// What pipelines are to be looked for in when they are made, where there is such a thing.
    pub(crate) fn compiled(&self) -> Option<&wgpu::PipelineCache> {
        self.compiled.as_deref().map(PipelineCache::get)
    }

    /// What is doubtful about this device: a damaged file of compiled pipelines.
    pub fn note(&self) -> Option<&str> {
        self.compiled.as_deref().and_then(PipelineCache::note)
    }

    /// The adapter's name, kind and driver.
    pub fn info(&self) -> wgpu::AdapterInfo {
        self.device.adapter_info()
    }

    /// Whether the adapter is a program on the CPU: faces warn about it.
    pub fn is_software(&self) -> bool {
        self.info().device_type == wgpu::DeviceType::Cpu
    }

    /// Does `work` on the device; errors of the device become the result.
    ///
    /// # Errors
    /// [`GpuError::OutOfMemory`] or [`GpuError::Refused`], saying that it happened while `doing`.
    pub fn guarded<T>(&self, doing: &'static str, work: impl FnOnce() -> T) -> Result<T> {
        let filters =
            [wgpu::ErrorFilter::OutOfMemory, wgpu::ErrorFilter::Validation, wgpu::ErrorFilter::Internal];
        let scopes = filters.map(|filter| self.device.push_error_scope(filter));
        let done = work();
        // The innermost scope is popped first.
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

    /// Has the device do what `encode` puts into a command encoder. Returns when it has been told, not when it is done: that
    /// can be waited for.
    ///
    /// # Errors
    /// Those of `encode`; [`GpuError::OutOfMemory`] or [`GpuError::Refused`], saying that it happened while `doing`.
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

    /// Has the device do `commands`, and what was written before. Waits while there is a [`Pause`].
    pub fn enqueue(&self, commands: impl IntoIterator<Item = wgpu::CommandBuffer>) -> wgpu::SubmissionIndex {
        self.gate.pass(|| self.queue.submit(commands))
    }

    /// Lets the device come to rest: from now on, until what this gives is dropped, it is given nothing to do by any clone of
    /// this. What it has been given it still does.
    ///
    /// A window cannot be configured anew while somebody else submits to its device; this is how it gets its turn.
    pub fn pause(&self) -> Pause {
        Pause::of(&self.gate)
    }

    /// A buffer with `bytes`, to be bound as storage and read.
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

    /// That the device is gone while `doing`.
    pub fn lost(&self, doing: &'static str) -> GpuError {
        let fault = self.fault.lock().unwrap_or_else(PoisonError::into_inner);
        let message = fault.clone().unwrap_or_else(|| "it answers no more".into());
        GpuError::Lost { doing, message }
    }

    /// A buffer of `size` bytes for `usage`, called `label` in tools; to be made within [`Self::guarded`].
    pub fn buffer(&self, label: &str, size: u64, usage: wgpu::BufferUsages) -> wgpu::Buffer {
        self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(label),
            size,
            usage,
            mapped_at_creation: false,
        })
    }

    /// Milliseconds between two timestamps.
    pub fn ms_between(&self, from: u64, to: u64) -> f64 {
        // Counters may start anew between two passes.
        to.saturating_sub(from) as f64 * f64::from(self.queue.get_timestamp_period()) * 1e-6
    }

    /// Waits until the queue is empty.
    ///
    /// # Errors
    /// [`GpuError::Lost`] where the device is gone.
    pub fn wait(&self) -> Result<()> {
        self.poll(wgpu::PollType::wait_indefinitely())
    }

    /// Waits until `submission` is done; what was submitted after it may go on.
    ///
    /// # Errors
    /// [`GpuError::Lost`] where the device is gone.
    pub fn wait_for(&self, submission: wgpu::SubmissionIndex) -> Result<()> {
        self.poll(wgpu::PollType::Wait { submission_index: Some(submission), timeout: None })
    }

    fn poll(&self, how: wgpu::PollType) -> Result<()> {
        // wgpu 30 panics in `poll` when the driver reports a loss; here that is an error like any other.
        let polled = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| self.device.poll(how)));
        match polled {
            Ok(Ok(_)) => Ok(()),
            Ok(Err(_)) | Err(_) => Err(self.lost("waiting for it")),
        }
    }
}

/// Keeps the first fault: those after it follow from it.
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
