//! Order of the slices, channels and time points among the pages of a TIFF file, and the voxel spacing.

use crate::Result;
use crate::volume::units::symbol;
use crate::volume::{Overrides, Source};
use fovol_core::{ChannelDisplay, Contents};

/// The numbers of slices, channels and time points.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Counts {
    /// Slices of one volume.
    pub slices: usize,
    /// Channels.
    pub channels: usize,
    /// Time points.
    pub times: usize,
}

impl Counts {
    /// One channel at one time.
    pub fn slices(slices: usize) -> Self {
        Self { slices, channels: 1, times: 1 }
    }

    /// The number of planes; none on overflow.
    pub fn planes(&self) -> Option<usize> {
        self.slices.checked_mul(self.channels)?.checked_mul(self.times)
    }

    /// The index of the plane of a slice, channel and time point.
    ///
    /// `order` names the axes `Z`, `C` and `T`, fastest first.
    pub fn plane(&self, order: &str, [slice, channel, time]: [usize; 3]) -> usize {
        let mut stride = 1;
        order.chars().fold(0, |plane, axis| {
            let (index, count) = match axis {
                'Z' => (slice, self.slices),
                'C' => (channel, self.channels),
                'T' => (time, self.times),
                _ => (0, 1),
            };
            let plane = plane + index * stride;
            stride *= count;
            plane
        })
    }
}

/// Pixel spacing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Resolution {
    /// The distance along x and y.
    pub pitch: [Option<f64>; 2],
    /// TIFF's number of its unit: 1 for none, 2 for inches, 3 for centimetres.
    pub unit: f64,
}

/// Arrangement of a file's planes in volumes.
#[derive(Debug, Clone, PartialEq)]
pub struct Hyperstack {
    /// The numbers of slices, channels and time points.
    pub counts: Counts,
    /// The page of every plane, in the order Z, C, T; none if another file holds it.
    pub pages: Vec<Option<usize>>,
    /// The names of the channels.
    pub names: Vec<String>,
    /// How the file asks to show each channel; empty where it says nothing.
    pub displays: Vec<ChannelDisplay>,
    /// The voxel spacing along x, y, z, as far as the file states it.
    pub spacing: [Option<f64>; 3],
    /// The unit of the spacing.
    pub units: Option<String>,
    /// Whether all planes follow the first one, without pages of their own.
    pub is_one_page: bool,
    /// Doubts about the metadata, one line each.
    pub notes: Vec<String>,
}

/// The slices of one volume of a file.
#[derive(Debug, Clone, PartialEq)]
pub struct Chosen {
    /// The page of every slice, from 0 on.
    pub pages: Vec<usize>,
    /// Contents of the file, and the selected part.
    pub contents: Contents,
}

impl Hyperstack {
    /// A stack of `pages` slices without further metadata.
    pub fn plain(pages: usize) -> Self {
        Self {
            counts: Counts::slices(pages),
            pages: (0..pages).map(Some).collect(),
            names: Vec::new(),
            displays: Vec::new(),
            spacing: [None; 3],
            units: None,
            is_one_page: false,
            notes: Vec::new(),
        }
    }

    /// `counts` planes in `order`, one a page.
    pub fn ordered(counts: Counts, order: &str) -> Self {
        let mut pages = Vec::new();
        for time in 0..counts.times {
            for channel in 0..counts.channels {
                let plane = |slice| Some(counts.plane(order, [slice, channel, time]));
                pages.extend((0..counts.slices).map(plane));
            }
        }
        Self { counts, pages, ..Self::plain(0) }
    }

    /// The spacing from the resolution of a print, where it is more than the habit of a program.
    pub fn with_print_resolution(mut self, Resolution { pitch, unit }: Resolution) -> Self {
        const INCH: f64 = 25.4;
        let ([Some(x), Some(y)], Some(scale)) =
            (pitch, [(2.0, INCH), (3.0, 10.0)].iter().find(|(u, _)| *u == unit))
        else {
            return self;
        };
        let dots = (1.0 / x).round();
        if scale.1 == INCH && [1.0, 72.0, 96.0, 150.0, 300.0, 600.0].contains(&dots) || dots == 1.0 {
            return self;
        }
        let [x, y] = [x, y].map(|pitch| pitch * scale.1);
        self.spacing = [Some(x), Some(y), Some(x)];
        self.units = Some("mm".into());
        self.notes.push(format!(
            "says no distance between slices; that of pixels along x, {x}, is taken; --spacing says others"
        ));
        self
    }

    /// The spacing along x, y and z; 1 where the file states none.
    pub fn spacing(&self) -> [f64; 3] {
        self.spacing.map(|spacing| spacing.filter(|s| s.is_finite() && *s > 0.0).unwrap_or(1.0))
    }

    /// The symbol of the unit of the spacing.
    pub fn units(&self) -> Option<&str> {
        self.units
            .as_deref()
            .map(symbol)
            .filter(|unit| !unit.is_empty() && *unit != "pixel" && *unit != "pixels")
    }

    /// The slices that `overrides` choose.
    ///
    /// # Errors
    /// A channel or time point that is out of range, or lies in another file.
    pub fn chosen(&self, source: &Source, overrides: &Overrides) -> Result<Chosen> {
        let Counts { slices, channels, times } = self.counts;
        let time = overrides.time_of(source, times)?;
        let channel = overrides.channel_of(source, channels)?;
        let first = (time * channels + channel) * slices;
        let pages: Option<Vec<usize>> = self.pages[first..first + slices].iter().copied().collect();
        let pages = pages.ok_or_else(|| {
            source.unsupported(format!(
                "slices of channel {channel} at time {time} lie in other files; export them to one file, or choose others by --channel and --time"
            ))
        })?;
        let names = if channels > 1 { self.channel_names() } else { Vec::new() };
        Ok(Chosen {
            pages,
            contents: Contents {
                channels: names,
                displays: self.channel_displays(),
                channel,
                times,
                time,
                ..Contents::default()
            },
        })
    }

    fn channel_displays(&self) -> Vec<ChannelDisplay> {
        if self.displays.iter().all(|display| *display == ChannelDisplay::default()) {
            return Vec::new();
        }
        (0..self.counts.channels).map(|c| self.displays.get(c).copied().unwrap_or_default()).collect()
    }

    fn channel_names(&self) -> Vec<String> {
        (0..self.counts.channels).map(|c| self.names.get(c).cloned().unwrap_or_default()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn planes_follow_the_order_of_axes() {
        let counts = Counts { slices: 3, channels: 2, times: 4 };
        assert_eq!(counts.plane("CZT", [2, 1, 3]), 1 + 2 * 2 + 3 * 6);
        assert_eq!(counts.plane("XYZCT", [2, 1, 3]), 2 + 3 + 3 * 6);
        let pages = Hyperstack::ordered(counts, "CZT").pages;
        assert_eq!(pages[..4], [Some(0), Some(2), Some(4), Some(1)]);
    }

    #[test]
    fn resolutions_of_prints_count_where_they_mean_something() {
        let spacing = |pitch, unit| {
            Hyperstack::plain(3).with_print_resolution(Resolution { pitch: [Some(pitch); 2], unit }).spacing()
        };
        assert_eq!(spacing(1.0 / 72.0, 2.0), [1.0; 3]);
        assert_eq!(spacing(0.01, 3.0), [0.1; 3]);
        assert_eq!(spacing(0.01, 1.0), [1.0; 3]);
    }
}
