use crate::scene::RayResult;
use fovol_core::{Frame, SampleList};

/// The sparse frame of packed samples: the listed pixels with alpha 1, all others transparent black.
///
/// A pixel that is listed twice has the colour of its last entry.
///
/// # Panics
/// When there are not as many samples as pixels.
pub fn scatter(list: &SampleList, marched: &[RayResult]) -> Frame {
    assert_eq!(list.len(), marched.len(), "one sample for every listed pixel");
    let mut frame = Frame::new(list.size());
    let width = list.size().width;
    let pixels = frame.pixels_mut();
    for (pixel, &RayResult { colour: [r, g, b], .. }) in list.pixels().iter().zip(marched) {
        pixels[pixel.index(width)] = [r, g, b, 1.0];
    }
    frame
}

#[cfg(test)]
mod tests {
    use super::*;
    use fovol_core::{FrameSize, Pixel};

    #[test]
    fn listed_pixels_are_opaque_and_others_clear() {
        let size = FrameSize::new(3, 2).unwrap();
        let list = SampleList::new(size, vec![Pixel { x: 2, y: 1 }, Pixel { x: 0, y: 0 }]);
        let first = RayResult { colour: [0.5, 0.25, 0.125], opacity: 0.3, depth: 1.0 };
        let frame = scatter(&list, &[first, RayResult::nothing([1.0, 0.0, 0.0])]);
        assert_eq!(frame.pixel(2, 1), [0.5, 0.25, 0.125, 1.0]);
        assert_eq!(frame.pixel(0, 0), [1.0, 0.0, 0.0, 1.0]);
        assert_eq!(frame.pixel(1, 1), [0.0; 4]);
    }
}
