//! Places of probe pixels.

use fovol_core::{Frame, FrameSize, Pixel, Region};

/// Distribution of probe pixels over a region.
///
/// Errors lie mostly at edges. Half of the probes are scattered evenly, half by the contrast of the frame that is shown.
/// Their weights make up for it, so that weighted means are those of the whole region.
#[derive(Debug, Clone, PartialEq)]
pub struct Scatter {
    region: Region,
    /// Sums of the cells' probabilities up to each cell, row by row.
    sums: Vec<f64>,
    columns: u32,
}

/// Most cells along a side of the region.
const CELLS: u32 = 48;
/// Pixels of a frame whose contrast is looked at, about.
const LOOKED_AT: usize = 100_000;
/// Part of the probes that is scattered evenly.
const EVEN: f64 = 0.5;

impl Scatter {
    /// Even distribution over `region`.
    pub fn even(region: Region) -> Self {
        Self::by(region, |_| 0.0)
    }

    /// Distribution over `region` of frames of `size` by the contrast of `shown`, which has any size.
    pub fn by_contrast(region: Region, size: FrameSize, shown: &Frame) -> Self {
        let small = shown.size();
        let every = (small.pixels() / LOOKED_AT).isqrt().max(1);
        let along =
            |at: u32, large: u32, small: u32| (u64::from(at) * u64::from(small) / u64::from(large)) as u32;
        Self::by(region, |cell| {
            let ends = |from: u32, length: u32, large: u32, small: u32| {
                let first = along(from, large, small);
                (first, along(from + length, large, small).clamp(first + 1, small))
            };
            let (left, right) = ends(cell.x, cell.size.width, size.width, small.width);
            let (top, bottom) = ends(cell.y, cell.size.height, size.height, small.height);
            let (mut sum, mut count) = (0.0, 0);
            for y in (top..bottom).step_by(every) {
                for x in (left..right).step_by(every) {
                    let here = shown.pixel(x, y);
                    let beside = shown.pixel((x + 1).min(small.width - 1), y);
                    let below = shown.pixel(x, (y + 1).min(small.height - 1));
                    let square = |other: [f32; 4]| (0..3).map(|c| (here[c] - other[c]).powi(2)).sum::<f32>();
                    sum += f64::from(square(beside) + square(below));
                    count += 1;
                }
            }
            (sum / f64::from(count)).sqrt() * cell.size.pixels() as f64
        })
    }

    /// Distribution in which cells count by their `importance`.
    fn by(region: Region, importance: impl Fn(Region) -> f64) -> Self {
        let columns = region.size.width.min(CELLS);
        let rows = region.size.height.min(CELLS);
        let cells: Vec<Region> = (0..columns * rows).map(|i| cell(region, [columns, rows], i)).collect();
        let important: Vec<f64> = cells.iter().map(|cell| importance(*cell)).collect();
        let all: f64 = important.iter().sum();
        let even = if all > 0.0 { EVEN } else { 1.0 };
        let mut sum = 0.0;
        let sums = cells.iter().zip(important).map(|(cell, important)| {
            let area = cell.size.pixels() as f64 / region.size.pixels() as f64;
            sum += even * area + if all > 0.0 { (1.0 - even) * important / all } else { 0.0 };
            sum
        });
        Self { region, sums: sums.collect(), columns }
    }

    /// The region.
    pub fn region(&self) -> Region {
        self.region
    }

    /// Pixel at the place (`u`, `v`) of the unit square, and its weight.
    fn pixel(&self, [u, v]: [f64; 2]) -> (Pixel, f64) {
        let at = self.sums.partition_point(|sum| *sum <= u).min(self.sums.len() - 1);
        let before = if at == 0 { 0.0 } else { self.sums[at - 1] };
        let probability = self.sums[at] - before;
        let rows = self.sums.len() as u32 / self.columns;
        let cell = cell(self.region, [self.columns, rows], at as u32);
        let along = |from: u32, length: u32, part: f64| {
            (f64::from(from) + (part.clamp(0.0, 1.0) * f64::from(length)).min(f64::from(length - 1)).floor())
                as u16
        };
        let x = along(cell.x, cell.size.width, (u - before) / probability);
        let y = along(cell.y, cell.size.height, v);
        let area = cell.size.pixels() as f64 / self.region.size.pixels() as f64;
        (Pixel { x, y }, area / probability)
    }

    /// `count` pixels of frame `number` with their weights: Roberts' sequence R₂, which goes on from frame to frame.
    pub fn pixels(&self, number: u32, count: usize) -> Vec<(Pixel, f64)> {
        const STEP: [u64; 2] = [13_925_308_310_254_404_935, 10_511_728_000_904_283_327];
        let first = u64::from(number).wrapping_mul(count as u64);
        let unit = |i: u64, axis: usize| {
            let fraction = i.wrapping_add(1).wrapping_mul(STEP[axis]) >> 11;
            fraction as f64 / (1u64 << 53) as f64
        };
        let place = |i: u64| [unit(first.wrapping_add(i), 0), unit(first.wrapping_add(i), 1)];
        (0..count as u64).map(|i| self.pixel(place(i))).collect()
    }
}

/// Cell number `i` of `columns` and `rows` in `region`.
fn cell(region: Region, [columns, rows]: [u32; 2], i: u32) -> Region {
    let part = |at: u32, of: u32, length: u32| (u64::from(at) * u64::from(length) / u64::from(of)) as u32;
    let ends = |at: u32, of: u32, length: u32| (part(at, of, length), part(at + 1, of, length));
    let (left, right) = ends(i % columns, columns, region.size.width);
    let (top, bottom) = ends(i / columns, rows, region.size.height);
    let size = FrameSize { width: right - left, height: bottom - top };
    Region { x: region.x + left, y: region.y + top, size }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn region() -> Region {
        Region { x: 10, y: 20, size: FrameSize::new(100, 50).unwrap() }
    }

    #[test]
    fn probes_are_scattered_evenly_and_move_on() {
        let scatter = Scatter::even(region());
        let (first, second) = (scatter.pixels(0, 400), scatter.pixels(1, 400));
        assert_ne!(first, second);
        let mut cells = [0u32; 50];
        for (pixel, weight) in first.iter().chain(&second) {
            let (x, y) = (u32::from(pixel.x) - 10, u32::from(pixel.y) - 20);
            assert!(x < 100 && y < 50 && (weight - 1.0).abs() < 1e-9);
            cells[(y / 10 * 10 + x / 10) as usize] += 1;
        }
        assert!(cells.iter().all(|count| (8..=26).contains(count)), "{cells:?}");
    }

    #[test]
    fn edges_have_more_probes_and_weights_make_up_for_it() {
        // A frame of half the size with one edge, at column 30 of 60.
        let size = FrameSize::new(120, 80).unwrap();
        let pixels =
            (0..60 * 40).map(|i| if i % 60 < 30 { [0.0, 0.0, 0.0, 1.0] } else { [1.0; 4] }).collect();
        let shown = Frame::from_pixels(FrameSize::new(60, 40).unwrap(), pixels).unwrap();
        let scatter = Scatter::by_contrast(region(), size, &shown);
        let probes: Vec<(Pixel, f64)> = (0..20).flat_map(|number| scatter.pixels(number, 200)).collect();
        let is_edge = |pixel: Pixel| (56..64).contains(&pixel.x);
        let edge = probes.iter().filter(|(pixel, _)| is_edge(*pixel)).count() as f64 / 4000.0;
        assert!(edge > 0.4, "{edge}");
        // The edge has 8 of 100 columns.
        let weighted: f64 =
            probes.iter().filter(|(pixel, _)| is_edge(*pixel)).map(|(_, weight)| weight).sum();
        assert!((weighted / 4000.0 - 0.08).abs() < 0.01, "{weighted}");
        let all: f64 = probes.iter().map(|(_, weight)| weight).sum();
        assert!((all / 4000.0 - 1.0).abs() < 0.05, "{all}");
        assert!(probes.iter().all(|(_, weight)| *weight <= 1.0 / EVEN + 1e-9));
    }

    #[test]
    fn small_regions_have_small_cells() {
        let one = Region { x: 3, y: 4, size: FrameSize::new(1, 2).unwrap() };
        let found = Scatter::even(one).pixels(5, 10);
        assert!(found.iter().all(|(pixel, _)| pixel.x == 3 && (4..6).contains(&pixel.y)));
    }
}
