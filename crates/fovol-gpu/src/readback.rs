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
    let staging = gpu.guarded(DOING, || copied(gpu, buffer, bytes))?;
    let (sender, receiver) = mpsc::channel();
    gpu.guarded(DOING, || {
        staging.map_async(wgpu::MapMode::Read, .., move |mapped| {
            // Whoever waits is still there: it waits below.
            let _ = sender.send(mapped);
        });
    })?;
    gpu.wait()?;
    // Where others wait for the same device too, it may be one of them who is about to call.
    match receiver.recv_timeout(PATIENCE) {
        Ok(Ok(())) => {}
        Ok(Err(_)) | Err(_) => return Err(gpu.lost(DOING)),
    }
    let view = staging.get_mapped_range(..).map_err(|e| GpuError::refused(DOING, &e.to_string()))?;
    Ok(bytemuck::pod_collect_to_vec(&view[..]))
}

/// A buffer that the host can read, with the first `bytes` of `buffer`.
fn copied(gpu: &Gpu, buffer: &wgpu::Buffer, bytes: u64) -> wgpu::Buffer {
    let usage = wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ;
    let staging = gpu.buffer("readback", bytes, usage);
    let mut encoder = gpu.device().create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    encoder.copy_buffer_to_buffer(buffer, 0, &staging, 0, Some(bytes));
    gpu.queue().submit([encoder.finish()]);
    staging
}
