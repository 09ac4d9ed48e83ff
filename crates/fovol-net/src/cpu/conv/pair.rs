//! Fuses two 3×3 convolutions of which the second alone reads the output of the first. They run a few rows at a
//! time, so the tensor between them never exists for a whole frame, and the output can overwrite an input.

use crate::cpu::conv::patch::{Access, Source};
use crate::cpu::conv::{PreparedConv, Scratch};
use crate::cpu::tensor::Tensor;
use crate::cpu::tensor::element::Element;
use crate::cpu::tensor::page_buf::PageBuf;
use crate::cpu::tensor::ring::Ring;
use crate::cpu::tensor::rows::Rows;
use crate::cpu::tensor::tensor_buf::TensorBuf;
use fovol_simd::Bf16;
use rayon::prelude::*;
use std::sync::{Mutex, PoisonError};

/// Limits of the number of output rows that are computed at once. Few rows pack more rows of the input twice; many
/// rows take more memory between the convolutions.
const ROWS: [usize; 2] = [4, 12];
/// Approximate number of elements between the convolutions.
const NUMBERS: usize = 1 << 17;
/// Fewest output rows of a task. The first convolution computes two rows more for each task.
const FEWEST: usize = 48;
/// Rows between the convolutions that are computed ahead. The second convolution reads one row ahead. Rows come in
/// groups of four from row 0 on, so that results do not depend on the number of tasks.
const BEYOND: usize = 4;
/// Rows of the input that a task reads beyond its own.
const AROUND: usize = BEYOND + 1;

/// Two consecutive convolutions with stride 1.
#[derive(Debug, Clone, Copy)]
pub struct Pair<'a> {
    pub first: &'a PreparedConv,
    pub second: &'a PreparedConv,
    /// Whether the tensor between them is stored as bf16.
    pub is_halved: bool,
    pub pool: &'a Pool,
}

/// Scratch memory of tasks, for reuse.
#[derive(Debug, Default)]
pub struct Pool(Mutex<Vec<Memory>>);

/// Scratch memory of one task.
#[derive(Debug, Default)]
struct Memory {
    /// Rows between the convolutions.
    between: PageBuf,
    scratch: Scratch,
}

impl Pool {
    fn lend(&self, task: impl FnOnce(&mut Memory)) {
        let free = || self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let mut memory = free().pop().unwrap_or_default();
        task(&mut memory);
        free().push(memory);
    }
}

impl Pair<'_> {
    /// Applies both convolutions to the concatenated `sources` and writes to `out`.
    pub fn run<T: Element>(&self, sources: &[Source<'_>], out: &mut Tensor<T>) {
        let [height, width] = sources[0].size();
        out.resize([height, width, self.second.outputs()]);
        self.strips(out, |_, _, make| make(sources));
    }

    /// Applies both convolutions in place: `out` holds source number `replaced`, and that entry of `sources` is
    /// ignored.
    ///
    /// A row is overwritten only after all rows between the convolutions that read it have been computed. The first
    /// convolution is [`BEYOND`] rows ahead.
    pub fn run_in_place<T: Element>(&self, sources: &[Source<'_>], replaced: usize, out: &mut Tensor<T>) {
        let Tensor { height, width, channels, .. } = *out;
        assert_eq!(channels, self.second.outputs(), "what replaces a map has its shape");
        let row = width * channels;
        let rows = strip_rows(height);
        // Copies of rows of neighbouring tasks, which these may have overwritten by the time they are read.
        let around: Vec<[TensorBuf<T>; 2]> = (0..height)
            .step_by(rows)
            .map(|first| {
                let end = (first + rows).min(height);
                let above = first.saturating_sub(AROUND)..first;
                let below = end..(end + AROUND).min(height);
                [above, below]
                    .map(|rows| out.data[rows.start * row..rows.end * row].iter().copied().collect())
            })
            .collect();
        self.strips(out, |first, strip, make| {
            let [above, below] = &around[first / rows];
            let pieces = [&above[..], strip, below];
            let rows = Rows::new(pieces, first - above.len() / row, [height, width, channels]);
            let mut sources = sources.to_vec();
            sources[replaced] = Source { rows: T::view(rows), access: Access::SAME };
            make(&sources);
        });
    }

    /// Number of output rows that are computed at once.
    fn rows(&self, width: usize) -> usize {
        let row = width * self.first.outputs().max(self.second.outputs());
        (NUMBERS / row).clamp(ROWS[0], ROWS[1]) & !3
    }

    /// Computes `out` in strips, in parallel. `with` gets the first row of a strip and its elements, old and new,
    /// and passes the sources of the first convolution to a callback.
    fn strips<T: Element>(
        &self,
        out: &mut Tensor<T>,
        with: impl Fn(usize, &[T], &mut dyn FnMut(&[Source<'_>])) + Sync,
    ) {
        let size = [out.height, out.width, self.first.outputs()];
        let rows = strip_rows(out.height);
        let strips = out.data.par_chunks_mut(rows * out.width * out.channels).enumerate();
        strips.for_each(|(number, strip)| {
            self.pool.lend(|memory| match self.is_halved {
                true => self.strip::<Bf16, T>(number * rows, strip, (size, memory), &with),
                false => self.strip::<f32, T>(number * rows, strip, (size, memory), &with),
            });
        });
    }

    /// Computes `strip`, which begins at row `first`, with elements of type `B` between the convolutions.
    fn strip<B: Element, T: Element>(
        &self,
        first: usize,
        strip: &mut [T],
        (size, Memory { between, scratch }): ([usize; 3], &mut Memory),
        with: &impl Fn(usize, &[T], &mut dyn FnMut(&[Source<'_>])),
    ) {
        let [height, width, channels] = size;
        let row = width * self.second.outputs();
        let (at_once, end) = (self.rows(width), first + strip.len() / row);
        let mut numbers = TensorBuf::<B>::within(std::mem::take(between));
        let room = (at_once + 2 * BEYOND).next_multiple_of(at_once);
        numbers.resize(room * width * channels);
        let mut ring = Ring::new(&mut numbers, [first.saturating_sub(BEYOND), first + BEYOND], size);
        for y in (first..end).step_by(at_once) {
            let here = y..(y + at_once).min(end);
            with(first, strip, &mut |sources| {
                ring.make((here.end + BEYOND).min(height), |y, out| {
                    self.first.rows(sources, y, scratch, out);
                });
            });
            let made = Source { rows: B::view(ring.rows()), access: Access::SAME };
            let out = &mut strip[(here.start - first) * row..(here.end - first) * row];
            self.second.rows(&[made], y, scratch, out);
        }
        *between = numbers.into_words();
    }
}

/// Rows of a task: as many tasks as threads, since rows at the borders of strips are computed twice.
fn strip_rows(height: usize) -> usize {
    height.div_ceil(rayon::current_num_threads()).max(FEWEST).next_multiple_of(BEYOND)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cpu::conv::{Arithmetic, ConvShape};
    use crate::cpu::tensor::AnyTensor;
    use crate::plan::{Activation, Padding, Resize};
    use fovol_simd::Simd;
    use proptest::prelude::*;

    fn random<T: Element>(seed: u64, [height, width, channels]: [usize; 3]) -> Tensor<T> {
        let parameter =
            crate::plan::Parameter { name: "x".into(), shape: vec![height * width * channels, 5] };
        let values = crate::weights::random::values(&parameter, seed);
        let mut map = Tensor::zeros(height, width, channels);
        map.data.iter_mut().zip(values).for_each(|(to, v)| *to = T::from_f32(v));
        map
    }

    fn conv(inputs: usize, outputs: usize, seed: u64, padding: Padding, simd: Simd) -> PreparedConv {
        let shape = ConvShape { inputs, outputs, size: 3, stride: 1, padding, activation: Activation::Relu };
        let weights = random::<f32>(seed, [outputs, inputs, 9]).data;
        PreparedConv::new(&shape, &weights, &vec![0.1; outputs], simd, Arithmetic::F32)
    }

    /// Applies one convolution after the other.
    fn apart<T: Element>(pair: &Pair<'_>, sources: &[Source<'_>]) -> Tensor<T> {
        let mut between = Tensor::<T>::default();
        pair.first.run(sources, &mut between);
        let between = T::stored(between);
        let mut out = Tensor::default();
        pair.second.run(&[Source::read(&between, Access::SAME)], &mut out);
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
        let pool = Pool::default();
        let pair = Pair { first: &first, second: &second, is_halved: size_of::<T>() == 2, pool: &pool };
        let coarse = T::stored(random::<T>(seed + 2, [height / 2, width / 2, coarse]));
        let old = random::<T>(seed + 3, [height, width, same]);
        let kept = T::stored(old.clone());
        let sources = [Source::new(&coarse, Resize::Bilinear), Source::read(&kept, Access::SAME)];
        let expected: Tensor<T> = apart(&pair, &sources);
        let mut out = Tensor::default();
        pair.run(&sources, &mut out);
        assert!(out == expected);
        let nothing = AnyTensor::default();
        let sources = [sources[0], Source::read(&nothing, Access::SAME)];
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
