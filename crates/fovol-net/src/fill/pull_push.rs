use fovol_core::{Frame, SparseFrame};
use rayon::prelude::*;

/// Pixel of a pyramid level: values premultiplied by a weight 0…1, and that weight.
pub trait Weighted: Copy + Send + Sync {
    const NOTHING: Self;

    fn plus(self, other: Self) -> Self;

    /// Scales values and weight so that the weight is 1 at most.
    fn cut(self) -> Self;

    /// Divides by the weight; zero where the weight is 0.
    fn divided(self) -> Self;

    /// Whether the weight is 1, so that coarser levels add nothing.
    fn is_whole(self) -> bool;

    /// Adds `coarse`, whose weight is 1, multiplied by the weight that is missing here to 1.
    fn blended(self, coarse: Self) -> Self;

    /// Interpolates linearly from `self` to `other`; `part` is 0…1.
    fn towards(self, other: Self, part: f32) -> Self;
}

/// Two values, each followed by its weight.
#[derive(Debug, Clone, Copy)]
pub struct Pair([f32; 4]);

impl Pair {
    /// Makes a pixel of two values. Values above 0 get weight 1, others 0.
    #[inline(always)]
    fn known(numbers: [f32; 2]) -> Self {
        let [a, b] = numbers.map(|number| if number > 0.0 { [number, 1.0] } else { [0.0; 2] });
        Self([a[0], a[1], b[0], b[1]])
    }

    /// Both values, without weights.
    #[inline(always)]
    pub fn numbers(self) -> [f32; 2] {
        [self.0[0], self.0[2]]
    }
}

/// Red, green and blue, and their weight.
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
#[derive(Debug, Clone)]
pub struct Level<P> {
    width: usize,
    height: usize,
    pixels: Vec<P>,
}

/// Number of rows that one task works on.
const ROWS: usize = 32;

impl<P: Weighted> Level<P> {
    /// Number of columns.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Interpolates this level bilinearly at pixel (x, y) of the next finer level.
    #[inline(always)]
    pub fn between(&self, [x, y]: [usize; 2]) -> P {
        let ((x0, x1, fx), (y0, y1, fy)) = (neighbours(x, self.width), neighbours(y, self.height));
        let at = |x: usize, y: usize| self.pixels[y * self.width + x];
        at(x0, y0).towards(at(x1, y0), fx).towards(at(x0, y1).towards(at(x1, y1), fx), fy)
    }
}

impl Level<Pair> {
    /// Interpolates between two rows of this level for row `y` of the next finer level. Writes value number
    /// `picture` of each pixel to `line`.
    #[inline(always)]
    pub fn line(&self, y: usize, picture: usize, line: &mut [f32]) {
        let (above, below, part) = neighbours(y, self.height);
        let row = |y: usize| &self.pixels[y * self.width..][..self.width];
        for (to, (above, below)) in line.iter_mut().zip(row(above).iter().zip(row(below))) {
            let (above, below) = (above.0[2 * picture], below.0[2 * picture]);
            *to = above + part * (below - above);
        }
    }
}

/// Fills `sparse` by pull-push. Sampled pixels keep their values exactly.
pub fn pull_push(sparse: &SparseFrame) -> Frame {
    let [width, height] = [sparse.size().width, sparse.size().height].map(|side| side as usize);
    let finest = Level { width, height, pixels: sparse.to_frame().into_pixels() };
    Frame::from_pixels(sparse.size(), filled(finest).pixels)
        .expect("the finest level has the size of the frame")
}

/// Fills `finest` by pull-push (Gortler et al. 1996, weights saturating at 1). Pull halves the image, averaging
/// known values, until one pixel is left. Push goes back and blends unknown pixels with the coarser level.
pub fn filled<P: Weighted>(finest: Level<P>) -> Level<P> {
    let mut levels = vec![finest];
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
    coarse
}

/// Pulls two scalar images to half their size. Values above 0 are known.
pub fn halved([width, height]: [usize; 2], known: [&[f32]; 2]) -> Level<Pair> {
    let coarse = [width, height].map(|side| side.div_ceil(2));
    let row = |y: usize| known.map(|numbers| if y < height { &numbers[y * width..][..width] } else { &[] });
    halves(coarse, |y, out| {
        let ([a_top, b_top], [a_below, b_below]) = (row(2 * y), row(2 * y + 1));
        for (x, p) in out.iter_mut().enumerate() {
            let of = |a: &[f32], b: &[f32], x: usize| Some(Pair::known([*a.get(x)?, *b.get(x)?]));
            let others =
                [of(a_top, b_top, 2 * x + 1), of(a_below, b_below, 2 * x), of(a_below, b_below, 2 * x + 1)];
            let first = Pair::known([a_top[2 * x], b_top[2 * x]]);
            *p = others.into_iter().flatten().fold(first, Pair::plus).cut();
        }
    })
}

/// Pulls to half the size, rounded up: sums of 2×2 pixels, with the weight limited to 1.
fn pull<P: Weighted>(fine: &Level<P>) -> Level<P> {
    let row = |y: usize| if y < fine.height { &fine.pixels[y * fine.width..][..fine.width] } else { &[] };
    halves([fine.width, fine.height].map(|side| side.div_ceil(2)), |y, out| {
        let (top, below) = (row(2 * y), row(2 * y + 1));
        for (x, p) in out.iter_mut().enumerate() {
            let others = [top.get(2 * x + 1), below.get(2 * x), below.get(2 * x + 1)];
            *p = others.into_iter().flatten().fold(top[2 * x], |sum, other| sum.plus(*other)).cut();
        }
    })
}

/// Makes a level, of which `row` writes the rows.
fn halves<P: Weighted>([width, height]: [usize; 2], row: impl Fn(usize, &mut [P]) + Sync) -> Level<P> {
    let mut pixels = vec![P::NOTHING; width * height];
    pixels.par_chunks_mut(width * ROWS).enumerate().for_each(|(chunk, rows)| {
        rows.chunks_mut(width).enumerate().for_each(|(number, out)| row(chunk * ROWS + number, out));
    });
    Level { width, height, pixels }
}

/// Pushes: blends every pixel of `fine` with the bilinear value of `coarse`, by the weight that is missing to 1.
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

/// Returns the two coarse pixels around the centre of fine pixel `i`, and its position between them, 0…1.
fn neighbours(i: usize, coarse: usize) -> (usize, usize, f32) {
    let nearest = i / 2;
    if i.is_multiple_of(2) {
        (nearest.saturating_sub(1), nearest, 0.75)
    } else {
        (nearest, (nearest + 1).min(coarse - 1), 0.25)
    }
}
