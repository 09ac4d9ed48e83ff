//! The first file format of VTK, of which structured points are read:
//! <https://docs.vtk.org/en/latest/vtk_file_formats/vtk_legacy_file_format.html>.

mod cursor;
mod header;

use super::affine::Affine;
use super::layout::{Layout, spacing_of};
use super::{Source, numbers};
use crate::Result;
use cursor::Cursor;
use fovol_core::{Dtype, Endian, Space, Volume};
use glam::DVec3;
use header::{Header, dtype, number};
use std::sync::Arc;

/// The first words of every such file.
pub const MARK: &[u8] = b"# vtk DataFile Version";

/// Reads a `.vtk` file of structured points: the first array of its points, else of its cells.
///
/// # Errors
/// A damaged file, other kinds of data, types that are not read.
pub fn parse(source: &Source) -> Result<Volume> {
    let mut cursor = Cursor::new(source.bytes());
    let header = Header::parse(source, &mut cursor)?;
    let array = Search { source, header: &header, cursor }.run()?;
    let layout = Layout {
        dims: if array.is_cells { header.cells() } else { header.dims },
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
    let volume = volume.with_format("VTK structured points");
    let Some(origin) = header.origin else { return Ok(volume) };
    let affine = Affine { steps: [DVec3::X, DVec3::Y, DVec3::Z], origin: DVec3::from_array(origin) };
    let zero = affine.placement(source, Space::Other)?;
    let to_middle = if array.is_cells { DVec3::splat(0.5) } else { DVec3::ZERO };
    let placement = zero.moved_to(to_middle, volume.grid());
    Ok(volume.with_placement(placement))
}

/// Colours are bytes, which VTK writes as text in 0..=1.
fn colour_bytes(text: &[u8]) -> Vec<u8> {
    let (values, _) = text.as_chunks::<4>();
    values.iter().map(|&value| (255.0 * f32::from_le_bytes(value) + 0.5) as u8).collect()
}

/// An array of values, and where it begins.
struct Array {
    is_cells: bool,
    is_colours: bool,
    dtype: Dtype,
    components: usize,
    start: usize,
}

/// The search for the array to show.
struct Search<'a> {
    source: &'a Source,
    header: &'a Header,
    cursor: Cursor<'a>,
}

/// The arrays that follow: of points or of cells, and how many values.
#[derive(Clone, Copy)]
struct Section {
    is_cells: bool,
    count: usize,
}

impl Search<'_> {
    /// The first array of points; where there is none, of cells, which come first in files that have both.
    fn run(mut self) -> Result<Array> {
        let mut section = None;
        let mut of_cells = None;
        while let Some(words) = self.cursor.words() {
            let keyword = words[0].to_ascii_uppercase();
            match (keyword.as_str(), section) {
                ("POINT_DATA", _) => section = Some(self.section(&words, false)?),
                ("CELL_DATA", _) => section = Some(self.section(&words, true)?),
                ("METADATA", _) => self.skip_metadata(),
                (keyword, section) => {
                    if let Some(array) = self.attribute(keyword, &words, section)? {
                        if !array.is_cells {
                            return Ok(array);
                        }
                        of_cells.get_or_insert(array);
                    }
                }
            }
        }
        of_cells
            .ok_or_else(|| self.source.malformed("it has no array of values in its POINT_DATA or CELL_DATA"))
    }

    fn section(&self, words: &[String], is_cells: bool) -> Result<Section> {
        let count = number(self.source, words, 1)?;
        let dims = if is_cells { self.header.cells() } else { self.header.dims };
        let expected = dims.iter().try_fold(1usize, |product, &dim| product.checked_mul(dim));
        match expected == Some(count) {
            true => Ok(Section { is_cells, count }),
            false => Err(self.source.malformed(format!(
                "its {} says {count}, but its size asks for {}x{}x{} values",
                words[0].escape_debug(),
                dims[0],
                dims[1],
                dims[2]
            ))),
        }
    }

    /// The array that `keyword` begins, of which the cursor is past the data; none where it is not one of values.
    fn attribute(
        &mut self,
        keyword: &str,
        words: &[String],
        section: Option<Section>,
    ) -> Result<Option<Array>> {
        if keyword == "FIELD" {
            return self.field(words, section);
        }
        let Some(section) = section else { return Err(self.unknown(words)) };
        let (kind, components) = match keyword {
            "SCALARS" => (2, if words.len() > 3 { number(self.source, words, 3)? } else { 1 }),
            "COLOR_SCALARS" => return self.colours(words, section).map(Some),
            "VECTORS" | "NORMALS" => (2, 3),
            "TENSORS" => (2, 9),
            "TENSORS6" => (2, 6),
            "TEXTURE_COORDINATES" => (3, number(self.source, words, 2)?),
            "LOOKUP_TABLE" => {
                let bytes = number::<usize>(self.source, words, 2)?.saturating_mul(4);
                self.skip(if self.header.is_binary { Dtype::U8 } else { Dtype::F32 }, bytes)?;
                return Ok(None);
            }
            _ => return Err(self.unknown(words)),
        };
        let dtype = dtype(self.source, words.get(kind).map_or("", String::as_str))?;
        if keyword == "SCALARS" {
            self.skip_table_name();
        }
        self.array(section, dtype, components).map(Some)
    }

    fn colours(&mut self, words: &[String], section: Section) -> Result<Array> {
        let array = self.array(section, Dtype::U8, number(self.source, words, 2)?)?;
        Ok(Array { is_colours: true, ..array })
    }

    /// The first array of a field that has a value for each point or cell.
    fn field(&mut self, words: &[String], section: Option<Section>) -> Result<Option<Array>> {
        let count: usize = number(self.source, words, 2)?;
        let mut found = None;
        for _ in 0..count {
            let words = self.field_words()?;
            let [components, tuples] =
                [number::<usize>(self.source, &words, 1)?, number(self.source, &words, 2)?];
            let kind = dtype(self.source, words.get(3).map_or("", String::as_str))?;
            match section {
                Some(section) if found.is_none() && tuples == section.count => {
                    let array = self.array(section, kind, components)?;
                    if !array.is_cells {
                        return Ok(Some(array));
                    }
                    found = Some(array);
                }
                _ => self.skip(kind, components.saturating_mul(tuples))?,
            }
        }
        Ok(found)
    }

    /// The line before the values of an array in a field.
    fn field_words(&mut self) -> Result<Vec<String>> {
        loop {
            let words = self.cursor.words().ok_or_else(|| self.source.malformed("it ends within a FIELD"))?;
            match words[0].as_str() {
                "METADATA" => self.skip_metadata(),
                _ => return Ok(words),
            }
        }
    }

    /// The array of `section` that begins here.
    fn array(&mut self, section: Section, dtype: Dtype, components: usize) -> Result<Array> {
        let start = self.cursor.at();
        self.skip(dtype, section.count.saturating_mul(components))?;
        Ok(Array { is_cells: section.is_cells, is_colours: false, dtype, components, start })
    }

    fn skip(&mut self, dtype: Dtype, values: usize) -> Result<()> {
        let skipped = match self.header.is_binary {
            true => self.cursor.skip_bytes(values.saturating_mul(dtype.size())),
            false => self.cursor.skip_words(values),
        };
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

    /// An empty line ends metadata.
    fn skip_metadata(&mut self) {
        while self.cursor.line().is_some_and(|words| !words.is_empty()) {}
    }

    fn unknown(&self, words: &[String]) -> crate::Error {
        let shown: String = words[0].chars().take(40).collect();
        let at = self.cursor.at();
        self.source
            .malformed(format!("the line before byte {at} is none of VTK's: `{}`", shown.escape_debug()))
    }
}

#[cfg(test)]
mod tests;
