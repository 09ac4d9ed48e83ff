//! Data elements, the atoms of DICOM (PS3.5, chapter 7): tag, type, length and value, one after another.

use super::tags::Vr;

/// How elements are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Encoding {
    /// Whether each element states its type.
    pub is_explicit: bool,
    /// Whether numbers are big-endian.
    pub is_big: bool,
}

/// The encoding of most files, and of every file's meta information.
pub const EXPLICIT_LITTLE: Encoding = Encoding { is_explicit: true, is_big: false };

/// The oldest encoding, and that of values of unknown type with an undefined length.
pub const IMPLICIT_LITTLE: Encoding = Encoding { is_explicit: false, is_big: false };

/// One element.
#[derive(Debug, Clone, Copy)]
pub struct Element {
    /// Group and element.
    pub tag: u32,
    /// The type of the value, if the file says it.
    pub vr: Option<Vr>,
    /// Where the value begins.
    pub start: usize,
    /// Where the value ends; before the mark that ends a value of undefined length.
    pub end: usize,
    /// Where the next element begins.
    pub next: usize,
    /// Whether the value has no stated length: a sequence, or compressed pixels.
    pub is_undefined: bool,
}

/// Sequences may lie in each other so deep.
const DEEPEST: usize = 24;

/// Start of an item, its end, and the end of a sequence.
const ITEM: u32 = 0xFFFE_E000;
const ITEM_END: u32 = 0xFFFE_E00D;
const SEQUENCE_END: u32 = 0xFFFE_E0DD;

/// The length that stands for no length.
const UNDEFINED: u32 = u32::MAX;

/// First group of pixels. They may be cut short, and nothing behind them is read.
pub const PIXEL_GROUP: u32 = 0x7FE0;

impl Encoding {
    fn u16(self, bytes: &[u8], at: usize) -> Option<u16> {
        let two = bytes.get(at..at.checked_add(2)?)?.try_into().ok()?;
        Some(if self.is_big { u16::from_be_bytes(two) } else { u16::from_le_bytes(two) })
    }

    fn u32(self, bytes: &[u8], at: usize) -> Option<u32> {
        let four = bytes.get(at..at.checked_add(4)?)?.try_into().ok()?;
        Some(if self.is_big { u32::from_be_bytes(four) } else { u32::from_le_bytes(four) })
    }

    fn tag(self, bytes: &[u8], at: usize) -> Option<u32> {
        Some(u32::from(self.u16(bytes, at)?) << 16 | u32::from(self.u16(bytes, at.checked_add(2)?)?))
    }

    /// The element at `at`; none where it is damaged.
    pub fn element(self, bytes: &[u8], at: usize) -> Option<Element> {
        self.element_within(bytes, at, 0)
    }

    fn element_within(self, bytes: &[u8], at: usize, depth: usize) -> Option<Element> {
        let tag = self.tag(bytes, at)?;
        let (vr, length, start) = self.head(bytes, at)?;
        let is_undefined = length == UNDEFINED;
        if !is_undefined {
            let end = start.checked_add(length as usize)?;
            let is_whole = end <= bytes.len() || tag >> 16 == PIXEL_GROUP;
            let end = end.min(bytes.len());
            return is_whole.then_some(Element { tag, vr, start, end, next: end, is_undefined });
        }
        if tag >> 16 == PIXEL_GROUP {
            let end = bytes.len();
            return Some(Element { tag, vr, start, end, next: end, is_undefined });
        }
        let inner = if vr == Some(*b"UN") { IMPLICIT_LITTLE } else { self };
        let end = inner.sequence_end(bytes, start, depth)?;
        Some(Element { tag, vr, start, end, next: end + 8, is_undefined })
    }

    /// Type and length of the element at `at`, and where its value begins.
    fn head(self, bytes: &[u8], at: usize) -> Option<(Option<Vr>, u32, usize)> {
        let implicit = || Some((None, self.u32(bytes, at + 4)?, at + 8));
        let vr: Vr = bytes.get(at + 4..at + 6)?.try_into().ok()?;
        // Some programs put an implicit element among explicit ones.
        if !self.is_explicit || !vr.iter().all(u8::is_ascii_uppercase) {
            return implicit();
        }
        match &vr {
            b"OB" | b"OW" | b"OF" | b"OD" | b"OL" | b"OV" | b"SQ" | b"UC" | b"UR" | b"UT" | b"UN" | b"SV"
            | b"UV" => Some((Some(vr), self.u32(bytes, at + 8)?, at + 12)),
            _ => Some((Some(vr), u32::from(self.u16(bytes, at + 6)?), at + 8)),
        }
    }

    /// Where the mark is that ends the sequence whose items begin at `start`.
    fn sequence_end(self, bytes: &[u8], start: usize, depth: usize) -> Option<usize> {
        let mut at = start;
        loop {
            match (self.tag(bytes, at)?, self.u32(bytes, at + 4)?) {
                (SEQUENCE_END, _) => return Some(at),
                (ITEM, length) => at = self.item_end(bytes, at + 8, length, depth)?.1,
                _ => return None,
            }
        }
    }

    /// Where the item whose content begins at `start` ends, and where the next one begins.
    fn item_end(self, bytes: &[u8], start: usize, length: u32, depth: usize) -> Option<(usize, usize)> {
        if length != UNDEFINED {
            let end = start.checked_add(length as usize).filter(|&end| end <= bytes.len())?;
            return Some((end, end));
        }
        if depth >= DEEPEST {
            return None;
        }
        let mut at = start;
        while self.tag(bytes, at)? != ITEM_END {
            at = self.element_within(bytes, at, depth + 1)?.next;
        }
        Some((at, at + 8))
    }

    /// The contents of the items of a sequence with the value `bytes[start..end]`, up to damage.
    pub fn items(self, bytes: &[u8], start: usize, end: usize) -> Vec<(usize, usize)> {
        let bytes = bytes.get(..end).unwrap_or_default();
        let mut items = Vec::new();
        let mut at = start;
        while self.tag(bytes, at) == Some(ITEM) {
            let Some(length) = self.u32(bytes, at + 4) else { break };
            let Some((end, next)) = self.item_end(bytes, at + 8, length, 0) else { break };
            items.push((at + 8, end));
            at = next;
        }
        items
    }
}

/// The fragments of compressed pixels in `bytes`, of which the first is a table of offsets.
pub fn fragments(bytes: &[u8]) -> Vec<&[u8]> {
    let mut fragments = Vec::new();
    let mut at = 0;
    while EXPLICIT_LITTLE.tag(bytes, at) == Some(ITEM) {
        let Some(length) = EXPLICIT_LITTLE.u32(bytes, at + 4) else { break };
        let end = (at + 8).saturating_add(length as usize).min(bytes.len());
        fragments.push(&bytes[at + 8..end]);
        at = end;
    }
    fragments
}
