//! From the XML to a [`Document`].

use super::document::{Appended, Array, Attributes, Coding, Compressor, Data, Document, Kind};
use crate::Result;
use crate::volume::Source;
use fovol_core::Endian;
use quick_xml::events::{BytesStart, Event};
use quick_xml::{Reader, XmlVersion};
use std::borrow::Cow;
use std::str::FromStr;

/// Reads the XML of `source`, up to its appended data.
///
/// # Errors
/// Broken XML, other kinds of data, compressions that are not read.
pub fn parse(source: &Source) -> Result<Document<'_>> {
    let (end, mark) = markup(source)?;
    let text = std::str::from_utf8(&source.bytes()[..end])
        .map_err(|e| source.malformed(format!("its XML is no UTF-8 text at byte {}", e.valid_up_to())))?;
    let mut reader = Reader::from_str(text);
    let mut walk = Walk { source, mark, document: Document::default(), places: Vec::new(), pieces: 0 };
    loop {
        match reader.read_event() {
            Ok(Event::Start(element)) => walk.enter(&element)?,
            Ok(Event::Empty(element)) => {
                walk.enter(&element)?;
                walk.leave();
            }
            Ok(Event::Text(text)) => {
                if let Cow::Borrowed(text) = text.into_inner() {
                    walk.text(text);
                }
            }
            Ok(Event::End(_)) => walk.leave(),
            Ok(Event::Eof) => return Ok(walk.document),
            Ok(_) => {}
            Err(e) => {
                let at = reader.error_position();
                let problem = e.to_string().replace('\n', " ");
                return Err(source.malformed(format!("its XML is broken at byte {at}: {problem}")));
            }
        }
    }
}

/// Where the XML ends, and where the appended data begins: raw bytes are not XML, so neither is found by
/// an XML parser.
fn markup(source: &Source) -> Result<(usize, Option<usize>)> {
    const TAG: &[u8] = b"<AppendedData";
    let bytes = source.bytes();
    let mut from = 0;
    let tag = loop {
        match bytes[from..].iter().position(|&byte| byte == b'<') {
            Some(found) if bytes[from + found..].starts_with(TAG) => break from + found,
            Some(found) => from += found + 1,
            None => return Ok((bytes.len(), None)),
        }
    };
    let end = bytes[tag..].iter().position(|&byte| byte == b'>').map(|at| tag + at + 1);
    let mark = end.and_then(|end| {
        let blanks = bytes[end..].iter().take_while(|byte| byte.is_ascii_whitespace()).count();
        (bytes.get(end + blanks) == Some(&b'_')).then_some(end + blanks + 1)
    });
    match (end, mark) {
        (Some(end), Some(mark)) => Ok((end, Some(mark))),
        _ => Err(source.malformed("its AppendedData does not begin with the mark _; is the file cut short?")),
    }
}

/// Advice for other data than images.
const RESAMPLE: &str =
    "make one of it in ParaView: Filters > Resample To Image, then File > Save Data as .vti";

/// The elements that matter, by where they may stand.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Place {
    File,
    Image,
    Piece,
    Points,
    Cells,
    Coordinates,
    Array,
    Appended,
    Other,
}

impl Place {
    fn of(parent: Option<Self>, name: &str) -> Self {
        match (parent, name) {
            (None, "VTKFile") => Self::File,
            (Some(Self::File), "ImageData" | "RectilinearGrid" | "PImageData") => Self::Image,
            (Some(Self::File), "AppendedData") => Self::Appended,
            (Some(Self::Image), "Piece") => Self::Piece,
            (Some(Self::Piece), "PointData") | (Some(Self::Image), "PPointData") => Self::Points,
            (Some(Self::Piece), "CellData") | (Some(Self::Image), "PCellData") => Self::Cells,
            (Some(Self::Piece), "Coordinates") => Self::Coordinates,
            (Some(Self::Points | Self::Cells), "DataArray" | "PDataArray") => Self::Array,
            (Some(Self::Coordinates), "DataArray") => Self::Array,
            _ => Self::Other,
        }
    }
}

/// A walk through the elements.
struct Walk<'a> {
    source: &'a Source,
    mark: Option<usize>,
    document: Document<'a>,
    /// The elements that are open.
    places: Vec<Place>,
    pieces: usize,
}

impl<'a> Walk<'a> {
    fn enter(&mut self, element: &BytesStart<'_>) -> Result<()> {
        let place = Place::of(self.places.last().copied(), element.name().as_ref());
        match place {
            Place::File => self.file(element)?,
            Place::Image => self.image(element)?,
            Place::Piece => self.piece(element)?,
            Place::Points => self.document.points.active = self.get(element, "Scalars")?,
            Place::Cells => self.document.cells.active = self.get(element, "Scalars")?,
            Place::Coordinates => self.document.coordinates = Attributes::default(),
            Place::Array => {
                let array = self.array(element)?;
                self.attributes().arrays.push(array);
            }
            Place::Appended => {
                let is_base64 = self.get(element, "encoding")?.as_deref() != Some("raw");
                self.document.appended = self.mark.map(|start| Appended { start, is_base64 });
            }
            Place::Other => {}
        }
        self.places.push(place);
        Ok(())
    }

    fn leave(&mut self) {
        self.places.pop();
    }

    /// The first text of an array that is not blank is its data.
    fn text(&mut self, text: &'a str) {
        if self.places.last() != Some(&Place::Array) || text.bytes().all(|byte| byte.is_ascii_whitespace()) {
            return;
        }
        // The array is in the list of the element around it.
        self.places.pop();
        if let Some(Data::Ascii(data) | Data::Inline(data)) =
            self.attributes().arrays.last_mut().map(|array| &mut array.data)
            && data.is_empty()
        {
            *data = text;
        }
        self.places.push(Place::Array);
    }

    /// The arrays of the innermost open `PointData` or `CellData`.
    fn attributes(&mut self) -> &mut Attributes<'a> {
        match self.places.last() {
            Some(Place::Cells) => &mut self.document.cells,
            Some(Place::Coordinates) => &mut self.document.coordinates,
            _ => &mut self.document.points,
        }
    }

    fn file(&mut self, element: &BytesStart<'_>) -> Result<()> {
        let kind = self.get(element, "type")?.unwrap_or_default();
        self.document.kind = match kind.as_str() {
            "ImageData" => Kind::Image,
            "RectilinearGrid" => Kind::Rectilinear,
            "PImageData" => Kind::Parallel,
            other => {
                return Err(self.source.unsupported(format!(
                    "it holds VTK {}, which is no image; {RESAMPLE}",
                    other.escape_debug()
                )));
            }
        };
        let endian = match self.get(element, "byte_order")?.as_deref() {
            Some("BigEndian") => Endian::Big,
            _ => Endian::Little,
        };
        let is_wide = self.get(element, "header_type")?.as_deref() == Some("UInt64");
        let compressor = match self.get(element, "compressor")?.as_deref() {
            None | Some("") => None,
            Some("vtkZLibDataCompressor") => Some(Compressor::Zlib),
            Some("vtkLZ4DataCompressor") => Some(Compressor::Lz4),
            Some(other) => {
                return Err(self.source.unsupported(format!(
                    "its compression {} is not read; write it with zlib, LZ4 or uncompressed",
                    other.escape_debug()
                )));
            }
        };
        self.document.coding = Coding { endian, is_wide, compressor };
        Ok(())
    }

    fn image(&mut self, element: &BytesStart<'_>) -> Result<()> {
        self.document.extent = self.extent(element, "WholeExtent")?;
        if let Some(text) = self.get(element, "Spacing")? {
            let spacing: Vec<f64> = self.numbers(&text, "Spacing")?;
            // Flat images often have no distance along their flat axis.
            self.document.spacing =
                spacing.into_iter().map(|step| if step == 0.0 { f64::NAN } else { step }).collect();
        }
        self.document.origin = self.floats(element, "Origin")?;
        self.document.direction = self.floats(element, "Direction")?;
        Ok(())
    }

    fn piece(&mut self, element: &BytesStart<'_>) -> Result<()> {
        if self.document.kind == Kind::Parallel {
            let piece = (self.extent(element, "Extent")?, self.get(element, "Source")?);
            self.document.pieces.push(piece);
            return Ok(());
        }
        self.pieces += 1;
        if self.pieces > 1 {
            return Err(self.source.unsupported("it is cut into several pieces; write it as one"));
        }
        if let Some(extent) = self.extent(element, "Extent")? {
            self.document.extent = Some(extent);
        }
        Ok(())
    }

    fn array(&self, element: &BytesStart<'_>) -> Result<Array<'a>> {
        let components = match self.get(element, "NumberOfComponents")? {
            Some(text) => self.numbers(&text, "NumberOfComponents")?.first().copied().unwrap_or(1),
            None => 1,
        };
        let data = match self.get(element, "format")?.as_deref() {
            Some("ascii") => Data::Ascii(""),
            Some("appended") => {
                let text = self.get(element, "offset")?.unwrap_or_else(|| "0".into());
                Data::Appended(self.numbers(&text, "offset")?.first().copied().unwrap_or(0))
            }
            _ => Data::Inline(""),
        };
        Ok(Array {
            name: self.get(element, "Name")?.unwrap_or_default(),
            kind: self.get(element, "type")?.unwrap_or_default(),
            components,
            data,
        })
    }

    fn floats<const N: usize>(&self, element: &BytesStart<'_>, name: &str) -> Result<Option<[f64; N]>> {
        let Some(text) = self.get(element, name)? else { return Ok(None) };
        let floats: Vec<f64> = self.numbers(&text, name)?;
        let wrong = |_| self.source.malformed(format!("its {name} has not {N} numbers"));
        floats.try_into().map(Some).map_err(wrong)
    }

    fn extent(&self, element: &BytesStart<'_>, name: &str) -> Result<Option<[i64; 6]>> {
        let Some(text) = self.get(element, name)? else { return Ok(None) };
        let extent = self.numbers(&text, name)?.try_into();
        let extent = extent.map_err(|_| self.source.malformed(format!("its {name} has not six numbers")))?;
        Ok(Some(extent))
    }

    fn numbers<T: FromStr>(&self, text: &str, name: &str) -> Result<Vec<T>> {
        let parse = |word: &str| {
            word.parse().map_err(|_| {
                let shown: String = word.chars().take(40).collect();
                let shown = shown.escape_debug();
                self.source.malformed(format!("`{shown}` in the {name} of its XML is no such number"))
            })
        };
        text.split_whitespace().map(parse).collect()
    }

    /// The value of an attribute.
    fn get(&self, element: &BytesStart<'_>, name: &str) -> Result<Option<String>> {
        let broken = |problem: String| {
            let problem = problem.replace('\n', " ");
            self.source.malformed(format!("its XML has a broken attribute: {problem}"))
        };
        let found = element.try_get_attribute(name).map_err(|e| broken(e.to_string()))?;
        let value = found.map(|found| found.normalized_value(XmlVersion::Implicit1_0).map(Cow::into_owned));
        value.transpose().map_err(|e| broken(e.to_string()))
    }
}
