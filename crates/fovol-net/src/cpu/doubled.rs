//! Rows of pictures at twice their resolution.

use super::map::Map;
use super::patch::halves;

/// What making such rows needs.
#[derive(Debug, Default)]
pub struct DoubledRow {
    /// A row between two, with one pixel more on both sides.
    between: Vec<f32>,
    /// The row.
    pub row: Vec<f32>,
}

impl DoubledRow {
    /// Makes [`Self::row`] row `y` of `picture` (three channels) at twice its resolution: bilinear between the centres of
    /// pixels, replicated at the border.
    #[inline(always)]
    pub fn make(&mut self, picture: &Map, y: usize) {
        let Self { between, row } = self;
        let [(a, wa), (b, wb)] = halves(y, picture.height);
        let length = 3 * picture.width;
        between.resize(length + 6, 0.0);
        row.resize(2 * length, 0.0);
        let inside = between[3..length + 3].iter_mut();
        for (to, (a, b)) in inside.zip(picture.row(a).iter().zip(picture.row(b))) {
            *to = wa * a + wb * b;
        }
        between.copy_within(3..6, 0);
        between.copy_within(length..length + 3, length + 3);
        for (x, to) in row.as_chunks_mut::<6>().0.iter_mut().enumerate() {
            let Some(around) = between[3 * x..].first_chunk::<9>() else { return };
            for c in 0..3 {
                let near = 0.75 * around[3 + c];
                to[c] = near + 0.25 * around[c];
                to[3 + c] = near + 0.25 * around[6 + c];
            }
        }
    }
}
