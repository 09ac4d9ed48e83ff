use crate::pass::{Counters, Pass};
use crate::{Gpu, Result, read};
use std::fmt::Display;
use std::sync::Arc;

/// Duration of a pass on the device.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PassTime<S> {
    /// The work of the pass.
    pub stage: S,
    /// Duration in milliseconds.
    pub ms: f64,
}

/// Timestamps around compute passes, if the device supports them. `S` names the work of a pass.
#[derive(Debug)]
pub struct Timing<S> {
    queries: Option<Queries>,
    counters: Arc<Counters>,
    /// Work of the passes since [`Timing::begin`], in order.
    stages: Vec<S>,
}

#[derive(Debug)]
struct Queries {
    set: wgpu::QuerySet,
    resolved: wgpu::Buffer,
}

impl<S: Copy + Display> Timing<S> {
    /// Prepares timestamps for at most `passes` passes on the device of `gpu`.
    pub fn new(gpu: &Gpu, passes: u32) -> Self {
        let queries = gpu.device().features().contains(wgpu::Features::TIMESTAMP_QUERY).then(|| {
            let count = 2 * passes;
            let descriptor =
                wgpu::QuerySetDescriptor { label: Some("passes"), ty: wgpu::QueryType::Timestamp, count };
            let set = gpu.device().create_query_set(&descriptor);
            let resolved = gpu.device().create_buffer(&wgpu::BufferDescriptor {
                label: Some("pass times"),
                size: u64::from(count) * 8,
                usage: wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC,
                mapped_at_creation: false,
            });
            Queries { set, resolved }
        });
        Self { queries, counters: Arc::clone(gpu.counters()), stages: Vec::new() }
    }

    /// Forgets all passes so far.
    pub fn begin(&mut self) {
        self.stages.clear();
    }

    /// Begins a compute pass for `stage`, with timestamps at its beginning and end.
    pub fn pass<'a>(&mut self, encoder: &'a mut wgpu::CommandEncoder, stage: S) -> Pass<'a> {
        let first = 2 * self.stages.len() as u32;
        self.stages.push(stage);
        self.stamped(encoder, stage, [Some(first), Some(first + 1)])
    }

    /// Times everything that `encode` puts into `encoder` as one span of `stage`. It may be any number of passes.
    ///
    /// # Errors
    /// Errors of `encode`.
    pub fn span<T, E>(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        stage: S,
        encode: impl FnOnce(&mut wgpu::CommandEncoder) -> std::result::Result<T, E>,
    ) -> std::result::Result<T, E> {
        let first = 2 * self.stages.len() as u32;
        self.stages.push(stage);
        // Empty passes carry the timestamps: few devices can write them outside passes.
        let is_timed = self.queries.is_some();
        if is_timed {
            drop(self.stamped(encoder, stage, [Some(first), None]));
        }
        let encoded = encode(encoder)?;
        if is_timed {
            drop(self.stamped(encoder, stage, [None, Some(first + 1)]));
        }
        Ok(encoded)
    }

    /// Begins a pass that writes its beginning and its end to the timestamps of these indices.
    fn stamped<'a>(
        &self,
        encoder: &'a mut wgpu::CommandEncoder,
        stage: S,
        [begins, ends]: [Option<u32>; 2],
    ) -> Pass<'a> {
        let timestamp_writes = self.queries.as_ref().map(|queries| wgpu::ComputePassTimestampWrites {
            query_set: &queries.set,
            beginning_of_pass_write_index: begins,
            end_of_pass_write_index: ends,
        });
        let descriptor = wgpu::ComputePassDescriptor { label: Some(&stage.to_string()), timestamp_writes };
        Pass::begin(&self.counters, encoder, &descriptor)
    }

    /// The queries, if the device has timestamps and there was a pass. An empty range cannot be resolved.
    fn recorded(&self) -> Option<&Queries> {
        self.queries.as_ref().filter(|_| !self.stages.is_empty())
    }

    /// Resolves the timestamps of all passes so far into a buffer.
    pub fn end(&self, encoder: &mut wgpu::CommandEncoder) {
        if let Some(queries) = self.recorded() {
            encoder.resolve_query_set(&queries.set, 0..2 * self.stages.len() as u32, &queries.resolved, 0);
        }
    }

    /// Copies the timestamps of all passes so far to `to`, from byte `offset` on: two of eight bytes for each pass.
    /// Returns the work of these passes; empty if the device has no timestamps.
    pub fn copy(&self, encoder: &mut wgpu::CommandEncoder, to: &wgpu::Buffer, offset: u64) -> Vec<S> {
        let Some(queries) = self.recorded() else { return Vec::new() };
        let bytes = 16 * self.stages.len() as u64;
        encoder.copy_buffer_to_buffer(&queries.resolved, 0, to, offset, Some(bytes));
        self.stages.clone()
    }

    /// Reads the duration of each pass, in milliseconds; `None` if the device has no timestamps.
    ///
    /// # Errors
    /// Those of [`read`].
    pub fn read(&self, gpu: &Gpu) -> Result<Option<Vec<PassTime<S>>>> {
        let Some(queries) = self.recorded() else { return Ok(self.queries.as_ref().map(|_| Vec::new())) };
        let ticks: Vec<u64> = read(gpu, &queries.resolved, 2 * self.stages.len())?;
        let (pairs, _) = ticks.as_chunks::<2>();
        let time = |(&stage, [from, to]): (&S, &[u64; 2])| PassTime { stage, ms: gpu.ms_between(*from, *to) };
        Ok(Some(self.stages.iter().zip(pairs).map(time).collect()))
    }
}
