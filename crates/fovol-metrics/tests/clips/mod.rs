//! Clips that the scripts of reference values make too.

use crate::pattern::{noise, triangle};
use fovol_core::{Frame, FrameSize};

/// Kind of distortion and its amount.
#[derive(Clone, Copy)]
pub struct Flaw<'a>(pub &'a str, pub i64);

/// No distortion.
pub const NONE: Flaw<'_> = Flaw("none", 0);

/// The script's pixel value before clamping to 0…255.
fn value(size: FrameSize, frame: i64, flaw: Flaw<'_>, [x, y, c]: [i64; 3]) -> i64 {
    let Flaw(kind, amount) = flaw;
    let scene = |x: i64, y: i64| {
        let x = if kind == "shift" { x + amount } else { x };
        let (width, height) = (i64::from(size.width), i64::from(size.height));
        let waves =
            (triangle(3 * x + 2 * y + 5 * frame, 40 + 9 * c) + triangle(x * (c + 1) + 7 * frame, 23)) / 2;
        let away = (x - width / 3 - 2 * frame).pow(2) + (y - height / 2).pow(2);
        if away < (height / 3).pow(2) { 200 - 60 * c } else { waves }
    };
    match kind {
        "noise" => scene(x, y) + ((noise(x, y, c, frame) - 128) * amount).div_euclid(128),
        "blur" => {
            let clamped = |v: i64, side: u32| v.clamp(0, i64::from(side) - 1);
            let side = -amount..=amount;
            let around = side.clone().flat_map(|dy| side.clone().map(move |dx| (dx, dy)));
            let sum: i64 =
                around.map(|(dx, dy)| scene(clamped(x + dx, size.width), clamped(y + dy, size.height))).sum();
            let area = (2 * amount + 1).pow(2);
            (sum + area / 2) / area
        }
        "brighter" => scene(x, y) + amount,
        "flicker" => scene(x, y) + amount * (frame % 2),
        "tint" => scene(x, y) + amount * (1 - c),
        _ => scene(x, y),
    }
}

/// Frame `frame` of the clip with `flaw`.
pub fn picture(size: FrameSize, frame: i64, flaw: Flaw<'_>) -> Frame {
    let at = |x, y, c| value(size, frame, flaw, [x, y, c]).clamp(0, 255) as f32 / 255.0;
    let pixels = (0..i64::from(size.height))
        .flat_map(|y| (0..i64::from(size.width)).map(move |x| (x, y)))
        .map(|(x, y)| [at(x, y, 0), at(x, y, 1), at(x, y, 2), 1.0])
        .collect();
    Frame::from_pixels(size, pixels).unwrap()
}

/// Frame size that is known to be valid.
pub fn size(width: u32, height: u32) -> FrameSize {
    FrameSize::new(width, height).unwrap()
}
