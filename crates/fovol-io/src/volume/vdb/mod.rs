//! OpenVDB: <https://www.openvdb.org/documentation/doxygen/codeExamples.html#sGridIO>.
//!
//! The box of the active voxels of a grid becomes a dense volume. Voxels in it that are not active have the values that the
//! tree gives them, mostly its background.

mod cursor;
mod file;
mod kind;
mod transform;
mod tree;
mod values;

use super::active_box::ActiveBox;
use super::affine::Affine;
use super::arrays::{self, Candidate};
use super::{Overrides, Source};
use crate::{Error, Result};
use cursor::Cursor;
pub use file::is_vdb;
use file::{Entry, Head, Metadata};
use fovol_core::Volume;
use kind::Kind;
use tree::Tree;
use values::{Packing, Problem};

/// The name of the format.
const FORMAT: &str = "OpenVDB";

/// Reads a `.vdb` file: the chosen grid, else the one called density, else the first scalar grid.
///
/// # Errors
/// Damaged files, no grid of voxels, transforms and codecs that are not read, a box that needs too much memory.
pub fn parse(source: &Source, overrides: &Overrides) -> Result<Volume> {
    let file = File::parse(source)?;
    let names: Vec<String> = file.grids.iter().map(|grid| grid.entry.name()).collect();
    let candidates: Vec<Candidate<'_>> =
        file.grids.iter().zip(&names).map(|(grid, name)| grid.candidate(name)).collect();
    if candidates.is_empty() {
        return Err(source.malformed("it holds no grids; save one with its voxels"));
    }
    let (index, contents) = arrays::shown(source, &candidates, overrides)?;
    Ok(file.grids[index].volume(&file, &names[index])?.with_format(FORMAT).with_contents(contents))
}

/// An open file.
struct File<'a> {
    source: &'a Source,
    grids: Vec<Grid>,
}

/// A grid of a file.
struct Grid {
    entry: Entry,
    /// Where the grid begins.
    start: u64,
    kind: std::result::Result<Kind, String>,
}

impl<'a> File<'a> {
    fn parse(source: &'a Source) -> Result<Self> {
        let head = Head::parse(source)?;
        let mut cursor = head.cursor;
        let mut file = Self { source, grids: Vec::new() };
        for _ in 0..head.grids {
            let entry = Entry::parse(&mut cursor).ok_or_else(|| source.damaged())?;
            let kind = Kind::of(&entry.kind);
            let start = if head.has_offsets { entry.start } else { cursor.place() };
            let end = entry.end;
            let grid = Grid { entry, start, kind };
            cursor = match head.has_offsets {
                true => Cursor::at(source.bytes(), end).ok_or_else(|| source.damaged())?,
                false => grid.passed(source)?,
            };
            file.grids.push(grid);
        }
        Ok(file)
    }
}

/// The beginning of a grid.
struct Opened<'a> {
    packing: Packing,
    metadata: Metadata,
    transform: std::result::Result<Affine, String>,
    /// Where the tree begins, if the grid has its own.
    cursor: Cursor<'a>,
}

impl Grid {
    fn candidate<'a>(&self, name: &'a str) -> Candidate<'a> {
        Candidate {
            name,
            components: self.kind.as_ref().map_or(1, |kind| kind.components),
            is_of_cells: false,
            is_active: name == "density",
            is_readable: self.kind.is_ok(),
        }
    }

    fn opened<'a>(&self, source: &'a Source) -> Option<Opened<'a>> {
        let mut cursor = Cursor::at(source.bytes(), self.start)?;
        let packing = Packing(cursor.u32()?);
        let metadata = Metadata::parse(&mut cursor)?;
        let transform = transform::parse(&mut cursor)?;
        Some(Opened { packing, metadata, transform, cursor })
    }

    /// Reads the grid only to find where it ends.
    fn passed<'a>(&self, source: &'a Source) -> Result<Cursor<'a>> {
        let opened = self.opened(source).ok_or_else(|| source.damaged())?;
        let unread = |problem: String| {
            let name = self.entry.name();
            source.unsupported(format!("its grid `{name}` {problem}, and others cannot be found behind it"))
        };
        let kind = self.kind.as_ref().map_err(|problem| unread(problem.clone()))?;
        opened.transform.as_ref().map_err(|name| unread(of_transform(name)))?;
        let mut cursor = opened.cursor;
        if self.entry.parent.is_empty() {
            let tree =
                Tree::parse(kind, opened.packing, &mut cursor).map_err(|problem| failed(source, problem))?;
            tree.values(&mut cursor, None).map_err(|problem| failed(source, problem))?;
        }
        Ok(cursor)
    }

    fn volume(&self, file: &File<'_>, name: &str) -> Result<Volume> {
        let source = file.source;
        let refused = |problem: &str| source.unsupported(format!("its grid `{name}` {problem}"));
        let kind = self.kind.as_ref().map_err(|problem| refused(problem))?;
        let opened = self.opened(source).ok_or_else(|| source.damaged())?;
        let affine = opened.transform.map_err(|name| refused(&of_transform(&name)))?;
        let mut cursor = opened.cursor;
        let mut packing = opened.packing;
        if !self.entry.parent.is_empty() {
            let owner = file.grids.iter().find(|grid| grid.entry.unique_name == self.entry.parent);
            let owner = owner.filter(|owner| owner.entry.parent.is_empty() && owner.kind == self.kind);
            let owner = owner.and_then(|owner| owner.opened(source)).ok_or_else(|| source.damaged())?;
            owner.transform.map_err(|name| refused(&of_transform(&name)))?;
            (cursor, packing) = (owner.cursor, owner.packing);
        }
        let tree = Tree::parse(kind, packing, &mut cursor).map_err(|problem| failed(source, problem))?;
        let mut filled = ActiveBox::new(source, tree.bounds, tree.background())?;
        tree.values(&mut cursor, Some(&mut filled)).map_err(|problem| failed(source, problem))?;
        let volume = filled.volume(source, kind.shown_dtype(), kind.components, affine)?;
        Ok(match opened.metadata.class.as_str() {
            "level set" => volume.with_note(super::active_box::LEVEL_SET),
            _ => volume,
        })
    }
}

/// The remark on a transform of the kind `name`.
fn of_transform(name: &str) -> String {
    format!("has the transform {name}, which is not linear; resample it to a grid of one voxel size")
}

/// The error for `problem`.
fn failed(source: &Source, problem: Problem) -> Error {
    match problem {
        Problem::Damaged => source.damaged(),
        Problem::Codec(name) => source.unsupported(format!(
            "it is packed by Blosc with {name}, which is not read; save it with zlib, or with Blosc's own LZ4"
        )),
    }
}
