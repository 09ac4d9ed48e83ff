use crate::{Error, Result};
use fovol_core::{TransferFunction, did_you_mean};
use std::path::Path;

/// Names of a file that are listed at most.
const LISTED: usize = 20;

/// A transfer function read from a file.
#[derive(Debug, Clone, PartialEq)]
pub struct Imported {
    /// The function, with the data values that it was made for where the file gives them.
    pub transfer: TransferFunction,
    /// Whether the function stretches over the displayed range, even if it has a range of its own.
    ///
    /// True of colour maps from 0 to 1 or from −1 to 1.
    pub is_stretched: bool,
    /// Assumptions made while reading, one line each.
    pub notes: Vec<String>,
}

impl From<TransferFunction> for Imported {
    /// Wraps `transfer`. If it has a range, it stays at those data values.
    fn from(transfer: TransferFunction) -> Self {
        Self::of(transfer)
    }
}

impl Imported {
    /// Wraps `transfer`. If it has a range, it stays at those data values.
    pub(super) fn of(transfer: TransferFunction) -> Self {
        let is_stretched = transfer.range().is_none();
        Self { transfer, is_stretched, notes: Vec::new() }
    }

    /// Wraps `transfer`, stretched over the displayed range.
    pub(super) fn stretched(transfer: TransferFunction) -> Self {
        Self { is_stretched: true, ..Self::of(transfer) }
    }

    /// The function as the file intends it: without its range if [`Self::is_stretched`].
    pub fn as_meant(&self) -> TransferFunction {
        let transfer = self.transfer.clone();
        if self.is_stretched { transfer.with_range(None).expect("no range is sound") } else { transfer }
    }
}

/// The error message for files of no known format.
pub const UNKNOWN: &str = "it is no transfer function that is known here; give {\"points\":[[v,r,g,b,a],…]}, a colour map of \
                       ParaView (.json), a preset of 3D Slicer (.xml, .vp) or vtk.js (.json), an .itf file of Inviwo, \
                       or a table of three numbers a line, r g b";

/// Returns the index of `wanted` in `names`, or 0 if none is wanted.
///
/// If one of several is chosen by default, a note lists the names.
pub fn chosen(path: &Path, names: &[&str], wanted: Option<&str>) -> Result<(usize, Option<String>)> {
    let mut listed: Vec<&str> = names.iter().take(LISTED).copied().collect();
    if names.len() > LISTED {
        listed.push("…");
    }
    let listed = listed.join(", ");
    let Some(wanted) = wanted else {
        let note = format!(
            "it holds {} transfer functions, `{}` is taken; FILE#NAME chooses one: {listed}",
            names.len(),
            names[0]
        );
        return Ok((0, (names.len() > 1).then_some(note)));
    };
    let exact = names.iter().position(|name| *name == wanted);
    let found = exact.or_else(|| names.iter().position(|name| name.eq_ignore_ascii_case(wanted)));
    let index = found.ok_or_else(|| {
        let meant = did_you_mean(wanted, names);
        Error::malformed(
            path,
            format!("it has no transfer function `{wanted}`; those in it: {listed}{meant}"),
        )
    })?;
    Ok((index, None))
}
