//! Files of BigDataViewer: `/tTTTTT/sSS/L/cells`, by time point, setup and level of resolution.
//!
//! Source: <https://imagej.net/plugins/bdv/#about-the-bigdataviewer-data-format>.

use super::element::{Element, unsigned};
use super::file::File;
use super::voxels;
use crate::Result;
use crate::volume::Overrides;
use crate::volume::layout::Layout;
use crate::volume::levels::{fits, noted};
use fovol_core::{Contents, Volume};
use hdf5_reader::Dataset;

/// Reads the chosen setup and time point in the finest level that fits in memory; none for other files.
///
/// # Errors
/// Damaged files, choices out of range.
pub fn parse(file: &File<'_>, overrides: &Overrides) -> Result<Option<Volume>> {
    let (times, setups) = (numbered(file, "/", 't', 5), numbered(file, "/", 's', 2));
    let (Some(_), Some(_)) = (times.first(), setups.first()) else { return Ok(None) };
    let source = file.source;
    let time = overrides.time_of(source, times.len())?;
    let channel = overrides.channel_of(source, setups.len())?;
    let cells = |level: usize| file.dataset(&format!("/{}/{}/{level}/cells", times[time], setups[channel]));
    let Some(factors) = factors(file, &setups[channel])? else { return Ok(None) };
    let mut shown = None;
    let chosen = overrides.level_of(source, factors.len())?;
    for level in chosen.map_or(0..factors.len(), |level| level..level + 1) {
        let Some(dataset) = cells(level)? else { break };
        let fits = fits(length(&dataset));
        shown = Some((level, dataset));
        if fits {
            break;
        }
    }
    let Some((level, dataset)) = shown else { return Ok(None) };
    let levels = factors.len();
    let contents = Contents {
        times: times.len(),
        time,
        channels: setups,
        channel,
        levels,
        level,
        ..Contents::default()
    };
    let volume = volume(file, &dataset, factors[level], contents)?;
    Ok(Some(noted(volume, level, chosen.is_some())))
}

fn volume(file: &File<'_>, dataset: &Dataset, factors: [f64; 3], contents: Contents) -> Result<Volume> {
    let source = file.source;
    let element = Element::of(dataset.dtype())
        .map_err(|problem| source.unsupported(format!("its values are {problem}")))?;
    let [z, y, x] = *dataset.shape() else {
        return Err(source.malformed("its cells do not have three axes; copy or download it again"));
    };
    let layout = Layout {
        spacing: factors,
        endian: element.endian,
        // The library writes unsigned values under the name of signed ones.
        ..Layout::new([x, y, z].map(|length| length as usize), unsigned(element.dtype))
    };
    layout.length(source)?;
    let part: Vec<_> = dataset.shape().iter().map(|&length| 0..length as usize).collect();
    let (bytes, start) = voxels::read(file, dataset, &element, &part)?;
    let volume =
        layout.volume(source, bytes, start)?.with_format("BigDataViewer HDF5").with_contents(contents);
    Ok(volume.with_note(
        "its spacing is in the .xml beside it and not read; that of the finest level is taken as 1, --spacing X,Y,Z sets another",
    ))
}

/// Names of groups in `path` that are `letter` and `digits` digits.
fn numbered(file: &File<'_>, path: &str, letter: char, digits: usize) -> Vec<String> {
    let names = file.group(path).and_then(|group| group.member_names().ok()).map(|(groups, _)| groups);
    let is_numbered = |name: &String| {
        let number = name.strip_prefix(letter);
        number.is_some_and(|number| number.len() == digits && number.bytes().all(|b| b.is_ascii_digit()))
    };
    let mut names: Vec<String> = names.unwrap_or_default().into_iter().filter(is_numbered).collect();
    names.sort();
    names
}

/// Sizes of a voxel of each level along x, y, z, in voxels of the finest.
fn factors(file: &File<'_>, setup: &str) -> Result<Option<Vec<[f64; 3]>>> {
    let Some(dataset) = file.dataset(&format!("/{setup}/resolutions"))? else { return Ok(None) };
    let values = dataset.read_array::<f64>().map_err(|problem| file.failed(problem))?;
    let values: Vec<f64> = values.iter().copied().collect();
    let levels = values.as_chunks::<3>().0;
    let is_sound = levels.iter().flatten().all(|factor| factor.is_finite() && *factor > 0.0);
    Ok(Some(levels.to_vec()).filter(|levels| is_sound && !levels.is_empty()))
}

/// Bytes of the values of `dataset`.
fn length(dataset: &Dataset) -> u64 {
    dataset.raw_byte_len().unwrap_or(usize::MAX) as u64
}
