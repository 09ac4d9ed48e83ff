use fovol_core::{Frame, FrameSize, Pixel, Region, Reprojection, SampleList};
use fovol_net::FilledNumbers;
use rayon::prelude::*;

/// How far away is what some pixels of a frame show.
#[derive(Debug, Clone, PartialEq)]
pub struct Depths {
    size: FrameSize,
    /// Those that show anything, with one over its distance from the eye.
    known: Vec<(Pixel, f32)>,
}

impl Depths {
    /// Of the pixels of `list`, whose rays met what they show at these `distances` from the eye; infinite where they met
    /// nothing (see [`Marched::depth`]).
    ///
    /// # Panics
    /// When there are not as many distances as pixels.
    ///
    /// [`Marched::depth`]: fovol_render::cpu::march::Marched
    pub fn new(list: &SampleList, distances: &[f32]) -> Self {
        assert_eq!(list.len(), distances.len(), "one distance for every listed pixel");
        let near = list.pixels().iter().zip(distances).filter(|(_, distance)| distance.is_finite());
        Self { size: list.size(), known: near.map(|(pixel, distance)| (*pixel, 1.0 / distance)).collect() }
    }

    /// Of pixels of a frame of `size` with one over the distance of each.
    pub fn of_inverse(size: FrameSize, known: Vec<(Pixel, f32)>) -> Self {
        Self { size, known }
    }

    /// Those in `region`, their pixels counted from its first one.
    #[must_use]
    pub fn within(&self, region: Region) -> Self {
        let moved = |(pixel, inverse): &(Pixel, f32)| {
            let x = u32::from(pixel.x).checked_sub(region.x).filter(|x| *x < region.size.width)?;
            let y = u32::from(pixel.y).checked_sub(region.y).filter(|y| *y < region.size.height)?;
            Some((Pixel { x: x as u16, y: y as u16 }, *inverse))
        };
        Self { size: region.size, known: self.known.iter().filter_map(moved).collect() }
    }

    /// Between them, and where nothing is known nearby.
    pub fn filled(&self) -> Filled {
        let [known, nothing] = [self.put(vec![0.0; self.size.pixels()]), vec![0.0; self.size.pixels()]];
        let [inverse, _] = FilledNumbers::new(self.size, [known, nothing]).pictures();
        Filled { size: self.size, inverse }
    }

    /// One over the distances between these, and between them and what frames `earlier` knew, seen from here: the nearest where
    /// several fall on a pixel. What `sparse` sampled in this frame is known better.
    pub fn filled_with(&self, earlier: &[(Reprojection, &Self)], sparse: &Frame) -> FilledNumbers {
        let nothing = || vec![0.0; self.size.pixels()];
        let (near, seen) = rayon::join(
            || self.put(nothing()),
            || {
                let mut seen = nothing();
                let here = earlier.par_iter().map(|(here, depths)| self.seen_before(here, depths, sparse));
                for (i, inverse) in here.collect::<Vec<_>>().into_iter().flatten() {
                    seen[i] = inverse.max(seen[i]);
                }
                self.put(seen)
            },
        );
        FilledNumbers::new(self.size, [near, seen])
    }

    /// The pixels, by their numbers, in which what an earlier frame knew is seen from `here`, where `sparse` has no samples.
    fn seen_before(&self, here: &Reprojection, earlier: &Self, sparse: &Frame) -> Vec<(usize, f32)> {
        let seen = |(pixel, inverse): &(Pixel, f32)| {
            let (place, inverse) = here.point(f32::from(pixel.x), f32::from(pixel.y), *inverse)?;
            let i = self.nearest_pixel(place)?;
            (sparse.pixels()[i][3] <= 0.5).then_some((i, inverse))
        };
        earlier.known.iter().filter_map(seen).collect()
    }

    /// `inverse` with what is known here.
    fn put(&self, mut inverse: Vec<f32>) -> Vec<f32> {
        for (pixel, known) in &self.known {
            inverse[pixel.index(self.size.width)] = *known;
        }
        inverse
    }

    /// The number of the pixel that `place` lies in.
    fn nearest_pixel(&self, place: [f32; 2]) -> Option<usize> {
        let [x, y] = place.map(|c| c + 0.5);
        let (width, height) = (self.size.width as usize, self.size.height as usize);
        let is_inside = x >= 0.0 && y >= 0.0 && x < width as f32 && y < height as f32;
        is_inside.then(|| y as usize * width + x as usize)
    }
}

/// How far away is what every pixel of a frame shows.
#[derive(Debug, Clone, PartialEq)]
pub struct Filled {
    size: FrameSize,
    inverse: Vec<f32>,
}

impl Filled {
    /// The size of the frame.
    pub fn size(&self) -> FrameSize {
        self.size
    }

    /// One over the distance for every pixel, row by row; 0 everywhere where nothing is known at all.
    pub fn inverse(&self) -> &[f32] {
        &self.inverse
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fovol_core::Camera;

    #[test]
    fn what_was_seen_before_is_seen_from_here_the_nearest_first() {
        let size = FrameSize::new(32, 24).unwrap();
        let [there, here] = [0.0, 4.0].map(|azimuth| Camera::on_sphere(azimuth, 5.0, 2.0, 40.0));
        let reprojection = Reprojection::new(&there, &here, size);
        let ([x, y], inverse) = reprojection.point(12.0, 9.0, 0.5).unwrap();
        let (x, y) = (x.round() as u32, y.round() as u32);
        let before = Depths::of_inverse(size, vec![(Pixel { x: 12, y: 9 }, 0.5)]);
        let behind = Depths::of_inverse(size, vec![(Pixel { x: x as u16, y: y as u16 }, 0.3)]);
        let same = Reprojection::new(&here, &here, size);
        let now = Depths::of_inverse(size, vec![(Pixel { x: 0, y: 0 }, 0.4)]);
        let mut sparse = Frame::new(size);
        sparse.pixels_mut()[0] = [0.0, 0.0, 0.0, 1.0];
        let [near, filled] = now.filled_with(&[(reprojection, &before), (same, &behind)], &sparse).pictures();
        assert_eq!(near, now.filled().inverse());
        assert!((filled[(y * 32 + x) as usize] - inverse).abs() < 1e-6);
        assert!((filled[0] - 0.4).abs() < 1e-6);
        // This frame saw nothing there.
        sparse.pixels_mut()[(y * 32 + x) as usize][3] = 1.0;
        let [_, filled] = now.filled_with(&[(reprojection, &before)], &sparse).pictures();
        assert!((filled[(y * 32 + x) as usize] - 0.4).abs() < 1e-6);
    }

    #[test]
    fn rays_that_met_nothing_are_not_known() {
        let size = FrameSize::new(4, 4).unwrap();
        let list = SampleList::new(size, vec![Pixel { x: 1, y: 2 }, Pixel { x: 3, y: 3 }]);
        let depths = Depths::new(&list, &[f32::INFINITY, 2.0]);
        assert_eq!(depths, Depths::of_inverse(size, vec![(Pixel { x: 3, y: 3 }, 0.5)]));
        assert!(depths.filled().inverse().iter().all(|inverse| (inverse - 0.5).abs() < 1e-6));
        let nothing = Depths::new(&list, &[f32::INFINITY; 2]);
        assert!(nothing.filled().inverse().iter().all(|inverse| *inverse == 0.0));
    }
}
