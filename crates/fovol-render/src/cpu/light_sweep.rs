//! Transmittance towards the light, swept through the volume slice by slice.

use super::light_crossing::{Crossed, CrossedGradients};
use crate::scene::{Bricks, Crossing, GradientTable, LightSlices};
use fovol_core::{Interpolation, LongWork, memory, stop};
use fovol_simd::{MOST_LANES, Simd, SimdOp};
use rayon::prelude::*;
use std::ops::Range;

/// Rows of columns that one task sweeps.
const BAND: usize = 16;

/// Volume through which light is swept.
pub struct LightSweep<'a> {
    /// The voxels.
    pub bricks: &'a Bricks,
    /// Order of the slices.
    pub slices: LightSlices,
    /// Lowest and highest corner of the part that casts shadows, in voxel-centre coordinates.
    pub clip: [[f32; 3]; 2],
    /// Planes that cut that part: weights of coordinates and a constant, whose sum is 0 or more inside.
    pub planes: &'a [[f32; 4]],
    /// Transmittance from slice to slice for every entry of the transfer table; NaN last. With gradients, the optical
    /// depth.
    pub transmittance: &'a [f32],
    /// Transmittance of the first stretch of a shadow ray, likewise.
    pub near_transmittance: &'a [f32],
    /// Lengths of gradients and the factors of the extinction for them, where it depends on them.
    pub gradient: Option<(&'a Bricks, &'a GradientTable)>,
    /// Way from a point to the sample of that stretch, in voxels.
    pub first_sample: [f32; 3],
    /// Instruction set.
    pub simd: Simd,
}

/// Transmittance of every voxel in steps of 1/255.
pub struct Swept {
    slices: LightSlices,
    dims: [usize; 3],
    bytes: Vec<u8>,
}

impl Swept {
    /// Writes the transmittance of a line of voxels along x, from `voxel` on.
    pub fn put(&self, voxel: [usize; 3], line: &mut [u8]) {
        let along = self.slices.axes[2];
        let first = row_of(&self.slices, self.dims, voxel) + voxel[along];
        if along == 0 {
            line.copy_from_slice(&self.bytes[first..first + line.len()]);
        } else {
            let next = self.bytes[first..].iter().step_by(self.dims[along]);
            line.iter_mut().zip(next).for_each(|(to, byte)| *to = *byte);
        }
    }
}

/// Where the row of `voxel` begins: rows lie in the order of z, then of the remaining axis.
fn row_of(slices: &LightSlices, dims: [usize; 3], voxel: [usize; 3]) -> usize {
    let along = slices.axes[2];
    let inner = 1 - along;
    (voxel[2] * dims[inner] + voxel[inner]) * dims[along]
}

impl LightSweep<'_> {
    /// Sweeps the whole volume.
    ///
    /// # Errors
    /// Too little memory.
    pub fn swept(&self) -> Result<Swept, memory::Shortage> {
        let dims = self.bricks.layout().dims;
        let [rows, length] = self.slices.size();
        let count = self.slices.count();
        let what = "the transmittance towards the light";
        let mut bytes = memory::zeroed::<u8>(rows * length * count, what, memory::SMALLER_VOLUME)?;
        let [[first, last], _] = self.slices.columns();
        let bands = (last - first + 1) as usize;
        let mut bands: Vec<Band<'_>> = (0..bands.div_ceil(BAND))
            .map(|number| Band {
                first: first + (number * BAND) as isize,
                rows: (0..count).map(|_| Vec::new()).collect(),
            })
            .collect();
        self.hand_out(&mut bytes, &mut bands, first);
        let work = LongWork::new("parts of the cached shadows", bands.len() as u64);
        bands.into_par_iter().for_each(|band| {
            self.sweep(band);
            work.step();
        });
        Ok(Swept { slices: self.slices, dims, bytes })
    }

    /// Gives every row of `bytes` to the band whose columns cross it.
    fn hand_out<'b>(&self, bytes: &'b mut [u8], bands: &mut [Band<'b>], first: isize) {
        let [deep, ..] = self.slices.axes;
        let dims = self.bricks.layout().dims;
        let [_, length] = self.slices.size();
        let inner = dims[1 - self.slices.axes[2]];
        for (at, row) in bytes.chunks_exact_mut(length).enumerate() {
            let [outer, inner] = [at / inner, at % inner];
            let (slice, y) = if deep == 2 { (outer, inner) } else { (inner, outer) };
            let number = self.slices.voxel(slice);
            let column = y as isize - self.slices.crossings(number)[0].whole;
            bands[(column - first) as usize / BAND].rows[number].push((y as isize, row));
        }
    }
}

/// Rows of columns that one task sweeps, with the rows of voxels that they cross.
struct Band<'b> {
    /// First column that has rows of voxels. One column before is swept as well.
    first: isize,
    /// For each slice the rows of voxels and their numbers in the slice, in order.
    rows: Vec<Vec<(isize, &'b mut [u8])>>,
}

/// Entry of a column that has crossed no slice.
const NEVER: f32 = -1.0;

/// Light in the columns of a band.
struct Columns {
    /// Product of the transmittances before the last slice.
    passed: Vec<f32>,
    /// Transmittance of the last slice, and its entry in the transfer table.
    through: Vec<f32>,
    entries: Vec<f32>,
    /// Its place in the table of gradients; empty where there is none.
    lengths: Vec<f32>,
    /// Columns along a row, with room for whole vectors.
    width: usize,
    /// First column along rows.
    first: isize,
}

impl Columns {
    fn new([first, last]: [isize; 2], have_gradients: bool) -> Self {
        let width = (last - first + 1) as usize + MOST_LANES;
        let numbers = |number| vec![number; width * (BAND + 1)];
        let lengths = if have_gradients { numbers(0.0) } else { Vec::new() };
        Self { passed: numbers(1.0), through: numbers(1.0), entries: numbers(NEVER), lengths, width, first }
    }

    /// Place of the column that crosses a slice at voxel −1 in row `number`.
    fn begin(&self, number: usize, along: &Crossing) -> usize {
        number * self.width + (-1 - along.whole - self.first) as usize
    }
}

/// Lines of voxels of one slice around a band, in entries of the transfer table. Beyond the grid the nearest voxel repeats.
struct Lines {
    entries: Vec<f32>,
    /// Places in the table of gradients; empty where there is none.
    lengths: Vec<f32>,
    width: usize,
}

impl Lines {
    fn new(width: usize, have_gradients: bool) -> Self {
        let numbers = || vec![0.0; width * (BAND + 2)];
        Self { entries: numbers(), lengths: if have_gradients { numbers() } else { Vec::new() }, width }
    }

    /// Line `number` of `entries` or `lengths`.
    fn line<'l>(&self, of: &'l [f32], number: isize) -> &'l [f32] {
        &of[number as usize * self.width..][..self.width]
    }
}

/// Slice of a sweep, around one band.
struct Slice {
    number: usize,
    down: Crossing,
    along: Crossing,
    /// Row of voxels at or before which the first row of columns crosses.
    top: isize,
    /// Rows of columns that come within a voxel of the slice.
    crossed: Range<isize>,
}

impl LightSweep<'_> {
    /// Sweeps the columns of `band` through all slices.
    fn sweep(&self, band: Band<'_>) {
        let [rows, length] = self.slices.size();
        let mut columns = Columns::new(self.slices.columns()[1], self.gradient.is_some());
        let width = length + 2 + MOST_LANES;
        let mut lines = Lines::new(width, self.gradient.is_some());
        let [mut before, mut here] = [vec![1.0; width], vec![1.0; width]];
        for (number, mut targets) in band.rows.into_iter().enumerate() {
            stop::point();
            let [down, along] = self.slices.crossings(number);
            let top = band.first - 1 + down.whole;
            let crossed = (-1 - top).max(0)..(rows as isize - top).min(BAND as isize + 1);
            let slice = Slice { number, down, along, top, crossed };
            self.put_lines(&slice, &mut lines);
            let mut targets = targets.iter_mut();
            for row in slice.crossed.clone() {
                self.cross(&slice, row, &lines, (&mut columns, &mut here));
                let target = if row > 0 && top + row >= 0 { targets.next() } else { None };
                if let Some((_, bytes)) = target {
                    let shares = [1.0 - down.part, 1.0 - along.part];
                    self.simd.vectorised(Mixed { before: &before, here: &here, shares, bytes });
                }
                std::mem::swap(&mut before, &mut here);
            }
        }
    }

    /// Takes `row` of the `columns` through `slice`, and writes the light that comes to it.
    fn cross(&self, slice: &Slice, row: isize, lines: &Lines, (columns, light): (&mut Columns, &mut [f32])) {
        let [deep, down, along] = self.slices.axes;
        let begin = columns.begin(row as usize, &slice.along);
        let count = self.slices.size()[1] + 1;
        let mut at = [0.0; 3];
        at[deep] = self.slices.voxel(slice.number) as f32;
        at[down] = (slice.top + row) as f32 + slice.down.part;
        at[along] = slice.along.part - 1.0;
        // Columns in the part that casts shadows, and those whose first shadow sample lies there.
        let [casts, sees] = [[0.0; 3], self.first_sample].map(|way| {
            let inside = |axis: usize| {
                let at = at[axis] + way[axis];
                self.clip[0][axis] <= at && at <= self.clip[1][axis]
            };
            let [low, high] = self.clip.map(|corner| corner[along] - at[along] - way[along]);
            let mut columns = low.ceil().max(0.0)..(high.floor() + 1.0).min(count as f32);
            for plane in self.planes {
                let first: f32 =
                    plane[3] + (0..3).map(|axis| plane[axis] * (at[axis] + way[axis])).sum::<f32>();
                columns = beyond(columns, first, plane[along]);
            }
            if inside(deep) && inside(down) { columns } else { 0.0..0.0 }
        });
        // The nearest line, voxel and slice stand for both between which a column passes.
        let both = |part: f32| match self.bricks.interpolation() {
            Interpolation::Linear => [0, 1],
            Interpolation::Nearest => [(part + 0.5) as isize; 2],
        };
        let rows = both(slice.down.part).map(|more| row + more);
        let gradients = self.gradient.map(|(_, table)| CrossedGradients {
            lines: rows.map(|row| lines.line(&lines.lengths, row)),
            factors: &table.factors,
            lengths: &mut columns.lengths[begin..],
        });
        self.simd.in_vectors(Crossed {
            lines: rows.map(|row| lines.line(&lines.entries, row)),
            gradients,
            voxels: both(slice.along.part).map(|more| more as usize),
            slices: both(self.slices.near()).map(|more| more == 1),
            shares: [slice.down.part, slice.along.part],
            tables: [self.transmittance, self.near_transmittance],
            near: self.slices.near(),
            casts,
            sees,
            passed: &mut columns.passed[begin..],
            through: &mut columns.through[begin..],
            entries: &mut columns.entries[begin..],
            light,
            count,
        });
    }

    /// Puts the lines of voxels around the columns of `slice` into `lines`.
    fn put_lines(&self, slice: &Slice, lines: &mut Lines) {
        let [deep, down, along] = self.slices.axes;
        let [rows, length] = self.slices.size();
        let factor = self.bricks.scale() * (self.transmittance.len() - 2) as f32;
        let mut beyond = Vec::new();
        for line in slice.crossed.start..=slice.crossed.end {
            let mut voxel = [0; 3];
            voxel[deep] = self.slices.voxel(slice.number);
            voxel[down] = (slice.top + line).clamp(0, rows as isize - 1) as usize;
            let to = &mut lines.entries[line as usize * lines.width..][..length + 2];
            self.bricks.put_line(voxel, along, factor, &mut to[1..=length]);
            if let Some((lengths, table)) = self.gradient {
                let to = &mut lines.lengths[line as usize * lines.width..][..length + 2];
                lengths.put_line(voxel, along, lengths.scale() * table.scale, &mut to[1..=length]);
                (to[0], to[length + 1]) = (to[1], to[length]);
            }
            if self.bricks.has_gaps() && self.bricks.interpolation() == Interpolation::Linear {
                // A sample is NaN where any voxel of its cell is, and its cell reaches the next slice of the grid.
                voxel[deep] = (voxel[deep] + 1).min(self.bricks.layout().dims[deep] - 1);
                beyond.resize(length, 0.0);
                self.bricks.put_line(voxel, along, factor, &mut beyond);
                let unknown = to[1..=length].iter_mut().zip(&beyond).filter(|(_, beyond)| beyond.is_nan());
                unknown.for_each(|(to, _)| *to = f32::NAN);
            }
            (to[0], to[length + 1]) = (to[1], to[length]);
        }
    }
}

/// The part of `columns` in which `first` + `step`·column is 0 or more.
fn beyond(columns: Range<f32>, first: f32, step: f32) -> Range<f32> {
    let crossing = -first / step;
    if step > 0.0 {
        columns.start.max(crossing.ceil())..columns.end
    } else if step < 0.0 {
        columns.start..columns.end.min(crossing.floor() + 1.0)
    } else if first < 0.0 {
        0.0..0.0
    } else {
        columns
    }
}

/// Transmittance of a row of voxels, from the columns before and after them along both axes.
struct Mixed<'a> {
    before: &'a [f32],
    here: &'a [f32],
    /// Weights of the columns at or after the voxels, from row to row and along rows.
    shares: [f32; 2],
    bytes: &'a mut [u8],
}

impl SimdOp for Mixed<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let [down, along] = self.shares;
        let length = self.bytes.len();
        let (before, here) = (&self.before[..=length], &self.here[..=length]);
        for x in 0..length {
            let a = before[x] + down * (here[x] - before[x]);
            let b = before[x + 1] + down * (here[x + 1] - before[x + 1]);
            let light = a + along * (b - a);
            // Added to 2²³ the whole number is in the lowest bits, which is quicker than a conversion.
            self.bytes[x] = (light * 255.0 + 8_388_608.0).to_bits() as u8;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{FIRST_STRETCH, LightPath};
    use fovol_core::{ClipBox, ClipPlane, ClipPlanes, Grid, Light, Volume};
    use proptest::prelude::*;

    /// Transmittances whose logarithms are 0 to −0.5, for 5 entries and NaN.
    const ENTRIES: [f32; 6] = [1.0, 0.9, 0.8, 0.7, 0.6, 1.0];

    /// Volume of `dims` voxels with values 0 to 4.
    fn volume(dims: [usize; 3], seed: u64) -> (Grid, Bricks) {
        let grid = Grid::new(dims, [1.0, 0.8, 1.3]).unwrap();
        let value = |i: u64| {
            if i < 2 { 4 * i } else { (i ^ seed).wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 61 & 3 }
        };
        let values: Vec<u8> = (0..grid.voxels() as u64).map(|i| value(i) as u8).collect();
        (grid, Bricks::of_volume(&Volume::from_values(grid, values).unwrap()).unwrap())
    }

    /// Light that comes to the column at `c` in slice `number`, followed alone from the first slice on.
    fn followed(sweep: &LightSweep<'_>, number: usize, c: [isize; 2]) -> f32 {
        let [deep, down, along] = sweep.slices.axes;
        let place = |number: usize| {
            let [d, a] = sweep.slices.crossings(number);
            let mut p = [0.0; 3];
            p[deep] = sweep.slices.voxel(number) as f32;
            p[down] = (c[0] + d.whole) as f32 + d.part;
            p[along] = (c[1] + a.whole) as f32 + a.part;
            p
        };
        let entry = |p: [f32; 3]| sweep.bricks.sample(p) * 4.0;
        let is_inside = |p: [f32; 3]| {
            let is_kept = |plane: &[f32; 4]| plane[3] + (0..3).map(|a| plane[a] * p[a]).sum::<f32>() >= 0.0;
            (0..3).all(|a| sweep.clip[0][a] <= p[a] && p[a] <= sweep.clip[1][a])
                && sweep.planes.iter().all(is_kept)
        };
        let table = |table: &[f32], entry: f32| table[(entry + 0.5) as usize];
        let is_near = |p: [f32; 3]| {
            let size = sweep.slices.size();
            p[down] > -1.0 && p[down] < size[0] as f32 && p[along] > -1.0 && p[along] < size[1] as f32
        };
        let mut light = 1.0;
        for before in 0..number.saturating_sub(1) {
            if is_inside(place(before)) {
                light *= table(sweep.transmittance, entry(place(before)));
            }
        }
        let here = place(number);
        let first: [f32; 3] = std::array::from_fn(|a| here[a] + sweep.first_sample[a]);
        if is_inside(first) {
            let before = number.checked_sub(1).map(place).filter(|p| is_near(*p)).map_or(entry(here), entry);
            light *=
                table(sweep.near_transmittance, entry(here) + sweep.slices.near() * (before - entry(here)));
        }
        light
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(24))]
        /// Light of a voxel is that of the four columns around it, each followed alone.
        #[test]
        fn light_is_that_of_single_columns(
            dims in prop::array::uniform3(2usize..23), light in prop::array::uniform3(-1.0f64..1.0), seed in 0u64..99,
            low in prop::array::uniform3(0.0f64..0.3), high in prop::array::uniform3(0.6f64..1.0),
            normal in prop::array::uniform3(-1.0f64..1.0),
        ) {
            prop_assume!(light.iter().any(|x| x.abs() > 0.1));
            let (grid, bricks) = volume(dims, seed);
            let corner = |share: [f64; 3]| std::array::from_fn::<f64, 3, _>(|a| share[a] * dims[a] as f64);
            let clip = ClipBox::new(corner(low).into(), corner(high).into(), &grid).unwrap();
            let path = LightPath::new(&Light::towards(light.into()).unwrap(), &grid, &clip, 0.5);
            let slices = LightSlices::new(dims, &path);
            let plane = ClipPlane { normal: normal.into(), distance: -0.1037 };
            let planes: Vec<[f32; 4]> =
                ClipPlanes::new(&[plane]).unwrap().in_voxels(&grid).map(|plane| plane.map(|w| w as f32)).collect();
            let near: Vec<f32> = ENTRIES.iter().map(|t| t.powf(FIRST_STRETCH as f32)).collect();
            let sweep = |simd| LightSweep {
                bricks: &bricks,
                slices,
                clip: clip.in_voxels(),
                planes: &planes,
                transmittance: &ENTRIES,
                near_transmittance: &near,
                gradient: None,
                first_sample: path.delta.map(|delta| slices.near() * slices.steps as f32 * delta),
                simd,
            };
            for simd in Simd::available() {
                let sweep = sweep(simd);
                let swept = sweep.swept().unwrap();
                let mut off = 0;
                for voxel in (0..grid.voxels()).map(|i| [i % dims[0], i / dims[0] % dims[1], i / (dims[0] * dims[1])]) {
                    let mut found = [0];
                    swept.put(voxel, &mut found);
                    let [deep, down, along] = slices.axes;
                    let number = slices.voxel(voxel[deep]);
                    let [d, a] = slices.crossings(number);
                    let c = [voxel[down] as isize - d.whole, voxel[along] as isize - a.whole];
                    let mut expected = 0.0;
                    for (row, share) in [(0, 1.0 - d.part), (1, d.part)] {
                        for (column, part) in [(0, 1.0 - a.part), (1, a.part)] {
                            expected += share * part * followed(&sweep, number, [c[0] - row, c[1] - column]);
                        }
                    }
                    // An entry may be rounded either way.
                    off += usize::from((f32::from(found[0]) / 255.0 - expected).abs() > 2.5 / 255.0);
                }
                prop_assert!(off * 50 <= grid.voxels(), "{simd}: {off} of {}", grid.voxels());
            }
        }
    }
}
