//! Elements of a file or of an item, found by their tags; values are read when they are asked for.

use super::elements::{Encoding, IMPLICIT_LITTLE, PIXEL_GROUP};
use super::tags::{self, Tag, Vr};

/// Elements of a file or an item. Values stay in the file's bytes.
pub struct DataSet<'a> {
    bytes: &'a [u8],
    encoding: Encoding,
    elements: Vec<Found>,
    is_latin: bool,
    /// Where damage ended the reading, if it did.
    pub damage: Option<usize>,
}

/// Where the value of an element is.
#[derive(Clone, Copy)]
struct Found {
    tag: u32,
    vr: Option<Vr>,
    start: usize,
    end: usize,
    is_undefined: bool,
}

/// Pixels as they are in a file.
#[derive(Debug, Clone, Copy)]
pub struct PixelValue<'a> {
    /// The attribute that holds them.
    pub tag: Tag,
    /// The bytes.
    pub bytes: &'a [u8],
    /// Whether they are in fragments, that is, compressed.
    pub is_encapsulated: bool,
    /// Whether they are written in words of 16 bits, which have a byte order.
    pub are_words: bool,
}

impl<'a> DataSet<'a> {
    /// The elements in `bytes[start..end]`, without those of private groups.
    pub fn new(bytes: &'a [u8], (start, end): (usize, usize), encoding: Encoding) -> Self {
        let within = &bytes[..end.min(bytes.len())];
        let mut set = Self { bytes, encoding, elements: Vec::new(), is_latin: false, damage: None };
        let mut at = start;
        while at < within.len() {
            let Some(element) = encoding.element(within, at) else {
                set.damage = Some(at);
                break;
            };
            let group = element.tag >> 16;
            if group > PIXEL_GROUP {
                break;
            }
            if group % 2 == 0 {
                set.elements.push(Found {
                    tag: element.tag,
                    vr: element.vr,
                    start: element.start,
                    end: element.end,
                    is_undefined: element.is_undefined,
                });
            }
            at = element.next;
        }
        let names = set.text(tags::CHARACTER_SET).unwrap_or_default();
        // Programs that name no characters write what they have, which is Latin in most places.
        set.is_latin = names.is_empty() || names.contains("IR 100") || names.contains("IR_100");
        set
    }

    fn found(&self, tag: Tag) -> Option<&Found> {
        self.elements.iter().find(|element| element.tag == tag.number)
    }

    /// Whether the attribute is there with a value.
    pub fn has(&self, tag: Tag) -> bool {
        self.found(tag).is_some_and(|found| found.end > found.start)
    }

    /// The bytes of the attribute's value.
    pub fn value(&self, tag: Tag) -> Option<&'a [u8]> {
        self.found(tag).map(|found| &self.bytes[found.start..found.end])
    }

    /// The value as text without padding; none where it is empty.
    pub fn text(&self, tag: Tag) -> Option<String> {
        let bytes = self.value(tag)?;
        let text = match std::str::from_utf8(bytes) {
            Ok(text) => text.to_owned(),
            Err(_) if self.is_latin => bytes.iter().copied().map(char::from).collect(),
            Err(_) => bytes.iter().map(|&b| if b.is_ascii() { char::from(b) } else { '?' }).collect(),
        };
        let text = text.trim_matches(|c: char| c == '\0' || c == ' ');
        (!text.is_empty()).then(|| text.to_owned())
    }

    /// The numbers of the attribute, up to the first that is none; `most` at the most.
    pub fn numbers(&self, tag: Tag, most: usize) -> Vec<f64> {
        let Some(found) = self.found(tag) else { return Vec::new() };
        let vr = found.vr.filter(|vr| vr != b"UN").unwrap_or(tag.vr);
        let bytes = &self.bytes[found.start..found.end];
        match &vr {
            b"DS" | b"IS" => decimals(bytes, most),
            _ => self.binary(bytes, vr).take(most).collect(),
        }
    }

    fn binary(&self, bytes: &'a [u8], vr: Vr) -> impl Iterator<Item = f64> + 'a {
        let is_big = self.encoding.is_big;
        let size = match &vr {
            b"US" | b"SS" | b"OW" => 2,
            b"UL" | b"SL" | b"FL" | b"OF" | b"OL" => 4,
            b"FD" | b"OD" | b"UV" | b"SV" => 8,
            // No numbers.
            _ => usize::MAX,
        };
        bytes.chunks_exact(size).map(move |chunk| {
            let mut word = [0; 8];
            word[..size].copy_from_slice(chunk);
            if is_big {
                word[..size].reverse();
            }
            let whole = u64::from_le_bytes(word);
            match &vr {
                b"SS" => f64::from(whole as u16 as i16),
                b"SL" => f64::from(whole as u32 as i32),
                b"SV" => whole as i64 as f64,
                b"FL" | b"OF" => f64::from(f32::from_bits(whole as u32)),
                b"FD" | b"OD" => f64::from_bits(whole),
                _ => whole as f64,
            }
        })
    }

    /// The first number, if it is finite.
    pub fn number(&self, tag: Tag) -> Option<f64> {
        self.numbers(tag, 1).first().copied().filter(|number| number.is_finite())
    }

    /// The first number, if it is whole and fits.
    pub fn whole<T: TryFrom<i64>>(&self, tag: Tag) -> Option<T> {
        let number = self.number(tag)?;
        let is_whole = number.fract() == 0.0 && number.abs() < 9e15;
        is_whole.then_some(number as i64).and_then(|number| T::try_from(number).ok())
    }

    /// The first `N` numbers, if there are so many and all are finite.
    pub fn vector<const N: usize>(&self, tag: Tag) -> Option<[f64; N]> {
        let numbers: [f64; N] = self.numbers(tag, N).try_into().ok()?;
        numbers.iter().all(|number| number.is_finite()).then_some(numbers)
    }

    /// The items of a sequence.
    pub fn items(&self, tag: Tag) -> Vec<DataSet<'a>> {
        let Some(found) = self.found(tag) else { return Vec::new() };
        let is_unknown = found.vr == Some(*b"UN");
        let encoding = if is_unknown { IMPLICIT_LITTLE } else { self.encoding };
        let items = encoding.items(self.bytes, found.start, found.end);
        let set = |range| Self { is_latin: self.is_latin, ..Self::new(self.bytes, range, encoding) };
        items.into_iter().map(set).collect()
    }

    /// The first item of a sequence.
    pub fn item(&self, tag: Tag) -> Option<DataSet<'a>> {
        self.items(tag).into_iter().next()
    }

    /// The pixels.
    pub fn pixels(&self) -> Option<PixelValue<'a>> {
        [tags::PIXELS, tags::FLOAT_PIXELS, tags::DOUBLE_PIXELS].into_iter().find_map(|tag| {
            let found = self.found(tag)?;
            let bytes = &self.bytes[found.start..found.end];
            let are_words = found.vr.unwrap_or(tag.vr) == *b"OW";
            Some(PixelValue { tag, bytes, is_encapsulated: found.is_undefined, are_words })
        })
    }

    /// The encoding of the elements.
    pub fn encoding(&self) -> Encoding {
        self.encoding
    }
}

/// Numbers in text, with backslashes between them.
fn decimals(bytes: &[u8], most: usize) -> Vec<f64> {
    let text = String::from_utf8_lossy(bytes);
    let trimmed = |word: &str| word.trim_matches(|c: char| c.is_whitespace() || c == '\0').parse().ok();
    text.split('\\').take(most).map_while(trimmed).collect()
}

#[cfg(test)]
mod tests {
    use super::super::elements::EXPLICIT_LITTLE;
    use super::*;

    fn element(tag: u32, vr: &[u8; 2], value: &[u8]) -> Vec<u8> {
        let [group, number] = [(tag >> 16) as u16, tag as u16].map(u16::to_le_bytes);
        [&group[..], &number, vr, &(value.len() as u16).to_le_bytes(), value].concat()
    }

    #[test]
    fn values_are_read_by_their_types() {
        let bytes = [
            element(tags::ROWS.number, b"US", &[3, 1]),
            element(tags::PIXEL_SPACING.number, b"DS", b"0.5\\ 2.25 "),
            element(tags::PIXEL_PADDING.number, b"SS", &(-7i16).to_le_bytes()),
            element(0x0029_0010, b"LO", b"private "),
        ]
        .concat();
        let set = DataSet::new(&bytes, (0, bytes.len()), EXPLICIT_LITTLE);
        assert_eq!(set.whole::<usize>(tags::ROWS), Some(259));
        assert_eq!(set.vector(tags::PIXEL_SPACING), Some([0.5, 2.25]));
        assert_eq!(set.vector::<3>(tags::PIXEL_SPACING), None);
        assert_eq!(set.number(tags::PIXEL_PADDING), Some(-7.0));
        assert_eq!((set.damage, set.elements.len()), (None, 3));
    }

    #[test]
    fn damage_is_known() {
        let mut bytes = element(tags::ROWS.number, b"US", &[3, 1]);
        bytes.extend([0x28, 0, 0x11, 0, b'U', b'S', 200, 0]);
        let set = DataSet::new(&bytes, (0, bytes.len()), EXPLICIT_LITTLE);
        assert_eq!((set.damage, set.has(tags::ROWS)), (Some(10), true));
    }

    #[test]
    fn nested_items_of_undefined_length() {
        let mark = |tag: u32, length: u32| {
            let [group, number] = [(tag >> 16) as u16, tag as u16].map(u16::to_le_bytes);
            [&group[..], &number, &length.to_le_bytes()].concat()
        };
        let bytes = [
            vec![0x00, 0x52, 0x29, 0x92, b'S', b'Q', 0, 0, 255, 255, 255, 255],
            mark(0xFFFE_E000, u32::MAX),
            element(tags::ROWS.number, b"US", &[9, 0]),
            mark(0xFFFE_E00D, 0),
            mark(0xFFFE_E0DD, 0),
            element(tags::COLUMNS.number, b"US", &[5, 0]),
        ]
        .concat();
        // Elements may stand in any order.
        let set = DataSet::new(&bytes, (0, bytes.len()), EXPLICIT_LITTLE);
        let item = set.item(tags::SHARED_GROUPS).unwrap();
        assert_eq!(item.whole::<u16>(tags::ROWS), Some(9));
        assert_eq!(set.whole::<u16>(tags::COLUMNS), Some(5));
    }
}
