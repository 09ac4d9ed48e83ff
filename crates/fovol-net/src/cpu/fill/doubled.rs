//! Doubles the resolution of pictures, row by row.

use crate::cpu::fill::pyramid::{Put, double};
use crate::cpu::tensor::Tensor;
use crate::cpu::tensor::upsampling::halves;
use fovol_simd::{Pixels, SimdF32};
use glam::Vec4;

/// Interpolates `picture` (three channels) at pixel (`y`, `x`) of twice its resolution, as [`DoubledRow::make`]
/// does. The fourth value is 0.
#[inline(always)]
pub fn doubled(picture: &Tensor, [y, x]: [usize; 2]) -> Vec4 {
    let [(a, wa), (b, wb)] = halves(y, picture.height);
    let [(near, wn), (far, wf)] = halves(x, picture.width);
    let (a, b) = (picture.row(a).as_chunks::<3>().0, picture.row(b).as_chunks::<3>().0);
    let between = |x: usize| {
        let (a, b) = (&a[x], &b[x]);
        Vec4::new(wa * a[0] + wb * b[0], wa * a[1] + wb * b[1], wa * a[2] + wb * b[2], 0.0)
    };
    wn * between(near) + wf * between(far)
}

/// A row of twice the resolution, and scratch memory. Pixels have a fourth value, 0, so that each fills a vector.
#[derive(Debug, Default)]
pub struct DoubledRow {
    /// Row interpolated between two rows of the picture, with one more pixel on both sides.
    between: Vec<[f32; 4]>,
    /// The row of twice the resolution.
    pub row: Vec<[f32; 4]>,
}

impl DoubledRow {
    /// Sets [`Self::row`] to row `y` of `picture` (three channels) at twice its resolution: bilinear between pixel
    /// centres, replicated at the border.
    #[inline(always)]
    pub fn make<V: SimdF32>(&mut self, picture: &Tensor, y: usize, some: V) {
        let Self { between, row } = self;
        let [(a, wa), (b, wb)] = halves(y, picture.height);
        let width = picture.width;
        between.resize(width + 2, [0.0; 4]);
        row.resize(2 * width, [0.0; 4]);
        let (a, b) = (picture.row(a), picture.row(b));
        // Whole vectors read values of the next pixels, as long as there are any.
        let (pixels, numbers) = (V::N / 4, between[1..].as_flattened_mut());
        let whole = if a.len() < V::N { 0 } else { (a.len() - V::N) / (3 * pixels) + 1 };
        for vector in 0..whole {
            let at = vector * 3 * pixels;
            let mean = some.load(&a[at..]) * some.splat(wa) + some.load(&b[at..]) * some.splat(wb);
            mean.with_zeros().store(&mut numbers[vector * V::N..]);
        }
        let rest = a.as_chunks::<3>().0.iter().zip(b.as_chunks::<3>().0).skip(whole * pixels);
        for (to, (a, b)) in between[1..].iter_mut().skip(whole * pixels).zip(rest) {
            *to = [wa * a[0] + wb * b[0], wa * a[1] + wb * b[1], wa * a[2] + wb * b[2], 0.0];
        }
        double(between, row, Storing, some);
    }
}

#[derive(Debug, Clone, Copy)]
struct Storing;

impl Put for Storing {
    #[inline(always)]
    fn put<V: Pixels>(self, pixels: V, to: &mut [f32]) {
        pixels.store(to);
    }
}
