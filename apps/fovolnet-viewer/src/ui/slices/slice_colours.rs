//! Colours of the voxels in slices.

use super::slice_pixels::Slice;
use super::value_window::ValueWindow;
use eframe::egui::{Color32, ColorImage};
use fovolnet::core::{TransferFunction, Volume, VoxelColours};
use fovolnet::{OpenVolume, RenderSettings, presets};

/// Colours of the slices of a volume and of what lies over it. They are found once, since label maps are searched for
/// their labels.
#[derive(Debug, Clone)]
pub struct SliceColours {
    /// Colours of the labels, if the volume is a label map.
    labels: Option<TransferFunction>,
    /// Transfer function of each further volume, and its greatest opacity; `None` for one that cannot be read.
    layers: Vec<Option<(TransferFunction, f64)>>,
}

/// Opacity of an overlay where its transfer function is most opaque. Opacities of transfer functions are for many
/// voxels behind each other; a slice has one.
const OVER: f64 = 0.6;
/// Steps of a table of colours.
const STEPS: usize = 1024;

impl SliceColours {
    /// Finds the colours of `opened`.
    pub fn new(opened: &OpenVolume) -> Self {
        let is_label_map = opened.volume.is_label_map() && opened.colours.is_none();
        let labels = is_label_map.then(|| presets::find("auto", opened).ok()).flatten();
        let of_layer = |layer: &fovolnet::OpenLayer| {
            let transfer_function = layer.transfer_function.clone();
            let settings = RenderSettings { transfer_function, ..RenderSettings::default() };
            let transfer = presets::chosen(&settings, &layer.opened).ok()?;
            let most = transfer.max_opacity(0.0, 1.0);
            Some((transfer, most))
        };
        Self { labels, layers: opened.layers.iter().map(of_layer).collect() }
    }

    /// Whether `opened` itself is shown in greys, which have a window.
    pub fn are_greys(&self, opened: &OpenVolume) -> bool {
        self.labels.is_none() && opened.colours.is_none()
    }

    /// Picture of `slice` of the volume itself. Greys are those of `window`.
    pub fn base(&self, opened: &OpenVolume, slice: Slice, window: ValueWindow) -> ColorImage {
        let volume = &opened.volume;
        if let Some(colours) = &opened.colours {
            return coloured(slice, colours);
        }
        match &self.labels {
            Some(labels) => slice.picture(
                volume,
                remembering(|value| {
                    let [r, g, b, a] = labels.evaluate(volume.normalised(value));
                    if a > 0.0 { opaque([r, g, b]) } else { Color32::BLACK }
                }),
            ),
            None => slice.picture(volume, |value| Color32::from_gray(window.grey(value))),
        }
    }

    /// Picture of `slice` of further volume `number` of `opened`, to lie over the others; `None` if it has no colours.
    pub fn over(&self, opened: &OpenVolume, number: usize, slice: Slice) -> Option<ColorImage> {
        let (transfer, most) = self.layers.get(number)?.as_ref()?;
        let layer = &opened.layers[number].opened;
        let volume = &layer.volume;
        let colour = |v: f64| {
            let [r, g, b, a] = transfer.evaluate(v);
            translucent([r, g, b], OVER * a / most.max(1e-9))
        };
        if volume.is_label_map() {
            return Some(slice.picture(volume, remembering(|value| colour(normalised(volume, value)))));
        }
        let table: Vec<Color32> = (0..=STEPS).map(|step| colour(step as f64 / STEPS as f64)).collect();
        let nan = colour(f64::NAN);
        let [lo, hi] = volume.range();
        let scale = if hi > lo { STEPS as f64 / (hi - lo) } else { 0.0 };
        let mut picture = slice.picture(volume, |value| {
            // A cast saturates.
            let step = ((value - lo) * scale + 0.5) as usize;
            if value.is_nan() { nan } else { table[step.min(STEPS)] }
        });
        if let Some(colours) = &layer.colours {
            let own = coloured(slice, colours);
            for (pixel, own) in picture.pixels.iter_mut().zip(own.pixels) {
                *pixel = own.gamma_multiply(f32::from(pixel.a()) / 255.0);
            }
        }
        Some(picture)
    }
}

/// Display value of `value`, or NaN, which has a colour of its own.
fn normalised(volume: &Volume, value: f64) -> f64 {
    if value.is_nan() { value } else { volume.normalised(value) }
}

/// Picture of `slice` of voxels with colours.
fn coloured(slice: Slice, colours: &VoxelColours) -> ColorImage {
    let [red, green, blue] = colours.each_ref().map(|channel| {
        let window = ValueWindow::over(channel.range());
        slice.picture(channel, |value| Color32::from_gray(window.grey(value)))
    });
    let greens_and_blues = green.pixels.iter().zip(&blue.pixels);
    let pixels = red.pixels.iter().zip(greens_and_blues);
    let pixels = pixels.map(|(r, (g, b))| Color32::from_rgb(r.r(), g.r(), b.r())).collect();
    ColorImage::new(red.size, pixels)
}

/// `colour`, which is asked once for equal values in a row: labels lie in runs.
fn remembering(mut colour: impl FnMut(f64) -> Color32) -> impl FnMut(f64) -> Color32 {
    let mut last = None;
    move |value| match last {
        Some((known, found)) if known == value => found,
        _ => {
            let found = colour(value);
            last = Some((value, found));
            found
        }
    }
}

fn opaque(rgb: [f64; 3]) -> Color32 {
    let [r, g, b] = rgb.map(|c| (c * 255.0).round() as u8);
    Color32::from_rgb(r, g, b)
}

fn translucent(rgb: [f64; 3], alpha: f64) -> Color32 {
    let [r, g, b] = rgb.map(|c| (c * 255.0).round() as u8);
    Color32::from_rgba_unmultiplied(r, g, b, (alpha.clamp(0.0, 1.0) * 255.0).round() as u8)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ui::slices::orientation::{Lie, Plane};
    use fovolnet::core::{Contents, Grid, Label};
    use fovolnet::{OpenLayer, TransferChoice};
    use std::sync::Arc;

    fn slice(plane: Plane, number: usize) -> Slice {
        Slice { lie: Lie::new(plane, None), number, every: 1 }
    }

    fn volume(values: Vec<u8>) -> Volume {
        Volume::from_values(Grid::new([values.len() / 2, 2, 1], [1.0; 3]).unwrap(), values).unwrap()
    }

    fn labels() -> Volume {
        let label = Label { value: 3, name: "liver".into(), colour: Some([255, 0, 51]) };
        let contents = Contents { labels: vec![label], ..Contents::default() };
        volume(vec![0, 0, 3, 3, 0, 1, 1, 3]).with_contents(contents)
    }

    #[test]
    fn scans_are_grey_and_labels_have_their_colours() {
        let grid = Grid::new([4, 2, 1], [1.0; 3]).unwrap();
        let values = vec![0.0f32, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 255.0];
        let scan: OpenVolume = Volume::from_values(grid, values).unwrap().into();
        let colours = SliceColours::new(&scan);
        let window = ValueWindow::over([0.0, 255.0]);
        let picture = colours.base(&scan, slice(Plane::Axial, 0), window);
        let greys: Vec<u8> = picture.pixels.iter().map(|pixel| pixel.r()).collect();
        assert_eq!(greys, [40, 50, 60, 255, 0, 10, 20, 30]);
        let map: OpenVolume = labels().into();
        let picture = SliceColours::new(&map).base(&map, slice(Plane::Axial, 0), window);
        let red = Color32::from_rgb(255, 0, 51);
        assert_eq!(picture.pixels[3], red);
        assert_eq!(picture.pixels[4..], [Color32::BLACK, Color32::BLACK, red, red]);
        assert!(picture.pixels[1] != Color32::BLACK && picture.pixels[1] != red);
    }

    #[test]
    fn overlays_let_the_scan_through() {
        let mut scan: OpenVolume = volume(vec![9; 8]).into();
        scan.layers.push(OpenLayer { opened: labels().into(), transfer_function: TransferChoice::Auto });
        let over = SliceColours::new(&scan).over(&scan, 0, slice(Plane::Axial, 0)).unwrap();
        assert_eq!(over.pixels[0], Color32::TRANSPARENT);
        assert_eq!(over.pixels[3], Color32::from_rgba_unmultiplied(255, 0, 51, 153));
    }

    #[test]
    fn voxels_with_colours_are_shown_in_them() {
        let channel = |first: u8| Arc::new(volume((0..8).map(|i| first + i).collect()));
        let mut opened: OpenVolume = volume(vec![0; 8]).into();
        opened.colours = Some([channel(10), channel(100), channel(200)]);
        let window = ValueWindow::over([0.0, 1.0]);
        let picture = SliceColours::new(&opened).base(&opened, slice(Plane::Axial, 0), window);
        assert_eq!(picture.pixels[0], Color32::from_rgb(14, 104, 204));
    }
}
