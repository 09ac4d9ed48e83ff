//! Damaged files: sound seeds of every kind, changed by a seeded generator.
//!
//! Shared by the tests, by the example `fuzz_parsers` and by the targets of cargo-fuzz.

mod readers;
pub mod seeds;
mod tiff_files;
mod transfer_functions;
#[cfg(feature = "zarr")]
mod zarr_files;

/// A parser under test and its seeds.
pub struct Target {
    /// Name on the command line.
    pub name: &'static str,
    /// The name of the file, which decides the parser where the content does not.
    pub file: &'static str,
    /// Valid files to mutate.
    pub seeds: Vec<Vec<u8>>,
    /// Parses one input and checks the result.
    pub read: readers::Reader,
}

/// A small generator of random numbers (SplitMix64): the same seed gives the same files everywhere.
pub struct Random(u64);

impl Random {
    /// The generator of `seed`.
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// A number below `end`; 0 when `end` is 0.
    pub fn below(&mut self, end: usize) -> usize {
        (self.next() % (end.max(1) as u64)) as usize
    }

    fn one_of<'a, T: ?Sized>(&mut self, items: &[&'a T]) -> &'a T {
        items[self.below(items.len())]
    }
}

/// Numbers that break things, as text.
const NUMBERS: &[&[u8]] = &[
    b"0",
    b"-0",
    b"1",
    b"-1",
    b"2",
    b"3",
    b"255",
    b"256",
    b"65535",
    b"65536",
    b"65537",
    b"2147483647",
    b"-2147483648",
    b"4294967295",
    b"4294967296",
    b"9223372036854775807",
    b"-9223372036854775808",
    b"18446744073709551615",
    b"18446744073709551616",
    b"340282366920938463463374607431768211456",
    b"1e308",
    b"1e-320",
    b"1e999",
    b"nan",
    b"-inf",
    b"0x10",
    b"",
    b" ",
    b"%d",
    b"%99d",
];

/// Numbers that break things, as bytes; written in both orders.
const BINARY: &[u64] = &[
    0,
    1,
    2,
    0x7F,
    0x80,
    0xFF,
    0x100,
    0x7FFF,
    0x8000,
    0xFFFF,
    0x1_0000,
    0x7FFF_FFFF,
    0x8000_0000,
    0xFFFF_FFFF,
    0x1_0000_0000,
    0x7FC0_0000,
    0x7F80_0000,
    i64::MAX as u64,
    i64::MIN as u64,
    u64::MAX,
    0x7FF0_0000_0000_0000,
];

/// Longer files are cut: what breaks at a gigabyte breaks at a kilobyte that claims to be one.
const LONGEST: usize = 1 << 15;

/// Words that occur in any of `seeds`: field names, types, encodings.
pub fn words(seeds: &[Vec<u8>]) -> Vec<Vec<u8>> {
    let is_part = |byte: &u8| byte.is_ascii_alphanumeric() || matches!(byte, b'_' | b'-' | b'%' | b'.');
    let mut words: Vec<Vec<u8>> = seeds
        .iter()
        .flat_map(|seed| seed.split(|byte| !is_part(byte)))
        .filter(|word| (2..24).contains(&word.len()))
        .map(<[u8]>::to_vec)
        .collect();
    words.sort();
    words.dedup();
    words.truncate(4096);
    words
}

/// One of `seeds` with one to eight changes.
pub fn mutated(random: &mut Random, seeds: &[Vec<u8>], words: &[Vec<u8>]) -> Vec<u8> {
    let mut bytes = seeds[random.below(seeds.len())].clone();
    for _ in 0..=random.below(8) {
        change(random, &mut bytes, seeds, words);
        bytes.truncate(LONGEST);
    }
    bytes
}

fn change(random: &mut Random, bytes: &mut Vec<u8>, seeds: &[Vec<u8>], words: &[Vec<u8>]) {
    let at = random.below(bytes.len() + 1);
    let end = (at + 1 + random.below(16)).min(bytes.len());
    match random.below(12) {
        0 => bytes.iter_mut().skip(at).take(1).for_each(|byte| *byte ^= 1 << random.below(8)),
        1 => bytes.iter_mut().skip(at).take(1).for_each(|byte| *byte = random.below(256) as u8),
        2 => bytes.truncate(at),
        3 => drop(bytes.drain(at..end)),
        4 => {
            let piece = bytes[at..end].to_vec();
            insert(bytes, random, &piece);
        }
        5 => {
            let other = &seeds[random.below(seeds.len())];
            let from = random.below(other.len() + 1);
            bytes.truncate(at);
            bytes.extend_from_slice(&other[from..]);
        }
        6 | 7 => replace_number(random, bytes),
        8 => replace_word(random, bytes, words),
        9 if !words.is_empty() => {
            let word = words[random.below(words.len())].clone();
            insert(bytes, random, &word);
        }
        10 => swap_lines(random, bytes),
        _ => overwrite(random, bytes, at),
    }
}

fn insert(bytes: &mut Vec<u8>, random: &mut Random, piece: &[u8]) {
    let at = random.below(bytes.len() + 1);
    bytes.splice(at..at, piece.iter().copied());
}

/// Puts a dangerous number where a number is; the search begins anywhere.
fn replace_number(random: &mut Random, bytes: &mut Vec<u8>) {
    let is_digit = |byte: &u8| byte.is_ascii_digit() || matches!(byte, b'.' | b'-');
    let number = random.one_of(NUMBERS);
    replace_run(random, bytes, is_digit, number);
}

/// Puts a word of another place where a word is.
fn replace_word(random: &mut Random, bytes: &mut Vec<u8>, words: &[Vec<u8>]) {
    if words.is_empty() {
        return;
    }
    let word = words[random.below(words.len())].clone();
    replace_run(random, bytes, |byte| byte.is_ascii_alphanumeric() || *byte == b'_', &word);
}

fn replace_run(random: &mut Random, bytes: &mut Vec<u8>, is_part: impl Fn(&u8) -> bool, new: &[u8]) {
    let from = random.below(bytes.len());
    let Some(start) = bytes[from..].iter().position(&is_part).map(|at| from + at) else { return };
    let length = bytes[start..].iter().take_while(|byte| is_part(byte)).count();
    bytes.splice(start..start + length, new.iter().copied());
}

/// Puts a dangerous number of 1, 2, 4 or 8 bytes at `at`.
fn overwrite(random: &mut Random, bytes: &mut [u8], at: usize) {
    let value = BINARY[random.below(BINARY.len())];
    let size = 1 << random.below(4);
    let number = match random.below(2) {
        0 => value.to_le_bytes()[..size].to_vec(),
        _ => value.to_be_bytes()[8 - size..].to_vec(),
    };
    bytes.iter_mut().skip(at).zip(number).for_each(|(byte, new)| *byte = new);
}

fn swap_lines(random: &mut Random, bytes: &mut Vec<u8>) {
    let mut lines: Vec<&[u8]> = bytes.split_inclusive(|&byte| byte == b'\n').collect();
    let (a, b) = (random.below(lines.len()), random.below(lines.len()));
    if a < lines.len() && b < lines.len() {
        lines.swap(a, b);
        *bytes = lines.concat();
    }
}
