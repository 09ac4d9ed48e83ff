use super::{GuideGrid, GuidePixel, UpsampledGuide, guide_pixel};
use fovol_core::{Pixel, SampleList, SparseFrame};
use fovol_render::scene::RayResult;

/// Guide of one frame as it was marched.
#[derive(Debug, Clone)]
pub struct MarchedGuide {
    grid: GuideGrid,
    /// Guide pixels of the grid, row by row.
    pixels: Vec<GuidePixel>,
    /// Guide pixels of the samples, in their order.
    of_samples: Vec<GuidePixel>,
    /// Pixels that were marched for the guide alone, and their distances from the eye.
    marched: SampleList,
    distances: Vec<f32>,
    headroom: f32,
}

/// Headroom of a guide with cached shadows: their grid is coarse, so pixels can be brighter than it says.
const CACHED_HEADROOM: f32 = 2.0;

impl MarchedGuide {
    /// Marches the pixels of `grid` with `march`, which returns ray results in list order. The samples of `sparse` have
    /// the guide pixels `of_samples` already, so they are not marched again.
    ///
    /// # Errors
    /// Those of `march`.
    pub fn new<E>(
        grid: GuideGrid,
        sparse: &SparseFrame,
        of_samples: Vec<GuidePixel>,
        march: impl FnOnce(&SampleList) -> Result<Vec<RayResult>, E>,
    ) -> Result<Self, E> {
        let listed = grid.list();
        let known = known(listed.pixels(), sparse);
        let unknown = listed.pixels().iter().zip(&known).filter(|(_, known)| known.is_none());
        let unknown = SampleList::new(listed.size(), unknown.map(|(pixel, _)| *pixel).collect());
        let results = march(&unknown)?;
        let distances = results.iter().map(|ray| ray.depth).collect();
        let mut results = results.iter();
        let pixel = |known: Option<usize>| match known {
            Some(sample) => of_samples[sample],
            None => results.next().map_or([0.0; 4], guide_pixel),
        };
        let pixels = known.into_iter().map(pixel).collect();
        Ok(Self { grid, pixels, of_samples, marched: unknown, distances, headroom: 1.0 })
    }

    /// Marches the pixels of `grid`, and the samples of `sparse` once more, with `march`, which returns ray results with
    /// cached shadows in list order.
    ///
    /// # Errors
    /// Those of `march`.
    pub fn with_cached_shadows<E>(
        grid: GuideGrid,
        sparse: &SparseFrame,
        mut march: impl FnMut(&SampleList) -> Result<Vec<RayResult>, E>,
    ) -> Result<Self, E> {
        let samples = SampleList::new(sparse.size(), sparse.pixels().to_vec());
        let of_samples: Vec<GuidePixel> = march(&samples)?.iter().map(guide_pixel).collect();
        let guide = Self::new(grid, sparse, of_samples, march)?;
        Ok(Self { headroom: CACHED_HEADROOM, ..guide })
    }

    /// Number of pixels that were marched for the guide alone.
    pub fn marched(&self) -> usize {
        self.marched.len()
    }

    /// Pixels that were marched for the guide alone, with their distances from the eye in world units.
    pub fn distances(&self) -> (&[Pixel], &[f32]) {
        (self.marched.pixels(), &self.distances)
    }

    /// Guide of every pixel: interpolated, and exact at the samples of `sparse`.
    pub fn upsampled(&self, sparse: &SparseFrame) -> UpsampledGuide {
        let mut guide = UpsampledGuide::new(self.grid, &self.pixels, self.headroom);
        for (pixel, value) in sparse.pixels().iter().zip(&self.of_samples) {
            guide.put(*pixel, *value);
        }
        guide
    }
}

/// For each of `pixels`, the index of its sample in `sparse`, if it has one. Both are in raster order.
fn known(pixels: &[Pixel], sparse: &SparseFrame) -> Vec<Option<usize>> {
    let place = |pixel: &Pixel| (pixel.y, pixel.x);
    let samples = sparse.pixels();
    let mut at = 0;
    let sample = |pixel: &Pixel| {
        while at < samples.len() && place(&samples[at]) < place(pixel) {
            at += 1;
        }
        (samples.get(at) == Some(pixel)).then_some(at)
    };
    pixels.iter().map(sample).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use fovol_core::{Frame, FrameSize, Region};

    #[test]
    fn samples_are_not_marched_again_and_stay_exact() {
        let size = FrameSize { width: 8, height: 6 };
        let mut picture = Frame::new(size);
        for at in [0, 9, 18, 19, 47] {
            picture.pixels_mut()[at] = [0.5, 0.5, 0.5, 1.0];
        }
        let sparse = SparseFrame::from(&picture);
        let of_samples: Vec<GuidePixel> = (0..5).map(|i| [0.1 * i as f32; 4]).collect();
        let grid = GuideGrid::new(2, 1, Region::whole(size), size);
        let guide = MarchedGuide::new(grid, &sparse, of_samples.clone(), |list| {
            // Pixels 0 and 18 (2, 2) are samples on the grid.
            assert_eq!(list.len(), 4 * 3 - 2);
            let ray = RayResult { unshadowed: [1.0; 3], opacity: 1.0, ..RayResult::nothing([0.0; 3]) };
            Ok::<_, ()>(vec![ray; list.len()])
        });
        let guide = guide.unwrap();
        assert_eq!(guide.marched(), 10);
        assert_eq!((guide.pixels[0], guide.pixels[5], guide.pixels[1]), ([0.0; 4], [0.2; 4], [1.0; 4]));
        let upsampled = guide.upsampled(&sparse);
        for (pixel, exact) in sparse.pixels().iter().zip(&of_samples) {
            assert_eq!(upsampled.row(pixel.y.into()).unwrap()[usize::from(pixel.x)], *exact);
        }
    }
}
