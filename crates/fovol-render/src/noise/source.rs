use super::asset::decode_ranks;
use super::kind::NoiseKind;
use super::random::hash;
use super::size::NoiseSize;
use super::void_and_cluster::ranks;
use std::sync::{Arc, OnceLock};

/// 128×128×64 ranks of spatio-temporal blue noise, packed; see the card beside the file.
static STBN: &[u8] = include_bytes!("../../assets/noise/stbn_128x128x64.ranks");

/// The edge in pixels of the tile that repeats over the frame.
const TILE: usize = NoiseSize::STBN.width;
/// Pixels of one word of a mask.
const WORD: usize = u64::BITS as usize;
/// After this many frames blue noise repeats in time.
const FRAMES: usize = NoiseSize::STBN.frames;

/// A source of thresholds for every pixel of every frame.
///
/// Pixel (x, y) of frame t is sampled where N = (rank + ½)/levels lies below the wanted density.
#[derive(Debug, Clone)]
pub struct Noise {
    kind: NoiseKind,
    seed: u64,
    tiles: Arc<[OnceLock<Vec<u32>>]>,
}

/// The noise of one frame.
#[derive(Debug, Clone, Copy)]
pub struct FrameNoise<'a> {
    source: Source<'a>,
    levels: u32,
}

#[derive(Debug, Clone, Copy)]
enum Source<'a> {
    Tile(&'a [u32]),
    Hash(u64),
}

impl Noise {
    /// Noise of a kind. `seed` changes uniform and blue noise; the spatio-temporal one is always the
    /// volume that the program carries.
    pub fn new(kind: NoiseKind, seed: u64) -> Self {
        Self { kind, seed, tiles: (0..FRAMES).map(|_| OnceLock::new()).collect() }
    }

    /// The kind.
    pub fn kind(&self) -> NoiseKind {
        self.kind
    }

    /// The noise of frame `t`.
    pub fn frame(&self, t: u32) -> FrameNoise<'_> {
        let slice = t as usize % FRAMES;
        match self.kind {
            NoiseKind::Stbn => {
                let tile = TILE * TILE;
                FrameNoise {
                    source: Source::Tile(&stbn()[slice * tile..][..tile]),
                    levels: NoiseSize::STBN.len() as u32,
                }
            }
            NoiseKind::Blue => {
                let size = NoiseSize { frames: 1, ..NoiseSize::STBN };
                let tile = self.tiles[slice].get_or_init(|| ranks(size, hash(self.seed, slice as u64)));
                FrameNoise { source: Source::Tile(tile), levels: size.len() as u32 }
            }
            NoiseKind::Uniform => {
                FrameNoise { source: Source::Hash(hash(self.seed, u64::from(t))), levels: 1 << 20 }
            }
        }
    }
}

/// The ranks that the program carries, \[t\]\[y\]\[x\].
fn stbn() -> &'static [u32] {
    static RANKS: OnceLock<Vec<u32>> = OnceLock::new();
    RANKS.get_or_init(|| {
        decode_ranks(STBN, NoiseSize::STBN.len()).expect("the file is complete: it is compiled in")
    })
}

impl FrameNoise<'_> {
    /// The number of levels, a power of two: N = (rank + ½)/levels.
    pub fn levels(&self) -> u32 {
        self.levels
    }

    /// The rank of pixel (`x`, `y`).
    pub fn rank(&self, x: u32, y: u32) -> u32 {
        match self.source {
            Source::Tile(ranks) => ranks[y as usize % TILE * TILE + x as usize % TILE],
            Source::Hash(seed) => (hash(seed, u64::from(y) << 32 | u64::from(x)) >> 44) as u32,
        }
    }

    /// The ranks of the tile that repeats, row by row; `None` where every pixel has its own.
    #[cfg(feature = "gpu")]
    pub(crate) fn tile(&self) -> Option<&[u32]> {
        match self.source {
            Source::Tile(ranks) => Some(ranks),
            Source::Hash(_) => None,
        }
    }

    /// The seed that ranks are hashed from; `None` where ranks come from a tile.
    #[cfg(feature = "gpu")]
    pub(crate) fn seed(&self) -> Option<u64> {
        match self.source {
            Source::Tile(_) => None,
            Source::Hash(seed) => Some(seed),
        }
    }

    /// The ranks of pixels 64·`word`…64·`word` + 63 of row `y`.
    pub fn word(&self, word: usize, y: u32) -> [u32; WORD] {
        match self.source {
            Source::Tile(ranks) => {
                let (row, _) = ranks[y as usize % TILE * TILE..][..TILE].as_chunks();
                row[word % row.len()]
            }
            Source::Hash(_) => std::array::from_fn(|bit| self.rank((word * WORD + bit) as u32, y)),
        }
    }

    /// After how many words a row repeats; `None` where it never does.
    pub fn words_per_tile(&self) -> Option<usize> {
        match self.source {
            Source::Tile(_) => Some(TILE / WORD),
            Source::Hash(_) => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_pixels_and_tiles_repeat() {
        for kind in NoiseKind::ALL {
            let noise = Noise::new(kind, 5);
            let frame = noise.frame(67);
            let row: Vec<u32> = (0..5).flat_map(|word| frame.word(word, 131)).collect();
            assert!((0..320u32).all(|x| row[x as usize] == frame.rank(x, 131)), "{kind}");
            assert!(row.iter().all(|&r| r < frame.levels()));
            assert_eq!(row[0] == row[TILE], kind != NoiseKind::Uniform);
            assert_eq!(frame.words_per_tile().is_some(), kind != NoiseKind::Uniform);
            assert!(frame.levels().is_power_of_two());
        }
    }

    #[test]
    fn frames_differ_and_repeat_after_64() {
        let noise = Noise::new(NoiseKind::Stbn, 0);
        assert_ne!(noise.frame(0).rank(5, 5), noise.frame(1).rank(5, 5));
        assert_eq!(noise.frame(3).rank(5, 5), noise.frame(67).rank(5, 5));
    }
}
