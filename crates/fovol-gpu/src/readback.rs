//! Copies from the device to the host, for tests, files and figures. Frames that are only shown stay on the device.

use crate::{Gpu, GpuError, Result};
use bytemuck::Pod;
use std::sync::mpsc;
use std::time::Duration;

const DOING: &str = "reading results back";
/// Longest wait for the callback of a mapping after its submission is done.
const PATIENCE: Duration = Duration::from_secs(10);

/// Reads the first `count` elements of `buffer` after all earlier submissions are done. The buffer needs the usage
/// `COPY_SRC`.
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

/// Reads the pixels of a texture of four bytes per pixel, row by row, after all earlier submissions are done. The
/// texture needs the usage `COPY_SRC`.
///
/// # Errors
/// [`GpuError::Lost`], [`GpuError::OutOfMemory`] or [`GpuError::Refused`].
pub fn read_picture(gpu: &Gpu, picture: &wgpu::Texture) -> Result<Vec<[u8; 4]>> {
    let size = picture.size();
    let width = size.width as usize;
    // WebGPU wants rows to begin at multiples of this many bytes.
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

/// Staging buffer: device memory that the host can map, as the target of copies.
#[derive(Debug)]
pub struct Landing {
    gpu: Gpu,
    buffer: wgpu::Buffer,
}

impl Landing {
    /// Allocates `bytes` bytes, a multiple of four.
    ///
    /// # Errors
    /// [`GpuError::OutOfMemory`] or [`GpuError::Refused`].
    pub fn new(gpu: &Gpu, bytes: u64) -> Result<Self> {
        let usage = wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ;
        let buffer = gpu.guarded(DOING, || gpu.buffer("readback", bytes, usage))?;
        Ok(Self { gpu: gpu.clone(), buffer })
    }

    /// The buffer to copy to.
    pub fn buffer(&self) -> &wgpu::Buffer {
        &self.buffer
    }

    /// Asks for the contents of the buffer after `submission`. Returns at once; [`Arrival::take`] waits.
    ///
    /// # Errors
    /// [`GpuError::Refused`].
    pub fn fetch(self, submission: wgpu::SubmissionIndex) -> Result<Arrival> {
        let (sender, receiver) = mpsc::channel();
        self.gpu.guarded(DOING, || {
            self.buffer.map_async(wgpu::MapMode::Read, .., move |mapped| {
                // The receiver is gone if the arrival was dropped; then nobody waits.
                let _ = sender.send(mapped);
            });
        })?;
        Ok(Arrival { landing: self, submission, receiver })
    }
}

/// A staging buffer that is being mapped.
#[derive(Debug)]
pub struct Arrival {
    landing: Landing,
    submission: wgpu::SubmissionIndex,
    receiver: mpsc::Receiver<std::result::Result<(), wgpu::BufferAsyncError>>,
}

impl Arrival {
    /// Waits for the mapping. Returns the values and the staging buffer, which can be used again.
    ///
    /// # Errors
    /// [`GpuError::Lost`] or [`GpuError::Refused`].
    pub fn take<T: Pod>(self) -> Result<(Vec<T>, Landing)> {
        let Self { landing, submission, receiver } = self;
        landing.gpu.wait_for(submission)?;
        // If other threads wait for the device too, one of them may be the one that runs the callback.
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
