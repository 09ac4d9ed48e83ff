//! Two 3×3 convolutions of which the second alone reads what the first writes, some rows at a time: what is between them
//! is never there for a whole frame, and what comes out can take the place of what goes in.

use super::conv::{PreparedConv, Scratch};
use super::element::Element;
use super::map::{Map, Stored, with_map};
use super::patch::{Access, Source};
use rayon::prelude::*;

/// Output rows that are made at once.
const ROWS: usize = 8;
/// Output rows that one task makes at least; the first convolution makes two more of them.
const FEWEST: usize = 48;
/// Rows between the convolutions that are made beyond those that are asked for: the second looks at one, and as they are
/// made in twos from row 0 on, numbers do not depend on how many tasks there are.
const BEYOND: usize = 2;
/// Rows of the input that those look beyond.
const AROUND: usize = BEYOND + 1;

/// Two convolutions in a row, with strides of 1.
#[derive(Debug, Clone, Copy)]
pub struct Pair<'a> {
    pub first: &'a PreparedConv,
    pub second: &'a PreparedConv,
    /// Whether numbers between them are stored in two bytes.
    pub is_halved: bool,
}

impl Pair<'_> {
    /// Writes what the second makes of what the first makes of the concatenated `sources` to `out`.
    pub fn run<T: Element>(&self, sources: &[Source<'_>], out: &mut Map<T>) {
        let [height, width] = sources[0].size();
        out.resize([height, width, self.second.outputs()]);
        self.strips(out, |first, rows, strip| {
            let mut made = Made::new(self, [height, width]);
            for y in (first..first + rows).step_by(ROWS) {
                let here = y - first..(y - first + ROWS).min(rows);
                made.second(y, here, sources, strip);
            }
        });
    }

    /// The same where `out` holds the source in place `replaced` of `sources`, whose map there is not looked at.
    pub fn run_in_place<T: Element>(&self, sources: &[Source<'_>], replaced: usize, out: &mut Map<T>) {
        let Map { height, width, channels, .. } = *out;
        assert_eq!(channels, self.second.outputs(), "what replaces a map has its shape");
        let row = width * channels;
        let rows = strip_rows(height);
        // Rows of the neighbours, which these may have written over by the time they are read.
        let around: Vec<[Vec<T>; 2]> = (0..height)
            .step_by(rows)
            .map(|first| {
                let end = (first + rows).min(height);
                let above = first.saturating_sub(AROUND)..first;
                let below = end..(end + AROUND).min(height);
                [above, below].map(|rows| out.data[rows.start * row..rows.end * row].to_vec())
            })
            .collect();
        self.strips(out, |first, rows, strip| {
            let mut made = Made::new(self, [height, width]);
            let [above, below] = &around[first / strip_rows(height)];
            let top = first - above.len() / row;
            let mut old = Map { data: above.clone(), height, width, channels, top };
            for y in (first..first + rows).step_by(ROWS) {
                let here = y - first..(y - first + ROWS).min(rows);
                // What is about to be written over, and a little more.
                let known = old.end();
                let wanted = y.saturating_sub(AROUND)..(first + here.end + AROUND).min(height);
                let inside = known.clamp(first, first + rows)..wanted.end.min(first + rows);
                let (into, beyond) = old.move_to(wanted.clone()).split_at_mut(inside.len() * row);
                into.copy_from_slice(&strip[(inside.start - first) * row..(inside.end - first) * row]);
                let passed = known.max(first + rows).min(wanted.end) - (first + rows).min(wanted.end);
                beyond.copy_from_slice(&below[passed * row..][..beyond.len()]);
                let stored = T::stored(std::mem::take(&mut old));
                let mut sources = sources.to_vec();
                sources[replaced] = Source { map: &stored, access: Access::SAME };
                made.second(y, here, &sources, strip);
                old = T::loaded(stored);
            }
        });
    }

    /// Calls `make` with the number of its first row, its rows and the numbers of each part of `out`.
    fn strips<T: Element>(&self, out: &mut Map<T>, make: impl Fn(usize, usize, &mut [T]) + Sync) {
        let rows = strip_rows(out.height);
        let row = out.width * out.channels;
        let strips = out.data.par_chunks_mut(rows * row).enumerate();
        strips.for_each(|(number, strip)| make(number * rows, strip.len() / row, strip));
    }
}

/// Rows of one task: two tasks for each thread, so that none waits for long.
fn strip_rows(height: usize) -> usize {
    height.div_ceil(2 * rayon::current_num_threads()).max(FEWEST).next_multiple_of(ROWS)
}

/// What one task has made of the rows between the convolutions.
struct Made<'a> {
    pair: &'a Pair<'a>,
    between: Stored,
    scratch: Scratch,
    is_begun: bool,
}

impl<'a> Made<'a> {
    fn new(pair: &'a Pair<'a>, [height, width]: [usize; 2]) -> Self {
        let channels = pair.first.outputs();
        let between = match pair.is_halved {
            true => Stored::Bf16(Map { height, width, channels, ..Map::default() }),
            false => Stored::F32(Map { height, width, channels, ..Map::default() }),
        };
        Self { pair, between, scratch: Scratch::default(), is_begun: false }
    }

    /// Makes the rows from `y` on, which are the rows `here` of `strip`.
    fn second<T: Element>(
        &mut self,
        y: usize,
        here: std::ops::Range<usize>,
        sources: &[Source<'_>],
        strip: &mut [T],
    ) {
        let Self { pair, between, scratch, is_begun } = self;
        with_map!(&mut *between, between => {
            let rows = y.saturating_sub(BEYOND)..(y + here.len() + BEYOND).min(between.height);
            if !*is_begun {
                (*is_begun, between.top) = (true, rows.start);
            }
            let known = between.end();
            pair.first.rows(sources, known, scratch, between.move_to(rows));
        });
        let between = [Source { map: between, access: Access::SAME }];
        let row = between[0].size()[1] * pair.second.outputs();
        pair.second.rows(&between, y, scratch, &mut strip[here.start * row..here.end * row]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cpu::conv::{Arithmetic, ConvShape};
    use crate::cpu::element::Bf16;
    use crate::cpu::simd::Simd;
    use crate::plan::{Activation, Padding, Resize};
    use proptest::prelude::*;

    fn random<T: Element>(seed: u64, [height, width, channels]: [usize; 3]) -> Map<T> {
        let parameter =
            crate::plan::Parameter { name: "x".into(), shape: vec![height * width * channels, 5] };
        let values = crate::weights::random::values(&parameter, seed);
        let mut map = Map::zeros(height, width, channels);
        map.data.iter_mut().zip(values).for_each(|(to, v)| *to = T::from_f32(v));
        map
    }

    fn conv(inputs: usize, outputs: usize, seed: u64, padding: Padding, simd: Simd) -> PreparedConv {
        let shape = ConvShape { inputs, outputs, size: 3, stride: 1, padding, activation: Activation::Relu };
        let weights = random::<f32>(seed, [outputs, inputs, 9]).data;
        PreparedConv::new(&shape, &weights, &vec![0.1; outputs], simd, Arithmetic::F32)
    }

    /// One convolution after the other.
    fn apart<T: Element>(pair: &Pair<'_>, sources: &[Source<'_>]) -> Map<T> {
        let mut between = Map::<T>::default();
        pair.first.run(sources, &mut between);
        let between = T::stored(between);
        let mut out = Map::default();
        pair.second.run(&[Source { map: &between, access: Access::SAME }], &mut out);
        out
    }

    fn agree<T: Element + std::fmt::Debug + PartialEq>(
        [height, width]: [usize; 2],
        channels: [usize; 3],
        (padding, simd, seed): (Padding, Simd, u64),
    ) {
        let [coarse, same, made] = channels;
        let first = conv(coarse + same, made, seed, padding, simd);
        let second = conv(made, same, seed + 1, padding, simd);
        let pair = Pair { first: &first, second: &second, is_halved: size_of::<T>() == 2 };
        let coarse = T::stored(random::<T>(seed + 2, [height / 2, width / 2, coarse]));
        let old = random::<T>(seed + 3, [height, width, same]);
        let kept = T::stored(old.clone());
        let sources = [
            Source { map: &coarse, access: Access::Resized(Resize::Bilinear) },
            Source { map: &kept, access: Access::SAME },
        ];
        let expected: Map<T> = apart(&pair, &sources);
        let mut out = Map::default();
        pair.run(&sources, &mut out);
        assert!(out == expected);
        let nothing = Stored::default();
        let sources = [sources[0], Source { map: &nothing, access: Access::SAME }];
        let mut out = old;
        pair.run_in_place(&sources, 1, &mut out);
        assert!(out == expected);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(24))]
        #[test]
        fn together_is_as_apart(
            sides in (1usize..80, 1usize..12),
            channels in prop::array::uniform3(1usize..20),
            is_zero in prop::bool::ANY,
            seed in 0u64..1000,
        ) {
            let padding = if is_zero { Padding::Zero } else { Padding::Replicate };
            for simd in Simd::available() {
                let size = [2 * sides.0, 2 * sides.1];
                agree::<f32>(size, channels, (padding, simd, seed));
                agree::<Bf16>(size, channels, (padding, simd, seed));
            }
        }
    }
}
