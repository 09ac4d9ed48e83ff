use super::error::{Error, Result};
use super::list_buffers::GroupSize;
use fovol_core::Integration;
use std::fmt;
use std::str::FromStr;

/// How threads share the work of marching. Pictures do not depend on it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum MarchStrategy {
    /// A thread follows a ray, and from every sample its shadow ray.
    Rays,
    /// The threads of a workgroup follow some rays together; see [`Pool`].
    Pool(Pool),
}

/// Workgroups that march rays together: samples that show something are queued, and all threads follow shadow rays from
/// the queue.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Pool {
    rays: u32,
    threads: u32,
    /// Places of the queue for each ray.
    queue: u32,
}

/// Places of a workgroup's queue. With them and 20 bytes each, workgroups stay below the 16 KB that every WebGPU has.
const QUEUE: u32 = 512;
/// Places with fine integration: 28 bytes each, and 8 bytes for an end of a part.
const FINE_QUEUE: u32 = 256;
/// Places for one ray, at most: more only wait.
const QUEUE_OF_RAY: u32 = 128;
/// Threads of a workgroup that every WebGPU has.
const MOST_THREADS: u32 = 256;
/// The environment variable that chooses a strategy.
const VARIABLE: &str = "FOVOLNET_GPU_MARCH";

impl Pool {
    /// Pool of `rays` rays (1, 4, 16 or 64) for `threads` threads, a multiple of them and at most 256.
    pub fn new(rays: u32, threads: u32) -> Option<Self> {
        Self::with_queue(rays, threads, (QUEUE / rays.max(1)).min(QUEUE_OF_RAY))
    }

    /// Like [`Self::new`], with a queue of `queue` places for each ray: at least the threads of one.
    pub fn with_queue(rays: u32, threads: u32, queue: u32) -> Option<Self> {
        GroupSize::of(rays)?;
        let fits = threads > 0 && threads.is_multiple_of(rays) && threads <= MOST_THREADS;
        (fits && threads / rays <= queue && queue * rays <= QUEUE).then_some(Self { rays, threads, queue })
    }

    /// Rays of a workgroup.
    pub fn rays(self) -> u32 {
        self.rays
    }

    /// Threads of a workgroup.
    pub fn threads(self) -> u32 {
        self.threads
    }

    /// Places of the queue for each ray.
    pub fn queue(self) -> u32 {
        self.queue
    }

    /// Pixels of a workgroup's list.
    pub(super) fn group_size(self) -> GroupSize {
        GroupSize::of(self.rays).expect("pools are made of such sizes")
    }

    /// Values of the `override` constants of shaders/pool_rays.wgsl, and of pool_fine.wgsl for fine integration.
    pub(super) fn constants(self, integration: Integration) -> Vec<(&'static str, f64)> {
        let mut constants = vec![("POOL_RAYS", self.rays.into()), ("POOL_THREADS", self.threads.into())];
        match integration {
            Integration::Plain => constants.push(("POOL_QUEUE", self.queue.into())),
            Integration::Fine => {
                constants.push(("POOL_QUEUE", self.fine_queue().into()));
                constants.push(("POOL_BLOCKS", self.blocks().into()));
            }
        }
        constants
    }

    /// Places of the queue for parts of each ray.
    fn fine_queue(self) -> u32 {
        self.queue.min(FINE_QUEUE / self.rays)
    }

    /// Blocks of each ray that are taken side by side: each may have two parts.
    fn blocks(self) -> u32 {
        (self.threads / self.rays).min(self.fine_queue() / 2)
    }
}

impl MarchStrategy {
    /// The strategy that the variable `FOVOLNET_GPU_MARCH` names; `None` if it is not set, or empty.
    ///
    /// # Errors
    /// [`Error::Strategy`] of a value that names none.
    pub fn from_environment() -> Result<Option<Self>> {
        let value = std::env::var(VARIABLE).unwrap_or_default();
        let parsed = (!value.is_empty()).then(|| value.parse()).transpose();
        parsed.map_err(Error::Strategy)
    }

    /// The strategy for devices of such a type, where nothing was measured.
    pub fn usual(device: wgpu::DeviceType) -> Self {
        let pool = |rays, threads| Pool::new(rays, threads).map_or(Self::Rays, Self::Pool);
        match device {
            // Programs on the processor gain nothing from threads that work together.
            wgpu::DeviceType::Cpu => Self::Rays,
            wgpu::DeviceType::IntegratedGpu => pool(16, 128),
            wgpu::DeviceType::DiscreteGpu | wgpu::DeviceType::VirtualGpu | wgpu::DeviceType::Other => {
                pool(4, 128)
            }
        }
    }

    /// Strategies that are worth a try.
    pub fn candidates() -> impl Iterator<Item = Self> {
        let pools = [(1, 32), (4, 128), (16, 128), (64, 64)];
        let pools = pools.into_iter().filter_map(|(rays, threads)| Pool::new(rays, threads));
        [Self::Rays].into_iter().chain(pools.map(Self::Pool))
    }
}

impl fmt::Display for MarchStrategy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Rays => f.write_str("rays"),
            Self::Pool(Pool { rays, threads, .. }) => write!(f, "pool:{rays},{threads}"),
        }
    }
}

impl FromStr for MarchStrategy {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let wrong = || {
            format!("`{text}` is no way to march on a GPU; use rays, or pool:RAYS,THREADS such as pool:4,128")
        };
        if text == "rays" {
            return Ok(Self::Rays);
        }
        let (rays, threads) =
            text.strip_prefix("pool:").and_then(|numbers| numbers.split_once(',')).ok_or_else(wrong)?;
        let number = |text: &str| text.trim().parse().map_err(|_| wrong());
        Pool::new(number(rays)?, number(threads)?).map(Self::Pool).ok_or_else(|| {
            format!(
                "`{text}` cannot be: a workgroup has 1, 4, 16 or 64 rays and a multiple of them as threads, at most {MOST_THREADS}"
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_read_back() {
        for strategy in MarchStrategy::candidates() {
            assert_eq!(strategy.to_string().parse(), Ok(strategy));
        }
        for wrong in [
            "ray",
            "pool",
            "pool:4",
            "pool:a,b",
            "pool:0,0",
            "pool:3,96",
            "pool:4,130",
            "pool:4,1024",
            "pool:1,256",
        ] {
            assert!(wrong.parse::<MarchStrategy>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn queues_hold_a_stretch_and_fit_every_webgpu() {
        for strategy in MarchStrategy::candidates() {
            let MarchStrategy::Pool(pool) = strategy else { continue };
            assert!(pool.queue >= pool.threads / pool.rays, "{strategy}");
            // Queue, entries, segments and numbers of shaders/pool.wgsl.
            let bytes = 20 * pool.queue * pool.rays + 4 * pool.threads + (48 + 12) * pool.rays + 16;
            assert!(bytes <= 16384, "{strategy}: {bytes}");
            let (queue, blocks) = (pool.fine_queue(), pool.blocks());
            assert!(blocks >= 1 && queue >= 2 * blocks, "{strategy}: {queue} {blocks}");
            // Parts, ends, opacities and marks, segments and numbers of shaders/pool_fine.wgsl.
            let ends = 8 * (queue + 2) * pool.rays;
            let bytes = 28 * queue * pool.rays + ends + 20 * pool.threads + (48 + 16) * pool.rays + 16;
            assert!(bytes <= 16384, "{strategy}: {bytes}");
        }
    }
}
