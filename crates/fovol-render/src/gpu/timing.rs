use super::device::Gpu;
use super::error::Result;
use super::readback::read;

/// A step of a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Stage {
    /// Which pixels are sampled.
    Mask,
    /// Their list.
    Compact,
    /// Their colours.
    March,
    /// The sparse frame.
    Scatter,
}

/// How long a step took on the device.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StageTime {
    /// The step.
    pub stage: Stage,
    /// Milliseconds.
    pub ms: f64,
}

/// Timestamps around each compute pass, where the device has them.
#[derive(Debug)]
pub struct Timing {
    queries: Option<Queries>,
    /// The passes of the last frame, in their order.
    stages: Vec<Stage>,
}

#[derive(Debug)]
struct Queries {
    set: wgpu::QuerySet,
    resolved: wgpu::Buffer,
}

/// Steps that a frame has at most.
const MOST_STAGES: u32 = 4;

impl Timing {
    /// Timing on the device of `gpu`.
    pub fn new(gpu: &Gpu) -> Self {
        let queries = gpu.device().features().contains(wgpu::Features::TIMESTAMP_QUERY).then(|| {
            let count = 2 * MOST_STAGES;
            let descriptor =
                wgpu::QuerySetDescriptor { label: Some("stages"), ty: wgpu::QueryType::Timestamp, count };
            let set = gpu.device().create_query_set(&descriptor);
            let resolved = gpu.device().create_buffer(&wgpu::BufferDescriptor {
                label: Some("stage times"),
                size: u64::from(count) * 8,
                usage: wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC,
                mapped_at_creation: false,
            });
            Queries { set, resolved }
        });
        Self { queries, stages: Vec::new() }
    }

    /// Forgets the last frame.
    pub fn begin(&mut self) {
        self.stages.clear();
    }

    /// The compute pass of `stage`, with timestamps at both ends.
    pub fn pass<'a>(&mut self, encoder: &'a mut wgpu::CommandEncoder, stage: Stage) -> wgpu::ComputePass<'a> {
        let first = 2 * self.stages.len() as u32;
        self.stages.push(stage);
        let timestamp_writes = self.queries.as_ref().map(|queries| wgpu::ComputePassTimestampWrites {
            query_set: &queries.set,
            beginning_of_pass_write_index: Some(first),
            end_of_pass_write_index: Some(first + 1),
        });
        encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some(match stage {
                Stage::Mask => "mask",
                Stage::Compact => "compact",
                Stage::March => "march",
                Stage::Scatter => "scatter",
            }),
            timestamp_writes,
        })
    }

    /// Makes the timestamps of all passes so far readable.
    pub fn end(&self, encoder: &mut wgpu::CommandEncoder) {
        if let Some(queries) = &self.queries {
            encoder.resolve_query_set(&queries.set, 0..2 * self.stages.len() as u32, &queries.resolved, 0);
        }
    }

    /// How long each step of the last frame took; `None` where the device has no timestamps.
    pub fn read(&self, gpu: &Gpu) -> Result<Option<Vec<StageTime>>> {
        let Some(queries) = &self.queries else { return Ok(None) };
        let ticks: Vec<u64> = read(gpu, &queries.resolved, 2 * self.stages.len())?;
        let ms_per_tick = f64::from(gpu.queue().get_timestamp_period()) * 1e-6;
        let (pairs, _) = ticks.as_chunks::<2>();
        let times = self.stages.iter().zip(pairs);
        // Counters may start anew between two passes.
        let time = |(&stage, [from, to]): (&Stage, &[u64; 2])| StageTime {
            stage,
            ms: to.saturating_sub(*from) as f64 * ms_per_tick,
        };
        Ok(Some(times.map(time).collect()))
    }
}
