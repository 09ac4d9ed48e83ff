use super::between::Between;
use super::{GuideGrid, GuidePixel, UpsampledGuide, guide_pixel};
use crate::Guide;
use fovol_core::{Pixel, SampleList, SparseFrame};
use fovol_render::scene::RayResult;

/// Guide of one frame, with the pixels that were marched for it.
///
/// A coarse grid is marched first. Between its pixels the guide is interpolated where it is smooth, and marched where
/// neighbours differ; then the same is done between the pixels of a grid twice as fine.
#[derive(Debug, Clone)]
pub struct MarchedGuide {
    guide: UpsampledGuide,
    /// Pixels that were marched for the guide alone, and their distances from the eye.
    pixels: Vec<Pixel>,
    distances: Vec<f32>,
}

/// Headroom of a guide with cached shadows: their grid is coarse, so pixels can be brighter than it says.
const CACHED_HEADROOM: f32 = 2.0;

/// Headroom of guides of this `kind`.
pub fn headroom(kind: Guide) -> f32 {
    if kind == Guide::Cached { CACHED_HEADROOM } else { 1.0 }
}

/// Differences of neighbours from which on a pixel between them is marched, for grids of every second and of every pixel.
pub const CONTRASTS: [f32; 2] = [0.05, 0.15];

/// Most pixels that are marched, as a part of the region, after each of the levels.
pub const BUDGETS: [f32; 2] = [0.2, 0.25];

impl MarchedGuide {
    /// Marches pixels of `grid` and of finer ones with `march`, which returns ray results in list order. The samples of
    /// `sparse` have the guide pixels `of_samples` already, so they are not marched again.
    ///
    /// # Errors
    /// Those of `march`.
    pub fn new<E>(
        grid: GuideGrid,
        sparse: &SparseFrame,
        of_samples: &[GuidePixel],
        march: impl FnMut(&SampleList) -> Result<Vec<RayResult>, E>,
    ) -> Result<Self, E> {
        let mut passes = Passes { sparse, of_samples, march, pixels: Vec::new(), distances: Vec::new() };
        let (mut grid, mut values) = (grid, passes.marched(&grid.pixels())?);
        let mut number = values.len();
        for (contrast, budget) in CONTRASTS.into_iter().zip(BUDGETS) {
            let Some(fine) = grid.finer() else { break };
            let between = Between::new(&grid, fine, &values);
            let budget = ((budget * grid.region.pixels() as f32) as usize).saturating_sub(number);
            let (pixels, places) = between.contrasting(contrast, budget);
            number += pixels.len();
            (grid, values) = (fine, between.interpolated());
            places.into_iter().zip(passes.marched(&pixels)?).for_each(|(at, value)| values[at] = value);
            let samples = sparse.pixels().iter().zip(of_samples);
            samples
                .for_each(|(pixel, value)| grid.index(*pixel).into_iter().for_each(|at| values[at] = *value));
        }
        let guide = UpsampledGuide::new(grid.region, values, 1.0);
        let Passes { pixels, distances, .. } = passes;
        Ok(Self { guide, pixels, distances })
    }

    /// Marches pixels of `grid` and of finer ones, and the samples of `sparse` once more, with `march`, which returns ray
    /// results with cached shadows in list order.
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
        let Self { guide, pixels, distances } = Self::new(grid, sparse, &of_samples, march)?;
        Ok(Self { guide: guide.with_headroom(headroom(Guide::Cached)), pixels, distances })
    }

    /// Number of pixels that were marched for the guide alone.
    pub fn marched(&self) -> usize {
        self.pixels.len()
    }

    /// Pixels that were marched for the guide alone, with their distances from the eye in world units.
    pub fn distances(&self) -> (&[Pixel], &[f32]) {
        (&self.pixels, &self.distances)
    }

    /// Guide of every pixel: exact at the samples and where it was marched, interpolated elsewhere.
    pub fn into_upsampled(self) -> UpsampledGuide {
        self.guide
    }
}

/// Marching of the pixels of a guide, level by level.
struct Passes<'a, M> {
    sparse: &'a SparseFrame,
    of_samples: &'a [GuidePixel],
    march: M,
    /// Pixels that were marched, and their distances.
    pixels: Vec<Pixel>,
    distances: Vec<f32>,
}

impl<M> Passes<'_, M> {
    /// Guide pixels of `pixels`, which are in raster order. Those that are no samples are marched.
    fn marched<E>(&mut self, pixels: &[Pixel]) -> Result<Vec<GuidePixel>, E>
    where
        M: FnMut(&SampleList) -> Result<Vec<RayResult>, E>,
    {
        let known = known(pixels, self.sparse);
        let unknown = pixels.iter().zip(&known).filter(|(_, known)| known.is_none());
        let unknown = SampleList::new(self.sparse.size(), unknown.map(|(pixel, _)| *pixel).collect());
        let results = (self.march)(&unknown)?;
        self.pixels.extend(unknown.pixels());
        self.distances.extend(results.iter().map(|ray| ray.depth));
        let mut results = results.iter();
        let pixel = |known: Option<usize>| match known {
            Some(sample) => self.of_samples[sample],
            None => results.next().map_or([0.0; 4], guide_pixel),
        };
        Ok(known.into_iter().map(pixel).collect())
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

    const SIZE: FrameSize = FrameSize { width: 64, height: 48 };

    /// Ray of `pixel` of a scene with a bright disc on a smooth slope.
    fn ray(pixel: &Pixel) -> RayResult {
        let [x, y] = [pixel.x, pixel.y].map(f32::from);
        let is_inside = (x - 30.0).hypot(y - 20.0) < 11.5;
        let value = if is_inside { 0.9 } else { 0.2 + 0.002 * x };
        RayResult { unshadowed: [value; 3], opacity: 1.0, depth: 1.0 + x, ..RayResult::nothing([0.0; 3]) }
    }

    fn march(list: &SampleList) -> Result<Vec<RayResult>, ()> {
        Ok(list.pixels().iter().map(ray).collect())
    }

    /// Sparse frame with samples at every `distance`-th pixel.
    fn sparse(distance: usize) -> SparseFrame {
        let mut picture = Frame::new(SIZE);
        picture.pixels_mut().iter_mut().step_by(distance).for_each(|pixel| *pixel = [0.5, 0.5, 0.5, 1.0]);
        SparseFrame::from(&picture)
    }

    #[test]
    fn samples_are_not_marched_again_and_stay_exact() {
        let sparse = sparse(7);
        let of_samples: Vec<GuidePixel> = (0..sparse.len()).map(|i| [0.001 * i as f32; 4]).collect();
        let grid = GuideGrid::every_pixel(Region::whole(SIZE), SIZE);
        let guide = MarchedGuide::new(grid, &sparse, &of_samples, march).unwrap();
        assert_eq!(guide.marched() + sparse.len(), SIZE.pixels());
        let (pixels, distances) = guide.distances();
        assert!(pixels.iter().zip(distances).all(|(pixel, distance)| *distance == 1.0 + f32::from(pixel.x)));
        let upsampled = guide.into_upsampled();
        for (pixel, exact) in sparse.pixels().iter().zip(&of_samples) {
            assert_eq!(upsampled.at(*pixel).unwrap(), *exact);
        }
    }

    #[test]
    fn outlines_are_marched_and_slopes_are_not() {
        let (nothing, region) = (sparse(usize::MAX), Region::whole(SIZE));
        for index in 0..16 {
            let grid = GuideGrid::coarsest(index, region, SIZE);
            let guide = MarchedGuide::new(grid, &nothing, &[[0.5; 4]], march).unwrap();
            assert!((SIZE.pixels() / 16..SIZE.pixels() / 4).contains(&guide.marched()));
            let mut seen = guide.distances().0.to_vec();
            let upsampled = guide.into_upsampled();
            for pixel in GuideGrid::every_pixel(region, SIZE).pixels().into_iter().skip(1) {
                // Pixels whose neighbours differ by less than 0.15 are interpolated, and cubics overshoot beside the outline.
                let error = (upsampled.at(pixel).unwrap()[0] - ray(&pixel).unshadowed[0]).abs();
                assert!(error < 0.15, "{pixel:?} {error}");
            }
            seen.sort_by_key(|pixel| (pixel.y, pixel.x));
            assert!(seen.windows(2).all(|two| two[0] != two[1]));
        }
    }
}
