//! Header of legacy VTK files: the encoding, the dimensions and the spacing.

use super::cursor::Cursor;
use crate::Result;
use crate::volume::Source;
use fovol_core::Dtype;
use std::str::FromStr;

/// The first words of every such file.
pub const MARK: &[u8] = b"# vtk DataFile Version";

/// The positions of points along an axis, as they stand in the file.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Positions {
    /// The type of a position.
    pub dtype: Dtype,
    /// The byte at which they begin.
    pub start: usize,
    /// How many there are.
    pub count: usize,
}

/// Header of a legacy VTK file of structured points or of a rectilinear grid.
#[derive(Debug, Clone, PartialEq)]
pub struct Header {
    /// Whether values are binary, big-endian, rather than text.
    pub is_binary: bool,
    /// Points along each axis.
    pub dims: [usize; 3],
    /// The distance between points along each axis; empty if the file does not state it.
    pub spacing: Vec<f64>,
    /// The position of the first point, if the file states it.
    pub origin: Option<[f64; 3]>,
    /// The positions along x, y and z, of a rectilinear grid.
    pub positions: [Option<Positions>; 3],
    /// Whether it is a rectilinear grid.
    pub is_rectilinear: bool,
}

impl Header {
    /// Reads the header at `cursor`, which stands at the first section afterwards.
    ///
    /// # Errors
    /// Missing lines, and unsupported content.
    pub fn parse(source: &Source, cursor: &mut Cursor<'_>) -> Result<Self> {
        if !source.bytes().starts_with(MARK) {
            return Err(
                source.malformed("it does not begin with `# vtk DataFile Version`; is the name right?")
            );
        }
        // The first line and the title.
        cursor.line();
        cursor.line();
        let is_binary = match first(cursor.words()).as_str() {
            "BINARY" => true,
            "ASCII" => false,
            other => {
                let shown: String = other.chars().take(40).collect();
                let shown = shown.escape_debug();
                return Err(
                    source.malformed(format!("its third line is `{shown}`; it must be ASCII or BINARY"))
                );
            }
        };
        let mut header = Self {
            is_binary,
            dims: [0; 3],
            spacing: Vec::new(),
            origin: None,
            positions: [None; 3],
            is_rectilinear: false,
        };
        header.take_lines(source, cursor)?;
        match header.dims.contains(&0) {
            true => {
                Err(source.malformed("its header has no DIMENSIONS of one point or more along each axis"))
            }
            false => Ok(header),
        }
    }

    /// Takes all lines that belong to the header.
    fn take_lines(&mut self, source: &Source, cursor: &mut Cursor<'_>) -> Result<()> {
        loop {
            let before = *cursor;
            let Some(words) = cursor.words() else { return Ok(()) };
            match words[0].to_ascii_uppercase().as_str() {
                "DATASET" => self.is_rectilinear = is_rectilinear(source, &words)?,
                "DIMENSIONS" => self.dims = three(source, &words)?,
                "EXTENT" => self.dims = extent(source, &words)?,
                "SPACING" | "ASPECT_RATIO" => self.spacing = spacing(source, &words)?,
                "X_COORDINATES" => self.positions[0] = Some(self.positions(source, cursor, &words)?),
                "Y_COORDINATES" => self.positions[1] = Some(self.positions(source, cursor, &words)?),
                "Z_COORDINATES" => self.positions[2] = Some(self.positions(source, cursor, &words)?),
                "ORIGIN" => self.origin = Some(three(source, &words)?),
                // Numbers of the whole image, its time for one, may come before its size.
                "FIELD" if self.dims == [0; 3] => self.skip_field(source, cursor, &words)?,
                "METADATA" if self.dims == [0; 3] => cursor.skip_metadata(),
                _ => {
                    *cursor = before;
                    return Ok(());
                }
            }
        }
    }

    /// The positions that `words` begin; the cursor is behind them then.
    fn positions(&self, source: &Source, cursor: &mut Cursor<'_>, words: &[String]) -> Result<Positions> {
        let count = number(source, words, 1)?;
        let dtype = dtype(source, words.get(2).map_or("", String::as_str))?;
        let start = cursor.at();
        cursor.skip_values(count, self.is_binary.then(|| dtype.size())).ok_or_else(|| {
            source.malformed(format!(
                "it ends before its {count} {}; copy or download it again",
                words[0].escape_debug()
            ))
        })?;
        Ok(Positions { dtype, start, count })
    }

    /// Passes over the arrays of the field that `words` begin.
    fn skip_field(&self, source: &Source, cursor: &mut Cursor<'_>, words: &[String]) -> Result<()> {
        for _ in 0..number::<usize>(source, words, 2)? {
            let words = cursor.field_words().ok_or_else(|| source.malformed("it ends within a FIELD"))?;
            let [components, tuples] = [number::<usize>(source, &words, 1)?, number(source, &words, 2)?];
            let dtype = dtype(source, words.get(3).map_or("", String::as_str))?;
            let values = components.saturating_mul(tuples);
            cursor.skip_values(values, self.is_binary.then(|| dtype.size())).ok_or_else(|| {
                source.malformed("it ends before the values of its FIELD; copy or download it again")
            })?;
        }
        Ok(())
    }

    /// Cells along each axis; an axis of one point has one layer of flat cells.
    pub fn cells(&self) -> [usize; 3] {
        self.dims.map(|dim| dim.saturating_sub(1).max(1))
    }
}

fn first(words: Option<Vec<String>>) -> String {
    words.and_then(|words| words.into_iter().next()).unwrap_or_default().to_ascii_uppercase()
}

fn is_rectilinear(source: &Source, words: &[String]) -> Result<bool> {
    let kind = words.get(1).map_or("", String::as_str);
    match kind.to_ascii_uppercase().as_str() {
        "STRUCTURED_POINTS" => Ok(false),
        "RECTILINEAR_GRID" => Ok(true),
        _ => Err(source.unsupported(format!(
            "it holds VTK {}, which is no image; make one of it in ParaView: Filters > Resample To Image, then File > Save Data as .vti",
            kind.chars().take(40).collect::<String>().escape_debug()
        ))),
    }
}

fn three<T: FromStr + Copy>(source: &Source, words: &[String]) -> Result<[T; 3]> {
    Ok([number(source, words, 1)?, number(source, words, 2)?, number(source, words, 3)?])
}

/// Flat images may have no distance along their flat axis.
fn spacing(source: &Source, words: &[String]) -> Result<Vec<f64>> {
    Ok(three(source, words)?.map(|step: f64| if step == 0.0 { f64::NAN } else { step }).to_vec())
}

fn extent(source: &Source, words: &[String]) -> Result<[usize; 3]> {
    let mut dims = [0; 3];
    for (axis, dim) in dims.iter_mut().enumerate() {
        let ends: [i64; 2] = [number(source, words, 1 + 2 * axis)?, number(source, words, 2 + 2 * axis)?];
        let count = ends[1].checked_sub(ends[0]).and_then(|steps| steps.checked_add(1));
        *dim = count.and_then(|count| usize::try_from(count).ok()).unwrap_or(0);
    }
    Ok(dims)
}

/// The number at `index` among the words of a line.
///
/// # Errors
/// Something else, or nothing.
pub fn number<T: FromStr>(source: &Source, words: &[String], index: usize) -> Result<T> {
    words.get(index).and_then(|word| word.parse().ok()).ok_or_else(|| {
        let shown: String = words.join(" ").chars().take(60).collect();
        source.malformed(format!(
            "word {} of its line `{}` is no such number",
            index + 1,
            shown.escape_debug()
        ))
    })
}

/// The type that VTK calls `name`.
///
/// # Errors
/// Types that are no numbers of whole bytes.
pub fn dtype(source: &Source, name: &str) -> Result<Dtype> {
    Ok(match name.to_ascii_lowercase().as_str() {
        "unsigned_char" => Dtype::U8,
        "char" | "signed_char" => Dtype::I8,
        "unsigned_short" => Dtype::U16,
        "short" => Dtype::I16,
        "unsigned_int" => Dtype::U32,
        // Identifiers are written as 32 bits in these files.
        "int" | "vtkidtype" => Dtype::I32,
        // As on 64-bit machines other than Windows.
        "unsigned_long" | "unsigned_long_long" | "vtktypeuint64" => Dtype::U64,
        "long" | "long_long" | "vtktypeint64" => Dtype::I64,
        "float" => Dtype::F32,
        "double" => Dtype::F64,
        _ => {
            let shown: String = name.chars().take(40).collect();
            return Err(source.unsupported(format!(
                "an array in it has type `{}`; write it as unsigned_char to double",
                shown.escape_debug()
            )));
        }
    })
}
