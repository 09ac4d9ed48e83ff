use crate::{Gpu, Result, read};
use std::fmt::Display;

/// How long a pass took on the device.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PassTime<S> {
    /// What it did.
    pub stage: S,
    /// Milliseconds.
    pub ms: f64,
}

/// Timestamps around compute passes, where the device has them; `S` says what a pass does.
#[derive(Debug)]
pub struct Timing<S> {
    queries: Option<Queries>,
    /// The passes since [`Timing::begin`], in their order.
    stages: Vec<S>,
}

#[derive(Debug)]
struct Queries {
    set: wgpu::QuerySet,
    resolved: wgpu::Buffer,
}

impl<S: Copy + Display> Timing<S> {
    /// Timing of at most `passes` passes on the device of `gpu`.
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
        Self { queries, stages: Vec::new() }
    }

    /// Forgets the passes so far.
    pub fn begin(&mut self) {
        self.stages.clear();
    }

    /// The compute pass of `stage`, with timestamps at both ends.
    pub fn pass<'a>(&mut self, encoder: &'a mut wgpu::CommandEncoder, stage: S) -> wgpu::ComputePass<'a> {
        let first = 2 * self.stages.len() as u32;
        self.stages.push(stage);
        self.stamped(encoder, stage, [Some(first), Some(first + 1)])
    }

    /// What `encode` puts into `encoder`, any number of passes, as one that does `stage`.
    ///
    /// # Errors
    /// That of `encode`.
    pub fn span<T, E>(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        stage: S,
        encode: impl FnOnce(&mut wgpu::CommandEncoder) -> std::result::Result<T, E>,
    ) -> std::result::Result<T, E> {
        let first = 2 * self.stages.len() as u32;
        self.stages.push(stage);
        // Passes that do nothing but tell the time: outside passes few devices can.
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

    /// A pass that writes timestamps of these numbers when it begins and when it ends.
    fn stamped<'a>(
        &self,
        encoder: &'a mut wgpu::CommandEncoder,
        stage: S,
        [begins, ends]: [Option<u32>; 2],
    ) -> wgpu::ComputePass<'a> {
        let timestamp_writes = self.queries.as_ref().map(|queries| wgpu::ComputePassTimestampWrites {
            query_set: &queries.set,
            beginning_of_pass_write_index: begins,
            end_of_pass_write_index: ends,
        });
        encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some(&stage.to_string()),
            timestamp_writes,
        })
    }

    /// The queries, where the device has them and there was a pass: nothing cannot be read.
    fn recorded(&self) -> Option<&Queries> {
        self.queries.as_ref().filter(|_| !self.stages.is_empty())
    }

    /// Makes the timestamps of all passes so far readable.
    pub fn end(&self, encoder: &mut wgpu::CommandEncoder) {
        if let Some(queries) = self.recorded() {
            encoder.resolve_query_set(&queries.set, 0..2 * self.stages.len() as u32, &queries.resolved, 0);
        }
    }

    /// Copies the timestamps of all passes so far to `to`, from byte `offset` on, eight bytes each, two of each pass; what they
    /// belong to. Nothing where the device has none.
    pub fn copy(&self, encoder: &mut wgpu::CommandEncoder, to: &wgpu::Buffer, offset: u64) -> Vec<S> {
        let Some(queries) = self.recorded() else { return Vec::new() };
        let bytes = 16 * self.stages.len() as u64;
        encoder.copy_buffer_to_buffer(&queries.resolved, 0, to, offset, Some(bytes));
        self.stages.clone()
    }

    /// How long each pass took; `None` where the device has no timestamps.
    ///
    /// # Errors
    /// As [`read`].
    pub fn read(&self, gpu: &Gpu) -> Result<Option<Vec<PassTime<S>>>> {
        let Some(queries) = self.recorded() else { return Ok(self.queries.as_ref().map(|_| Vec::new())) };
        let ticks: Vec<u64> = read(gpu, &queries.resolved, 2 * self.stages.len())?;
        let (pairs, _) = ticks.as_chunks::<2>();
        let time = |(&stage, [from, to]): (&S, &[u64; 2])| PassTime { stage, ms: gpu.ms_between(*from, *to) };
        Ok(Some(self.stages.iter().zip(pairs).map(time).collect()))
    }
}
