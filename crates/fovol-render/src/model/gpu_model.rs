/// Constants of a GPU that the model counts with.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GpuModel {
    /// Name as it is asked for.
    pub name: &'static str,
    /// Multiprocessors, or compute units.
    pub multiprocessors: u32,
    /// Cycles of a nanosecond.
    pub ghz: f64,
    /// Warps that a multiprocessor holds at a time.
    pub warps: u32,
    /// Cycles until a look into the macrocells is known.
    pub look: f64,
    /// Cycles until a sample is known: two texture loads, then the table.
    pub sample: f64,
    /// Cycles of a step besides.
    pub step: f64,
    /// Cycles of the texture unit for one load of a warp.
    pub load: f64,
}

/// Latencies that agree with five measurements on an H200 within a third; see docs/measurements.md. Others are taken to have
/// the same.
const H200: GpuModel = GpuModel {
    name: "h200",
    multiprocessors: 132,
    ghz: 1.85,
    warps: 32,
    look: 300.0,
    sample: 450.0,
    step: 60.0,
    load: 8.0,
};

impl GpuModel {
    /// All that are known.
    pub const ALL: [Self; 5] = [
        H200,
        Self { name: "h100", ..H200 },
        Self { name: "rtx-4090", multiprocessors: 128, ghz: 2.5, ..H200 },
        Self { name: "rtx-3060", multiprocessors: 28, ghz: 1.78, ..H200 },
        Self { name: "integrated", multiprocessors: 12, ghz: 2.0, warps: 16, ..H200 },
    ];

    /// The GPU that is called `name`, in letters of any case.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|gpu| gpu.name.eq_ignore_ascii_case(name))
    }

    /// Milliseconds of `cycles`.
    pub fn ms(&self, cycles: f64) -> f64 {
        cycles / self.ghz / 1e6
    }
}
