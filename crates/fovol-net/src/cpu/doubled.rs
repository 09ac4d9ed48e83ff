//! Rows of pictures at twice their resolution.

use super::map::Map;
use super::patch::halves;
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
    pub fn make(&mut self, picture: &Map, y: usize) {
        let Self { between, row } = self;
        let [(a, wa), (b, wb)] = halves(y, picture.height);
        let width = picture.width;
        between.resize(width + 2, [0.0; 4]);
        row.resize(2 * width, [0.0; 4]);
        let rows = picture.row(a).as_chunks::<3>().0.iter().zip(picture.row(b).as_chunks::<3>().0);
        for (to, (a, b)) in between[1..=width].iter_mut().zip(rows) {
            *to = [wa * a[0] + wb * b[0], wa * a[1] + wb * b[1], wa * a[2] + wb * b[2], 0.0];
        }
        (between[0], between[width + 1]) = (between[1], between[width]);
        for (to, around) in row.as_chunks_mut::<2>().0.iter_mut().zip(between.array_windows::<3>()) {
            let [left, near, right] = around.map(Vec4::from_array);
            let near = 0.75 * near;
            *to = [(near + 0.25 * left).to_array(), (near + 0.25 * right).to_array()];
        }
    }
}
