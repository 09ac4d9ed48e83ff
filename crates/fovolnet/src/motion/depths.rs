use fovol_core::{FrameSize, Pixel, Region, Reprojection, SampleList};
use fovol_net::FilledNumbers;
use fovol_net::cpu::{Simd, SimdOp};
use rayon::prelude::*;
use std::sync::atomic::{AtomicU32, Ordering};

/// How far away is what some pixels of a frame show.
#[derive(Debug, Clone, PartialEq)]
pub struct Depths {
    size: FrameSize,
    /// With one over the distance of each from the eye, 0 where nothing was met.
    known: Vec<(Pixel, f32)>,
}

impl Depths {
    /// Of the pixels of `list`, whose rays met what they show at these `distances` from the eye; infinite where they met
    /// nothing (see [`RayResult::depth`]).
    ///
    /// # Panics
    /// When there are not as many distances as pixels.
    ///
    /// [`RayResult::depth`]: fovol_render::scene::RayResult
    pub fn new(list: &SampleList, distances: &[f32]) -> Self {
        assert_eq!(list.len(), distances.len(), "one distance for every listed pixel");
        let inverse = distances.iter().map(|distance| 1.0 / distance);
        Self { size: list.size(), known: list.pixels().iter().copied().zip(inverse).collect() }
    }

    /// Of pixels of a frame of `size` with one over the distance of each, 0 where nothing was met.
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
    /// several fall on a pixel. What is known of this frame is known better.
    pub fn filled_with(&self, earlier: &[(Reprojection, &Self)]) -> FilledNumbers {
        let (near, seen) = rayon::join(
            || self.put(vec![0.0; self.size.pixels()]),
            || {
                let seen: Vec<_> = (0..self.size.pixels()).map(|_| AtomicU32::new(0)).collect();
                earlier.par_iter().for_each(|(here, depths)| depths.see(here, &seen));
                self.put(seen.into_iter().map(|inverse| f32::from_bits(inverse.into_inner())).collect())
            },
        );
        FilledNumbers::new(self.size, [near, seen])
    }

    /// Makes `seen` the nearest of what it is, and what this knew, seen from `here`: the bits of one over distances, which are in
    /// the order of these numbers as none is negative.
    fn see(&self, here: &Reprojection, seen: &[AtomicU32]) {
        self.known.par_chunks(KNOWN_OF_TASK).for_each(|known| {
            Simd::best().vectorised(Seeing { known, here, size: self.size, seen });
        });
    }

    /// `inverse` with what is known here.
    fn put(&self, mut inverse: Vec<f32>) -> Vec<f32> {
        for (pixel, known) in &self.known {
            inverse[pixel.index(self.size.width)] = *known;
        }
        inverse
    }
}

/// How many pixels a task moves.
const KNOWN_OF_TASK: usize = 4096;

/// Pixels that are moved at once.
const LANES: usize = 16;

/// The seeing of what some pixels of another frame showed.
struct Seeing<'a> {
    known: &'a [(Pixel, f32)],
    here: &'a Reprojection,
    size: FrameSize,
    seen: &'a [AtomicU32],
}

impl SimdOp for Seeing<'_> {
    #[inline(always)]
    fn run(self) {
        let mut moved = Moved::default();
        for known in self.known.chunks(LANES) {
            for (lane, (pixel, inverse)) in known.iter().enumerate() {
                [moved.x[lane], moved.y[lane]] = [pixel.x, pixel.y].map(f32::from);
                moved.inverse[lane] = *inverse;
            }
            moved.make(self.here);
            for lane in 0..known.len() {
                self.put(moved.x[lane], moved.y[lane], moved.inverse[lane]);
            }
        }
    }
}

impl Seeing<'_> {
    /// Puts what is one over `inverse` away to the pixel that (`x`, `y`) lies in, if there is one.
    #[inline(always)]
    fn put(&self, x: f32, y: f32, inverse: f32) {
        let (width, height) = (self.size.width as f32, self.size.height as f32);
        let (x, y) = (x + 0.5, y + 0.5);
        if inverse > 0.0 && x >= 0.0 && y >= 0.0 && x < width && y < height {
            // 32 bits are enough, and take one instruction.
            let i = y as i32 as usize * self.size.width as usize + x as i32 as usize;
            raise(&self.seen[i], inverse.to_bits());
        }
    }
}

/// Places of points, and one over the distance of each, 0 where there is none.
#[derive(Default)]
struct Moved {
    x: [f32; LANES],
    y: [f32; LANES],
    inverse: [f32; LANES],
}

impl Moved {
    /// Moves them to where they are seen from `here`; what is not in front becomes one of those.
    #[inline(always)]
    fn make(&mut self, here: &Reprojection) {
        for lane in 0..LANES {
            let ([x, y], inverse) =
                here.point(self.x[lane], self.y[lane], self.inverse[lane]).unwrap_or(([0.0; 2], 0.0));
            (self.x[lane], self.y[lane], self.inverse[lane]) = (x, y, inverse);
        }
    }
}

/// Makes `number` at least `to`. Most are that already or were 0: reading first saves what changing costs.
#[inline(always)]
fn raise(number: &AtomicU32, to: u32) {
    if number.load(Ordering::Relaxed) < to {
        number.fetch_max(to, Ordering::Relaxed);
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
        let [near, filled] = now.filled_with(&[(reprojection, &before), (same, &behind)]).pictures();
        assert_eq!(near, now.filled().inverse());
        assert!((filled[(y * 32 + x) as usize] - inverse).abs() < 1e-6);
        assert!((filled[0] - 0.4).abs() < 1e-6);
        // This frame saw nothing there.
        let nothing = (Pixel { x: x as u16, y: y as u16 }, 0.0);
        let now = Depths::of_inverse(size, vec![(Pixel { x: 0, y: 0 }, 0.4), nothing]);
        let [_, filled] = now.filled_with(&[(reprojection, &before)]).pictures();
        assert!((filled[(y * 32 + x) as usize] - 0.4).abs() < 1e-6);
    }

    #[test]
    fn rays_that_met_nothing_are_not_known() {
        let size = FrameSize::new(4, 4).unwrap();
        let list = SampleList::new(size, vec![Pixel { x: 1, y: 2 }, Pixel { x: 3, y: 3 }]);
        let depths = Depths::new(&list, &[f32::INFINITY, 2.0]);
        assert!(depths.filled().inverse().iter().all(|inverse| (inverse - 0.5).abs() < 1e-6));
        let nothing = Depths::new(&list, &[f32::INFINITY; 2]);
        assert!(nothing.filled().inverse().iter().all(|inverse| *inverse == 0.0));
    }
}
