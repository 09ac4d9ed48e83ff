//! Which of several named arrays is shown.

use super::{Overrides, Source};
use crate::Result;
use fovol_core::Contents;

/// One array of a file, as far as the choice among them goes.
#[derive(Debug, Clone, Copy)]
pub struct Candidate<'a> {
    /// Name of the array; empty if it has none.
    pub name: &'a str,
    /// Values per point or cell.
    pub components: usize,
    /// Whether its values belong to cells.
    pub is_of_cells: bool,
    /// Whether the file calls it the active scalars.
    pub is_active: bool,
    /// Whether its values are numbers that can be read.
    pub is_readable: bool,
}

impl Candidate<'_> {
    /// Whether the array marks which points are valid, rather than holding their values.
    fn is_bookkeeping(&self) -> bool {
        const MARKS: [&str; 5] = ["vtkGhost", "vtkValidPointMask", "vtkOriginal", "avtGhost", "avtOriginal"];
        MARKS.iter().any(|mark| self.name.starts_with(mark))
    }
}

/// Selects the array to show, and returns its index in `candidates` and the contents of the file.
///
/// It is the chosen array, else the active scalars, else the first scalar array, else the first array. Point data come
/// before cell data.
///
/// # Errors
/// The chosen array does not exist, or the file has no array.
pub fn shown(
    source: &Source,
    candidates: &[Candidate<'_>],
    overrides: &Overrides,
) -> Result<(usize, Contents)> {
    let data: Vec<usize> = (0..candidates.len()).filter(|&i| !candidates[i].is_bookkeeping()).collect();
    let all: Vec<usize> = (0..candidates.len()).collect();
    // An image of nothing but marks has them for its values.
    let listed = if data.iter().any(|&i| candidates[i].is_readable) { data } else { all };
    let mut names: Vec<String> = listed.iter().map(|&i| name(candidates, i)).collect();
    let index = match &overrides.array {
        None => default(candidates, &listed).ok_or_else(|| {
            source.malformed("it has no data arrays of points or cells; write the image with its scalars")
        })?,
        Some(chosen) => (0..candidates.len())
            .find(|&i| name(candidates, i) == *chosen)
            .ok_or_else(|| Overrides::no_array(source, chosen, &names))?,
    };
    let array = listed.iter().position(|&i| i == index).unwrap_or_else(|| {
        names.push(name(candidates, index));
        names.len() - 1
    });
    let components = candidates[index].components.max(1);
    Ok((index, Contents { arrays: names, array, components, ..Contents::default() }))
}

fn default(candidates: &[Candidate<'_>], listed: &[usize]) -> Option<usize> {
    let rank = |&i: &usize| {
        let array = &candidates[i];
        (!array.is_readable, array.is_of_cells, !array.is_active, array.components != 1)
    };
    listed.iter().copied().min_by_key(rank)
}

/// The name of an array. A cell array gets the prefix `cells:` if a point array has the same name.
fn name(candidates: &[Candidate<'_>], index: usize) -> String {
    let array = candidates[index];
    let is_shared = candidates.iter().any(|other| other.name == array.name && !other.is_of_cells);
    match array.is_of_cells && is_shared {
        true => format!("cells:{}", array.name),
        false => array.name.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn array(name: &str, components: usize) -> Candidate<'_> {
        Candidate { name, components, is_of_cells: false, is_active: false, is_readable: true }
    }

    fn choose(candidates: &[Candidate<'_>], chosen: Option<&str>) -> Result<(usize, Contents)> {
        let overrides = Overrides { array: chosen.map(str::to_owned), ..Overrides::default() };
        shown(&Source::from_bytes(Path::new("x"), vec![]), candidates, &overrides)
    }

    #[test]
    fn scalars_come_before_vectors_and_marks_are_no_data() {
        let [ghost, vector, scalar] = [array("vtkGhostType", 1), array("v", 3), array("t", 1)];
        let active = Candidate { is_active: true, ..array("a", 3) };
        let text = Candidate { is_readable: false, ..array("s", 1) };
        let cells = Candidate { is_of_cells: true, ..array("c", 1) };
        for (candidates, expected) in [
            (vec![ghost, vector, scalar], 2),
            (vec![scalar, vector, active], 2),
            (vec![text, vector], 1),
            (vec![cells, vector], 1),
            (vec![ghost, cells], 1),
            (vec![ghost], 0),
        ] {
            assert_eq!(choose(&candidates, None).unwrap().0, expected, "{candidates:?}");
        }
        assert!(choose(&[], None).is_err());
    }

    #[test]
    fn arrays_are_chosen_by_name() {
        let cells = Candidate { is_of_cells: true, ..array("t", 1) };
        let candidates = [array("vtkGhostType", 1), array("t", 1), cells];
        let (index, contents) = choose(&candidates, Some("cells:t")).unwrap();
        assert_eq!((index, contents.arrays, contents.array), (2, vec!["t".into(), "cells:t".into()], 1));
        let (index, contents) = choose(&candidates, Some("vtkGhostType")).unwrap();
        assert_eq!((index, contents.array_name()), (0, Some("vtkGhostType")));
        let error = choose(&candidates, Some("p")).unwrap_err().to_string();
        assert!(error.ends_with("--array p is not there; it has t, cells:t"), "{error}");
    }
}
