use super::variation::Variation;
use crate::clips::Clip;
use fovol_core::{Frame, FrameSize, Pixel, Region, SampleList, SparseFrame};
use fovolnet::guide::{EPSILON, GuideGrid, GuidePixel, MarchedGuide, UpsampledGuide};
use fovolnet::render::scene::RayResult;
use std::convert::Infallible;

/// Black: clips have no background.
pub(super) const BACKGROUND: [f32; 3] = [0.0; 3];

/// Every pixel of a frame of a clip, as a lesson shows it.
pub(super) struct Picture {
    size: FrameSize,
    rays: Vec<RayResult>,
}

impl Picture {
    /// Frame `number` of `clip` with the colours and the blank border of `variation`.
    pub fn new(clip: &Clip, number: usize, variation: &Variation) -> Self {
        let size = clip.scenery.part;
        let ray = |at: usize| {
            if variation.is_blank(at % size.width as usize, at / size.width as usize, size) {
                return RayResult::nothing(BACKGROUND);
            }
            let numbers = |channels: usize, frames: &[Vec<_>]| {
                let numbers = &frames[number][channels * at..];
                variation.recoloured([numbers[0], numbers[1], numbers[2]])
            };
            RayResult {
                colour: numbers(3, &clip.frames),
                unshadowed: numbers(4, &clip.guides),
                opacity: clip.guides[number][4 * at + 3].to_f32(),
                depth: 1.0 / clip.inverse_distances[number][at].to_f32(),
            }
        };
        Self { size, rays: (0..size.pixels()).map(ray).collect() }
    }

    pub fn size(&self) -> FrameSize {
        self.size
    }

    /// The picture itself.
    pub fn frame(&self) -> Frame {
        self.frame_of(|ray| ray.colour)
    }

    fn frame_of(&self, colour: impl Fn(&RayResult) -> [f32; 3]) -> Frame {
        let mut frame = Frame::new(self.size);
        for (pixel, ray) in frame.pixels_mut().iter_mut().zip(&self.rays) {
            let [r, g, b] = colour(ray);
            *pixel = [r, g, b, 1.0];
        }
        frame
    }

    fn pixel(&self, at: usize) -> Pixel {
        let width = self.size.width as usize;
        Pixel { x: (at % width) as u16, y: (at / width) as u16 }
    }

    /// The pixels that `is_sampled` says are known.
    pub fn samples(&self, is_sampled: impl Fn(usize) -> bool) -> SparseFrame {
        let known: Vec<usize> = (0..self.rays.len()).filter(|at| is_sampled(*at)).collect();
        let list = SampleList::new(self.size, known.iter().map(|at| self.pixel(*at)).collect());
        let colours = known.iter().map(|at| self.rays[*at].colour).collect();
        SparseFrame::new(list, colours, known.iter().map(|at| self.rays[*at].depth).collect())
    }

    fn guide_pixel(&self, pixel: &Pixel) -> GuidePixel {
        fovolnet::guide::guide_pixel(&self.rays[pixel.index(self.size.width)])
    }

    /// Guide of frame number `index` with the samples `sparse`, as the program marches it.
    pub fn guide(&self, index: u32, sparse: &SparseFrame) -> MarchedGuide {
        let grid = GuideGrid::coarsest(index, Region::whole(self.size), self.size);
        let of_samples: Vec<GuidePixel> =
            sparse.pixels().iter().map(|pixel| self.guide_pixel(pixel)).collect();
        let march = |list: &SampleList| {
            let pixels = list.pixels().iter();
            Ok::<_, Infallible>(pixels.map(|pixel| self.rays[pixel.index(self.size.width)]).collect())
        };
        let Ok(guide) = MarchedGuide::new(grid, sparse, &of_samples, march);
        guide
    }

    /// Guide that is marched at every pixel.
    pub fn whole_guide(&self) -> UpsampledGuide {
        let pixels = self.rays.iter().map(fovolnet::guide::guide_pixel).collect();
        UpsampledGuide::new(Region::whole(self.size), pixels, 1.0)
    }

    /// Light ratio of every pixel.
    pub fn ratios(&self) -> Frame {
        let ratio = |ray: &RayResult, c: usize| (ray.colour[c] + EPSILON) / (ray.unshadowed[c] + EPSILON);
        self.frame_of(|ray| std::array::from_fn(|c| ratio(ray, c).clamp(0.0, 1.0)))
    }
}
