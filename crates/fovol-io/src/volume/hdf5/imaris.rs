//! Imaris files (`.ims`): <https://imaris.oxinst.com/assets/uploads/docs/Imaris5FileFormat.pdf>.

use super::element::Element;
use super::file::{File, attributes};
use super::voxels;
use crate::Result;
use crate::volume::cf::{Attributes, Spaced, with_spacing_notes};
use crate::volume::layout::Layout;
use crate::volume::levels::{fits, noted};
use crate::volume::units::symbol;
use crate::volume::{Overrides, Source};
use fovol_core::{Contents, Volume};
use hdf5_reader::Dataset;

/// Reads the chosen channel and time point in the finest level that fits in memory; none for other files.
///
/// # Errors
/// Damaged files, choices out of range.
pub fn parse(file: &File<'_>, overrides: &Overrides) -> Result<Option<Volume>> {
    let finest = "/DataSet/ResolutionLevel 0";
    let (times, source) = (count(file, finest, "TimePoint"), file.source);
    let channels = count(file, &format!("{finest}/TimePoint 0"), "Channel");
    if times == 0 || channels == 0 {
        return Ok(None);
    }
    let time = overrides.time_of(source, times)?;
    let channel = overrides.channel_of(source, channels)?;
    let levels = count(file, "/DataSet", "ResolutionLevel");
    let chosen = overrides.level_of(source, levels)?;
    for level in chosen.map_or(0..levels, |level| level..level + 1) {
        let path = format!("/DataSet/ResolutionLevel {level}/TimePoint {time}/Channel {channel}");
        let Some(dataset) = file.dataset(&format!("{path}/Data"))? else { break };
        let next = format!("/DataSet/ResolutionLevel {}", level + 1);
        if chosen.is_none() && !fits(length(&dataset)) && file.group(&next).is_some() {
            continue;
        }
        let contents = Contents {
            times,
            time,
            channels: (0..channels).map(|index| channel_name(file, index)).collect(),
            channel,
            levels,
            level,
            ..Contents::default()
        };
        let image = Image::of(file, &path, &dataset)?;
        let volume = image.volume(file, &dataset, contents)?;
        return Ok(Some(noted(volume, level, chosen.is_some())));
    }
    Ok(None)
}

/// Size and extent of an image.
struct Image {
    dims: [usize; 3],
    spaced: Option<Spaced>,
}

impl Image {
    /// The image in the channel at `path`, whose voxels are in `dataset`. Chunks may be filled up beyond its size.
    fn of(file: &File<'_>, path: &str, dataset: &Dataset) -> Result<Self> {
        let [z, y, x] = *dataset.shape() else {
            return Err(file
                .source
                .malformed("its data does not have three axes; copy or download it again"));
        };
        let channel = group_attributes(file, path);
        let stored = [x, y, z].map(|length| length as usize);
        let dims = std::array::from_fn(|axis| {
            let said = number(&channel, ["ImageSizeX", "ImageSizeY", "ImageSizeZ"][axis]);
            said.map_or(stored[axis], |size| (size as usize).clamp(1, stored[axis].max(1)))
        });
        let info = group_attributes(file, "/DataSetInfo/Image");
        let steps: [Option<f64>; 3] = std::array::from_fn(|axis| {
            let [low, high] = ["ExtMin", "ExtMax"].map(|name| number(&info, &format!("{name}{axis}")));
            Some((high? - low?) / dims[axis] as f64).filter(|step| step.is_finite() && *step > 0.0)
        });
        let spaced = match steps {
            [Some(x), Some(y), Some(z)] => Some(Spaced {
                spacing: [x, y, z],
                units: Some(symbol(info.text("Unit").unwrap_or("um")).to_owned()),
                notes: Vec::new(),
            }),
            _ => None,
        };
        Ok(Self { dims, spaced })
    }

    fn volume(&self, file: &File<'_>, dataset: &Dataset, contents: Contents) -> Result<Volume> {
        let source: &Source = file.source;
        let element = Element::of(dataset.dtype())
            .map_err(|problem| source.unsupported(format!("its values are {problem}")))?;
        let layout = Layout {
            spacing: self.spaced.as_ref().map_or([1.0; 3], |spaced| spaced.spacing),
            endian: element.endian,
            ..Layout::new(self.dims, element.dtype)
        };
        layout.length(source)?;
        let [x, y, z] = self.dims;
        let (bytes, start) = voxels::read(file, dataset, &element, &[0..z, 0..y, 0..x])?;
        let volume = layout.volume(source, bytes, start)?.with_format("Imaris").with_contents(contents);
        Ok(with_spacing_notes(volume, self.spaced.as_ref(), &Overrides::default()))
    }
}

/// How many groups `path` holds that are called `name` and a number.
fn count(file: &File<'_>, path: &str, name: &str) -> usize {
    let groups = file.group(path).and_then(|group| group.member_names().ok()).map(|(groups, _)| groups);
    let groups = groups.unwrap_or_default();
    (0..groups.len()).take_while(|index| groups.contains(&format!("{name} {index}"))).count()
}

fn channel_name(file: &File<'_>, index: usize) -> String {
    let info = group_attributes(file, &format!("/DataSetInfo/Channel {index}"));
    info.text("Name").unwrap_or_default().to_owned()
}

fn group_attributes(file: &File<'_>, path: &str) -> Attributes {
    let found = file.group(path).and_then(|group| group.attributes().ok());
    attributes(&found.unwrap_or_default())
}

/// A number that is written as text.
fn number(attributes: &Attributes, name: &str) -> Option<f64> {
    attributes.text(name)?.trim().parse().ok().filter(|number: &f64| number.is_finite())
}

/// Bytes of the values of `dataset`.
fn length(dataset: &Dataset) -> u64 {
    dataset.raw_byte_len().unwrap_or(usize::MAX) as u64
}
