//! Composition of pictures from pictures.

use fovolnet::core::{Frame, FrameSize};

/// Places `frames` of equal height side by side, with `gap` white pixels between them.
pub fn side_by_side(frames: &[&Frame], gap: u32) -> Frame {
    let height = frames.iter().map(|f| f.size().height).max().unwrap_or(1);
    let width = frames.iter().map(|f| f.size().width + gap).sum::<u32>().saturating_sub(gap);
    let mut sheet = blank(width, height);
    let mut left = 0;
    for frame in frames {
        draw(&mut sheet, frame, left, 0);
        left += frame.size().width + gap;
    }
    sheet
}

/// Places `frames` of equal width below each other, with `gap` white pixels between them.
pub fn stacked(frames: &[Frame], gap: u32) -> Frame {
    let width = frames.iter().map(|f| f.size().width).max().unwrap_or(1);
    let height = frames.iter().map(|f| f.size().height + gap).sum::<u32>().saturating_sub(gap);
    let mut sheet = blank(width, height);
    let mut top = 0;
    for frame in frames {
        draw(&mut sheet, frame, 0, top);
        top += frame.size().height + gap;
    }
    sheet
}

/// Shrinks by `factor`; each pixel is a mean of `factor`² pixels.
pub fn smaller(frame: &Frame, factor: u32) -> Frame {
    let FrameSize { width, height } = frame.size();
    let size = FrameSize::new((width / factor).max(1), (height / factor).max(1))
        .expect("it is smaller than a frame");
    let sides = [factor.min(width), factor.min(height)];
    let mean = |x: u32, y: u32| {
        let places = (0..sides[1]).flat_map(|j| (0..sides[0]).map(move |i| (x * factor + i, y * factor + j)));
        let sum = places
            .map(|(x, y)| frame.pixel(x, y))
            .fold([0.0; 4], |a, b| std::array::from_fn(|c| a[c] + b[c]));
        sum.map(|v| v / (sides[0] * sides[1]) as f32)
    };
    let pixels = (0..size.height).flat_map(|y| (0..size.width).map(move |x| mean(x, y))).collect();
    Frame::from_pixels(size, pixels).expect("as many pixels as the size says")
}

/// Enlarges by `factor`; each pixel becomes `factor`² pixels.
pub fn larger(frame: &Frame, factor: u32) -> Frame {
    let FrameSize { width, height } = frame.size();
    let size = FrameSize::new(width * factor, height * factor).expect("parts are small");
    let places = (0..size.height).flat_map(|y| (0..size.width).map(move |x| (x / factor, y / factor)));
    let pixels = places.map(|(x, y)| frame.pixel(x, y)).collect();
    Frame::from_pixels(size, pixels).expect("as many pixels as the size says")
}

/// Grey picture of `value` at each pixel, from 0 (black) to 1 (white).
pub fn grey(size: FrameSize, value: impl Fn(u32, u32) -> f32) -> Frame {
    let pixels = (0..size.height).flat_map(|y| (0..size.width).map(move |x| (x, y)));
    let grey = pixels.map(|(x, y)| value(x, y)).map(|v| [v, v, v, 1.0]).collect();
    Frame::from_pixels(size, grey).expect("as many pixels as the size says")
}

fn blank(width: u32, height: u32) -> Frame {
    let size = FrameSize::new(width.max(1), height.max(1)).expect("sheets are made of few frames");
    let mut sheet = Frame::new(size);
    sheet.fill([1.0; 4]);
    sheet
}

fn draw(sheet: &mut Frame, frame: &Frame, left: u32, top: u32) {
    let (from, to) = (frame.size().width as usize, sheet.size().width as usize);
    for (y, row) in frame.pixels().chunks(from).enumerate() {
        let at = (top as usize + y) * to + left as usize;
        for (out, &[r, g, b, _]) in sheet.pixels_mut()[at..at + from].iter_mut().zip(row) {
            *out = [r, g, b, 1.0];
        }
    }
}
