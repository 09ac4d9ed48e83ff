//! Parses the bytes of an input and checks the result.

use fovol_io::transfer_function;
use fovol_io::volume::{Overrides, Source, parse, read};
use std::path::Path;

/// Parses bytes as the content of the file at the path; returns whether they are valid.
///
/// `Err` marks a wrong answer: a message that is not one line of plain text, or impossible values.
pub type Reader = fn(&Path, &[u8]) -> Result<bool, String>;

/// Reads a volume.
pub fn volume(path: &Path, input: &[u8]) -> Result<bool, String> {
    judged(parse(&Source::from_bytes(path, input.to_vec()), &Overrides::default()))
}

/// Reads a grid of NanoVDB into which the input is written: each twelve bytes are a place and eight bytes for it. Whole grids
/// are too long to be mutated.
pub fn patched_grid(path: &Path, input: &[u8]) -> Result<bool, String> {
    let mut grid = super::seeds::plain_grid();
    for patch in input.as_chunks::<12>().0 {
        let [a, b, c, d, word @ ..] = *patch;
        let at = u32::from_le_bytes([a, b, c, d]) as usize % (grid.len() - word.len());
        grid[at..at + word.len()].copy_from_slice(&word);
    }
    volume(path, &grid)
}

/// Reads eight thousand bytes from a file whose name is the input.
pub fn file_name(path: &Path, input: &[u8]) -> Result<bool, String> {
    let name = String::from_utf8_lossy(input).replace(['/', '\0'], "");
    let path = path.with_file_name(if name.is_empty() { "v" } else { &name });
    judged(parse(&Source::from_bytes(&path, vec![1; 8000]), &Overrides::default()))
}

/// Reads a folder in which the input is the third of four slices.
pub fn folder(path: &Path, input: &[u8]) -> Result<bool, String> {
    std::fs::write(path, input).map_err(|e| e.to_string())?;
    judged(read(path.parent().unwrap_or(path), &Overrides::default()))
}

/// Reads a hierarchy of Zarr, all of it and parts, whose files are in the input.
#[cfg(feature = "zarr")]
pub fn zarr(path: &Path, input: &[u8]) -> Result<bool, String> {
    let source = Source::from_bytes(path, super::zarr_files::archive(input));
    let label = Overrides { array: Some("labels/a".into()), ..Overrides::default() };
    let coarse = Overrides { level: Some(1), channel: Some(1), ..Overrides::default() };
    let mut is_read = false;
    for overrides in [Overrides::default(), label, coarse] {
        is_read |= judged(parse(&source, &overrides))?;
    }
    Ok(is_read)
}

fn judged(read: fovol_io::Result<fovol_core::Volume>) -> Result<bool, String> {
    match read {
        Ok(volume) => {
            let [x, y, z] = volume.grid().dims();
            volume.value([x - 1, y - 1, z - 1]);
            match volume.notes().iter().find(|note| note.contains(char::is_control)) {
                Some(note) => Err(format!("notes {note:?}")),
                None => Ok(true),
            }
        }
        Err(error) => refused(&error),
    }
}

/// Reads a transfer function and checks its values.
pub fn transfer_function(path: &Path, input: &[u8]) -> Result<bool, String> {
    let imported = match transfer_function::parse(path, &String::from_utf8_lossy(input), None) {
        Ok(imported) => imported,
        Err(error) => return refused(&error),
    };
    if let Some(note) = imported.notes.iter().find(|note| note.contains(char::is_control)) {
        return Err(format!("notes {note:?}"));
    }
    for transfer in [&imported.transfer, &imported.as_meant()] {
        let wrong = (0..=64).find(|&i| {
            let rgba = transfer.evaluate(f64::from(i) / 64.0);
            !rgba.iter().all(|c| (0.0..=1.0).contains(c))
        });
        if let Some(i) = wrong {
            return Err(format!("is {:?} at {i}/64", transfer.evaluate(f64::from(i) / 64.0)));
        }
    }
    Ok(true)
}

fn refused(error: &fovol_io::Error) -> Result<bool, String> {
    let message = error.to_string();
    if message.contains(char::is_control) { Err(format!("says {message:?}")) } else { Ok(false) }
}
