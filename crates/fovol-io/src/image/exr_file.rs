//! OpenEXR files: any layers, channels and data windows, as frames of the size of the display window.

use super::channels;
use super::picture::{Motion, Picture};
use crate::{Error, Result};
use exr::image::{AnyChannels, FlatSamples, Layer};
use exr::math::Vec2;
use exr::meta::MetaData;
use exr::meta::attribute::IntegerBounds;
use exr::prelude::{ReadChannels, ReadLayers, WritableImage};
use fovol_core::{Frame, FrameSize, input};
use std::io::{BufReader, Cursor};
use std::path::Path;

/// Magic number of EXR files: their first four bytes.
pub(super) const MAGIC: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];

/// Largest compression ratio: deflate reaches 1032, run-length encoding less.
const LARGEST_RATIO: u64 = 1100;
/// Bytes that any file may decode to, whatever its length: enough for small images.
const ALWAYS: u64 = 1 << 20;
/// The most pixels of a display window around data that are few.
const LARGEST_EMPTY: u64 = 1 << 25;

/// `frame` as the bytes of an EXR file: RGBA of f32. Equal pixels give equal bytes.
pub(super) fn encode(frame: &Frame) -> exr::error::Result<Vec<u8>> {
    let (width, height) = (frame.size().width as usize, frame.size().height as usize);
    let pixels = |at: Vec2<usize>| {
        let [r, g, b, a] = frame.pixels()[at.y() * width + at.x()];
        (r, g, b, a)
    };
    // Without an order, parts of the picture are written as threads finish them.
    let encoding = exr::image::Encoding {
        line_order: exr::meta::attribute::LineOrder::Increasing,
        ..exr::image::Encoding::FAST_LOSSLESS
    };
    let channels = exr::image::SpecificChannels::rgba(pixels);
    let layer =
        Layer::new((width, height), exr::meta::header::LayerAttributes::default(), encoding, channels);
    let mut bytes = Cursor::new(Vec::new());
    exr::image::Image::from_layer(layer).write().to_buffered(&mut bytes)?;
    Ok(bytes.into_inner())
}

/// An EXR file that is known to be no larger than its bytes can justify.
struct Sound<'a> {
    path: &'a Path,
    display: IntegerBounds,
    size: FrameSize,
}

impl<'a> Sound<'a> {
    /// Looks at the header of the file at `path`.
    fn look(path: &'a Path) -> Result<Self> {
        let file = input::open(path).map_err(|e| Error::io("read", path, e))?;
        let length = file.metadata().map_err(|e| Error::io("read", path, e))?.len();
        let meta = MetaData::read_from_buffered(BufReader::new(file), false).map_err(|e| damaged(path, e))?;
        let mut bytes = 0u64;
        let mut largest = 0u64;
        for header in &meta.headers {
            if header.deep {
                return Err(Error::unsupported(
                    path,
                    "it holds deep pixels; flatten it to one sample a pixel",
                ));
            }
            let list = &header.channels.list;
            if list.iter().any(|channel| channel.sampling != Vec2(1, 1)) {
                let problem =
                    "it has channels of fewer pixels than the picture; write all channels at full size";
                return Err(Error::unsupported(path, problem));
            }
            let Vec2(width, height) = header.layer_size;
            frame_size(path, width, height)?;
            let pixels = width as u64 * height as u64;
            bytes = bytes.saturating_add(4 * pixels.saturating_mul(list.len() as u64));
            largest = largest.max(pixels);
        }
        if bytes > length.saturating_mul(LARGEST_RATIO) + ALWAYS {
            return Err(Error::malformed(
                path,
                "it is too short for the pixels that it says it has; it is damaged",
            ));
        }
        let display = meta.headers.first().map(|header| header.shared_attributes.display_window);
        let display = display.ok_or_else(|| Error::malformed(path, "it holds no picture"))?;
        let size = frame_size(path, display.size.x(), display.size.y())?;
        let pixels = size.pixels() as u64;
        if pixels > LARGEST_EMPTY.max(16 * largest) {
            let problem = format!("its display window of {size} is far larger than its pixels; crop it");
            return Err(Error::malformed(path, problem));
        }
        Ok(Self { path, display, size })
    }

    /// All layers of the file.
    fn layers(&self) -> Result<Vec<Layer<AnyChannels<FlatSamples>>>> {
        let read = exr::prelude::read().no_deep_data().largest_resolution_level().all_channels().all_layers();
        let image = read.all_attributes().from_file(self.path).map_err(|e| damaged(self.path, e))?;
        Ok(image.layer_data.into_vec())
    }

    /// Where the data of `layer` begin in the display window.
    fn offset(&self, layer: &Layer<AnyChannels<FlatSamples>>) -> [i64; 2] {
        let (at, from) = (layer.attributes.layer_position, self.display.position);
        [i64::from(at.x()) - i64::from(from.x()), i64::from(at.y()) - i64::from(from.y())]
    }

    /// The values of channels, in order, at every pixel of the display window; `outside` where there are no data. Also
    /// whether a part of the data lies outside of it, and whether the data leave a part of it open.
    fn placed<const N: usize>(
        &self,
        layer: &Layer<AnyChannels<FlatSamples>>,
        channels: [Option<&FlatSamples>; N],
        outside: [f32; N],
    ) -> (Vec<[f32; N]>, Fit) {
        let [left, top] = self.offset(layer);
        let [width, height] = [layer.size.x() as i64, layer.size.y() as i64];
        let [wide, high] = [i64::from(self.size.width), i64::from(self.size.height)];
        let (columns, rows) = (left.max(0)..(left + width).min(wide), top.max(0)..(top + height).min(high));
        let mut pixels = vec![outside; self.size.pixels()];
        for y in rows.clone() {
            for x in columns.clone() {
                let from = ((y - top) * width + x - left) as usize;
                let pixel = &mut pixels[(y * wide + x) as usize];
                for (value, channel) in pixel.iter_mut().zip(channels) {
                    if let Some(channel) = channel {
                        *value = channel.value_by_flat_index(from).to_f32();
                    }
                }
            }
        }
        let inside = (columns.end - columns.start).max(0) * (rows.end - rows.start).max(0);
        (pixels, Fit { cuts: inside < width * height, leaves_open: inside < wide * high })
    }
}

/// How the data window lies to the display window.
#[derive(Clone, Copy)]
struct Fit {
    /// A part of the data is not shown.
    cuts: bool,
    /// A part of the display window has no data.
    leaves_open: bool,
}

/// The channels of all layers by their full names, each with the number of its layer.
fn all_channels(layers: &[Layer<AnyChannels<FlatSamples>>]) -> (Vec<String>, Vec<(usize, &FlatSamples)>) {
    let mut all = Vec::new();
    for (i, layer) in layers.iter().enumerate() {
        let prefix = layer.attributes.layer_name.as_ref().map(ToString::to_string).unwrap_or_default();
        for channel in &layer.channel_data.list {
            let name = match prefix.is_empty() || layers.len() == 1 {
                true => channel.name.to_string(),
                false => format!("{prefix}.{}", channel.name),
            };
            all.push((name, (i, &channel.sample_data)));
        }
    }
    all.into_iter().unzip()
}

/// The size of the frame in the file at `path`.
pub(super) fn size(path: &Path) -> Result<FrameSize> {
    Ok(Sound::look(path)?.size)
}

/// Reads colours, and alpha if the file has it.
pub(super) fn read(path: &Path) -> Result<Picture> {
    let sound = Sound::look(path)?;
    let layers = sound.layers()?;
    let (names, channels) = all_channels(&layers);
    let Some(found) = channels::colours(&names) else {
        let problem = format!("it has no channels R, G and B but {}", listed(&names));
        return Err(Error::malformed(path, problem));
    };
    let mut notes = Vec::new();
    if found.others > 0 {
        let [r, g, b] = found.colours.map(|i| names[i].as_str());
        notes.push(format!("it has several layers of colours; {r}, {g} and {b} are taken"));
    }
    let layer = channels[found.colours[0]].0;
    let [r, g, b] = found.colours.map(|i| Some(channels[i].1));
    let alpha = found.alpha.map(|i| channels[i].1);
    let outside = [0.0, 0.0, 0.0, if alpha.is_some() { 0.0 } else { 1.0 }];
    let (pixels, fit) = sound.placed(&layers[layer], [r, g, b, alpha], outside);
    if fit.cuts {
        notes.push("its data reach beyond its display window and are cut there".into());
    }
    let frame = Frame::from_pixels(sound.size, pixels).expect("as many pixels as the display window has");
    Ok(Picture { frame, has_alpha: alpha.is_some(), notes })
}

/// Reads the two channels of motion.
pub(super) fn read_motion(path: &Path) -> Result<Motion> {
    let sound = Sound::look(path)?;
    let layers = sound.layers()?;
    let (names, channels) = all_channels(&layers);
    let Some(found) = channels::ways(&names) else {
        let problem = format!(
            "it has no two channels of motion but {}; name the way right X and the way down Y, or R and G",
            listed(&names)
        );
        return Err(Error::malformed(path, problem));
    };
    let [right, down] = found.channels.map(|i| channels[i]);
    let [x, y] = found.channels.map(|i| names[i].as_str());
    let mut notes = Vec::new();
    if found.others > 0 || x.to_lowercase().contains("forward") || x.to_lowercase().contains("next") {
        notes.push(format!(
            "motion is read from {x} and {y}; they must lead to where a pixel was in the frame before"
        ));
    }
    let (ways, fit) = sound.placed(&layers[right.0], [Some(right.1), Some(down.1)], [0.0; 2]);
    if fit.leaves_open {
        notes.push("its data leave a part of the frame open, which counts as still".into());
    }
    Ok(Motion { size: sound.size, ways, notes })
}

/// The names of some channels, and how many there are besides.
fn listed(names: &[String]) -> String {
    const MOST: usize = 8;
    let some = names.iter().take(MOST).map(String::as_str).collect::<Vec<_>>().join(", ");
    match names.len() {
        0 => "none at all".into(),
        count if count > MOST => format!("{some} and {} more", count - MOST),
        _ => some,
    }
}

fn frame_size(path: &Path, width: usize, height: usize) -> Result<FrameSize> {
    let side = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
    FrameSize::new(side(width), side(height)).map_err(|e| Error::malformed(path, e.to_string()))
}

fn damaged(path: &Path, error: exr::error::Error) -> Error {
    match error {
        exr::error::Error::Io(e) => Error::io("read", path, e),
        e => Error::malformed(path, format!("it is no EXR picture that can be read ({e})")),
    }
}
