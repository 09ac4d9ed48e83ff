//! From the device to the host: for tests, files and figures, never for a frame that stays on the device.

use crate::{Gpu, GpuError, Result};
use bytemuck::Pod;
use std::sync::mpsc;
use std::time::Duration;

const DOING: &str = "reading results back";
/// How long a call that is due may take to come.
const PATIENCE: Duration = Duration::from_secs(10);

/// The first `count` elements of `buffer`, which must be one that can be copied from, once everything submitted so far is
/// done.
///
/// # Errors
/// [`GpuError::Lost`], [`GpuError::OutOfMemory`] or [`GpuError::Refused`].
pub fn read<T: Pod>(gpu: &Gpu, buffer: &wgpu::Buffer, count: usize) -> Result<Vec<T>> {
    let bytes = (count * size_of::<T>()) as u64;
    if bytes == 0 {
        return Ok(Vec::new());
    }
    let landing = Landing::new(gpu, bytes)?;
    let ((), submission) = gpu.submit(DOING, |encoder| {
        encoder.copy_buffer_to_buffer(buffer, 0, landing.buffer(), 0, Some(bytes));
        Ok::<_, GpuError>(())
    })?;
    Ok(landing.fetch(submission)?.take()?.0)
}

/// The pixels of a picture of four bytes each, row by row, once everything submitted so far is done; it must be one that can be
/// copied from.
///
/// # Errors
/// As [`read`].
pub fn read_picture(gpu: &Gpu, picture: &wgpu::Texture) -> Result<Vec<[u8; 4]>> {
    let size = picture.size();
    let width = size.width as usize;
    // Rows begin at multiples of this.
    let row = (4 * width).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT as usize);
    let landing = Landing::new(gpu, row as u64 * u64::from(size.height))?;
    let ((), submission) = gpu.submit(DOING, |encoder| {
        let layout =
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row as u32), rows_per_image: None };
        let to = wgpu::TexelCopyBufferInfo { buffer: landing.buffer(), layout };
        encoder.copy_texture_to_buffer(picture.as_image_copy(), to, size);
        Ok::<_, GpuError>(())
    })?;
    let (pixels, _) = landing.fetch(submission)?.take::<[u8; 4]>()?;
    Ok(pixels.chunks_exact(row / 4).flat_map(|row| &row[..width]).copied().collect())
}

/// Memory that the host can read, for what a submission copies there.
#[derive(Debug)]
pub struct Landing {
    gpu: Gpu,
    buffer: wgpu::Buffer,
}

impl Landing {
    /// Room for `bytes`, a multiple of four.
    ///
    /// # Errors
    /// [`GpuError::OutOfMemory`] or [`GpuError::Refused`].
    pub fn new(gpu: &Gpu, bytes: u64) -> Result<Self> {
        let usage = wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ;
        let buffer = gpu.guarded(DOING, || gpu.buffer("readback", bytes, usage))?;
        Ok(Self { gpu: gpu.clone(), buffer })
    }

    /// Where to copy to.
    pub fn buffer(&self) -> &wgpu::Buffer {
        &self.buffer
    }

    /// Asks for what `submission` leaves there. Returns at once.
    ///
    /// # Errors
    /// [`GpuError::Refused`].
    pub fn fetch(self, submission: wgpu::SubmissionIndex) -> Result<Arrival> {
        let (sender, receiver) = mpsc::channel();
        self.gpu.guarded(DOING, || {
            self.buffer.map_async(wgpu::MapMode::Read, .., move |mapped| {
                // Nobody waits any more where the arrival was dropped.
                let _ = sender.send(mapped);
            });
        })?;
        Ok(Arrival { landing: self, submission, receiver })
    }
}

/// Bytes on their way to the host.
#[derive(Debug)]
pub struct Arrival {
    landing: Landing,
    submission: wgpu::SubmissionIndex,
    receiver: mpsc::Receiver<std::result::Result<(), wgpu::BufferAsyncError>>,
}

impl Arrival {
    /// Waits for them, and gives the memory back for others.
    ///
    /// # Errors
    /// [`GpuError::Lost`] or [`GpuError::Refused`].
    pub fn take<T: Pod>(self) -> Result<(Vec<T>, Landing)> {
        let Self { landing, submission, receiver } = self;
        landing.gpu.wait_for(submission)?;
        // Where others wait for the same device too, it may be one of them who is about to call.
        match receiver.recv_timeout(PATIENCE) {
            Ok(Ok(())) => {}
            Ok(Err(_)) | Err(_) => return Err(landing.gpu.lost(DOING)),
        }
        let view =
            landing.buffer.get_mapped_range(..).map_err(|e| GpuError::refused(DOING, &e.to_string()))?;
        let values = bytemuck::pod_collect_to_vec(&view[..]);
        drop(view);
        landing.buffer.unmap();
        Ok((values, landing))
    }
}
