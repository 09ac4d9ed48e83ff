//! OME-XML in the description of the first page: sizes, order of planes, distances and names of channels.
//! <https://ome-model.readthedocs.io/en/stable/ome-tiff/specification.html>

use super::hyperstack::{Counts, Hyperstack};
use crate::Result;
use crate::volume::Source;
use crate::volume::units::{metres, symbol};
use fovol_core::ChannelDisplay;
use quick_xml::events::{BytesStart, Event};
use quick_xml::{Reader, XmlVersion};
use std::collections::BTreeMap;

/// Parses the OME-XML `text` of the file `source`, which has `pages` pages.
///
/// If the XML describes several images, the first one is read, and a note says so.
///
/// # Errors
/// Broken XML, or an image without sizes.
pub fn hyperstack(source: &Source, text: &str, pages: usize) -> Result<Hyperstack> {
    let found =
        walk(text).map_err(|problem| source.malformed(format!("its OME-XML is broken: {problem}")))?;
    let Some(pixels) = &found.pixels else {
        return Ok(Hyperstack::plain(pages));
    };
    pixels.hyperstack(source, &found, pages)
}

type Attributes = BTreeMap<String, String>;

/// The elements that matter of a document.
#[derive(Default)]
struct Found {
    images: usize,
    pixels: Option<Pixels>,
}

/// The `Pixels` element of the first image.
struct Pixels {
    said: Attributes,
    channels: Vec<Attributes>,
    blocks: Vec<Block>,
}

/// One `TiffData` element.
struct Block {
    said: Attributes,
    file: Option<String>,
}

fn walk(text: &str) -> std::result::Result<Found, String> {
    let mut reader = Reader::from_str(text.trim_start_matches('\u{feff}'));
    let mut found = Found::default();
    loop {
        match reader.read_event().map_err(|e| e.to_string().replace('\n', " "))? {
            Event::Start(element) | Event::Empty(element) => found.enter(&element),
            Event::Eof => return Ok(found),
            _ => {}
        }
    }
}

impl Found {
    fn enter(&mut self, element: &BytesStart<'_>) {
        let said = attributes(element);
        let name = element.local_name();
        self.images += usize::from(name.as_ref() == "Image");
        if self.images > 1 {
            return;
        }
        match (name.as_ref(), &mut self.pixels) {
            ("Pixels", pixels @ None) => {
                *pixels = Some(Pixels { said, channels: Vec::new(), blocks: Vec::new() });
            }
            ("Channel", Some(pixels)) => pixels.channels.push(said),
            ("TiffData", Some(pixels)) => pixels.blocks.push(Block { said, file: None }),
            ("UUID", Some(pixels)) => {
                if let Some(block) = pixels.blocks.last_mut() {
                    block.file = said.get("FileName").cloned();
                }
            }
            _ => {}
        }
    }
}

fn attributes(element: &BytesStart<'_>) -> Attributes {
    let pair = |attribute: quick_xml::events::attributes::Attribute<'_>| {
        let name = attribute.key.local_name().as_ref().to_owned();
        let value = attribute.normalized_value(XmlVersion::Implicit1_0).ok()?;
        Some((name, value.into_owned()))
    };
    element.attributes().flatten().filter_map(pair).collect()
}

/// A whole number among attributes.
fn number(said: &Attributes, name: &str) -> Option<usize> {
    said.get(name)?.trim().parse().ok()
}

impl Pixels {
    fn hyperstack(&self, source: &Source, found: &Found, pages: usize) -> Result<Hyperstack> {
        let size =
            |axis: &str| number(&self.said, &format!("Size{axis}")).filter(|&size| size > 0).unwrap_or(1);
        // Colours of one pixel lie together in one plane.
        let samples = self.channels.iter().filter_map(|channel| number(channel, "SamplesPerPixel")).max();
        let channels = (size("C") / samples.unwrap_or(1).max(1)).max(1);
        let counts = Counts { slices: size("Z"), channels, times: size("T") };
        let Some(planes) = counts.planes().filter(|&planes| planes <= pages.saturating_mul(1 << 12)) else {
            return Err(source.malformed("its OME-XML claims more planes than the file can hold"));
        };
        let mut stack = Hyperstack { counts, ..Hyperstack::plain(pages) };
        match self.pages(&counts, planes, pages) {
            Some(pages) => stack.pages = pages,
            None => {
                stack.counts = Counts::slices(pages);
                stack
                    .notes
                    .push(format!("says {planes} planes, but has {pages} pages; all are shown as slices"));
            }
        }
        self.place(&mut stack);
        stack.names = self.channels.iter().map(|c| c.get("Name").cloned().unwrap_or_default()).collect();
        stack.displays = self.channels.iter().map(display).collect();
        if found.images > 1 {
            stack.notes.push(format!("has {} images, the first is shown", found.images));
        }
        Ok(stack)
    }

    fn order(&self) -> &str {
        self.said.get("DimensionOrder").map_or("XYZCT", String::as_str)
    }

    /// The page of every plane in the order Z, C, T; none if pages and planes do not match.
    fn pages(&self, counts: &Counts, planes: usize, pages: usize) -> Option<Vec<Option<usize>>> {
        let order = self.order();
        let own = self.own_file();
        // From the place in the file's order to the place among Z, C, T.
        let mut places = vec![0; planes];
        for (place, [slice, channel, time]) in positions(counts).enumerate() {
            *places.get_mut(counts.plane(order, [slice, channel, time]))? = place;
        }
        let mut found = vec![None; planes];
        if self.blocks.is_empty() {
            return (planes == pages).then(|| Hyperstack::ordered(*counts, order).pages);
        }
        for block in &self.blocks {
            if block.file.as_deref() != own {
                continue;
            }
            let at = |name| number(&block.said, name);
            let first = ["FirstZ", "FirstC", "FirstT"].map(|name| at(name).unwrap_or(0));
            let page = at("IFD").unwrap_or(0);
            let is_whole = at("IFD").is_none() && at("PlaneCount").is_none();
            let count = if is_whole { pages } else { at("PlaneCount").unwrap_or(1) };
            let plane = counts.plane(order, first);
            for i in 0..count.min(planes.checked_sub(plane)?).min(pages.saturating_sub(page)) {
                found[places[plane + i]] = Some(page + i);
            }
        }
        let missing = found.iter().filter(|page| page.is_none()).count();
        let is_of_many = self.blocks.iter().any(|block| block.file.as_deref() != own);
        (missing == 0 || is_of_many && missing < planes).then_some(found)
    }

    /// The name of this file in its metadata. A renamed file keeps its old name there, so the first named file counts
    /// as this one.
    fn own_file(&self) -> Option<&str> {
        self.blocks.first().and_then(|block| block.file.as_deref())
    }

    /// Takes over distances and their unit.
    fn place(&self, stack: &mut Hyperstack) {
        const AXES: [&str; 3] = ["X", "Y", "Z"];
        let size = |axis: &str| -> Option<f64> {
            self.said.get(&format!("PhysicalSize{axis}"))?.trim().parse().ok().filter(|&s: &f64| s > 0.0)
        };
        let unit =
            |axis: &str| self.said.get(&format!("PhysicalSize{axis}Unit")).map_or("µm", String::as_str);
        let sizes = AXES.map(size);
        let Some(lead) = AXES.iter().zip(sizes).find_map(|(axis, size)| size.map(|_| unit(axis))) else {
            return;
        };
        for (axis, size) in AXES.into_iter().zip(sizes) {
            // All sides in the unit of the first.
            let scale = match (metres(symbol(unit(axis))), metres(symbol(lead))) {
                (Some(own), Some(lead)) => own / lead,
                _ => 1.0,
            };
            let index = AXES.iter().position(|&a| a == axis).unwrap_or(0);
            stack.spacing[index] = size.map(|size| if scale == 1.0 { size } else { size * scale });
        }
        if stack.spacing[2].is_none() && stack.counts.slices > 1 {
            stack.spacing[2] = stack.spacing[0];
            stack.notes.push(
                "says no distance between slices; that of pixels along x is taken; --spacing says others"
                    .into(),
            );
        }
        stack.units = Some(lead.to_owned());
    }
}

/// How a channel is shown: its colour is a signed number of the bytes red, green, blue and opacity.
fn display(channel: &Attributes) -> ChannelDisplay {
    let number = channel.get("Color").and_then(|text| text.trim().parse::<i64>().ok());
    let colour = number.map(|number| {
        let [red, green, blue, _] = (number as u32).to_be_bytes();
        [red, green, blue]
    });
    ChannelDisplay { colour, ..ChannelDisplay::default() }
}

/// Slice, channel and time point of all planes in the order Z, C, T.
fn positions(counts: &Counts) -> impl Iterator<Item = [usize; 3]> {
    let Counts { slices, channels, times } = *counts;
    (0..times).flat_map(move |t| (0..channels).flat_map(move |c| (0..slices).map(move |z| [z, c, t])))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn stack(pixels: &str, inside: &str, pages: usize) -> Result<Hyperstack> {
        let text = format!(
            "<?xml version=\"1.0\"?><OME xmlns=\"x\"><Image ID=\"Image:0\"><Pixels {pixels}>{inside}</Pixels></Image></OME>"
        );
        hyperstack(&Source::from_bytes(Path::new("x.ome.tif"), vec![]), &text, pages)
    }

    const SIZES: &str = r#"DimensionOrder="XYCZT" SizeX="4" SizeY="4" SizeZ="3" SizeC="2" SizeT="1""#;

    #[test]
    fn planes_without_blocks_follow_the_order() {
        let stack = stack(SIZES, "", 6).unwrap();
        assert_eq!(stack.counts, Counts { slices: 3, channels: 2, times: 1 });
        assert_eq!(stack.pages, [0, 2, 4, 1, 3, 5].map(Some));
    }

    #[test]
    fn blocks_say_where_planes_are() {
        let block =
            |c: usize, page: usize| format!(r#"<TiffData FirstC="{c}" IFD="{page}" PlaneCount="1"/>"#);
        let one_slice = r#"DimensionOrder="XYZCT" SizeZ="1" SizeC="2" SizeT="1""#;
        let stack = stack(one_slice, &(block(0, 1) + &block(1, 0)), 2).unwrap();
        assert_eq!(stack.pages, [Some(1), Some(0)]);
        let all = self::stack(SIZES, "<TiffData/>", 6).unwrap();
        assert_eq!(all.pages, [0, 2, 4, 1, 3, 5].map(Some));
    }

    #[test]
    fn distances_and_names() {
        let said = format!(
            r#"{SIZES} PhysicalSizeX="0.5" PhysicalSizeY="0.5" PhysicalSizeZ="2000" PhysicalSizeZUnit="nm""#
        );
        let channels = r#"<Channel Name="DAPI" SamplesPerPixel="1" Color="-16776961"/><Channel Name="GFP"/>"#;
        let stack = stack(&said, channels, 6).unwrap();
        assert_eq!((stack.spacing(), stack.units()), ([0.5, 0.5, 2.0], Some("µm")));
        assert_eq!(stack.names, ["DAPI", "GFP"]);
        assert_eq!([0, 1].map(|channel| stack.displays[channel].colour), [Some([255, 0, 0]), None]);
    }

    #[test]
    fn files_of_a_set_say_what_is_missing() {
        let block = |c: usize, file: &str| {
            format!(
                r#"<TiffData FirstC="{c}" IFD="0" PlaneCount="3"><UUID FileName="{file}">u</UUID></TiffData>"#
            )
        };
        let sizes = SIZES.replace("XYCZT", "XYZCT");
        let stack = stack(&sizes, &(block(0, "a.tif") + &block(1, "b.tif")), 3).unwrap();
        let source = Source::from_bytes(Path::new("a.tif"), vec![]);
        let choose =
            |channel| stack.chosen(&source, &crate::volume::Overrides { channel, ..Default::default() });
        assert_eq!(choose(None).unwrap().pages, [0, 1, 2]);
        assert!(choose(Some(1)).unwrap_err().to_string().contains("lie in other files"));
    }

    #[test]
    fn damage_is_said() {
        assert!(stack("SizeZ=\"9\"><", "", 2).is_err());
        assert!(stack(r#"SizeZ="99999999" SizeT="99999999""#, "", 2).is_err());
        assert!(stack(r#"SizeZ="3""#, "", 2).unwrap().notes[0].contains("has 2 pages"));
    }
}
