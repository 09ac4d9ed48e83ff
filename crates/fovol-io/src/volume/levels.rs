//! Levels of resolution: the finest that fits in memory is shown.

use fovol_core::{Volume, memory};

/// Bytes that are taken to be available where the system does not say.
const USUAL_MEMORY: u64 = 8 << 30;

/// Whether so many bytes fit in half of the available memory: what renders them needs the rest.
pub fn fits(length: u64) -> bool {
    length <= memory::available().unwrap_or(USUAL_MEMORY) / 2
}

/// `volume`, of `level`, with a note if finer ones do not fit. A chosen level needs none.
pub fn noted(volume: Volume, level: usize, is_chosen: bool) -> Volume {
    match level {
        0 => volume,
        _ if is_chosen => volume,
        _ => volume.with_note("finer levels of resolution need more than half of the available memory"),
    }
}
