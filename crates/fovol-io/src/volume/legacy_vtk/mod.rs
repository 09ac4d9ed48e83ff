//! The first file format of VTK, of which structured points and rectilinear grids are read:
//! <https://docs.vtk.org/en/latest/vtk_file_formats/vtk_legacy_file_format.html>.

mod cursor;
mod header;

pub use header::MARK;

use super::affine::Affine;
use super::arrays::{self, Candidate};
use super::layout::{Layout, spacing_of};
use super::rectilinear::Coordinates;
use super::{Overrides, Source, numbers, reals};
use crate::Result;
use cursor::Cursor;
use fovol_core::{Dtype, Endian, Space, Volume};
use glam::DVec3;
use header::{Header, dtype, number};
use std::sync::Arc;

/// Reads a `.vtk` file of structured points or of a rectilinear grid: the chosen array, else the scalars of its points, else of its cells.
///
/// # Errors
/// A damaged file, other kinds of data, types that are not read.
pub fn parse(source: &Source, overrides: &Overrides) -> Result<Volume> {
    let mut cursor = Cursor::new(source.bytes());
    let header = Header::parse(source, &mut cursor)?;
    let mut search = Search { source, header: &header, cursor, found: Vec::new() };
    let damage = match search.run() {
        // What was found before the damage can be shown.
        Err(error) if !search.found.is_empty() => Some(error.to_string()),
        searched => {
            searched?;
            None
        }
    };
    let candidates: Vec<Candidate<'_>> = search.found.iter().map(Array::candidate).collect();
    let (index, mut contents) = arrays::shown(source, &candidates, overrides)?;
    let array = &search.found[index];
    contents.are_colours = array.is_colours && array.components > 2;
    let layout = Layout {
        dims: if array.is_of_cells { header.cells() } else { header.dims },
        spacing: spacing_of(&header.spacing),
        dtype: array.dtype,
        endian: if header.is_binary { Endian::Big } else { Endian::Little },
        components: array.components,
    };
    let values = layout.values(source)?;
    let volume = match header.is_binary {
        true => layout.volume(source, source.shared(), array.start)?,
        false => {
            let text = &source.bytes()[array.start..];
            let bytes = match array.is_colours {
                true => colour_bytes(&numbers::decimal(source, text, Dtype::F32, values)?),
                false => numbers::decimal(source, text, layout.dtype, values)?,
            };
            layout.volume(source, Arc::new(bytes), 0)?
        }
    };
    let format = if header.is_rectilinear { "VTK rectilinear grid" } else { "VTK structured points" };
    let volume = volume.with_format(format).with_contents(contents);
    let volume = match damage {
        Some(damage) => volume.with_note(format!("{damage}; only the arrays before this place are read")),
        None => volume,
    };
    if header.is_rectilinear {
        let coordinates = coordinates(source, &header)?;
        return Coordinates::new(source, &coordinates, header.dims, array.is_of_cells)?
            .applied(source, volume);
    }
    let Some(origin) = header.origin else { return Ok(volume) };
    let affine = Affine { steps: [DVec3::X, DVec3::Y, DVec3::Z], origin: DVec3::from_array(origin) };
    let zero = affine.placement(source, Space::Other)?;
    let to_middle = if array.is_of_cells { DVec3::splat(0.5) } else { DVec3::ZERO };
    let placement = zero.moved_to(to_middle, volume.grid());
    Ok(volume.with_placement(placement))
}

/// The positions of points along each axis.
fn coordinates(source: &Source, header: &Header) -> Result<[Vec<f64>; 3]> {
    let mut found: [Vec<f64>; 3] = Default::default();
    for (axis, values) in found.iter_mut().enumerate() {
        let name = ["X_COORDINATES", "Y_COORDINATES", "Z_COORDINATES"][axis];
        let Some(positions) = header.positions[axis] else {
            return Err(source.malformed(format!("it has no {name} before its data; write the file again")));
        };
        let bytes = &source.bytes()[positions.start..];
        *values = match header.is_binary {
            true => {
                let length = positions.count.saturating_mul(positions.dtype.size()).min(bytes.len());
                reals::decoded(&bytes[..length], positions.dtype, Endian::Big)
            }
            false => {
                let decimal = numbers::decimal(source, bytes, Dtype::F64, positions.count)?;
                decimal.as_chunks().0.iter().map(|value| f64::from_le_bytes(*value)).collect()
            }
        };
    }
    Ok(found)
}

/// Colours are bytes, which VTK writes as text in 0..=1.
fn colour_bytes(text: &[u8]) -> Vec<u8> {
    let (values, _) = text.as_chunks::<4>();
    values.iter().map(|&value| (255.0 * f32::from_le_bytes(value) + 0.5) as u8).collect()
}

/// An array of values and its offset.
struct Array {
    name: String,
    is_of_cells: bool,
    is_active: bool,
    is_colours: bool,
    dtype: Dtype,
    components: usize,
    start: usize,
}

impl Array {
    fn candidate(&self) -> Candidate<'_> {
        Candidate {
            name: &self.name,
            components: self.components,
            is_of_cells: self.is_of_cells,
            is_active: self.is_active,
            is_readable: true,
        }
    }
}

/// The search for arrays.
struct Search<'a> {
    source: &'a Source,
    header: &'a Header,
    cursor: Cursor<'a>,
    /// Arrays found so far.
    found: Vec<Array>,
}

/// The arrays that follow: of points or of cells, and how many values.
#[derive(Clone, Copy)]
struct Section {
    is_of_cells: bool,
    count: usize,
}

impl Search<'_> {
    /// Finds all arrays up to the end of the file.
    fn run(&mut self) -> Result<()> {
        let mut section = None;
        while let Some(words) = self.cursor.words() {
            let keyword = words[0].to_ascii_uppercase();
            match keyword.as_str() {
                "POINT_DATA" => section = Some(self.section(&words, false)?),
                "CELL_DATA" => section = Some(self.section(&words, true)?),
                "METADATA" => self.cursor.skip_metadata(),
                "FIELD" => self.field(&words, section)?,
                keyword => self.attribute(keyword, &words, section)?,
            }
        }
        Ok(())
    }

    fn section(&self, words: &[String], is_of_cells: bool) -> Result<Section> {
        let count = number(self.source, words, 1)?;
        let dims = if is_of_cells { self.header.cells() } else { self.header.dims };
        let expected = dims.iter().try_fold(1usize, |product, &dim| product.checked_mul(dim));
        match expected == Some(count) {
            true => Ok(Section { is_of_cells, count }),
            false => Err(self.source.malformed(format!(
                "its {} says {count}, but its size asks for {}x{}x{} values",
                words[0].escape_debug(),
                dims[0],
                dims[1],
                dims[2]
            ))),
        }
    }

    /// Takes the array that `keyword` begins; the cursor is past its data then.
    fn attribute(&mut self, keyword: &str, words: &[String], section: Option<Section>) -> Result<()> {
        let Some(section) = section else { return Err(self.unknown(words)) };
        let (kind, components) = match keyword {
            "SCALARS" => (2, if words.len() > 3 { number(self.source, words, 3)? } else { 1 }),
            "COLOR_SCALARS" => (usize::MAX, number(self.source, words, 2)?),
            "VECTORS" | "NORMALS" => (2, 3),
            "TENSORS" => (2, 9),
            "TENSORS6" => (2, 6),
            "TEXTURE_COORDINATES" => (3, number(self.source, words, 2)?),
            "LOOKUP_TABLE" => {
                let bytes = number::<usize>(self.source, words, 2)?.saturating_mul(4);
                return self.skip(if self.header.is_binary { Dtype::U8 } else { Dtype::F32 }, bytes);
            }
            _ => return Err(self.unknown(words)),
        };
        let is_colours = keyword == "COLOR_SCALARS";
        let dtype = match is_colours {
            true => Dtype::U8,
            false => dtype(self.source, words.get(kind).map_or("", String::as_str))?,
        };
        if keyword == "SCALARS" {
            self.skip_table_name();
        }
        let name = words.get(1).map_or("", String::as_str);
        self.array(section, name, dtype, components)?;
        let is_first =
            !self.found.iter().any(|array| array.is_active && array.is_of_cells == section.is_of_cells);
        if let Some(array) = self.found.last_mut() {
            array.is_active = is_first && (keyword == "SCALARS" || is_colours);
            array.is_colours = is_colours;
        }
        Ok(())
    }

    /// Takes the arrays of a field that have a value for each point or cell.
    fn field(&mut self, words: &[String], section: Option<Section>) -> Result<()> {
        let count: usize = number(self.source, words, 2)?;
        for _ in 0..count {
            let words = self.cursor.field_words();
            let words = words.ok_or_else(|| self.source.malformed("it ends within a FIELD"))?;
            let [components, tuples] =
                [number::<usize>(self.source, &words, 1)?, number(self.source, &words, 2)?];
            let kind = words.get(3).map_or("", String::as_str);
            match section {
                Some(section) if tuples == section.count => {
                    self.array(section, &words[0], dtype(self.source, kind)?, components)?;
                }
                _ => self.skip(dtype(self.source, kind)?, components.saturating_mul(tuples))?,
            }
        }
        Ok(())
    }

    /// Takes the array of `section` that begins here.
    fn array(&mut self, section: Section, name: &str, dtype: Dtype, components: usize) -> Result<()> {
        let start = self.cursor.at();
        self.skip(dtype, section.count.saturating_mul(components))?;
        self.found.push(Array {
            name: decoded(name),
            is_of_cells: section.is_of_cells,
            is_active: false,
            is_colours: false,
            dtype,
            components,
            start,
        });
        Ok(())
    }

    fn skip(&mut self, dtype: Dtype, values: usize) -> Result<()> {
        let skipped = self.cursor.skip_values(values, self.header.is_binary.then(|| dtype.size()));
        skipped.ok_or_else(|| {
            self.source.malformed(format!(
                "it ends before the {values} values of an array that begins at byte {}; copy or download it again",
                self.cursor.at()
            ))
        })
    }

    /// The line that names a table of colours is between scalars and their values.
    fn skip_table_name(&mut self) {
        let mut next = self.cursor;
        if next.words().is_some_and(|words| words[0].eq_ignore_ascii_case("LOOKUP_TABLE")) {
            self.cursor = next;
        }
    }

    fn unknown(&self, words: &[String]) -> crate::Error {
        let shown: String = words[0].chars().take(40).collect();
        let at = self.cursor.at();
        self.source
            .malformed(format!("the line before byte {at} is none of VTK's: `{}`", shown.escape_debug()))
    }
}

/// A name as VTK writes it: what is no plain letter stands as `%20`.
fn decoded(name: &str) -> String {
    let bytes = name.as_bytes();
    let mut out = Vec::with_capacity(bytes.len());
    let mut at = 0;
    while at < bytes.len() {
        let digits = bytes.get(at + 1..at + 3).and_then(|digits| std::str::from_utf8(digits).ok());
        match digits.and_then(|digits| u8::from_str_radix(digits, 16).ok()) {
            Some(byte) if bytes[at] == b'%' => {
                out.push(byte);
                at += 3;
            }
            _ => {
                out.push(bytes[at]);
                at += 1;
            }
        }
    }
    String::from_utf8_lossy(&out).into_owned()
}

#[cfg(test)]
mod tests;
