use super::{EPSILON, GuidePixel, UpsampledGuide};
use fovol_core::{Frame, SampleList, SparseFrame};
use rayon::prelude::*;

/// Guides whose channels sum up to no more than this have no ratio: it would be the rounding of 8-bit colours.
const FAINT: f32 = 4.5 / 255.0;

/// Light ratios of the samples of `sparse`: ρ = (F + ε)/(U + ε)/h for each channel, with F the colour before the background,
/// U that of `guide` and h its headroom. Depths stay. Samples with a faint guide are left out.
pub fn light_ratios(sparse: &SparseFrame, guide: &UpsampledGuide, background: [f32; 3]) -> SparseFrame {
    let (mut pixels, mut colours, mut depths) = (Vec::new(), Vec::new(), Vec::new());
    let scale = 1.0 / guide.headroom();
    for (at, pixel) in sparse.pixels().iter().enumerate() {
        let Some(guide) = guide.at(*pixel) else { continue };
        let [r, g, b, _] = guide;
        if r + g + b > FAINT {
            pixels.push(*pixel);
            colours.push(
                ratio(sparse.colours()[at], &guide, background).map(|ratio| (scale * ratio).clamp(0.0, 1.0)),
            );
            depths.push(sparse.depths()[at]);
        }
    }
    SparseFrame::new(SampleList::new(sparse.size(), pixels), colours, depths)
}

/// (F + ε)/(U + ε) of a pixel with the colour `over` the background.
fn ratio(over: [f32; 3], [r, g, b, opacity]: &GuidePixel, background: [f32; 3]) -> [f32; 3] {
    let unshadowed = [r, g, b];
    std::array::from_fn(|c| {
        let colour = over[c] - (1.0 - opacity) * background[c];
        (colour + EPSILON) / (unshadowed[c] + EPSILON)
    })
}

/// Turns `frame` from light ratios into colours over the background: h·(U + ε)·ρ − ε + (1 − O)·B, clamped to 0…1. Pixels
/// that the guide does not cover become background, and samples of `sparse` show their exact colours.
pub fn compose(frame: &mut Frame, guide: &UpsampledGuide, sparse: &SparseFrame, background: [f32; 3]) {
    let width = frame.size().width as usize;
    let (region, headroom) = (guide.region(), guide.headroom());
    let (first, end) = (region.x as usize, (region.x + region.size.width) as usize);
    let [r, g, b] = background.map(|value| value.clamp(0.0, 1.0));
    let nothing = [r, g, b, 1.0];
    frame.pixels_mut().par_chunks_exact_mut(width).enumerate().for_each(|(y, row)| {
        match guide.row(y) {
            Some(guides) => {
                row[..first].fill(nothing);
                row[end..].fill(nothing);
                for (pixel, guide) in row[first..end].iter_mut().zip(guides) {
                    *pixel = colour(pixel, guide, background, headroom);
                }
            }
            None => row.fill(nothing),
        }
        let samples = sparse.row(y);
        for (pixel, [r, g, b]) in sparse.pixels()[samples.clone()].iter().zip(&sparse.colours()[samples]) {
            row[usize::from(pixel.x)] = [*r, *g, *b, 1.0];
        }
    });
}

/// Colour over the background of a pixel with the light `ratio`.
#[inline(always)]
fn colour(ratio: &[f32; 4], guide: &GuidePixel, background: [f32; 3], headroom: f32) -> [f32; 4] {
    let left = 1.0 - guide[3];
    let mut colour = [1.0; 4];
    for c in 0..3 {
        let lit = headroom * (guide[c] + EPSILON) * ratio[c] - EPSILON;
        colour[c] = (lit.max(0.0) + left * background[c]).clamp(0.0, 1.0);
    }
    colour
}

#[cfg(test)]
mod tests {
    use super::*;
    use fovol_core::{FrameSize, Pixel, Region};

    const BACKGROUND: [f32; 3] = [0.1, 0.2, 0.4];

    #[test]
    fn ratios_times_the_guide_are_the_colours() {
        let size = FrameSize { width: 4, height: 3 };
        let every: Vec<Pixel> = (0..3).flat_map(|y| (0..4).map(move |x| Pixel { x, y })).collect();
        let guides: Vec<GuidePixel> =
            (0..12).map(|i| [0.05 * i as f32, 0.04 * i as f32, 0.5, 0.06 * i as f32 + 0.3]).collect();
        let over = |(i, guide): (usize, &GuidePixel)| {
            std::array::from_fn(|c| guide[c] * (0.3 + 0.05 * i as f32) + (1.0 - guide[3]) * BACKGROUND[c])
        };
        let colours: Vec<[f32; 3]> = guides.iter().enumerate().map(over).collect();
        let list = SampleList::new(size, every);
        let sparse = SparseFrame::new(list.clone(), colours.clone(), vec![1.0; 12]);
        let guide = UpsampledGuide::new(Region::whole(size), guides.clone(), 1.0);
        let ratios = light_ratios(&sparse, &guide, BACKGROUND);
        assert_eq!(ratios.pixels(), sparse.pixels());
        let mut frame = ratios.to_frame();
        let nothing = SparseFrame::from(&Frame::new(size));
        compose(&mut frame, &guide, &nothing, BACKGROUND);
        for (found, expected) in frame.pixels().iter().zip(&colours) {
            assert!(
                (0..3).all(|c| (found[c] - expected[c]).abs() < 1e-6) && found[3] == 1.0,
                "{found:?} {expected:?}"
            );
        }
    }

    #[test]
    fn faint_samples_have_no_ratio_and_show_their_colour() {
        let size = FrameSize { width: 3, height: 1 };
        let list = SampleList::new(size, vec![Pixel { x: 0, y: 0 }, Pixel { x: 2, y: 0 }]);
        let colours = vec![[0.101, 0.2, 0.4], [0.5; 3]];
        let sparse = SparseFrame::new(list, colours, vec![f32::INFINITY, 2.0]);
        let guides = [[0.005, 0.0, 0.0, 0.01], [0.6, 0.6, 0.6, 1.0], [0.6, 0.6, 0.6, 1.0]];
        let everywhere = UpsampledGuide::new(Region::whole(size), guides.to_vec(), 1.0);
        let ratios = light_ratios(&sparse, &everywhere, BACKGROUND);
        assert_eq!((ratios.pixels(), ratios.depths()), (&[Pixel { x: 2, y: 0 }][..], &[2.0][..]));
        let region = Region { x: 0, y: 0, size: FrameSize { width: 1, height: 1 } };
        let guide = UpsampledGuide::new(region, guides[..1].to_vec(), 1.0);
        let mut frame = Frame::new(size);
        compose(&mut frame, &guide, &sparse, BACKGROUND);
        assert_eq!(frame.pixel(0, 0), [0.101, 0.2, 0.4, 1.0]);
        assert_eq!(frame.pixel(1, 0), [0.1, 0.2, 0.4, 1.0]);
        assert_eq!(frame.pixel(2, 0), [0.5, 0.5, 0.5, 1.0]);
    }
}
