//! Input transform BᵀdB.

use super::parts::{Factors, Scratch, Strip, Winograd};
use super::tile::{self, PLACES, REACH, SIDE};
use crate::cpu::conv::patch::{Access, Source};
use crate::plan::Padding;
use bytemuck::{cast_slice, cast_slice_mut};
use fovol_simd::{SimdF32, SimdF32Op};

/// Operation that computes BᵀdB for every tile and input channel.
pub struct Transform<'a> {
    pub conv: &'a Winograd,
    pub sources: &'a [Source<'a>],
    pub strip: Strip,
    pub scratch: &'a mut Scratch,
}

impl SimdF32Op for Transform<'_> {
    type Output = ();

    #[inline(always)]
    fn run<V: SimdF32>(self, some: V) {
        let Self { conv, sources, strip, scratch } = self;
        scratch.transformed.resize(PLACES * strip.tiles * conv.pixel());
        let (patch, out) = (&scratch.patch.words[..], &mut scratch.transformed[..]);
        let pixel = conv.loaded_pixel();
        for word in (0..conv.shape.inputs.div_ceil(conv.factors.loaded())).step_by(V::N) {
            let inputs = match in_place(conv, sources, word) {
                Some((source, word)) => Inputs::of_source(conv, source, strip, word),
                None => Inputs::of_patch(patch, pixel, strip, word),
            };
            let part = Part { tiles: strip.tiles, pixel, word };
            match &conv.factors {
                Factors::F32 => {
                    let load = |words: &[u32]| [some.load(cast_slice(&words[..V::N]))];
                    let mut store =
                        |_, at: usize, [v]: [V; 1]| v.store(cast_slice_mut(&mut out[at..at + V::N]));
                    transform((&inputs, part), load, &mut store, some);
                }
                Factors::Bf16 => {
                    let load = |words: &[u32]| some.load_halves(words);
                    let mut store =
                        |_, at: usize, [low, high]: [V; 2]| low.store_halves(high, &mut out[at..at + V::N]);
                    transform((&inputs, part), load, &mut store, some);
                }
                Factors::Bytes(bytes) => {
                    let load = |words: &[u32]| some.load_halves(words);
                    let out: &mut [u8] = cast_slice_mut(out);
                    let mut store = |place: usize, at: usize, [low, high]: [V; 2]| {
                        let [even, odd] = bytes.factors(place, word, V::N).map(|factors| some.load(factors));
                        V::store_bytes([low, high], [even, odd], &mut out[2 * at..2 * (at + V::N)]);
                    };
                    transform((&inputs, part), load, &mut store, some);
                }
            }
        }
    }
}

/// Finds the source that is read without a copy and has the channels at word `word` of a pixel. Returns it with the
/// word of its own pixels, or `None` if these channels are in the patch.
fn in_place<'a>(conv: &Winograd, sources: &'a [Source<'a>], word: usize) -> Option<(&'a Source<'a>, usize)> {
    let mut first = 0;
    for source in sources {
        let words = source.channels().div_ceil(conv.factors.loaded());
        if source.access == Access::InPlace && (first..first + words).contains(&word) {
            return Some((source, word - first));
        }
        first += words;
    }
    None
}

/// Six rows of inputs for tiles side by side.
struct Inputs<'a> {
    /// Words of each row; `None` beyond a border of zeros.
    rows: [Option<&'a [u32]>; REACH],
    /// Words of a pixel, and the first of those that are read.
    pixel: usize,
    word: usize,
    /// First column within the rows, and number of columns.
    x: isize,
    width: isize,
    padding: Padding,
}

impl<'a> Inputs<'a> {
    /// Reads from the patch `words`, which has all columns of the strip.
    fn of_patch(words: &'a [u32], pixel: usize, strip: Strip, word: usize) -> Self {
        let width = SIDE * strip.tiles + 2;
        let row = |y: usize| &words[(strip.row + y) * width * pixel..][..width * pixel];
        let rows = std::array::from_fn(|y| Some(row(y)));
        Self { rows, pixel, word, x: 0, width: width as isize, padding: Padding::Replicate }
    }

    /// Reads from `source`, beginning one row and column before `strip`.
    fn of_source(conv: &Winograd, source: &Source<'a>, strip: Strip, word: usize) -> Self {
        let ([height, width], padding) = (source.size(), conv.shape.padding);
        let [y, x] = strip.place.map(|first| first as isize - 1);
        let row = |row: usize| {
            let y = y + row as isize;
            let is_beyond = padding == Padding::Zero && !(0..height as isize).contains(&y);
            (!is_beyond).then(|| source.rows.words(y.clamp(0, height as isize - 1) as usize))
        };
        let pixel = source.channels() / conv.factors.loaded();
        Self { rows: std::array::from_fn(row), pixel, word, x, width: width as isize, padding }
    }

    /// Index of the word at which a column is read; `None` beyond a border of zeros.
    #[inline(always)]
    fn place(&self, column: usize) -> Option<usize> {
        let x = self.x + column as isize;
        let inside = x.clamp(0, self.width - 1);
        (inside == x || self.padding != Padding::Zero).then(|| inside as usize * self.pixel + self.word)
    }
}

/// Some channels of the tiles of a strip.
#[derive(Clone, Copy)]
struct Part {
    tiles: usize,
    /// Words of a pixel, if transformed values were stored like inputs.
    pixel: usize,
    /// First word of each pixel.
    word: usize,
}

/// Computes BᵀdB for the channels of one vector of words, in every tile. `load` unpacks words to vectors; `store`
/// packs the results of one place. Values beyond the last channel are undefined.
#[inline(always)]
fn transform<V: SimdF32, const PARTS: usize>(
    (inputs, Part { tiles, pixel, word }): (&Inputs<'_>, Part),
    load: impl Fn(&[u32]) -> [V; PARTS],
    store: &mut impl FnMut(usize, usize, [V; PARTS]),
    some: V,
) {
    let mut columns = [[[some; REACH]; REACH]; PARTS];
    let mut first = 0;
    for tile in 0..tiles {
        // Consecutive tiles share two columns.
        for column in first..REACH {
            let mut d = [[some.splat(0.0); REACH]; PARTS];
            if let Some(at) = inputs.place(SIDE * tile + column) {
                for y in 0..REACH {
                    let Some(row) = inputs.rows[y] else { continue };
                    let parts = load(&row[at..]);
                    for part in 0..PARTS {
                        d[part][y] = parts[part];
                    }
                }
            }
            for part in 0..PARTS {
                columns[part][column] = tile::inputs(d[part]);
            }
        }
        first = REACH - SIDE;
        for y in 0..REACH {
            let mut rows = [[some; REACH]; PARTS];
            for part in 0..PARTS {
                let mut d = [some; REACH];
                for x in 0..REACH {
                    d[x] = columns[part][x][y];
                }
                rows[part] = tile::inputs(d);
            }
            for x in 0..REACH {
                let mut parts = [some; PARTS];
                for part in 0..PARTS {
                    parts[part] = rows[part][x];
                }
                let place = y * REACH + x;
                store(place, (place * tiles + tile) * pixel + word, parts);
            }
        }
        for part in 0..PARTS {
            columns[part].copy_within(SIDE.., 0);
        }
    }
}
