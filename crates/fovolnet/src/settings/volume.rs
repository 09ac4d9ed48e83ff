use super::overlay::overlay;
#[cfg(feature = "clap")]
use super::parse;
use super::{ChannelChoice, ComponentChoice, LayerChoice, TimeChoice};
use serde::{Deserialize, Serialize};

overlay! {
/// Settings for reading a volume's file: what the file leaves out or gets wrong.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
#[serde(default, rename_all = "kebab-case", deny_unknown_fields)]
pub struct VolumeSettings {
    /// Voxels along x, y, z
    #[cfg_attr(feature = "clap", arg(long, value_name = "X,Y,Z", value_parser = parse::whole_numbers::<3>))]
    pub dims: Option<[usize; 3]>,
    /// Voxel type: u8 i8 u16 i16 u32 i32 u64 i64 f16 f32 f64
    #[cfg_attr(feature = "clap", arg(long, value_name = "TYPE"))]
    pub dtype: Option<fovol_core::Dtype>,
    /// Byte order: little or big
    #[cfg_attr(feature = "clap", arg(long, value_name = "ORDER"))]
    pub endian: Option<fovol_core::Endian>,
    /// Distance between voxels along x, y, z
    #[cfg_attr(feature = "clap", arg(long, value_name = "X,Y,Z", value_parser = parse::numbers::<3>, allow_hyphen_values = true))]
    pub spacing: Option<[f64; 3]>,
    /// Values shown as 0 and 1
    #[cfg_attr(feature = "clap", arg(long, value_name = "LO,HI", value_parser = parse::numbers::<2>, allow_hyphen_values = true))]
    pub range: Option<[f64; 2]>,
    /// Centre and width of the values to show, as radiologists give them: --range C-W/2,C+W/2
    #[cfg_attr(feature = "clap", arg(long, value_name = "CENTRE,WIDTH", value_parser = parse::numbers::<2>, allow_hyphen_values = true, conflicts_with = "range"))]
    pub window: Option<[f64; 2]>,
    /// Array of values to read, by its name, where a file has several
    #[cfg_attr(feature = "clap", arg(long, value_name = "NAME"))]
    pub array: Option<String>,
    /// Component of each voxel to show, if there are several, from 0 on, or rgb: three or four components as colours
    /// [default: rgb where the file says that they are colours, else 0]
    #[cfg_attr(feature = "clap", arg(long, value_name = "N|rgb"))]
    pub component: Option<ComponentChoice>,
    /// Channel to show, if there are several, from 0 on, or up to four to blend, such as 0,2 [default: those that have
    /// colours in the file, blended, else 0]
    #[cfg_attr(feature = "clap", arg(long, value_name = "C"))]
    pub channel: Option<ChannelChoice>,
    /// Time point to show, if there are several, from 0 on; or a clip over time, one frame a time point: all, or a first
    /// and last one such as 2..8 [default: 0]
    #[cfg_attr(feature = "clap", arg(long, value_name = "T|T..T|all"))]
    pub time: Option<TimeChoice>,
    /// Level of resolution to read, if there are several, from 0 on, the finest [default: the finest that fits into memory]
    #[cfg_attr(feature = "clap", arg(long, value_name = "N"))]
    pub level: Option<usize>,
    /// Series of a DICOM folder to read: its UID, or its number from 1 on as `info` lists them [default: the one with most slices]
    #[cfg_attr(feature = "clap", arg(long, value_name = "UID|N"))]
    pub series: Option<String>,
    /// A further volume on the box of the first, blended with it, with its transfer function after an @; up to 3 times
    #[cfg_attr(feature = "clap", arg(long, value_name = "FILE[@TF]"))]
    pub overlay: Option<Vec<LayerChoice>>,
    /// Average N×N×N voxels to one, for a volume that is too large for a device [default: 1]
    #[cfg_attr(feature = "clap", arg(long, value_name = "N"))]
    pub downsample: Option<usize>,
}
}

impl VolumeSettings {
    /// Combines these settings with `over`, which takes precedence.
    #[must_use]
    pub fn overridden_by(mut self, over: Self) -> Self {
        // A window and a range replace each other.
        if over.range.is_some() {
            self.window = None;
        }
        if over.window.is_some() {
            self.range = None;
        }
        self.laid_under(over)
    }

    /// Values shown as 0 and 1, if they are chosen: those of the window or of the range.
    pub fn shown_range(&self) -> Option<[f64; 2]> {
        let of_window = |[centre, width]: [f64; 2]| [centre - 0.5 * width, centre + 0.5 * width];
        self.window.map(of_window).or(self.range)
    }

    /// Converts the settings for the file readers.
    #[cfg(feature = "files")]
    pub fn overrides(&self) -> fovol_io::volume::Overrides {
        fovol_io::volume::Overrides {
            dims: self.dims,
            dtype: self.dtype,
            endian: self.endian,
            spacing: self.spacing,
            range: self.shown_range(),
            array: self.array.clone(),
            component: self.component.and_then(ComponentChoice::number),
            channel: self.channel.as_ref().and_then(ChannelChoice::first),
            time: self.time.map(TimeChoice::first),
            level: self.level,
            series: self.series.clone(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn windows_are_ranges() {
        let window = VolumeSettings { window: Some([40.0, 400.0]), ..Default::default() };
        assert_eq!(window.shown_range(), Some([-160.0, 240.0]));
        let range = VolumeSettings { range: Some([0.0, 1.0]), ..Default::default() };
        assert_eq!(window.clone().overridden_by(range.clone()), range);
        assert_eq!(range.overridden_by(window.clone()), window);
        assert_eq!(VolumeSettings::default().shown_range(), None);
    }
}
