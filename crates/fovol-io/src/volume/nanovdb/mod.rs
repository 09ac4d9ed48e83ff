//! NanoVDB: <https://github.com/AcademySoftwareFoundation/openvdb/blob/master/nanovdb/nanovdb/NanoVDB.h>.
//!
//! The box of the active voxels of a grid becomes a dense volume, as it does for OpenVDB.

mod file;
mod kind;
mod tree;

use super::active_box::{ActiveBox, LEVEL_SET};
use super::affine::Affine;
use super::arrays::{self, Candidate};
use super::{Overrides, Source};
use crate::Result;
pub use file::is_nanovdb;
use file::{Entry, entries, u32_at, u64_at};
use fovol_core::Volume;
use glam::DVec3;
use kind::Kind;
use std::collections::HashMap;
use tree::Tree;

/// The name of the format.
const FORMAT: &str = "NanoVDB";

/// Where a grid has its matrix, its translation and its class.
const MATRIX: usize = 384;
const TRANSLATION: usize = 528;
const CLASS: usize = 632;

/// The class of level sets.
const IS_LEVEL_SET: u32 = 1;

/// Reads a `.nvdb` file: the chosen grid, else the one called density, else the first scalar grid.
///
/// # Errors
/// Damaged files, no grid of voxels, versions and codecs that are not read, a box that needs too much memory.
pub fn parse(source: &Source, overrides: &Overrides) -> Result<Volume> {
    let entries = entries(source)?;
    let names = names(&entries);
    let kinds: Vec<_> = entries.iter().map(|entry| Kind::of(entry.kind)).collect();
    let candidates: Vec<Candidate<'_>> = names
        .iter()
        .zip(&kinds)
        .map(|(name, kind)| Candidate {
            name,
            components: kind.as_ref().map_or(1, |kind| kind.components),
            is_of_cells: false,
            is_active: name == "density",
            is_readable: kind.is_ok(),
        })
        .collect();
    if candidates.is_empty() {
        return Err(source.malformed("it holds no grids; save one with its voxels"));
    }
    let (index, mut contents) = arrays::shown(source, &candidates, overrides)?;
    let refused = |problem: &String| source.unsupported(format!("its grid `{}` {problem}", names[index]));
    let kind = *kinds[index].as_ref().map_err(refused)?;
    contents.are_colours = kind.is_colour;
    Ok(volume(source, &entries[index], kind)?.with_format(FORMAT).with_contents(contents))
}

/// Names of all grids. Those that have the same get a number in brackets.
fn names(entries: &[Entry]) -> Vec<String> {
    let mut counts: HashMap<&str, usize> = HashMap::new();
    entries.iter().for_each(|entry| *counts.entry(&entry.name).or_default() += 1);
    let mut numbers: HashMap<&str, usize> = HashMap::new();
    let mut named = Vec::new();
    for entry in entries {
        let number = numbers.entry(&entry.name).or_default();
        named.push(match counts[&*entry.name] {
            1 => entry.name.clone(),
            _ => format!("{}[{number}]", entry.name),
        });
        *number += 1;
    }
    named
}

fn volume(source: &Source, entry: &Entry, kind: Kind) -> Result<Volume> {
    let bytes = entry.bytes(source)?;
    let affine = affine(&bytes).ok_or_else(|| source.damaged())?;
    let tree = Tree::parse(&bytes, kind).ok_or_else(|| source.damaged())?;
    let mut filled = ActiveBox::new(source, tree.bounds, tree.background)?;
    tree.fill(&mut filled).ok_or_else(|| source.damaged())?;
    let volume = filled.volume(source, kind.dtype, kind.components, affine)?;
    Ok(match u32_at(&bytes, CLASS) {
        Some(IS_LEVEL_SET) => volume.with_note(LEVEL_SET),
        _ => volume,
    })
}

/// The way from indices to the world; the matrix stands in rows.
fn affine(bytes: &[u8]) -> Option<Affine> {
    let vector = |at: usize, step: usize| {
        let part = |index: usize| u64_at(bytes, at + index * step).map(f64::from_bits);
        Some(DVec3::new(part(0)?, part(1)?, part(2)?))
    };
    let steps = [vector(MATRIX, 24)?, vector(MATRIX + 8, 24)?, vector(MATRIX + 16, 24)?];
    Some(Affine { steps, origin: vector(TRANSLATION, 8)? })
}
