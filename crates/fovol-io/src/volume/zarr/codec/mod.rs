//! The encoding of a chunk: how axes are ordered, filters of values, bytes or shards, compressions.

mod compression;
mod crc32c;
mod decoding;
mod filter;
mod index;

use super::element::{Element, of_numpy};
use super::json::{configured, named, whole_numbers};
use compression::{Compression, unknown};
pub use decoding::Scratch;
use filter::Filter;
use fovol_core::{Dtype, Endian};
use serde_json::Value;

/// The encoding of a chunk.
#[derive(Debug)]
pub struct Chain {
    /// The axis of the array that each axis of a stored chunk is.
    pub order: Vec<usize>,
    /// The content of the bytes.
    pub layout: Layout,
    /// Changes of the values, as they are made when writing.
    filters: Vec<Filter>,
    /// Compressions and checksums, as they are made when writing.
    compressions: Vec<Compression>,
    /// Whether bytes are turned before filters are undone.
    is_turned: bool,
}

/// The content of a chunk without its compressions.
#[derive(Debug)]
pub enum Layout {
    /// All values in C order.
    Bytes,
    /// Smaller chunks.
    Shards(Box<Shards>),
}

/// Chunks within a chunk, found by an index.
#[derive(Debug)]
pub struct Shards {
    /// Shape of a chunk, in the order of the stored axes.
    pub chunk: Vec<usize>,
    /// Chunks along each axis.
    pub counts: Vec<usize>,
    /// The encoding of a chunk.
    pub inner: Chain,
    /// The encoding of the index.
    index: Chain,
    index_endian: Endian,
    is_index_first: bool,
}

impl Chain {
    /// The chain of an array of version 2.
    ///
    /// # Errors
    /// An unknown filter or compressor.
    pub fn of_v2(
        axes: usize,
        element: Element,
        is_fortran: bool,
        filters: &[Value],
        compressor: Option<&Value>,
    ) -> Result<Self, String> {
        let name = |value: &Value| value.get("id").and_then(Value::as_str).unwrap_or_default().to_owned();
        let mut chain = Self {
            order: if is_fortran { (0..axes).rev().collect() } else { (0..axes).collect() },
            layout: Layout::Bytes,
            filters: Vec::new(),
            compressions: Vec::new(),
            is_turned: false,
        };
        for filter in filters {
            // A compressor may stand among the filters, behind those of values.
            match Filter::of(&name(filter), filter, element, of_numpy)? {
                Some(found) if chain.compressions.is_empty() => chain.filters.push(found),
                Some(_) => {
                    return Err(format!(
                        "has the filter `{}` behind a compressor; write it again",
                        name(filter)
                    ));
                }
                None => chain.compressions.push(Compression::of(&name(filter), filter)?),
            }
        }
        if let Some(compressor) = compressor {
            chain.compressions.push(Compression::of(&name(compressor), compressor)?);
        }
        Ok(chain)
    }

    /// The chain of chunks of shape `chunk` in version 3, and how decoded values are stored.
    ///
    /// # Errors
    /// Codecs that are unknown or in an impossible order.
    pub fn of_v3(chunk: &[usize], dtype: Dtype, codecs: &[Value]) -> Result<(Self, Element), String> {
        let mut order: Vec<usize> = (0..chunk.len()).collect();
        let (mut layout, mut filters, mut compressions) = (None, Vec::new(), Vec::new());
        let mut element = Element::little(dtype);
        for codec in codecs {
            let name = named(codec);
            let short = name.strip_prefix("numcodecs.").unwrap_or(name);
            let nothing = Value::Null;
            let configuration = codec.get("configuration").unwrap_or(&nothing);
            match (short, &layout) {
                ("transpose", None) => order = transposed(&order, codec)?,
                ("bytes" | "endian", None) => {
                    layout = Some(Layout::Bytes);
                    if configured(codec, "endian").and_then(Value::as_str) == Some("big") {
                        element.endian = Endian::Big;
                    }
                }
                ("sharding_indexed", None) => {
                    let shape: Vec<usize> = order.iter().map(|&axis| chunk[axis]).collect();
                    let (shards, inner) = Shards::of_v3(&shape, dtype, codec)?;
                    (layout, element) = (Some(Layout::Shards(Box::new(shards))), inner);
                }
                (_, None) => match Filter::of(short, configuration, element, of_numpy)? {
                    Some(filter) => filters.push(filter),
                    None => return Err(unknown(name)),
                },
                (_, Some(_)) => compressions.push(Compression::of(short, configuration)?),
            }
        }
        let layout = layout.ok_or("has codecs without `bytes`; write it again")?;
        let is_turned = !filters.is_empty() && element.endian == Endian::Big;
        if !filters.is_empty() {
            element = Element::little(dtype);
        }
        if matches!(layout, Layout::Shards(_)) && !filters.is_empty() {
            return Err("has filters before its shards, which are not read; write it without them".into());
        }
        Ok((Self { order, layout, filters, compressions, is_turned }, element))
    }

    /// Bytes that `length` bytes become, where that does not depend on their values.
    fn fixed_length(&self, length: usize) -> Option<usize> {
        let is_plain = matches!(self.layout, Layout::Bytes) && self.filters.is_empty();
        let lengths = self.compressions.iter().map(|compression| compression.added());
        lengths.fold(is_plain.then_some(length), |length, added| length?.checked_add(added?))
    }
}

impl Shards {
    /// The shards of shape `shape`, and how their values are stored.
    fn of_v3(shape: &[usize], dtype: Dtype, codec: &Value) -> Result<(Self, Element), String> {
        let wrong = || "has shards whose chunks do not fill them; write it again".to_owned();
        let chunk = whole_numbers(configured(codec, "chunk_shape")).ok_or_else(wrong)?;
        let divides = |(&length, &part): (&usize, &usize)| part > 0 && length % part == 0;
        if chunk.len() != shape.len() || !shape.iter().zip(&chunk).all(divides) {
            return Err(wrong());
        }
        let counts: Vec<usize> = shape.iter().zip(&chunk).map(|(length, part)| length / part).collect();
        let list =
            |key: &str| configured(codec, key).and_then(Value::as_array).map_or(&[][..], Vec::as_slice);
        let (inner, element) = Self::inner(&chunk, dtype, list("codecs"))?;
        let (index, index_element) = Self::inner(&[counts.len()], Dtype::U64, list("index_codecs"))?;
        if index.fixed_length(0).is_none() {
            return Err("has a packed index of its shards, which is not read; write it without that".into());
        }
        let is_index_first = configured(codec, "index_location").and_then(Value::as_str) == Some("start");
        Ok((
            Self { chunk, counts, inner, index, index_endian: index_element.endian, is_index_first },
            element,
        ))
    }

    fn inner(chunk: &[usize], dtype: Dtype, codecs: &[Value]) -> Result<(Chain, Element), String> {
        match codecs {
            [] => Err("has shards without codecs; write it again".into()),
            codecs => Chain::of_v3(chunk, dtype, codecs),
        }
    }
}

/// `order` after the codec `transpose`.
fn transposed(order: &[usize], codec: &Value) -> Result<Vec<usize>, String> {
    let axes = order.len();
    let said = configured(codec, "order");
    let by = match said.and_then(Value::as_str) {
        Some("F") => (0..axes).rev().collect(),
        Some("C") => (0..axes).collect(),
        _ => whole_numbers(said).unwrap_or_default(),
    };
    let mut sorted = by.clone();
    sorted.sort_unstable();
    if !sorted.into_iter().eq(0..axes) {
        return Err("has a codec `transpose` without a sound order; write it again".into());
    }
    Ok(by.into_iter().map(|axis| order[axis]).collect())
}
