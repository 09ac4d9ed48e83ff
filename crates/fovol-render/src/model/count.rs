/// Threads of a warp.
pub const WARP: usize = 32;

/// Counts of one warp or workgroup.
#[derive(Debug, Clone, Copy, Default)]
pub struct Count {
    pub chain: u64,
    pub warp_steps: u64,
    /// Steps of lanes, and of warps, in shadow rays.
    pub lane_steps: u64,
    pub shadow_warp_steps: u64,
    /// Loads of lanes in shadow rays.
    pub shadow_loads: u64,
    /// Loads of warps.
    pub loads: u64,
    pub cycles: f64,
}

impl Count {
    /// Adds what warps of the same workgroup do beside it: all but chain and cycles.
    pub fn add(&mut self, other: &Self) {
        self.warp_steps += other.warp_steps;
        self.lane_steps += other.lane_steps;
        self.shadow_warp_steps += other.shadow_warp_steps;
        self.shadow_loads += other.shadow_loads;
        self.loads += other.loads;
    }
}
