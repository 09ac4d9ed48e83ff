//! Void-and-cluster ranks (Ulichney 1993), extended to time as in spatio-temporal blue noise
//! (Wolfe, Morrical, Akenine-Möller, Ramamoorthi 2022): two positions of the volume repel each other if
//! they share a slice or share a pixel.
//!
//! Energies are fixed-point numbers and ties are broken by a hash, so the ranks are the same on every
//! machine, bit for bit.

use super::random::hash;

/// The seed of the ranks that the program carries.
pub const STBN_SEED: u64 = 2022;

/// Standard deviation of the kernel along every axis, in pixels and frames.
const SIGMA: f64 = 1.9;
/// Where the kernel has fallen to 0.005: ⌊√(−2σ² ln 0.005)⌋.
const RADIUS: usize = 6;
/// Share of positions that the initial pattern switches on.
const INITIAL: f64 = 0.1;
/// Fixed-point one.
const ONE: f64 = (1 << 22) as f64;

/// The size of a volume of noise: pixels along x and y, frames.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct NoiseSize {
    /// Pixels along x, 16…256.
    pub width: usize,
    /// Pixels along y, 16…256.
    pub height: usize,
    /// Frames, 1…256; one frame is plain blue noise.
    pub frames: usize,
}

impl NoiseSize {
    /// The paper's tile: 128×128 pixels, 64 frames.
    pub const STBN: Self = Self { width: 128, height: 128, frames: 64 };

    /// A size within the limits.
    ///
    /// # Errors
    /// A side outside 16…256 or a number of frames outside 1…256.
    pub fn new(width: usize, height: usize, frames: usize) -> Result<Self, String> {
        let side = 16..=256;
        if side.contains(&width) && side.contains(&height) && (1..=256).contains(&frames) {
            Ok(Self { width, height, frames })
        } else {
            Err(format!(
                "noise of {width}x{height}x{frames} is out of reach; use 16 to 256 pixels a side and 1 to 256 frames"
            ))
        }
    }

    /// The number of ranks.
    pub fn len(self) -> usize {
        self.width * self.height * self.frames
    }

    /// Never: sizes have at least one rank.
    pub fn is_empty(self) -> bool {
        self.len() == 0
    }
}

/// The ranks of a volume of noise, \[t\]\[y\]\[x\]: a permutation of 0…len − 1.
///
/// 128×128×64 takes seconds.
pub fn ranks(size: NoiseSize, seed: u64) -> Vec<u32> {
    let initial = relaxed(size, seed);
    let mut ranks = vec![0u32; size.len()];
    let count = initial.iter().filter(|&&on| on).count();
    // From the initial pattern down: the tightest cluster goes first and has the highest rank of these.
    let mut pattern = Pattern::new(size, seed, initial.clone(), Seek::Cluster);
    for remaining in (0..count).rev() {
        let at = pattern.best();
        pattern.switch(at, false);
        ranks[at] = remaining as u32;
    }
    // From the initial pattern up to half: the largest void goes first.
    let mut pattern = Pattern::new(size, seed, initial, Seek::Void);
    for rank in count..size.len() / 2 {
        let at = pattern.best();
        pattern.switch(at, true);
        ranks[at] = rank as u32;
    }
    // From half on the free positions are the minority: their tightest cluster goes first.
    let free = pattern.on.iter().map(|&on| !on).collect();
    let mut pattern = Pattern::new(size, seed, free, Seek::Cluster);
    for rank in size.len() / 2..size.len() {
        let at = pattern.best();
        pattern.switch(at, false);
        ranks[at] = rank as u32;
    }
    ranks
}

/// The initial pattern: random positions, moved from the tightest cluster to the largest void until
/// they are the same place.
fn relaxed(size: NoiseSize, seed: u64) -> Vec<bool> {
    let mut order: Vec<usize> = (0..size.len()).collect();
    order.sort_unstable_by_key(|&i| (hash(seed ^ 0x5EED, i as u64), i));
    let mut on = vec![false; size.len()];
    let count = ((size.len() as f64 * INITIAL) as usize).max(1);
    order[..count].iter().for_each(|&i| on[i] = true);
    let mut clusters = Pattern::new(size, seed, on.clone(), Seek::Cluster);
    let mut voids = Pattern::new(size, seed, on, Seek::Void);
    loop {
        let tightest = clusters.best();
        clusters.switch(tightest, false);
        voids.switch(tightest, false);
        let largest = voids.best();
        clusters.switch(largest, true);
        voids.switch(largest, true);
        if tightest == largest {
            return clusters.on;
        }
    }
}

/// What a pattern is searched for.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Seek {
    /// The position with the most energy among those that are on.
    Cluster,
    /// The position with the least energy among those that are off.
    Void,
}

/// Which positions are on, the energy everywhere, and the best position of every row and frame.
struct Pattern {
    size: NoiseSize,
    seek: Seek,
    seed: u64,
    on: Vec<bool>,
    energy: Vec<u32>,
    /// Smaller is better; `u64::MAX` where a position is not sought.
    keys: Vec<u64>,
    best_of_row: Vec<u64>,
    best_of_frame: Vec<u64>,
    space: [[u32; 2 * RADIUS + 1]; 2 * RADIUS + 1],
    time: [u32; RADIUS + 1],
}

impl Pattern {
    fn new(size: NoiseSize, seed: u64, on: Vec<bool>, seek: Seek) -> Self {
        let mut pattern = Self {
            size,
            seek,
            seed,
            energy: vec![0; on.len()],
            keys: vec![u64::MAX; on.len()],
            best_of_row: vec![u64::MAX; size.height * size.frames],
            best_of_frame: vec![u64::MAX; size.frames],
            space: space_kernel(),
            time: time_kernel(),
            on,
        };
        for at in 0..pattern.on.len() {
            if pattern.on[at] {
                pattern.splat(at, true);
            }
        }
        for at in 0..pattern.on.len() {
            pattern.keys[at] = pattern.key(at);
        }
        for row in 0..pattern.best_of_row.len() {
            pattern.renew_row(row);
        }
        for frame in 0..size.frames {
            pattern.renew_frame(frame);
        }
        pattern
    }

    /// The position that is sought.
    fn best(&self) -> usize {
        let least =
            |keys: &[u64]| (0..keys.len()).min_by_key(|&i| keys[i]).expect("no list of keys is empty");
        let frame = least(&self.best_of_frame);
        let row = frame * self.size.height + least(self.best_of_frame_rows(frame));
        row * self.size.width + least(self.row_keys(row))
    }

    /// Switches position `at` and keeps everything up to date.
    fn switch(&mut self, at: usize, on: bool) {
        self.on[at] = on;
        self.splat(at, on);
        let (height, frames) = (self.size.height, self.size.frames);
        let row = at / self.size.width;
        let (y, t) = (row % height, row / height);
        self.keys[at] = self.key(at);
        for dy in 0..=2 * RADIUS {
            self.renew_row(t * height + (y + height + dy - RADIUS) % height);
        }
        self.renew_frame(t);
        for dt in 1..=temporal_radius(frames) {
            for other in [(t + dt) % frames, (t + frames - dt) % frames] {
                self.renew_row(other * height + y);
                self.renew_frame(other);
            }
        }
    }

    /// Adds or removes the energy that position `at` spreads.
    fn splat(&mut self, at: usize, add: bool) {
        let NoiseSize { width, height, frames } = self.size;
        let (x, y, t) = (at % width, at / width % height, at / (width * height));
        for dy in 0..=2 * RADIUS {
            let row = (t * height + (y + height + dy - RADIUS) % height) * width;
            for dx in 0..=2 * RADIUS {
                self.change(row + (x + width + dx - RADIUS) % width, self.space[dy][dx], add);
            }
        }
        for dt in 1..=temporal_radius(frames) {
            for other in [(t + dt) % frames, (t + frames - dt) % frames] {
                self.change((other * height + y) * width + x, self.time[dt], add);
            }
        }
    }

    #[inline]
    fn change(&mut self, at: usize, by: u32, add: bool) {
        let energy = &mut self.energy[at];
        *energy = if add { *energy + by } else { *energy - by };
        if self.keys[at] != u64::MAX {
            self.keys[at] = self.key(at);
        }
    }

    fn key(&self, at: usize) -> u64 {
        let energy = u64::from(self.energy[at]);
        let tie = hash(self.seed, at as u64) & 0xFFFF_FFFF;
        match (self.seek, self.on[at]) {
            (Seek::Cluster, true) => (u64::from(u32::MAX - 1) - energy) << 32 | tie,
            (Seek::Void, false) => energy << 32 | tie,
            _ => u64::MAX,
        }
    }

    fn row_keys(&self, row: usize) -> &[u64] {
        &self.keys[row * self.size.width..][..self.size.width]
    }

    fn best_of_frame_rows(&self, frame: usize) -> &[u64] {
        &self.best_of_row[frame * self.size.height..][..self.size.height]
    }

    fn renew_row(&mut self, row: usize) {
        self.best_of_row[row] = smallest(self.row_keys(row));
    }

    fn renew_frame(&mut self, frame: usize) {
        self.best_of_frame[frame] = smallest(self.best_of_frame_rows(frame));
    }
}

/// The smallest of `keys`, in a form that compiles to vector instructions.
fn smallest(keys: &[u64]) -> u64 {
    let mut lanes = [u64::MAX; 8];
    let mut chunks = keys.chunks_exact(8);
    for chunk in &mut chunks {
        for (lane, &key) in lanes.iter_mut().zip(chunk) {
            *lane = if key < *lane { key } else { *lane };
        }
    }
    lanes.iter().chain(chunks.remainder()).copied().min().unwrap_or(u64::MAX)
}

/// Frames further away than this would be reached both ways round.
fn temporal_radius(frames: usize) -> usize {
    RADIUS.min((frames - 1) / 2)
}

fn gauss(d: f64) -> f64 {
    (-d * d / (2.0 * SIGMA * SIGMA)).exp()
}

/// Σ_{d=1..6} k(d), by which the kernel of each axis is divided.
fn kernel_sum() -> f64 {
    (1..=RADIUS).map(|d| gauss(d as f64)).sum()
}

fn space_kernel() -> [[u32; 2 * RADIUS + 1]; 2 * RADIUS + 1] {
    let scale = ONE / (kernel_sum() * kernel_sum());
    let offset = |i: usize| i as f64 - RADIUS as f64;
    std::array::from_fn(|y| {
        std::array::from_fn(|x| (scale * gauss(offset(x)) * gauss(offset(y))).round() as u32)
    })
}

fn time_kernel() -> [u32; RADIUS + 1] {
    std::array::from_fn(|d| (ONE / kernel_sum() * gauss(d as f64)).round() as u32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranks_are_a_permutation() {
        let size = NoiseSize::new(16, 24, 8).unwrap();
        let mut sorted = ranks(size, 1);
        assert_ne!(sorted, ranks(size, 2));
        sorted.sort_unstable();
        assert!(sorted.iter().enumerate().all(|(i, &r)| i == r as usize));
    }

    #[test]
    fn kept_bests_are_the_true_ones() {
        let size = NoiseSize::new(16, 16, 16).unwrap();
        let on = (0..size.len()).map(|i| hash(3, i as u64).is_multiple_of(7)).collect();
        let mut pattern = Pattern::new(size, 9, on, Seek::Void);
        for _ in 0..200 {
            let best = pattern.best();
            let all = (0..size.len()).map(|i| pattern.key(i)).min().unwrap();
            assert_eq!(pattern.key(best), all);
            pattern.switch(best, true);
        }
        let fresh = Pattern::new(size, 9, pattern.on.clone(), Seek::Void);
        assert_eq!(fresh.energy, pattern.energy);
    }

    #[test]
    fn sizes_have_limits() {
        assert!(NoiseSize::new(15, 16, 1).is_err() && NoiseSize::new(16, 257, 1).is_err());
        assert!(NoiseSize::new(16, 16, 0).is_err());
    }
}
