//! Text in pictures.

use fovolnet::core::Frame;
use noto_sans_mono_bitmap::{FontWeight, RasterHeight, get_raster, get_raster_width};

/// Opacity of the dark box behind the text.
const BOX: f32 = 0.6;

/// Writes `text` (ASCII) into the top left corner of `frame`, white on a dark box. Its height follows that of the frame;
/// characters that do not fit are left out.
pub fn label(frame: &mut Frame, text: &str) {
    let height = match frame.size().height {
        0..360 => RasterHeight::Size16,
        360..540 => RasterHeight::Size20,
        540..900 => RasterHeight::Size24,
        _ => RasterHeight::Size32,
    };
    let margin = height.val() / 4;
    let advance = get_raster_width(FontWeight::Regular, height);
    shade(frame, 2 * margin + advance * text.chars().count(), margin + height.val());
    for (i, character) in text.chars().enumerate() {
        let Some(raster) = get_raster(character, FontWeight::Regular, height) else { continue };
        let left = margin + i * advance;
        for (y, row) in raster.rows().enumerate() {
            for (x, &coverage) in row.iter().enumerate() {
                blend(frame, left + x, margin / 2 + y, 1.0, f32::from(coverage) / 255.0);
            }
        }
    }
}

/// Darkens the top left `width` times `height` pixels.
fn shade(frame: &mut Frame, width: usize, height: usize) {
    for y in 0..height {
        for x in 0..width {
            blend(frame, x, y, 0.0, BOX);
        }
    }
}

/// Moves the colour of pixel (`x`, `y`), if there is one, towards `grey` by `share`.
fn blend(frame: &mut Frame, x: usize, y: usize, grey: f32, share: f32) {
    let (width, height) = (frame.size().width as usize, frame.size().height as usize);
    if x < width && y < height {
        let pixel = &mut frame.pixels_mut()[y * width + x];
        for channel in &mut pixel[..3] {
            *channel += (grey - *channel) * share;
        }
        pixel[3] = 1.0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fovolnet::core::FrameSize;

    fn labelled(size: [u32; 2], text: &str) -> Frame {
        let mut frame = Frame::new(FrameSize::new(size[0], size[1]).unwrap());
        frame.fill([0.5, 0.5, 0.5, 1.0]);
        label(&mut frame, text);
        frame
    }

    #[test]
    fn text_is_white_on_dark_and_the_rest_stays() {
        let frame = labelled([200, 100], "8% sampled");
        let count = |is: fn(f32) -> bool| frame.pixels().iter().filter(|pixel| is(pixel[0])).count();
        assert!(count(|v| v > 0.8) > 30, "{} bright pixels", count(|v| v > 0.8));
        assert!(count(|v| v < 0.25) > 500, "{} dark pixels", count(|v| v < 0.25));
        assert!(frame.pixels()[50 * 200..].iter().all(|pixel| pixel[0] == 0.5));
        assert_ne!(frame, labelled([200, 100], "9% sampled"));
    }

    #[test]
    fn small_pictures_cut_it_off() {
        assert!(labelled([16, 9], "every pixel").pixels().iter().any(|pixel| pixel[0] < 0.5));
    }
}
