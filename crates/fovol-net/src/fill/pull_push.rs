use fovol_core::{Frame, FrameSize};
use rayon::prelude::*;

/// What a pixel of a level is: numbers premultiplied by how much is known of them, and that weight.
trait Weighted: Copy + Send + Sync {
    const NOTHING: Self;

    fn plus(self, other: Self) -> Self;

    /// With no weight above 1.
    fn cut(self) -> Self;

    /// With weight 1; zero where nothing is known.
    fn divided(self) -> Self;

    /// Whether a coarser level can add nothing.
    fn is_whole(self) -> bool;

    /// With what the weight leaves open taken from `coarse`, whose weight is 1.
    fn blended(self, coarse: Self) -> Self;

    /// The way from `self` to `other` by `part`.
    fn towards(self, other: Self, part: f32) -> Self;
}

/// Two numbers, each followed by its weight.
#[derive(Debug, Clone, Copy)]
struct Pair([f32; 4]);

/// Red, green, blue, and their weight.
impl Weighted for [f32; 4] {
    const NOTHING: Self = [0.0; 4];

    fn plus(self, other: Self) -> Self {
        std::array::from_fn(|c| self[c] + other[c])
    }

    fn cut(self) -> Self {
        let scale = if self[3] > 1.0 { 1.0 / self[3] } else { 1.0 };
        self.map(|c| c * scale)
    }

    fn divided(self) -> Self {
        let [r, g, b, weight] = self;
        if weight > 0.0 { [r / weight, g / weight, b / weight, 1.0] } else { [0.0, 0.0, 0.0, 1.0] }
    }

    fn is_whole(self) -> bool {
        self[3] >= 1.0
    }

    fn blended(self, coarse: Self) -> Self {
        let open = 1.0 - self[3];
        let [r, g, b] = std::array::from_fn(|c| self[c] + open * coarse[c]);
        [r, g, b, 1.0]
    }

    fn towards(self, other: Self, part: f32) -> Self {
        std::array::from_fn(|c| self[c] + part * (other[c] - self[c]))
    }
}

impl Weighted for Pair {
    const NOTHING: Self = Self([0.0; 4]);

    fn plus(self, other: Self) -> Self {
        Self(self.0.plus(other.0))
    }

    fn cut(self) -> Self {
        let scale = |weight: f32| if weight > 1.0 { 1.0 / weight } else { 1.0 };
        let [a, b] = [scale(self.0[1]), scale(self.0[3])];
        Self([self.0[0] * a, self.0[1] * a, self.0[2] * b, self.0[3] * b])
    }

    fn divided(self) -> Self {
        let divided = |number: f32, weight: f32| if weight > 0.0 { number / weight } else { 0.0 };
        Self([divided(self.0[0], self.0[1]), 1.0, divided(self.0[2], self.0[3]), 1.0])
    }

    fn is_whole(self) -> bool {
        self.0[1] >= 1.0 && self.0[3] >= 1.0
    }

    fn blended(self, coarse: Self) -> Self {
        let [a, a_weight, b, b_weight] = self.0;
        let open = [1.0 - a_weight, 1.0 - b_weight];
        Self([a + open[0] * coarse.0[0], 1.0, b + open[1] * coarse.0[2], 1.0])
    }

    fn towards(self, other: Self, part: f32) -> Self {
        Self(self.0.towards(other.0, part))
    }
}

/// One level of the pyramid.
struct Level<P> {
    width: usize,
    height: usize,
    pixels: Vec<P>,
}

/// Rows of a level that one task works on.
const ROWS: usize = 32;

/// The full frame of `sparse`; samples exactly as they were.
pub fn pull_push(sparse: &Frame) -> Frame {
    let known = |p: &[f32; 4]| if p[3] > 0.5 { [p[0], p[1], p[2], 1.0] } else { [0.0; 4] };
    let filled = filled(sparse.size(), sparse.pixels().par_iter().map(known).collect());
    Frame::from_pixels(sparse.size(), filled).expect("the finest level has the size of the frame")
}

/// Two pictures of numbers of a frame of `size`, row by row, filled by pull-push between those that are known: above 0. All are 0
/// where none is known.
///
/// # Panics
/// When there is not a number for every pixel.
pub fn fill_numbers(size: FrameSize, known: [&[f32]; 2]) -> [Vec<f32>; 2] {
    assert!(known.iter().all(|numbers| numbers.len() == size.pixels()), "a number for every pixel");
    let weighted = |number: f32| if number > 0.0 { [number, 1.0] } else { [0.0; 2] };
    let pair = |(a, b): (&f32, &f32)| {
        let ([a, a_weight], [b, b_weight]) = (weighted(*a), weighted(*b));
        Pair([a, a_weight, b, b_weight])
    };
    let filled = filled(size, known[0].par_iter().zip(known[1]).map(pair).collect());
    [0, 2].map(|c| filled.par_iter().map(|pair| pair.0[c]).collect())
}

/// Pull: halve the picture, averaging what is known, until one pixel is left. Push: on the way back,
/// blend what is unknown with the coarser level (Gortler et al. 1996, weights saturating at 1).
fn filled<P: Weighted>(size: FrameSize, pixels: Vec<P>) -> Vec<P> {
    let mut levels = vec![Level { width: size.width as usize, height: size.height as usize, pixels }];
    while levels[levels.len() - 1].pixels.len() > 1 {
        let coarser = pull(&levels[levels.len() - 1]);
        levels.push(coarser);
    }
    let mut coarse = levels.pop().expect("a frame has at least one pixel");
    for p in &mut coarse.pixels {
        *p = p.divided();
    }
    while let Some(mut fine) = levels.pop() {
        push(&coarse, &mut fine);
        coarse = fine;
    }
    coarse.pixels
}

/// Half the size, rounded up: sums of 2×2 pixels, with the total weight cut to 1.
fn pull<P: Weighted>(fine: &Level<P>) -> Level<P> {
    let (width, height) = (fine.width.div_ceil(2), fine.height.div_ceil(2));
    let mut pixels = vec![P::NOTHING; width * height];
    pixels.par_chunks_mut(width * ROWS).enumerate().for_each(|(chunk, rows)| {
        for (row, out) in rows.chunks_mut(width).enumerate() {
            let y = 2 * (chunk * ROWS + row);
            let top = &fine.pixels[y * fine.width..][..fine.width];
            let below =
                if y + 1 < fine.height { &fine.pixels[(y + 1) * fine.width..][..fine.width] } else { &[] };
            for (x, p) in out.iter_mut().enumerate() {
                let others = [top.get(2 * x + 1), below.get(2 * x), below.get(2 * x + 1)];
                *p = others.into_iter().flatten().fold(top[2 * x], |sum, other| sum.plus(*other)).cut();
            }
        }
    });
    Level { width, height, pixels }
}

/// Blends every pixel of `fine` with the bilinear value of `coarse` by what its weight leaves open.
fn push<P: Weighted>(coarse: &Level<P>, fine: &mut Level<P>) {
    let width = fine.width;
    fine.pixels.par_chunks_mut(width * ROWS).enumerate().for_each(|(chunk, rows)| {
        for (row, out) in rows.chunks_mut(width).enumerate() {
            let (y0, y1, fy) = neighbours(chunk * ROWS + row, coarse.height);
            let above = &coarse.pixels[y0 * coarse.width..][..coarse.width];
            let below = &coarse.pixels[y1 * coarse.width..][..coarse.width];
            for (x, p) in out.iter_mut().enumerate() {
                if p.is_whole() {
                    continue;
                }
                let (x0, x1, fx) = neighbours(x, coarse.width);
                let top = above[x0].towards(above[x1], fx);
                let low = below[x0].towards(below[x1], fx);
                *p = p.blended(top.towards(low, fy));
            }
        }
    });
}

/// The two coarse pixels around the centre of fine pixel `i`, and how far between them it lies.
fn neighbours(i: usize, coarse: usize) -> (usize, usize, f32) {
    let nearest = i / 2;
    if i.is_multiple_of(2) {
        (nearest.saturating_sub(1), nearest, 0.75)
    } else {
        (nearest, (nearest + 1).min(coarse - 1), 0.25)
    }
}
