//! Rows of pictures at twice their resolution.

use super::floats::Floats;
use super::map::Map;
use super::patch::halves;
use super::pyramid::{Put, double};
use glam::Vec4;

/// What `picture` (three channels) has at pixel (`y`, `x`) at twice its resolution, as [`DoubledRow::make`] has it, and 0.
#[inline(always)]
pub fn doubled(picture: &Map, [y, x]: [usize; 2]) -> Vec4 {
    let [(a, wa), (b, wb)] = halves(y, picture.height);
    let [(near, wn), (far, wf)] = halves(x, picture.width);
    let (a, b) = (picture.row(a).as_chunks::<3>().0, picture.row(b).as_chunks::<3>().0);
    let between = |x: usize| {
        let (a, b) = (&a[x], &b[x]);
        Vec4::new(wa * a[0] + wb * b[0], wa * a[1] + wb * b[1], wa * a[2] + wb * b[2], 0.0)
    };
    wn * between(near) + wf * between(far)
}

/// What making such rows needs. Pixels have a fourth number, 0, so that each is a vector.
#[derive(Debug, Default)]
pub struct DoubledRow {
    /// A row between two, with one pixel more on both sides.
    between: Vec<[f32; 4]>,
    /// The row.
    pub row: Vec<[f32; 4]>,
}

impl DoubledRow {
    /// Makes [`Self::row`] row `y` of `picture` (three channels) at twice its resolution: bilinear between the centres of
    /// pixels, replicated at the border.
    #[inline(always)]
    pub fn make<V: Floats>(&mut self, picture: &Map, y: usize, some: V) {
        let Self { between, row } = self;
        let [(a, wa), (b, wb)] = halves(y, picture.height);
        let width = picture.width;
        between.resize(width + 2, [0.0; 4]);
        row.resize(2 * width, [0.0; 4]);
        let (a, b) = (picture.row(a), picture.row(b));
        // With the first number of the next pixel, as vectors are; the last pixel has no next one.
        let windows = a.windows(4).step_by(3).zip(b.windows(4).step_by(3));
        for (to, (a, b)) in between[1..].iter_mut().zip(windows) {
            *to = (wa * Vec4::from_slice(a) + wb * Vec4::from_slice(b)).with_w(0.0).to_array();
        }
        let last = 3 * (width - 1);
        let ends = a[last..].iter().zip(&b[last..]);
        between[width][..3].iter_mut().zip(ends).for_each(|(to, (a, b))| *to = wa * a + wb * b);
        between[width][3] = 0.0;
        double(between, row, Storing, some);
    }
}

#[derive(Debug, Clone, Copy)]
struct Storing;

impl Put for Storing {
    #[inline(always)]
    fn put<V: Floats>(self, pixels: V, to: &mut [f32]) {
        pixels.store(to);
    }
}
