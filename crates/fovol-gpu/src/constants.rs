//! Constants of a GPU: what a dispatch, a pass and a read of memory take at least.

use crate::binding::{Slot, bind_group, bind_group_layout, compute_pipeline};
use crate::{Gpu, GpuError, Pass, Result, Shader, Timing, shader};
use std::fmt;
use std::time::Instant;

const CONSTANTS: Shader = shader!("shaders/", "constants":);

/// Dispatches of a measurement.
const DISPATCHES: usize = 256;
/// Dependent reads of a measurement.
const READS: usize = 4096;
/// Measurements of a median.
const ROUNDS: usize = 5;
/// Bytes of a word.
const WORD: u64 = 4;

/// A constant of a device.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Constant {
    /// A dispatch that waits for the one before it, in the same pass.
    Dispatch,
    /// Such a dispatch in a pass of its own.
    Pass,
    /// Such a dispatch whose workgroups are counted on the device.
    Indirect,
    /// A read of a storage buffer of so many MiB, which waits for the one before it.
    Read(u64),
}

impl fmt::Display for Constant {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Dispatch => f.write_str("constant, dispatch after dispatch"),
            Self::Pass => f.write_str("constant, pass after pass"),
            Self::Indirect => f.write_str("constant, indirect dispatch after dispatch"),
            Self::Read(mib) => write!(f, "constant, read after read of {mib} MiB"),
        }
    }
}

impl Constant {
    /// All constants; only small buffers where it has to be `quick`.
    pub fn all(quick: bool) -> Vec<Self> {
        let sizes: &[u64] = if quick { &[1] } else { &[1, 16, 64] };
        let reads = sizes.iter().map(|mib| Self::Read(*mib));
        [Self::Dispatch, Self::Pass, Self::Indirect].into_iter().chain(reads).collect()
    }

    /// Microseconds of one of them: the median of several measurements, by the clock of the device if it has one.
    ///
    /// # Errors
    /// A device that is lost or has no memory left.
    pub fn measure(self, gpu: &Gpu) -> Result<f64> {
        let (bytes, count) = match self {
            Self::Read(mib) => (mib << 20, READS),
            _ => (WORD, DISPATCHES),
        };
        let bench = gpu.guarded("making room for constants", || Bench::new(gpu, bytes))?;
        let mut all = Vec::new();
        for _ in 0..=ROUNDS {
            all.push(1e3 * bench.ms(self)? / count as f64);
        }
        // The first round fills caches.
        all.remove(0);
        all.sort_by(f64::total_cmp);
        Ok(all[ROUNDS / 2])
    }
}

/// Pipelines and buffers of a measurement.
struct Bench<'a> {
    gpu: &'a Gpu,
    touch: wgpu::ComputePipeline,
    follow: wgpu::ComputePipeline,
    group: wgpu::BindGroup,
    /// One workgroup.
    one: wgpu::Buffer,
}

impl<'a> Bench<'a> {
    fn new(gpu: &'a Gpu, bytes: u64) -> Self {
        use wgpu::BufferUsages as Usage;
        let layout = bind_group_layout(gpu, "constants", &[Slot::Write, Slot::Write]);
        let pipeline = |entry_point, constants: &[(&str, f64)]| {
            compute_pipeline(gpu, &CONSTANTS, entry_point, &[&layout], constants)
        };
        let words = gpu.buffer("words", bytes, Usage::STORAGE | Usage::COPY_DST);
        gpu.queue().write_buffer(&words, 0, bytemuck::cast_slice(&cycle((bytes / WORD) as usize)));
        let found = gpu.buffer("found", WORD, Usage::STORAGE);
        let one = gpu.buffer("one workgroup", 3 * WORD, Usage::INDIRECT | Usage::COPY_DST);
        gpu.queue().write_buffer(&one, 0, bytemuck::cast_slice(&[1u32; 3]));
        let buffers = [&words, &found].map(wgpu::Buffer::as_entire_binding);
        Self {
            gpu,
            touch: pipeline("touch", &[]),
            follow: pipeline("follow", &[("READS", READS as f64)]),
            group: bind_group(gpu, "constants", &layout, &buffers),
            one,
        }
    }

    /// Milliseconds of all dispatches or reads of `constant`.
    fn ms(&self, constant: Constant) -> Result<f64> {
        let mut timing = Timing::new(self.gpu, 1);
        let started = Instant::now();
        self.gpu.submit("measuring constants", |encoder| -> Result<()> {
            timing.begin();
            timing.span(encoder, constant, |encoder| {
                let passes = if constant == Constant::Pass { DISPATCHES } else { 1 };
                (0..passes).for_each(|_| self.dispatch(&mut self.gpu.pass(encoder), constant));
                Ok::<_, GpuError>(())
            })?;
            timing.end(encoder);
            Ok(())
        })?;
        self.gpu.wait()?;
        let host_ms = started.elapsed().as_secs_f64() * 1e3;
        Ok(timing.read(self.gpu)?.and_then(|times| Some(times.first()?.ms)).unwrap_or(host_ms))
    }

    fn dispatch(&self, pass: &mut Pass<'_>, constant: Constant) {
        let is_read = matches!(constant, Constant::Read(_));
        pass.set_pipeline(if is_read { &self.follow } else { &self.touch });
        pass.set_bind_group(0, &self.group, &[]);
        match constant {
            Constant::Dispatch => (0..DISPATCHES).for_each(|_| pass.dispatch_workgroups(1, 1, 1)),
            Constant::Indirect => {
                (0..DISPATCHES).for_each(|_| pass.dispatch_workgroups_indirect(&self.one, 0));
            }
            Constant::Pass | Constant::Read(_) => pass.dispatch_workgroups(1, 1, 1),
        }
    }
}

/// Indices that lead from each of `count` words to another one far away, through all of them.
fn cycle(count: usize) -> Vec<u32> {
    // An odd step and a power of two have no common divisor.
    let count = count.next_power_of_two();
    let step = (count / 2 + count / 8) | 1;
    (0..count).map(|at| ((at + step) % count) as u32).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_words_are_read_before_the_first_one_again() {
        for count in [1usize, 64, 1024] {
            let words = cycle(count);
            let mut at = 0;
            for round in 1..=count {
                at = words[at] as usize;
                assert_eq!(at == 0, round == count, "{count} {round}");
            }
        }
    }
}
