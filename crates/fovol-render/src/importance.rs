use fovol_core::Region;

/// How important samples are over a region, for each cell of 4×4 pixels.
///
/// Importance is relative: its mean over the cells is 1. Densities follow it; see [`crate::cpu::adaptive_mask`].
#[derive(Debug, Clone, PartialEq)]
pub struct Importance {
    region: Region,
    columns: usize,
    cells: Vec<f32>,
}

/// Share of the density that every place gets, whatever its importance: f₀.
const FLOOR: f32 = 0.25;

impl Importance {
    /// Edge of a cell in pixels.
    pub const CELL: usize = 4;

    /// Number of cells along x and y of `region`.
    pub fn cells_of(region: Region) -> [usize; 2] {
        [region.size.width, region.size.height].map(|side| (side as usize).div_ceil(Self::CELL))
    }

    /// Importance of the cells of `region`, row by row, from any numbers of 0 or more. Numbers that are not finite count
    /// as 0. If all are 0, every cell is as important as the others.
    ///
    /// # Panics
    /// If there is not one number for every cell.
    pub fn new(region: Region, numbers: Vec<f32>) -> Self {
        let [columns, rows] = Self::cells_of(region);
        assert_eq!(numbers.len(), columns * rows, "a number for every cell");
        let known = |number: f32| if number.is_finite() { number.max(0.0) } else { 0.0 };
        let sum: f64 = numbers.iter().map(|number| f64::from(known(*number))).sum();
        let scale = if sum > 0.0 { (numbers.len() as f64 / sum) as f32 } else { 0.0 };
        let cells = numbers.into_iter().map(|number| {
            let relative = if scale > 0.0 { known(number) * scale } else { 1.0 };
            FLOOR + (1.0 - FLOOR) * relative
        });
        Self { region, columns, cells: cells.collect() }
    }

    /// Writes 1 / importance of the pixels of row `y` of the frame to `row`, from column `first` on.
    pub(crate) fn put_inverse(&self, y: u32, first: u32, row: &mut [f32]) {
        row.fill(1.0);
        let Region { x: left, y: top, size } = self.region;
        let Some(y) = y.checked_sub(top).filter(|y| *y < size.height) else { return };
        let cells = &self.cells[y as usize / Self::CELL * self.columns..][..self.columns];
        let end = (left + size.width).saturating_sub(first) as usize;
        let skipped = first.saturating_sub(left) as usize;
        let begin = left.saturating_sub(first) as usize;
        let length = row.len();
        let Some(inside) = row.get_mut(begin..end.min(length)) else { return };
        for (i, to) in inside.iter_mut().enumerate() {
            *to = 1.0 / cells[(skipped + i) / Self::CELL];
        }
    }

    /// Importance of pixel (`x`, `y`) of the frame: 0.25 or more. It is 1 outside the region.
    #[inline]
    pub fn at(&self, x: u32, y: u32) -> f32 {
        self.region.inside(x, y).map_or(1.0, |[x, y]| {
            self.cells[y as usize / Self::CELL * self.columns + x as usize / Self::CELL]
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fovol_core::FrameSize;

    #[test]
    fn importance_is_relative_and_nowhere_nothing() {
        let region = Region { x: 8, y: 3, size: FrameSize { width: 9, height: 4 } };
        assert_eq!(Importance::cells_of(region), [3, 1]);
        let importance = Importance::new(region, vec![0.0, 0.02, f32::NAN]);
        assert_eq!([importance.at(8, 3), importance.at(12, 6), importance.at(16, 3)], [0.25, 2.5, 0.25]);
        assert_eq!([importance.at(7, 3), importance.at(17, 3), importance.at(8, 7)], [1.0; 3]);
        assert_eq!(Importance::new(region, vec![0.0; 3]).at(8, 3), 1.0);
    }
}
