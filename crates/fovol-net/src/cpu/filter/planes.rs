use crate::cpu::conv::pack::Floats;
use crate::cpu::conv::patch::{Access, Memory, Source, Window};
use crate::cpu::tensor::rows::View;
use crate::plan::{Padding, Taps};
use fovol_simd::{MOST_LANES, Simd, SimdF32, SimdF32Op};
use std::ops::Range;

/// Channels of a picture; kernels only filter pictures.
pub const CHANNELS: usize = 3;

/// TensorBuf of the rows that kernels of `taps` read for `count` output rows from `y` on. Row y has number y + 1.
pub fn rows_for(taps: Taps, y: usize, count: usize) -> Range<usize> {
    match taps {
        Taps::Around => y..y + count + 2,
        Taps::Centre => y + 1..y + 1 + count,
    }
}

/// A row of a picture, split into planes. Pixel x = expand·i + phase has index i + 1 in the planes of its phase,
/// one for each colour. Beyond both ends are zeros.
#[derive(Debug, Default)]
pub struct Planes {
    numbers: Vec<f32>,
    /// Distance between planes.
    stride: usize,
}

impl Planes {
    /// Values of colour `c` of the pixels of phase `phase`.
    #[inline(always)]
    pub fn of(&self, c: usize, phase: usize) -> &[f32] {
        &self.numbers[(phase * CHANNELS + c) * self.stride..][..self.stride]
    }

    /// Splits `row` into these planes, or fills them with zeros.
    fn take(&mut self, row: Option<&[f32]>, width: usize, expand: usize, simd: Simd) {
        let cells = width / expand;
        // The last vector may begin at the last pixel, and its right neighbour one beyond.
        self.stride = cells + 2 + MOST_LANES;
        self.numbers.resize(expand * CHANNELS * self.stride, 0.0);
        let Some(row) = row else { return self.numbers.fill(0.0) };
        for plane in self.numbers.chunks_exact_mut(self.stride) {
            plane[0] = 0.0;
            plane[cells + 1..].fill(0.0);
        }
        simd.in_vectors(TakingApart { row, planes: self, expand });
    }
}

struct TakingApart<'a> {
    row: &'a [f32],
    planes: &'a mut Planes,
    expand: usize,
}

impl SimdF32Op for TakingApart<'_> {
    type Output = ();

    #[inline(always)]
    fn run<V: SimdF32>(self, some: V) {
        let Self { row, planes: Planes { numbers, stride }, expand } = self;
        match expand {
            1 => take_apart::<V, 1, { CHANNELS }>(row, numbers, *stride, some),
            _ => take_apart::<V, 2, { 2 * CHANNELS }>(row, numbers, *stride, some),
        }
    }
}

/// Splits `row` into `N` planes: three values for each of `PIXELS` pixels.
#[inline(always)]
fn take_apart<V: SimdF32, const PIXELS: usize, const N: usize>(
    row: &[f32],
    numbers: &mut [f32],
    stride: usize,
    some: V,
) {
    let cells = row.len() / N;
    let whole = cells / V::N * V::N;
    for first in (0..whole).step_by(V::N) {
        let from = &row[first * N..][..V::N * N];
        // Colours of as many pixels as a vector has lanes, one plane after the other.
        let mut colours = [[some; CHANNELS]; PIXELS];
        for (number, colours) in colours.iter_mut().enumerate() {
            let from = &from[number * CHANNELS * V::N..];
            *colours =
                V::deinterleave3([some.load(from), some.load(&from[V::N..]), some.load(&from[2 * V::N..])]);
        }
        for c in 0..CHANNELS {
            let mut phases = [colours[0][c]; PIXELS];
            if PIXELS == 2 {
                phases.copy_from_slice(&colours[0][c].deinterleave2(colours[1][c]));
            }
            for (phase, numbers_of_phase) in phases.into_iter().enumerate() {
                numbers_of_phase.store(&mut numbers[(phase * CHANNELS + c) * stride + 1 + first..]);
            }
        }
    }
    for cell in whole..cells {
        for n in 0..N {
            numbers[n * stride + 1 + cell] = row[cell * N + n];
        }
    }
}

/// Ring buffer of the rows of an image that kernels read, split into planes.
#[derive(Debug, Default)]
pub struct Ring {
    /// Row number n (see [`rows_for`]) has index n mod 4.
    rows: [Planes; 4],
    held: [Option<usize>; 4],
    between: Vec<f32>,
}

impl Ring {
    /// Empties the buffer, for the next image.
    pub fn forget(&mut self) {
        self.held = [None; 4];
    }

    /// Row number `n`.
    #[inline(always)]
    pub fn row(&self, n: usize) -> &Planes {
        &self.rows[n % 4]
    }

    /// Loads the rows `numbers` of `image` that are not in the buffer yet.
    pub fn hold(
        &mut self,
        image: &Source<'_>,
        numbers: Range<usize>,
        expand: usize,
        (simd, memory): (Simd, &mut Memory),
    ) {
        let width = image.size()[1];
        for number in numbers {
            if self.held[number % 4] == Some(number) {
                continue;
            }
            let row = row_of(image, number as isize - 1, &mut self.between, (simd, memory));
            self.rows[number % 4].take(row, width, expand, simd);
            self.held[number % 4] = Some(number);
        }
    }
}

/// Returns row `y` of `image`, assembled in `between` if it is transformed during reading; `None` beyond the
/// border.
fn row_of<'a>(
    image: &Source<'a>,
    y: isize,
    between: &'a mut Vec<f32>,
    (simd, memory): (Simd, &mut Memory),
) -> Option<&'a [f32]> {
    let [height, width] = image.size();
    match (&image.rows, image.access) {
        (View::F32(rows), Access::SAME) => (0..height as isize).contains(&y).then(|| {
            rows.prefetch_after(y as usize, 0..width * CHANNELS);
            rows.row(y as usize)
        }),
        _ => {
            between.resize(width * CHANNELS, 0.0);
            let window = Window { y, x: 0, rows: 1, columns: width };
            let to = (Floats::<f32>::default(), &mut between[..], CHANNELS);
            window.row(&[*image], Padding::Zero, 0, to, (simd, memory)).then_some(&between[..])
        }
    }
}
