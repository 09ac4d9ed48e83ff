//! Detection of values far outside all others. They mark voxels without data and would compress the displayed range
//! of the rest.

use crate::{Dtype, Outlier, Volume, Voxel, with_voxel_type};

/// Number of different values kept at each end. Fewer than half of them can be outliers.
const KEPT: usize = 8;

/// Most different outliers at one end; more of them are a real distribution.
const MOST: usize = 3;

/// Smallest and largest different values, with their counts.
#[derive(Debug, Clone, Copy)]
pub struct Extremes {
    low: End,
    high: End,
}

/// Different values at one end, outermost first. The high end stores negated values.
#[derive(Debug, Clone, Copy)]
struct End {
    values: [Outlier; KEPT],
    length: usize,
}

impl End {
    const NONE: Self = Self { values: [Outlier { value: f64::INFINITY, count: 0 }; KEPT], length: 0 };

    /// Counts `value` if it is among the smallest.
    #[inline]
    fn add(&mut self, value: f64, count: u64) {
        if self.values[0].value == value {
            self.values[0].count += count;
        } else if value <= self.values[KEPT - 1].value {
            self.insert(value, count);
        }
    }

    #[cold]
    fn insert(&mut self, value: f64, count: u64) {
        let at = self.values[..self.length].iter().position(|kept| value <= kept.value);
        let at = at.unwrap_or(self.length);
        if at < self.length && self.values[at].value == value {
            self.values[at].count += count;
        } else if at < KEPT {
            self.length = (self.length + 1).min(KEPT);
            self.values.copy_within(at..KEPT - 1, at + 1);
            self.values[at] = Outlier { value, count };
        }
    }

    fn merge(&mut self, other: &Self) {
        for kept in &other.values[..other.length] {
            self.add(kept.value, kept.count);
        }
    }
}

impl Extremes {
    /// No values.
    pub const NONE: Self = Self { low: End::NONE, high: End::NONE };

    /// Adds a finite value.
    #[inline]
    pub fn add(&mut self, value: f64) {
        self.low.add(value, 1);
        self.high.add(-value, 1);
    }

    /// Adds all values of `other`.
    pub fn merge(&mut self, other: &Self) {
        self.low.merge(&other.low);
        self.high.merge(&other.high);
    }

    /// Smallest and largest value; `None` without values.
    pub fn ends(&self) -> Option<[f64; 2]> {
        (self.low.length > 0).then(|| [self.low.values[0].value, -self.high.values[0].value])
    }

    /// Known different values, smallest first, and whether there may be more between them.
    fn distinct(&self) -> (Vec<Outlier>, bool) {
        let mut values = self.low.values[..self.low.length].to_vec();
        let last = values.last().map_or(f64::NEG_INFINITY, |kept| kept.value);
        let high = self.high.values[..self.high.length].iter().rev();
        let above = high.map(|kept| Outlier { value: -kept.value, ..*kept }).filter(|kept| kept.value > last);
        let before = values.len();
        values.extend(above);
        let is_full = self.low.length == KEPT && values.len() == before + KEPT;
        (values, is_full)
    }
}

/// Range of the values of `volume` without outliers, and the outliers.
pub fn split(volume: &Volume, extremes: &Extremes) -> ([f64; 2], Vec<Outlier>) {
    let (values, has_more) = extremes.distinct();
    let (mut first, mut last) = (0, values.len() - 1);
    let search = Search { volume, values: &values, has_more };
    while let Some([low, high]) = search.next(first, last) {
        (first, last) = (first + low, last - high);
        if first > MOST || values.len() - 1 - last > MOST {
            (first, last) = (0, values.len() - 1);
            break;
        }
    }
    let outliers = [&values[..first], &values[last + 1..]].concat();
    ([values[first].value, values[last].value], outliers)
}

/// Search for outliers among different values, smallest first.
struct Search<'a> {
    volume: &'a Volume,
    values: &'a [Outlier],
    /// Whether the middle has more values than are known.
    has_more: bool,
}

impl Search<'_> {
    /// Number of outliers at the low and the high end of the values `first` to `last`; `None` if there are none.
    fn next(&self, first: usize, last: usize) -> Option<[usize; 2]> {
        let counts = (0..=MOST).flat_map(|low| (0..=MOST).map(move |high| [low, high]));
        let mut counts: Vec<_> =
            counts.filter(|[low, high]| (1..=last - first).contains(&(low + high))).collect();
        counts.sort_by_key(|[low, high]| low + high);
        counts.into_iter().find(|&[low, high]| {
            let (inner, end) = (first + low, last - high);
            let gap = |from: usize, to: usize| self.values[to].value - self.values[from].value;
            (low == 0 || self.are_outliers(&self.values[first..inner], gap(inner - 1, inner), inner, end))
                && (high == 0
                    || self.are_outliers(&self.values[end + 1..=last], gap(end, end + 1), inner, end))
        })
    }

    /// Whether all of `few` are outliers, given their `gap` to the values `first` to `last`.
    fn are_outliers(&self, few: &[Outlier], gap: f64, first: usize, last: usize) -> bool {
        let spread = self.values[last].value - self.values[first].value;
        // A single remaining value has no spread to compare with.
        let rest = last - first + 1;
        few.iter().all(|outlier| {
            let kind = Kind::of(self.volume, outlier.value);
            rest >= kind.least_rest(self.volume, self.has_more) && gap >= kind.least_gap() * spread
        }) && spread > 0.0
    }
}

/// How much a value looks like a marker of missing data.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    /// Declared by the file.
    Declared,
    /// Common fill value, such as −9999 or the least value of a type.
    Fill,
    /// Too large for a measurement.
    Huge,
    /// Any other value.
    Plain,
}

/// Fill values of programs for geography, weather and medicine. ±9.97·10³⁶, −2147483647 and −32767 are NetCDF's.
const FILLS: [f64; 6] =
    [-9.969_209_968_386_869e36, 9.969_209_968_386_869e36, 3.4e38, -3.4e38, -2_147_483_647.0, -32_767.0];

/// Lower bound of values too large for a measurement.
const HUGE: f64 = 1e10;

impl Kind {
    fn of(volume: &Volume, value: f64) -> Self {
        let is_close = |fill: f64| (value - fill).abs() <= 1e-6 * fill.abs();
        if volume.no_data().is_some_and(|declared| declared == value || is_close(declared)) {
            Self::Declared
        } else if is_least(volume, value) || FILLS.into_iter().any(is_close) || is_nines(value) {
            Self::Fill
        } else if value.abs() >= HUGE {
            Self::Huge
        } else {
            Self::Plain
        }
    }

    /// Smallest gap of an outlier to the rest, in spreads of the rest.
    fn least_gap(self) -> f64 {
        match self {
            Self::Declared => 0.0,
            Self::Fill => 0.5,
            Self::Huge | Self::Plain => 1000.0,
        }
    }

    /// Fewest different values in the rest; labels and masks have few.
    fn least_rest(self, volume: &Volume, has_more: bool) -> usize {
        match self {
            Self::Declared | Self::Fill | Self::Huge => 2,
            Self::Plain if volume.dtype().is_integer() && (volume.dtype().size() < 4 || !has_more) => {
                usize::MAX
            }
            Self::Plain => 3,
        }
    }
}

/// Whether `value` is the least of a signed type: the volume's type, or one that its values were converted from.
fn is_least(volume: &Volume, value: f64) -> bool {
    let rescale = volume.rescale();
    let least = match volume.dtype() {
        Dtype::I8 => Some(f64::from(i8::MIN)),
        Dtype::I16 => Some(f64::from(i16::MIN)),
        Dtype::I32 => Some(f64::from(i32::MIN)),
        Dtype::I64 => Some(i64::MIN as f64),
        Dtype::F16 | Dtype::F32 | Dtype::F64 => {
            let limit = with_voxel_type!(volume.dtype(), T => T::from_f64(f64::MAX).to_f64());
            if limit.is_finite() && value.abs() >= limit { Some(value) } else { None }
        }
        _ => None,
    };
    let made_from = [f64::from(i16::MIN), f64::from(i32::MIN), f64::from(f32::MIN), f64::from(f32::MAX)];
    least.is_some_and(|least| rescale.apply(least) == value) || made_from.contains(&value)
}

/// Whether the decimal digits of `value` are all nines, at least three: −9999, 99999, −999.
fn is_nines(value: f64) -> bool {
    let size = value.abs();
    (999.0..1e12).contains(&size) && size.fract() == 0.0 && (size + 1.0).log10().fract() == 0.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::volume::bytes::Plain;
    use crate::{Grid, Rescale};
    use proptest::prelude::*;

    fn volume<T: Voxel + Plain>(values: Vec<T>) -> Volume {
        Volume::from_values(Grid::new([values.len(), 1, 1], [1.0; 3]).unwrap(), values).unwrap()
    }

    fn outliers(volume: &Volume) -> Vec<f64> {
        volume.statistics().outliers.iter().map(|outlier| outlier.value).collect()
    }

    #[test]
    fn fill_values_of_many_programs() {
        let data: Vec<f32> = (0..100).map(|i| i as f32 * 0.5 - 20.0).collect();
        let nines: f32 = -9999.0;
        for fills in [
            vec![nines],
            vec![1e20],
            vec![1e30],
            vec![3.4e38],
            vec![nines, 3.4e38],
            vec![f32::MAX],
            vec![f32::MIN],
            vec![-999.0],
            vec![-32768.0],
            vec![9.96921e36],
            vec![123_456.0],
            vec![-1e20, 1e20],
        ] {
            let with = volume([&data[..], &fills, &fills].concat());
            assert_eq!(with.range(), [-20.0, 29.5], "{fills:?}");
            let mut expected: Vec<f64> = fills.iter().map(|&fill| f64::from(fill)).collect();
            expected.sort_by(f64::total_cmp);
            assert_eq!(outliers(&with), expected);
            assert!(with.statistics().outliers.iter().all(|outlier| outlier.count == 2));
            let [min, max] = [with.statistics().min, with.statistics().max];
            assert!(min < -20.0 || max > 29.5, "the true ends stay: {min} {max}");
        }
        let few = volume(vec![-20.0f32, 80.0, -20.0, 80.0, nines, 3.4e38]);
        assert_eq!(few.range(), [-20.0, 80.0]);
    }

    #[test]
    fn the_least_value_of_a_type() {
        let scan: Vec<i16> = (0..4096).map(|i| i - 1024).collect();
        let with = volume([&scan[..], &[i16::MIN; 7]].concat());
        assert_eq!(with.range(), [-1024.0, 3071.0]);
        let scaled = with.with_rescale(Rescale { slope: 0.5, intercept: 10.0 }).unwrap();
        assert_eq!(scaled.range(), [-502.0, 1545.5]);
    }

    #[test]
    fn a_declared_value_is_left_out_wherever_it_lies() {
        let with = volume(vec![0.0f32, 10.0, 11.0, 12.0]);
        assert_eq!(with.range(), [0.0, 12.0]);
        assert_eq!(with.with_no_data(0.0).range(), [10.0, 12.0]);
    }

    #[test]
    fn honest_data_keep_their_range() {
        let metal: Vec<i16> = (-1024..3072).chain([9000, 20000, 30000, 31743]).collect();
        let decades: Vec<f32> = (0..30).map(|i| 10f32.powi(i - 10)).collect();
        let steep: Vec<f64> = (0..60).map(|i| 10f64.powi(4 * i - 100)).collect();
        let beads: Vec<u16> = (90..140).chain([60000, 65535, 65535]).collect();
        let noise: Vec<f32> =
            (0..500).map(|i| (i * 7919 % 500) as f32 * 0.01).chain([500.0, 500.0]).collect();
        let bright: Vec<u16> = std::iter::repeat_n(0, 1000).chain([1000, 1000]).collect();
        let labels: Vec<i16> = vec![0, 1, 2, 3, 17, 5000, 0, 1];
        let padded: Vec<i16> = (-1024..3072).chain([-2000; 50]).collect();
        for (what, volume) in [
            ("metal", volume(metal)),
            ("decades", volume(decades)),
            ("steep", volume(steep)),
            ("beads", volume(beads)),
            ("noise", volume(noise)),
            ("bright", volume(bright)),
            ("labels", volume(labels)),
            ("padding", volume(padded)),
            ("mask", volume(vec![0u16, 1, 1, 0])),
            ("two far values", volume(vec![-9999i32, 1, 1])),
            ("constant", volume(vec![-9999f32; 5])),
            ("signed bytes", volume((-128i8..=127).collect())),
        ] {
            let statistics = volume.statistics();
            assert_eq!(statistics.shown, [statistics.min, statistics.max], "{what}");
            assert!(statistics.outliers.is_empty(), "{what}");
        }
    }

    proptest! {
        #[test]
        fn smooth_distributions_keep_their_range(
            // Of a handful of values one may well lie far from the others.
            values in prop::collection::vec(-1.0f64..1.0, 40..400),
            power in 1.0f64..6.0,
            scale in -6.0f64..9.0,
        ) {
            // Powers skew the values strongly; logarithms even more.
            let skewed: Vec<f64> = values.iter().map(|v| v.abs().powf(power) * v.signum() * 10f64.powf(scale)).collect();
            let statistics = volume(skewed).statistics().clone();
            prop_assert_eq!(statistics.shown, [statistics.min, statistics.max]);
        }

        #[test]
        fn fills_are_left_out_of_any_data(
            values in prop::collection::vec(-1000.0f32..3000.0, 40..400),
            fill in prop::sample::select(vec![-9999.0f32, 1e20, 1e30, -1e30, -32768.0, f32::MAX, -99999.0]),
            count in 1usize..50,
        ) {
            let clean = volume(values.clone()).statistics().clone();
            let with = volume([values, vec![fill; count]].concat());
            prop_assert_eq!(with.range(), [clean.min, clean.max]);
            prop_assert_eq!(&with.statistics().outliers, &[Outlier { value: f64::from(fill), count: count as u64 }]);
        }

        #[test]
        fn counts_do_not_depend_on_the_order(mut values in prop::collection::vec(-6i16..6, 1..200)) {
            let whole = volume(values.clone()).statistics().clone();
            let mut parts = Extremes::NONE;
            values.rotate_left(1);
            for part in values.chunks(7) {
                let mut extremes = Extremes::NONE;
                part.iter().for_each(|&value| extremes.add(f64::from(value)));
                parts.merge(&extremes);
            }
            prop_assert_eq!(parts.ends(), Some([whole.min, whole.max]));
            let (known, _) = parts.distinct();
            for kept in known {
                let count = values.iter().filter(|&&value| f64::from(value) == kept.value).count();
                prop_assert_eq!(kept.count, count as u64);
            }
        }
    }
}
