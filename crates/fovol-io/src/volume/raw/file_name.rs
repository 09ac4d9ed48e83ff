//! Layout of raw volumes from their file names: `bonsai_256x256x256_uint8.raw`, `ct_12x10x8_1.5x1.5x3mm_int16_be.raw`.

use super::description::Description;
use fovol_core::{Dtype, Endian};
use std::path::Path;

/// Layout that a file name states, and the words in it that look like a size or type but are not understood.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct FileName {
    /// Size, type, byte order and spacing, where the name states them.
    pub said: Description,
    /// Words like sizes or types that are not understood.
    pub unclear: Vec<String>,
}

impl FileName {
    /// Reads the name of `path`.
    pub fn of(path: &Path) -> Self {
        let name = path.file_name().unwrap_or_default().to_string_lossy().to_lowercase().replace('×', "x");
        let mut found = Self::default();
        for word in words(&name).into_iter().flat_map(pieces) {
            if !found.take(word) {
                found.unclear.push(word.to_owned());
            }
        }
        found
    }

    /// Interprets `word`; returns false if it looks like a size or type but is neither.
    fn take(&mut self, word: &str) -> bool {
        if let Some((dtype, endian)) = voxel_type(word) {
            self.said.dtype = Some(dtype);
            self.said.endian = endian.or(self.said.endian);
        } else if let Some(endian) = byte_order(word) {
            self.said.endian = Some(endian);
        } else if word.contains('x') && word.starts_with(|c: char| c.is_ascii_digit()) {
            return self.take_sides(word);
        } else if looks_like_type(word) {
            return false;
        }
        true
    }

    /// Takes three numbers joined by `x`: the first whole ones are the size, others the spacing.
    fn take_sides(&mut self, word: &str) -> bool {
        let bare = without_unit(word);
        let parts: Vec<&str> = bare.split('x').collect();
        let whole: Option<Vec<usize>> = parts.iter().map(|part| part.parse().ok()).collect();
        if let (Some(Ok(dims)), None) = (whole.map(<[usize; 3]>::try_from), self.said.dims)
            && bare == word
        {
            self.said.dims = Some(dims);
            return true;
        }
        let sides: Option<Vec<f64>> =
            parts.iter().map(|part| part.parse().ok().filter(|&s: &f64| s > 0.0)).collect();
        match (sides.map(<[f64; 3]>::try_from), self.said.spacing) {
            (Some(Ok(spacing)), None) => {
                self.said.spacing = Some(spacing);
                true
            }
            // Words like `2x` or `0x1f` are no sizes.
            _ => parts.len() < 3 || parts.iter().any(|part| part.parse::<f64>().is_err()),
        }
    }
}

/// The words of `name`. A dot between two digits belongs to a number.
fn words(name: &str) -> Vec<&str> {
    let bytes = name.as_bytes();
    let is_digit = |i: Option<usize>| i.and_then(|i| bytes.get(i)).is_some_and(u8::is_ascii_digit);
    let is_decimal = |at: usize| is_digit(at.checked_sub(1)) && is_digit(Some(at + 1));
    let mut words = Vec::new();
    let mut from = 0;
    for (at, c) in name.char_indices() {
        if "_- ,;()[]+".contains(c) || c == '.' && !is_decimal(at) {
            words.push(&name[from..at]);
            from = at + 1;
        }
    }
    words.push(&name[from..]);
    words.retain(|word| !word.is_empty());
    words
}

/// Longer words are not searched for dots that part two.
const LONGEST_WORD: usize = 64;

/// The parts of `word` where dots between digits part words that are understood: `int16.12x10x8`, `12x10x8.1.5x1.5x3`.
fn pieces(word: &str) -> Vec<&str> {
    if word.len() > LONGEST_WORD || is_understood(word) {
        return vec![word];
    }
    let parted = word.match_indices('.').find_map(|(at, _)| {
        let (left, right) = (&word[..at], &word[at + 1..]);
        let rest = if is_understood(left) { pieces(right) } else { return None };
        rest.iter().all(|piece| is_understood(piece)).then(|| [&[left], rest.as_slice()].concat())
    });
    parted.unwrap_or_else(|| vec![word])
}

/// Whether `word` is a type, a byte order or three numbers.
fn is_understood(word: &str) -> bool {
    let mut sides =
        without_unit(word).split('x').map(|side| side.parse::<f64>().is_ok_and(|side| side > 0.0));
    let are_sides = [sides.next(), sides.next(), sides.next(), sides.next()];
    voxel_type(word).is_some()
        || byte_order(word).is_some()
        || are_sides == [Some(true), Some(true), Some(true), None]
}

/// `word` without a unit of length at its end.
fn without_unit(word: &str) -> &str {
    ["mm", "um", "µm"].iter().find_map(|unit| word.strip_suffix(unit)).unwrap_or(word)
}

/// The voxel type that `word` names, with the byte order at its end.
fn voxel_type(word: &str) -> Option<(Dtype, Option<Endian>)> {
    if let Ok(dtype) = word.parse() {
        return Some((dtype, None));
    }
    [("le", Endian::Little), ("be", Endian::Big)].into_iter().find_map(|(end, endian)| {
        let bare = word.strip_suffix(end)?;
        bare.parse().ok().map(|dtype| (dtype, Some(endian)))
    })
}

fn byte_order(word: &str) -> Option<Endian> {
    match word {
        "le" | "little" | "littleendian" | "lsb" => Some(Endian::Little),
        "be" | "big" | "bigendian" | "msb" => Some(Endian::Big),
        _ => None,
    }
}

/// Whether `word` is `int`, `uint` or `float` and a number, or a number and `bit`.
fn looks_like_type(word: &str) -> bool {
    let is_number = |rest: &str| !rest.is_empty() && rest.bytes().all(|byte| byte.is_ascii_digit());
    ["uint", "int", "float"].iter().any(|kind| word.strip_prefix(kind).is_some_and(is_number))
        || ["bits", "bit"].iter().any(|end| word.strip_suffix(end).is_some_and(is_number))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn of(name: &str) -> FileName {
        FileName::of(Path::new(name))
    }

    #[test]
    fn size_type_order_and_spacing() {
        let said = of("/data/Lung_CT-115X157X129.INT16.raw.gz").said;
        assert_eq!((said.dims, said.dtype, said.endian), (Some([115, 157, 129]), Some(Dtype::I16), None));
        for name in ["v_12x10x8_int16_be.raw", "v 12x10x8 int16be.raw", "v(12x10x8)_big_i16.raw"] {
            let said = of(name).said;
            let expected = (Some([12, 10, 8]), Some(Dtype::I16), Some(Endian::Big));
            assert_eq!((said.dims, said.dtype, said.endian), expected, "{name}");
        }
        assert_eq!(of("v_12x10x8_uint16le.raw").said.endian, Some(Endian::Little));
        for name in ["ct_12x10x8_1.5x1.5x3_int16.raw", "ct_12x10x8_1.5x1.5x3mm_int16.raw"] {
            let said = of(name).said;
            assert_eq!((said.dims, said.spacing), (Some([12, 10, 8]), Some([1.5, 1.5, 3.0])), "{name}");
        }
        assert_eq!(of("ct_64x64x64_1x1x2_u8.raw").said.spacing, Some([1.0, 1.0, 2.0]));
        for name in [
            "ct.int16.12x10x8.1.5x1.5x3.raw",
            "ct.1.5x1.5x3mm.12x10x8.i16.raw",
            "ct_12x10x8.1.5x1.5x3.int16.raw",
        ] {
            let Description { dims, dtype, spacing, .. } = of(name).said;
            let expected = (Some([12, 10, 8]), Some(Dtype::I16), Some([1.5, 1.5, 3.0]));
            assert_eq!((dims, dtype, spacing), expected, "{name}");
        }
        assert_eq!(of("x.raw"), FileName::default());
    }

    #[test]
    fn words_that_are_not_understood_are_named() {
        assert_eq!(of("v_12x10x8x2_int12_8bit.raw").unclear, ["12x10x8x2", "int12", "8bit"]);
        assert_eq!(of("scan_2x_0x1f_int_of_10.5.raw").unclear, Vec::<String>::new());
    }

    proptest! {
        #[test]
        fn any_name_is_read(name in "[0-9x._ébe-]{0,30}") {
            of(&name);
        }

        #[test]
        fn sizes_are_found(dims in prop::array::uniform3(1usize..5000), name in "[a-w]{1,8}") {
            let [x, y, z] = dims;
            prop_assert_eq!(of(&format!("{name}_{x}x{y}x{z}_f32be.raw")).said.dims, Some(dims));
        }

        #[test]
        fn words_are_understood_in_any_order(
            dims in prop::array::uniform3(1usize..5000),
            tenths in prop::array::uniform3(1u32..90),
            dtype in prop::sample::select(Dtype::ALL.to_vec()),
            order in prop::sample::select(vec![("BE", Endian::Big), ("little", Endian::Little), ("msb", Endian::Big)]),
            separator in prop::sample::select(vec!["_", "-", " ", "__", "."]),
            places in Just([0, 1, 2, 3]).prop_shuffle(),
        ) {
            let [sx, sy, sz] = tenths.map(|t| format!("{}.{}", t / 10, t % 10));
            let size = dims.map(|n| n.to_string()).join("x");
            let words = [size, dtype.to_string(), order.0.to_owned(), format!("{sx}x{sy}x{sz}mm")];
            let words: Vec<&str> = places.iter().map(|&place| words[place].as_str()).collect();
            let found = of(&format!("scan{separator}{}.raw", words.join(separator)));
            prop_assert_eq!(found.unclear, Vec::<String>::new());
            let Description { dims: size, dtype: kind, endian, spacing, .. } = found.said;
            prop_assert_eq!((size, kind, endian), (Some(dims), Some(dtype), Some(order.1)));
            prop_assert_eq!(spacing, Some(tenths.map(|t| format!("{}.{}", t / 10, t % 10).parse().unwrap())));
        }
    }
}
