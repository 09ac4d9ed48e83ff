//! The XML of a VTK image: its extents, its arrays, and the location of their data.

use crate::Result;
use crate::volume::arrays::{self, Candidate};
use crate::volume::{Overrides, Source};
use fovol_core::{Contents, Dtype, Endian};

/// The XML, read.
#[derive(Debug, Default)]
pub struct Document<'a> {
    /// The kind of data.
    pub kind: Kind,
    /// How bytes are written.
    pub coding: Coding,
    /// First and last point along each axis, of the piece that holds the data.
    pub extent: Option<Extent>,
    /// The spacing of the points, if the file states it.
    pub spacing: Vec<f64>,
    /// The position of point (0, 0, 0), if the file states it.
    pub origin: Option<[f64; 3]>,
    /// The direction matrix by rows, if the file states it; its columns are the directions of the axes.
    pub direction: Option<[f64; 9]>,
    /// The arrays of points.
    pub points: Attributes<'a>,
    /// The arrays of cells.
    pub cells: Attributes<'a>,
    /// The positions of points along x, y and z, of a rectilinear grid.
    pub coordinates: Attributes<'a>,
    /// The pieces of a parallel image: the extent and the file of each.
    pub pieces: Vec<(Option<Extent>, Option<String>)>,
    /// The appended data after the arrays, if any.
    pub appended: Option<Appended>,
}

/// First and last point along x, y and z.
pub type Extent = [i64; 6];

/// The kinds of data that are read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Kind {
    /// An image in one piece.
    #[default]
    Image,
    /// Values at points whose distances may differ.
    Rectilinear,
    /// An image whose pieces are in other files.
    Parallel,
}

/// How the bytes of all arrays are written.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Coding {
    /// The byte order of lengths and values.
    pub endian: Endian,
    /// Whether lengths have 64 bits instead of 32.
    pub is_wide: bool,
    /// The compression of binary data.
    pub compressor: Option<Compressor>,
}

/// The compressions that are read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Compressor {
    /// Blocks of zlib.
    Zlib,
    /// Blocks of bare LZ4.
    Lz4,
}

/// The arrays of points or of cells.
#[derive(Debug, Default)]
pub struct Attributes<'a> {
    /// The name of the array to show.
    pub active: Option<String>,
    /// All arrays, in the order of the file.
    pub arrays: Vec<Array<'a>>,
}

/// One `DataArray`.
#[derive(Debug)]
pub struct Array<'a> {
    /// Name of the array; empty if it has none.
    pub name: String,
    /// The name of the type of its values.
    pub kind: String,
    /// Values per point.
    pub components: usize,
    /// Where its data is.
    pub data: Data<'a>,
}

/// Where the data of an array is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Data<'a> {
    /// Here, as decimal numbers.
    Ascii(&'a str),
    /// Here, as base64.
    Inline(&'a str),
    /// In the appended data, this far from its mark.
    Appended(usize),
}

/// The data at the end of the file.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Appended {
    /// The byte after the mark `_`.
    pub start: usize,
    /// Whether it is base64 rather than raw.
    pub is_base64: bool,
}

impl Document<'_> {
    /// The number of points along each axis, and the extent that says so.
    ///
    /// # Errors
    /// No sound extent.
    pub fn points_and_extent(&self, source: &Source) -> Result<([usize; 3], Extent)> {
        let extent = self.extent.ok_or_else(|| source.malformed("its XML has no image with an Extent"))?;
        let points = points(extent).ok_or_else(|| {
            source.malformed(format!("its Extent {extent:?} is not first and last point along each axis"))
        })?;
        Ok((points, extent))
    }

    /// The array to show.
    ///
    /// # Errors
    /// No array, none of the chosen name, or no sound extent.
    pub fn shown(&self, source: &Source, overrides: &Overrides) -> Result<Shown<'_>> {
        let (points, _) = self.points_and_extent(source)?;
        let of = |attributes: &'_ Attributes<'_>, is_of_cells: bool| {
            let is_active = |array: &Array<'_>| attributes.active.as_deref() == Some(&*array.name);
            let arrays = attributes.arrays.iter();
            arrays.map(|array| (is_active(array), is_of_cells)).collect::<Vec<_>>()
        };
        let arrays: Vec<&Array<'_>> = self.points.arrays.iter().chain(&self.cells.arrays).collect();
        let places = [of(&self.points, false), of(&self.cells, true)].concat();
        let candidates: Vec<Candidate<'_>> = arrays
            .iter()
            .zip(places)
            .map(|(array, (is_active, is_of_cells))| Candidate {
                name: &array.name,
                components: array.components,
                is_of_cells,
                is_active,
                is_readable: array.dtype(source).is_ok(),
            })
            .collect();
        let (index, contents) = arrays::shown(source, &candidates, overrides)?;
        let is_of_cells = candidates[index].is_of_cells;
        let dims = match is_of_cells {
            // An axis of one point has one layer of flat cells.
            true => points.map(|count| (count - 1).max(1)),
            false => points,
        };
        Ok(Shown { array: arrays[index], is_of_cells, dims, contents })
    }
}

/// The array to show.
pub struct Shown<'a> {
    /// The array.
    pub array: &'a Array<'a>,
    /// Whether it has a value for each cell rather than for each point.
    pub is_of_cells: bool,
    /// Values along each axis.
    pub dims: [usize; 3],
    /// Contents of the file, and the selected part.
    pub contents: Contents,
}

/// The number of points along each axis.
pub fn points(extent: Extent) -> Option<[usize; 3]> {
    let mut counts = [0; 3];
    for (count, ends) in counts.iter_mut().zip(extent.chunks_exact(2)) {
        let steps = usize::try_from(ends[1].checked_sub(ends[0])?).ok()?;
        *count = steps.checked_add(1)?;
    }
    Some(counts)
}

impl Array<'_> {
    /// The type of the values.
    ///
    /// # Errors
    /// Types that are no numbers.
    pub fn dtype(&self, source: &Source) -> Result<Dtype> {
        Ok(match self.kind.as_str() {
            "UInt8" => Dtype::U8,
            "Int8" => Dtype::I8,
            "UInt16" => Dtype::U16,
            "Int16" => Dtype::I16,
            "UInt32" => Dtype::U32,
            "Int32" => Dtype::I32,
            "UInt64" => Dtype::U64,
            "Int64" => Dtype::I64,
            "Float32" => Dtype::F32,
            "Float64" => Dtype::F64,
            other => {
                return Err(source.unsupported(format!(
                    "its array `{}` has type `{}`; only Int8 to UInt64, Float32 and Float64 are read",
                    self.name.escape_debug(),
                    other.escape_debug()
                )));
            }
        })
    }
}
