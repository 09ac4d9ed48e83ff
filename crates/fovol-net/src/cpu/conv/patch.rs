//! Patches: concatenated, resized and padded parts of a convolution's inputs. They are assembled piece by piece,
//! never for a whole frame.

use crate::cpu::conv::pack::{Channels, Pack, To};
use crate::cpu::tensor::AnyTensor;
use crate::cpu::tensor::element::Element;
use crate::cpu::tensor::rows::{Rows, View, with_rows};
use crate::cpu::tensor::samples::{Sample, Samples};
use crate::cpu::tensor::upsampling::halves;
use crate::plan::{Padding, Resize};
use bytemuck::cast_slice_mut;
use fovol_simd::{AlignedBuf, Simd, SimdOp};

/// One of the input tensors of a layer.
#[derive(Debug, Clone, Copy)]
pub struct Source<'a> {
    /// Rows of the tensor.
    pub rows: View<'a>,
    /// Transformation during reading.
    pub access: Access<'a>,
}

/// Transformation of a tensor while it is read.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Access<'a> {
    /// Unchanged, or at twice the resolution.
    Resized(Resize),
    /// 2×2 pixels folded into one with four times the channels, in the order of [`unfolded`].
    Folded,
    /// 2×2 pixels of the channel of this number folded into one pixel of four channels.
    FoldedChannel(usize),
    /// Average of 2×2 pixels, with the values of `reshape::pool`.
    Pooled,
    /// Unchanged and not copied: patches leave its channels as they are, and the kernel reads the tensor itself.
    InPlace,
    /// The tensor is not stored. It has three channels and is zero except at these samples.
    Samples(&'a Samples),
}

impl Access<'_> {
    /// Reads the tensor unchanged.
    pub const SAME: Self = Self::Resized(Resize::Same);
}

impl<'a> Source<'a> {
    /// Reads `map` at the resolution of `resize`.
    pub fn new(map: &'a AnyTensor, resize: Resize) -> Self {
        Self::read(map, Access::Resized(resize))
    }

    /// Reads `map` with the transformation `access`.
    pub fn read(map: &'a AnyTensor, access: Access<'a>) -> Self {
        Self { rows: map.into(), access }
    }

    /// Reads the colours of `samples` as a tensor that is zero elsewhere.
    pub fn samples(samples: &'a Samples) -> Self {
        let [height, width] = samples.size();
        let rows = Rows::new([&[]; 3], 0, [height, width, 3]);
        Self { rows: View::F32(rows), access: Access::Samples(samples) }
    }

    /// Rows and columns after the transformation.
    pub fn size(&self) -> [usize; 2] {
        let [height, width, _] = self.rows.size();
        match self.access {
            Access::Resized(Resize::Same) | Access::InPlace | Access::Samples(_) => [height, width],
            Access::Resized(Resize::Bilinear | Resize::Nearest) => [2 * height, 2 * width],
            Access::Folded | Access::FoldedChannel(_) | Access::Pooled => [height / 2, width / 2],
        }
    }

    /// Channels after the transformation.
    pub fn channels(&self) -> usize {
        match self.access {
            Access::Folded => 4 * self.rows.size()[2],
            Access::FoldedChannel(_) => 4,
            Access::Resized(_) | Access::Pooled | Access::InPlace | Access::Samples(_) => self.rows.size()[2],
        }
    }

    /// Writes the `count` pixels from column `x0` of row `y` on to `out`. All of them must lie inside the tensor.
    #[inline(always)]
    fn copy<P: Pack>(&self, [y, x0]: [usize; 2], count: usize, mut out: Pixels<'_, P>, memory: &mut Memory) {
        let c = self.rows.size()[2];
        match self.access {
            Access::InPlace => {}
            Access::Samples(samples) => copy_samples(samples.row(y), x0, count, out, memory),
            Access::Folded => self.copy_folded([y, x0], count, out, memory),
            Access::FoldedChannel(number) => self.copy_channel(number, [y, x0], count, out, memory),
            Access::Pooled => self.copy_pooled([y, x0], count, out, memory),
            Access::Resized(Resize::Bilinear) => self.copy_bilinear([y, x0], count, out, memory),
            Access::Resized(Resize::Same) => with_rows!(self.rows, rows => {
                rows.prefetch_after(y, x0 * c..(x0 + count) * c);
                out.write((0, 1), &rows.row(y)[x0 * c..(x0 + count) * c], &mut memory.packed);
            }),
            Access::Resized(Resize::Nearest) => with_rows!(self.rows, rows => {
                for phase in 0..2 {
                    let columns = Columns::of_phase(phase, x0, count);
                    let pixels = &rows.row(y / 2)[columns.from * c..columns.to * c];
                    out.write((columns.first, 2), pixels, &mut memory.packed);
                }
            }),
        }
    }

    /// [`Self::copy`] for [`Access::Folded`].
    #[inline(always)]
    fn copy_folded<P: Pack>(
        &self,
        [y, x0]: [usize; 2],
        count: usize,
        Pixels { pack, numbers, stride, channels }: Pixels<'_, P>,
        Memory { packed, .. }: &mut Memory,
    ) {
        let pair = 2 * self.rows.size()[2];
        let columns = x0 * pair..(x0 + count) * pair;
        with_rows!(self.rows, rows => {
            rows.prefetch_after_pair(2 * y, columns.clone());
            let pixels = [2 * y, 2 * y + 1].map(|y| &rows.row(y)[columns.clone()]);
            let to = To { numbers: &mut numbers[channels.first..], stride };
            pack.pack_squares(channels, pixels, packed, to);
        });
    }

    /// [`Self::copy`] for [`Access::FoldedChannel`] of channel `number`.
    #[inline(always)]
    fn copy_channel<P: Pack>(
        &self,
        number: usize,
        [y, x0]: [usize; 2],
        count: usize,
        mut out: Pixels<'_, P>,
        Memory { near, packed, .. }: &mut Memory,
    ) {
        let c = self.rows.size()[2];
        let columns = 2 * x0 * c..2 * (x0 + count) * c;
        near.resize(4 * count, 0.0);
        with_rows!(self.rows, rows => {
            rows.prefetch_after_pair(2 * y, columns.clone());
            let [above, below] = [2 * y, 2 * y + 1].map(|y| rows.row(y)[columns.clone()].chunks_exact(2 * c));
            for (to, (above, below)) in near.as_chunks_mut().0.iter_mut().zip(above.zip(below)) {
                *to = [above[number], above[c + number], below[number], below[c + number]].map(Element::to_f32);
            }
        });
        out.write((0, 1), &near[..], packed);
    }

    /// [`Self::copy`] for [`Access::Pooled`].
    #[inline(always)]
    fn copy_pooled<P: Pack>(
        &self,
        [y, x0]: [usize; 2],
        count: usize,
        mut out: Pixels<'_, P>,
        Memory { near, packed, .. }: &mut Memory,
    ) {
        let c = self.rows.size()[2];
        near.resize(count * c, 0.0);
        with_rows!(self.rows, rows => {
            let columns = 2 * x0 * c..2 * (x0 + count) * c;
            rows.prefetch_after_pair(2 * y, columns.clone());
            let (above, below) = (&rows.row(2 * y)[columns.clone()], &rows.row(2 * y + 1)[columns]);
            let pairs = above.chunks_exact(2 * c).zip(below.chunks_exact(2 * c));
            for (to, (above, below)) in near.chunks_exact_mut(c).zip(pairs) {
                let ((a, b), (d, e)) = (above.split_at(c), below.split_at(c));
                for k in 0..c {
                    let sums = (a[k].to_f32() + b[k].to_f32()) + (d[k].to_f32() + e[k].to_f32());
                    to[k] = 0.25 * sums;
                }
            }
        });
        out.write((0, 1), &near[..], packed);
    }

    /// [`Self::copy`] at twice the resolution, bilinear: first between two rows, then along them, the even columns
    /// before the odd ones.
    #[inline(always)]
    fn copy_bilinear<P: Pack>(
        &self,
        [y, x0]: [usize; 2],
        count: usize,
        mut out: Pixels<'_, P>,
        Memory { near, far, packed, .. }: &mut Memory,
    ) {
        let [height, width, c] = self.rows.size();
        let [(a, wa), (b, wb)] = halves(y, height);
        // One more column on both sides; at a border the last one is repeated.
        let (first, end) = (x0 / 2, (x0 + count).div_ceil(2));
        let inside = first.saturating_sub(1)..(end + 1).min(width);
        let before = usize::from(first == 0) * c;
        far.resize((end - first + 2) * c, 0.0);
        with_rows!(self.rows, rows => {
            let columns = inside.start * c..inside.end * c;
            rows.prefetch_after(a.max(b), columns.clone());
            let both = rows.row(a)[columns.clone()].iter().zip(&rows.row(b)[columns]);
            for (to, (a, b)) in far[before..].iter_mut().zip(both) {
                *to = wa * a.to_f32() + wb * b.to_f32();
            }
        });
        if first == 0 {
            far.copy_within(c..2 * c, 0);
        }
        if end == width {
            let length = far.len();
            far.copy_within(length - 2 * c..length - c, length - c);
        }
        for phase in 0..2 {
            let columns = Columns::of_phase(phase, x0, count);
            let from = columns.from - first;
            let length = (columns.to - columns.from) * c;
            let nearest = &far[(from + 1) * c..][..length];
            let beside = &far[(from + 2 * phase) * c..][..length];
            near.resize(length, 0.0);
            for (to, (nearest, beside)) in near.iter_mut().zip(nearest.iter().zip(beside)) {
                *to = 0.75 * nearest + 0.25 * beside;
            }
            out.write((columns.first, 2), &near[..], packed);
        }
    }
}

/// Writes the colours of `samples`, all of one row, for the `count` columns from `x0` on. Other pixels become zero.
#[inline(always)]
fn copy_samples<P: Pack>(
    samples: &[Sample],
    x0: usize,
    count: usize,
    mut out: Pixels<'_, P>,
    Memory { near, packed, .. }: &mut Memory,
) {
    near.clear();
    near.resize(3 * count, 0.0);
    let pixels = near.as_chunks_mut().0;
    let first = samples.partition_point(|sample| (sample.x as usize) < x0);
    for sample in samples[first..].iter().take_while(|sample| (sample.x as usize) < x0 + count) {
        pixels[sample.x as usize - x0] = sample.colour;
    }
    out.write((0, 1), &near[..], packed);
}

/// Columns of a map from which the even or the odd columns at twice its resolution are computed.
#[derive(Debug, Clone, Copy)]
struct Columns {
    /// Index, within the range, of the first column of that parity.
    first: usize,
    /// First column of the map.
    from: usize,
    /// End of the columns of the map.
    to: usize,
}

impl Columns {
    /// Finds the columns for the even (`phase` 0) or odd (1) ones among the `count` columns from `x0` on.
    fn of_phase(phase: usize, x0: usize, count: usize) -> Self {
        let first = (x0 + phase) % 2;
        let number = count.saturating_sub(first).div_ceil(2);
        let from = (x0 + first) / 2;
        Self { first, from, to: from + number }
    }
}

/// Pixels of a patch. A source writes some of their channels.
struct Pixels<'a, P: Pack> {
    pack: P,
    numbers: &'a mut [P::Number],
    /// Distance between pixels.
    stride: usize,
    channels: Channels,
}

impl<P: Pack> Pixels<'_, P> {
    /// Packs `pixels` to the positions `first`, `first` + `step` and so on.
    #[inline(always)]
    fn write<T: Element>(&mut self, (first, step): (usize, usize), pixels: &[T], row: &mut AlignedBuf) {
        if pixels.is_empty() {
            return;
        }
        let numbers = &mut self.numbers[first * self.stride + self.channels.first..];
        let to = To { numbers, stride: step * self.stride };
        self.pack.pack(self.channels, pixels, row, to);
    }
}

/// Operation that copies a part of a row.
struct Copying<'a, P: Pack> {
    source: Source<'a>,
    place: [usize; 2],
    count: usize,
    out: Pixels<'a, P>,
    memory: &'a mut Memory,
}

impl<P: Pack> SimdOp for Copying<'_, P> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        self.source.copy(self.place, self.count, self.out, self.memory);
    }
}

/// Order of the channels of [`Access::Folded`], as channel numbers of
/// [`space_to_depth`](crate::cpu::layers::reshape::space_to_depth).
///
/// The two upper pixels come first, then the two lower ones, with their channels together. In this order folding is
/// a plain copy of rows.
pub fn unfolded(channels: usize) -> impl Iterator<Item = usize> {
    (0..4).flat_map(move |part| (0..channels).map(move |c| 4 * c + part))
}

/// Scratch rows.
#[derive(Debug, Default)]
pub struct Memory {
    near: Vec<f32>,
    far: Vec<f32>,
    packed: AlignedBuf,
}

/// Part of the inputs that a patch covers.
#[derive(Debug, Clone, Copy)]
pub struct Window {
    /// First row; it may lie before the border.
    pub y: isize,
    /// First column; it may lie before the border.
    pub x: isize,
    /// Number of rows.
    pub rows: usize,
    /// Number of columns.
    pub columns: usize,
}

impl Window {
    /// Writes row `row` of the window of the concatenated `sources` to `out`. A pixel has `channels` numbers, with
    /// zeros for channels that no source has. Returns false, and writes nothing, for rows beyond a border of zeros.
    pub fn row<P: Pack>(
        &self,
        sources: &[Source<'_>],
        padding: Padding,
        row: usize,
        (pack, out, channels): (P, &mut [P::Number], usize),
        (simd, memory): (Simd, &mut Memory),
    ) -> bool {
        let [height, width] = sources[0].size();
        let y = self.y + row as isize;
        let y = match padding {
            Padding::Zero if y < 0 || y >= height as isize => return false,
            _ => y.clamp(0, height as isize - 1) as usize,
        };
        let before = (-self.x).clamp(0, self.columns as isize) as usize;
        let first = (self.x + before as isize) as usize;
        let inside = self.columns.saturating_sub(before).min(width.saturating_sub(first));
        if inside == 0 {
            return false;
        }
        let end = before + inside;
        let pixels = &mut out[before * channels..end * channels];
        let mut filled = 0;
        for &source in sources {
            let of_source = Channels { first: filled, count: source.channels() };
            let out = Pixels { pack, numbers: pixels, stride: channels, channels: of_source };
            simd.vectorised(Copying { source, place: [y, first], count: inside, out, memory });
            filled += of_source.count;
        }
        let whole = filled.next_multiple_of(size_of::<u32>() / size_of::<P::Number>());
        if filled < whole {
            for pixel in pixels.chunks_exact_mut(channels) {
                pixel[filled..whole].fill(P::Number::default());
            }
        }
        let pixel = |x: usize| x * channels..(x + 1) * channels;
        if padding == Padding::Replicate {
            (0..before).for_each(|x| out.copy_within(pixel(before), x * channels));
            (end..self.columns).for_each(|x| out.copy_within(pixel(end - 1), x * channels));
        } else {
            out[..before * channels].fill(P::Number::default());
            out[end * channels..].fill(P::Number::default());
        }
        true
    }
}

/// A window of concatenated sources, packed in 32-bit words for convolution kernels. Pixels begin at whole words.
/// Zeros follow the last row, since kernels may read beyond it.
#[derive(Debug, Default)]
pub struct Patch {
    /// The packed words.
    pub words: AlignedBuf,
    memory: Memory,
}

/// Number of zero words after the last row.
const BEYOND: usize = 16;

impl Patch {
    /// Fills the patch with the `window` of `sources`.
    pub fn assemble<P: Pack>(
        &mut self,
        sources: &[Source<'_>],
        padding: Padding,
        window: Window,
        (pack, words, simd): (P, usize, Simd),
    ) {
        let per_word = size_of::<u32>() / size_of::<P::Number>();
        let length = window.rows * window.columns * words;
        self.words.resize(length + BEYOND);
        self.words[length..].fill(0);
        for (number, to) in self.words[..length].chunks_exact_mut(window.columns * words).enumerate() {
            let numbers: &mut [P::Number] = cast_slice_mut(to);
            let row = (pack, numbers, words * per_word);
            if !window.row(sources, padding, number, row, (simd, &mut self.memory)) {
                to.fill(0);
            }
        }
    }
}
