//! Known pixels averaged over ever larger squares, and back: what fills frames.

use super::patch::halves;
use super::simd::{Simd, Work};
use rayon::prelude::*;

/// Divisors are at least this.
const SMALLEST: f32 = 1e-8;
/// A mean weight of one part in this many is enough to know a pixel of half the resolution.
const GAIN: f32 = 8.0;
/// Rows of a task.
const BAND: usize = 8;
/// The weights of four neighbours.
const BINOMIAL: [f32; 4] = [0.125, 0.375, 0.375, 0.125];

/// Three numbers times how far they are known, and that, 0…1.
pub type Known = [f32; 4];

/// Known pixels of a frame that are made when they are wanted.
pub trait KnownRows: Sync {
    /// What making a row needs.
    type Memory: Default + Send;

    /// Rows and columns.
    fn size(&self) -> [usize; 2];

    /// Makes `to` row `y`.
    fn make(&self, y: usize, memory: &mut Self::Memory, to: &mut Vec<Known>);
}

/// An image of known pixels.
#[derive(Debug)]
pub struct Level {
    pixels: Vec<Known>,
    width: usize,
}

impl Level {
    /// Row `y`.
    pub fn row(&self, y: usize) -> &[Known] {
        &self.pixels[y * self.width..(y + 1) * self.width]
    }

    fn height(&self) -> usize {
        self.pixels.len() / self.width
    }

    /// What is known at 2^`lowest` times lower resolution than that of `frame` where this is half of it, everywhere: with
    /// what is missing taken from up to 2^`levels` times lower ones.
    ///
    /// Pulling halves the resolution: premultiplied numbers c and weights w are averaged over 4×4 pixels by (1, 3, 3, 1)/8
    /// along both axes, replicated at the border, then w' = min(8w, 1) and c' = c·w'/max(w, 1e-8). Pushing goes back: each
    /// finer level gets c' + (1 − w')·(c of the coarser, bilinear), and its weight likewise.
    pub fn completed(self, levels: u32, lowest: u32) -> Self {
        let mut finest = self;
        for _ in 1..lowest {
            finest = pulled(&finest);
        }
        let mut above: Vec<Self> = Vec::new();
        for _ in lowest..levels {
            above.push(pulled(above.last().unwrap_or(&finest)));
        }
        while let Some(coarser) = above.pop() {
            push(above.last_mut().unwrap_or(&mut finest), &coarser);
        }
        finest
    }
}

/// The numbers themselves.
#[inline(always)]
pub fn divided([a, b, c, weight]: Known) -> [f32; 3] {
    let factor = 1.0 / weight.max(SMALLEST);
    [a * factor, b * factor, c * factor]
}

/// Half the resolution of `known`, which is `width` pixels wide.
pub fn pulled_from(known: &[Known], width: usize) -> Level {
    let height = known.len() / width;
    let row = |y: usize| &known[y * width..(y + 1) * width];
    let mut pixels = vec![[0.0; 4]; width / 2 * (height / 2)];
    pixels.par_chunks_exact_mut(width / 2).enumerate().for_each_init(Vec::new, |blended, (y, to)| {
        let rows = around(y, height).map(row);
        Simd::best().vectorised(PullRow { rows, blended, to });
    });
    Level { pixels, width: width / 2 }
}

fn pulled(finer: &Level) -> Level {
    pulled_from(&finer.pixels, finer.width)
}

/// Half the resolution of `known`, which is nowhere as a whole.
pub fn pulled_of<K: KnownRows>(known: &K) -> Level {
    let [height, width] = known.size();
    let width = width / 2;
    let mut pixels = vec![[0.0; 4]; width * (height / 2)];
    let bands = pixels.par_chunks_mut(BAND * width).enumerate();
    bands.for_each_init(Ring::<K>::default, |ring, (band, rows)| {
        ring.held = [None; 4];
        for (row, to) in rows.chunks_exact_mut(width).enumerate() {
            let wanted = around(band * BAND + row, height);
            wanted.iter().for_each(|&y| ring.hold(known, y));
            let Ring { rows, blended, .. } = ring;
            let rows = wanted.map(|y| &rows[y % 4][..]);
            Simd::best().vectorised(PullRow { rows, blended, to });
        }
    });
    Level { pixels, width }
}

/// The last four rows: every one is wanted twice.
struct Ring<K: KnownRows> {
    /// Row y has place y mod 4.
    rows: [Vec<Known>; 4],
    held: [Option<usize>; 4],
    blended: Vec<Known>,
    memory: K::Memory,
}

impl<K: KnownRows> Default for Ring<K> {
    fn default() -> Self {
        Self { rows: Default::default(), held: [None; 4], blended: Vec::new(), memory: K::Memory::default() }
    }
}

impl<K: KnownRows> Ring<K> {
    fn hold(&mut self, known: &K, y: usize) {
        if self.held[y % 4] != Some(y) {
            known.make(y, &mut self.memory, &mut self.rows[y % 4]);
            self.held[y % 4] = Some(y);
        }
    }
}

/// The rows of `height` that row `y` of half the resolution is made of.
fn around(y: usize, height: usize) -> [usize; 4] {
    [(2 * y).saturating_sub(1), 2 * y, 2 * y + 1, (2 * y + 2).min(height - 1)]
}

/// The pulling of four rows to one.
struct PullRow<'a> {
    rows: [&'a [Known]; 4],
    blended: &'a mut Vec<Known>,
    to: &'a mut [Known],
}

impl Work for PullRow<'_> {
    #[inline(always)]
    fn run(self) {
        let Self { rows: [a, b, c, d], blended, to } = self;
        let width = a.len();
        // One more on both sides.
        blended.resize(width + 2, [0.0; 4]);
        for (x, blended) in blended[1..=width].iter_mut().enumerate() {
            for k in 0..4 {
                blended[k] = (BINOMIAL[0] * a[x][k] + BINOMIAL[1] * b[x][k])
                    + (BINOMIAL[2] * c[x][k] + BINOMIAL[3] * d[x][k]);
            }
        }
        (blended[0], blended[width + 1]) = (blended[1], blended[width]);
        for (x, to) in to.iter_mut().enumerate() {
            let Some([a, b, c, d]) = blended[2 * x..].first_chunk() else { return };
            let mut mean = [0.0f32; 4];
            for k in 0..4 {
                mean[k] =
                    (BINOMIAL[0] * a[k] + BINOMIAL[1] * b[k]) + (BINOMIAL[2] * c[k] + BINOMIAL[3] * d[k]);
            }
            let weight = (GAIN * mean[3]).min(1.0);
            let factor = weight / mean[3].max(SMALLEST);
            for k in 0..4 {
                to[k] = mean[k] * factor;
            }
            to[3] = weight;
        }
    }
}

/// Adds what is missing in `finer` from `coarser`.
fn push(finer: &mut Level, coarser: &Level) {
    let width = finer.width;
    let bands = finer.pixels.par_chunks_mut(BAND * width).enumerate();
    bands.for_each_init(Vec::new, |blended, (band, rows)| {
        for (y, row) in rows.chunks_exact_mut(width).enumerate() {
            Simd::best().vectorised(PushRow { y: band * BAND + y, row, coarser, blended });
        }
    });
}

/// The pushing of one row.
struct PushRow<'a> {
    y: usize,
    row: &'a mut [Known],
    coarser: &'a Level,
    blended: &'a mut Vec<Known>,
}

impl Work for PushRow<'_> {
    #[inline(always)]
    fn run(self) {
        let Self { y, row, coarser, blended } = self;
        let [(a, wa), (b, wb)] = halves(y, coarser.height());
        let width = coarser.width;
        // One more on both sides, so that every pixel has two neighbours.
        blended.resize(width + 2, [0.0; 4]);
        for (to, (a, b)) in blended[1..].iter_mut().zip(coarser.row(a).iter().zip(coarser.row(b))) {
            for c in 0..4 {
                to[c] = wa * a[c] + wb * b[c];
            }
        }
        (blended[0], blended[width + 1]) = (blended[1], blended[width]);
        for (to, around) in row.as_chunks_mut::<2>().0.iter_mut().zip(blended.windows(3)) {
            let open = [1.0 - to[0][3], 1.0 - to[1][3]];
            for c in 0..4 {
                let near = 0.75 * around[1][c];
                to[0][c] += open[0] * (near + 0.25 * around[0][c]);
                to[1][c] += open[1] * (near + 0.25 * around[2][c]);
            }
        }
    }
}
