use super::arithmetic::{Arithmetic, MOST_LANES};
use crate::bf16::{Bf16, HALF_ULP, UPPER_HALF};

/// Loads and stores of narrower numbers.
pub trait Storage: Arithmetic {
    /// Loads the bf16 in the lower halves and in the upper halves of words.
    ///
    /// # Panics
    /// Where there are fewer words than lanes.
    #[inline(always)]
    fn load_halves(self, words: &[u32]) -> [Self; 2] {
        let mut halves = [[0.0; MOST_LANES]; 2];
        for i in 0..Self::N {
            halves[0][i] = f32::from_bits(words[i] << 16);
            halves[1][i] = f32::from_bits(words[i] & UPPER_HALF);
        }
        halves.map(|half| self.load(&half))
    }
    /// Rounds two vectors to bf16 and stores them in the lower and the upper halves of words.
    ///
    /// # Panics
    /// Where there are fewer words than lanes.
    #[inline(always)]
    fn store_halves(self, upper: Self, words: &mut [u32]) {
        let mut halves = [[0.0; MOST_LANES]; 2];
        self.store(&mut halves[0]);
        upper.store(&mut halves[1]);
        for i in 0..Self::N {
            let [lower, upper] =
                [halves[0][i], halves[1][i]].map(|half| half.to_bits().wrapping_add(HALF_ULP));
            words[i] = lower >> 16 | upper & UPPER_HALF;
        }
    }

    /// Stores the lanes as bf16, rounded to nearest, ties to even.
    ///
    /// # Panics
    /// Where `to` is shorter than the vector.
    #[inline(always)]
    fn store_bf16(self, to: &mut [Bf16]) {
        let mut numbers = [0.0; MOST_LANES];
        self.store(&mut numbers);
        for i in 0..Self::N {
            to[i] = Bf16::from_f32(numbers[i]);
        }
    }
    /// Loads words as signed integers and converts them to f32.
    ///
    /// # Panics
    /// Where there are fewer words than lanes.
    #[inline(always)]
    fn load_integers(self, words: &[u32]) -> Self {
        let mut numbers = [0.0; MOST_LANES];
        for i in 0..Self::N {
            numbers[i] = words[i] as i32 as f32;
        }
        self.load(&numbers)
    }
    /// Stores two vectors, interleaved, as bytes: numbers times factors, rounded, clamped to −128…127, plus 128.
    /// Products beyond ±32767 are undefined.
    ///
    /// # Panics
    /// Where there are fewer than two bytes for each lane.
    #[inline(always)]
    fn store_bytes(numbers: [Self; 2], factors: [Self; 2], bytes: &mut [u8]) {
        let mut both = [[0.0; MOST_LANES]; 2];
        (numbers[0] * factors[0]).store(&mut both[0]);
        (numbers[1] * factors[1]).store(&mut both[1]);
        for i in 0..Self::N {
            for (part, numbers) in both.iter().enumerate() {
                bytes[2 * i + part] = (numbers[i].round_ties_even().clamp(-128.0, 127.0) + 128.0) as u8;
            }
        }
    }

    /// Splits each lane, a word of two bf16, into the lower and the upper one.
    fn halves(self) -> [Self; 2];
}
