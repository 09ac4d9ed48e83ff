//! Pictures made of pictures.

use fovolnet::core::{Frame, FrameSize};

/// `frames` side by side, all of the same height, `gap` white pixels between them.
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

/// `frames` below each other, all of the same width, `gap` white pixels between them.
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
