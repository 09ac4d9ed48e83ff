use fovol_core::{FrameSize, Pixel, Region, Reprojection, SparseFrame};
use fovol_net::FilledNumbers;
use fovol_simd::{Simd, SimdOp};
use rayon::prelude::*;
use std::sync::atomic::{AtomicU32, Ordering};

/// Depths of some pixels of a frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Depths {
    size: FrameSize,
    /// Pixels with their inverse distances from the eye; 0 where the ray met nothing.
    known: Vec<(Pixel, f32)>,
}

impl Depths {
    /// Depths of the samples of `sparse`.
    pub fn new(sparse: &SparseFrame) -> Self {
        let inverse = sparse.depths().iter().map(|distance| 1.0 / distance);
        Self { size: sparse.size(), known: sparse.pixels().iter().copied().zip(inverse).collect() }
    }

    /// Depths of a frame of `size`, from the inverse distances of its pixels, row by row; 0 where nothing is known.
    #[cfg(feature = "gpu")]
    pub(crate) fn of_frame(size: FrameSize, inverse: &[f32]) -> Self {
        let width = size.width as usize;
        let place = |at: usize| Pixel { x: (at % width) as u16, y: (at / width) as u16 };
        let known = inverse.iter().enumerate().filter(|(_, inverse)| **inverse > 0.0);
        Self { size, known: known.map(|(at, inverse)| (place(at), *inverse)).collect() }
    }

    /// Size of the frame.
    pub fn size(&self) -> FrameSize {
        self.size
    }

    /// Adds the `distances` of more `pixels`, in world units from the eye; infinite where the ray met nothing.
    #[must_use]
    pub fn with(mut self, (pixels, distances): (&[Pixel], &[f32])) -> Self {
        self.known.extend(pixels.iter().copied().zip(distances.iter().map(|distance| 1.0 / distance)));
        self
    }

    /// Depths in `region`, with pixel positions relative to its top left pixel.
    #[must_use]
    pub fn within(&self, region: Region) -> Self {
        let moved = |(pixel, inverse): &(Pixel, f32)| {
            let [x, y] = region.inside(pixel.x.into(), pixel.y.into())?;
            Some((Pixel { x: x as u16, y: y as u16 }, *inverse))
        };
        Self { size: region.size, known: self.known.iter().filter_map(moved).collect() }
    }

    /// Interpolates the depths to every pixel of the frame.
    pub fn filled(&self) -> Filled {
        let [known, nothing] = [self.put(vec![0.0; self.size.pixels()]), vec![0.0; self.size.pixels()]];
        let [inverse, _] = FilledNumbers::new(self.size, [known, nothing]).pictures();
        Filled { size: self.size, inverse }
    }

    /// Interpolates inverse distances to every pixel in two ways: from these samples alone, and from these together
    /// with those of `earlier` frames. Earlier samples are reprojected to this view; the nearest one wins at each
    /// pixel, and samples of this frame replace them.
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

    /// Reprojects these depths by `here` and raises `seen` to their inverse distances, so that the nearest remains.
    /// `seen` holds the bits of f32 values. None is negative, so the bits are in the order of the values.
    fn see(&self, here: &Reprojection, seen: &[AtomicU32]) {
        self.known.par_chunks(KNOWN_OF_TASK).for_each(|known| {
            Simd::best().vectorised(Seeing { known, here, size: self.size, seen });
        });
    }

    /// Overwrites `inverse` at the pixels whose depths are known.
    fn put(&self, mut inverse: Vec<f32>) -> Vec<f32> {
        for (pixel, known) in &self.known {
            inverse[pixel.index(self.size.width)] = *known;
        }
        inverse
    }
}

/// Pixels reprojected by one task.
const KNOWN_OF_TASK: usize = 4096;

/// Pixels reprojected at once.
const LANES: usize = 16;

/// SIMD operation that reprojects some pixels of another frame.
struct Seeing<'a> {
    known: &'a [(Pixel, f32)],
    here: &'a Reprojection,
    size: FrameSize,
    seen: &'a [AtomicU32],
}

impl SimdOp for Seeing<'_> {
    type Output = ();

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
    /// Writes the inverse distance `inverse` to the pixel at (`x`, `y`), if it lies in the frame and nothing nearer is
    /// there.
    #[inline(always)]
    fn put(&self, x: f32, y: f32, inverse: f32) {
        let (width, height) = (self.size.width as f32, self.size.height as f32);
        let (x, y) = (x + 0.5, y + 0.5);
        if inverse > 0.0 && x >= 0.0 && y >= 0.0 && x < width && y < height {
            // Casts to 32 bits take a single instruction, and suffice.
            let i = y as i32 as usize * self.size.width as usize + x as i32 as usize;
            raise(&self.seen[i], inverse.to_bits());
        }
    }
}

/// Positions of points in pixels, and their inverse distances; 0 for none.
#[derive(Default)]
struct Moved {
    x: [f32; LANES],
    y: [f32; LANES],
    inverse: [f32; LANES],
}

impl Moved {
    /// Moves the points to their positions in the other view, `here`. Points behind its eye get the inverse distance 0.
    #[inline(always)]
    fn make(&mut self, here: &Reprojection) {
        for lane in 0..LANES {
            let ([x, y], inverse) =
                here.point(self.x[lane], self.y[lane], self.inverse[lane]).unwrap_or(([0.0; 2], 0.0));
            (self.x[lane], self.y[lane], self.inverse[lane]) = (x, y, inverse);
        }
    }
}

/// Raises `number` to at least `to`. Most numbers need no change, so a plain read first avoids costly writes.
#[inline(always)]
fn raise(number: &AtomicU32, to: u32) {
    if number.load(Ordering::Relaxed) < to {
        number.fetch_max(to, Ordering::Relaxed);
    }
}

/// Depths of every pixel of a frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Filled {
    size: FrameSize,
    inverse: Vec<f32>,
}

impl Filled {
    /// Size of the frame.
    pub fn size(&self) -> FrameSize {
        self.size
    }

    /// Inverse distance of every pixel, row by row; all 0 if no depth is known.
    pub fn inverse(&self) -> &[f32] {
        &self.inverse
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fovol_core::{Camera, SampleList};

    /// Depths of pixels with their inverse distances.
    fn depths(size: FrameSize, known: &[(Pixel, f32)]) -> Depths {
        let list = SampleList::new(size, known.iter().map(|(pixel, _)| *pixel).collect());
        let distances = known.iter().map(|(_, inverse)| 1.0 / inverse).collect();
        Depths::new(&SparseFrame::new(list, vec![[0.0; 3]; known.len()], distances))
    }

    #[test]
    fn what_was_seen_before_is_seen_from_here_the_nearest_first() {
        let size = FrameSize::new(32, 24).unwrap();
        let [there, here] = [0.0, 4.0].map(|azimuth| Camera::on_sphere(azimuth, 5.0, 2.0, 40.0));
        let reprojection = Reprojection::new(&there, &here, size);
        let ([x, y], inverse) = reprojection.point(12.0, 9.0, 0.5).unwrap();
        let (x, y) = (x.round() as u32, y.round() as u32);
        let before = depths(size, &[(Pixel { x: 12, y: 9 }, 0.5)]);
        let behind = depths(size, &[(Pixel { x: x as u16, y: y as u16 }, 0.3)]);
        let same = Reprojection::new(&here, &here, size);
        let now = depths(size, &[(Pixel { x: 0, y: 0 }, 0.4)]);
        let [near, filled] = now.filled_with(&[(reprojection, &before), (same, &behind)]).pictures();
        assert_eq!(near, now.filled().inverse());
        assert!((filled[(y * 32 + x) as usize] - inverse).abs() < 1e-6);
        assert!((filled[0] - 0.4).abs() < 1e-6);
        // Rays of this frame met nothing there.
        let nothing = (Pixel { x: x as u16, y: y as u16 }, 0.0);
        let now = depths(size, &[(Pixel { x: 0, y: 0 }, 0.4), nothing]);
        let [_, filled] = now.filled_with(&[(reprojection, &before)]).pictures();
        assert!((filled[(y * 32 + x) as usize] - 0.4).abs() < 1e-6);
    }

    #[test]
    fn rays_that_met_nothing_are_not_known() {
        let size = FrameSize::new(4, 4).unwrap();
        let pixels = [Pixel { x: 1, y: 2 }, Pixel { x: 3, y: 3 }];
        let one = depths(size, &[(pixels[0], 0.0), (pixels[1], 0.5)]);
        assert!(one.filled().inverse().iter().all(|inverse| (inverse - 0.5).abs() < 1e-6));
        let nothing = depths(size, &pixels.map(|pixel| (pixel, 0.0)));
        assert!(nothing.filled().inverse().iter().all(|inverse| *inverse == 0.0));
    }
}
