use crate::{Frame, FrameSize, RayBasis};
use glam::DVec3;
use rayon::prelude::*;

/// A rectangle of pixels of a frame; never empty.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Region {
    /// Its first column.
    pub x: u32,
    /// Its first row.
    pub y: u32,
    /// How large it is.
    pub size: FrameSize,
}

impl Region {
    /// All of a frame of `size`.
    pub fn whole(size: FrameSize) -> Self {
        Self { x: 0, y: 0, size }
    }

    /// The smallest region of a frame of `size` that has every pixel whose ray of `rays` meets the box from `low` to `high`;
    /// `None` if none does. All of the frame where the box reaches behind the eye.
    pub fn of_box(rays: &RayBasis, [low, high]: [DVec3; 2], size: FrameSize) -> Option<Self> {
        let [forward, right, up] = rays.axes();
        let mut ends = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
        for corner in 0..8 {
            let chosen = |axis: usize| if corner >> axis & 1 == 0 { low[axis] } else { high[axis] };
            let to = DVec3::new(chosen(0), chosen(1), chosen(2)) - rays.origin();
            let ahead = to.dot(forward) / forward.length_squared();
            if ahead < 1e-6 {
                return Some(Self::whole(size));
            }
            let across = to.dot(right) / (right.length_squared() * ahead);
            let above = to.dot(up) / (up.length_squared() * ahead);
            let place = [
                (1.0 + across) * 0.5 * f64::from(size.width) - 0.5,
                (1.0 - above) * 0.5 * f64::from(size.height) - 0.5,
            ];
            for (ends, at) in ends.iter_mut().zip(place) {
                *ends = [ends[0].min(at), ends[1].max(at)];
            }
        }
        // Rounded outwards: rays through corners are as good as inside.
        let along = |[first, last]: [f64; 2], count: u32| {
            let [first, end] =
                [first.floor(), last.ceil() + 1.0].map(|at| at.clamp(0.0, f64::from(count)) as u32);
            (first < end).then_some([first, end - first])
        };
        let [x, width] = along(ends[0], size.width)?;
        let [y, height] = along(ends[1], size.height)?;
        Some(Self { x, y, size: FrameSize { width, height } })
    }

    /// How many pixels it has.
    pub fn pixels(&self) -> usize {
        self.size.pixels()
    }

    /// Whether all of `other` lies in it.
    pub fn contains(&self, other: &Self) -> bool {
        let ends = |region: &Self| [region.x + region.size.width, region.y + region.size.height];
        let (mine, others) = (ends(self), ends(other));
        self.x <= other.x && self.y <= other.y && others[0] <= mine[0] && others[1] <= mine[1]
    }

    /// The region with a border of `margin` pixels, its edges moved outwards to multiples of `multiple` where that does not lead
    /// beyond a frame of `size`.
    #[must_use]
    pub fn grown(&self, margin: u32, multiple: u32, size: FrameSize) -> Self {
        let along = |first: u32, length: u32, count: u32| {
            let end = (first + length + margin).next_multiple_of(multiple).min(count);
            let first = first.saturating_sub(margin) / multiple * multiple;
            [first, end - first]
        };
        let [x, width] = along(self.x, self.size.width, size.width);
        let [y, height] = along(self.y, self.size.height, size.height);
        Self { x, y, size: FrameSize { width, height } }
    }

    /// The rows of it of an image of `width` columns, from the top: where in the image each begins and ends.
    pub fn rows(self, width: u32) -> impl Iterator<Item = std::ops::Range<usize>> {
        let length = self.size.width as usize;
        (self.y..self.y + self.size.height).map(move |y| {
            let first = y as usize * width as usize + self.x as usize;
            first..first + length
        })
    }

    /// The part of `pixels`, in rows of `width`, that it is.
    pub fn part<T: Copy + Default + Send + Sync>(self, pixels: &[T], width: u32) -> Vec<T> {
        let mut part = vec![T::default(); self.size.pixels()];
        let rows = part.par_chunks_exact_mut(self.size.width as usize);
        rows.zip(pixels.par_chunks_exact(width as usize).skip(self.y as usize)).for_each(|(to, row)| {
            to.copy_from_slice(&row[self.x as usize..][..to.len()]);
        });
        part
    }

    /// The part of `frame` that it is.
    pub fn of(self, frame: &Frame) -> Frame {
        let pixels = self.part(frame.pixels(), frame.size().width);
        Frame::from_pixels(self.size, pixels).expect("the part has as many pixels")
    }

    /// Puts the pixels of `part`, which has its size, where they are among `pixels`, in rows of `width`.
    pub fn put_part<T: Copy + Send + Sync>(self, part: &[T], pixels: &mut [T], width: u32) {
        let rows = pixels.par_chunks_exact_mut(width as usize).skip(self.y as usize);
        rows.zip(part.par_chunks_exact(self.size.width as usize)).for_each(|(row, from)| {
            row[self.x as usize..][..from.len()].copy_from_slice(from);
        });
    }

    /// Puts `part`, which has its size, where it is in `frame`.
    pub fn put(self, part: &Frame, frame: &mut Frame) {
        let width = frame.size().width;
        self.put_part(part.pixels(), frame.pixels_mut(), width);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Camera;
    use proptest::prelude::*;

    const SIZE: FrameSize = FrameSize { width: 37, height: 23 };

    proptest! {
        #[test]
        fn every_ray_that_meets_the_box_is_in_the_region(
            azimuth in 0.0f64..360.0, elevation in -89.0f64..89.0, distance in 0.1f64..3.0, fovy in 5.0f64..120.0,
            low in prop::array::uniform3(-0.5f64..0.4), extent in prop::array::uniform3(0.01f64..0.4),
        ) {
            let (low, extent) = (DVec3::from_array(low), DVec3::from_array(extent));
            let camera = Camera { target: DVec3::splat(0.1), ..Camera::on_sphere(azimuth, elevation, distance, fovy) };
            let rays = camera.rays(SIZE);
            let region = Region::of_box(&rays, [low, low + extent], SIZE);
            let centre = low + extent * 0.5;
            for (x, y) in (0..23).flat_map(|y| (0..37).map(move |x| (x, y))) {
                let mut ray = rays.ray(x, y);
                ray.origin -= centre;
                if ray.clip_to(extent * 0.5).is_some() {
                    let pixel = Region { x, y, size: FrameSize { width: 1, height: 1 } };
                    prop_assert!(region.is_some_and(|region| region.contains(&pixel)), "{x} {y} {region:?}");
                }
            }
        }
    }

    #[test]
    fn what_is_not_seen_has_no_region_and_what_is_behind_the_whole_frame() {
        let rays = Camera::on_sphere(0.0, 0.0, 2.0, 30.0).rays(SIZE);
        let near = |centre: DVec3| [centre - 0.1, centre + 0.1];
        assert_eq!(Region::of_box(&rays, near(DVec3::new(3.0, 0.0, 0.0)), SIZE), None);
        assert_eq!(Region::of_box(&rays, near(DVec3::Z * 2.0), SIZE), Some(Region::whole(SIZE)));
        let middle = Region::of_box(&rays, near(DVec3::ZERO), SIZE).unwrap();
        assert!(middle.pixels() < 60 && middle.x > 10 && middle.y > 6, "{middle:?}");
    }

    #[test]
    fn regions_grow_to_multiples_and_stay_in_the_frame() {
        let region = Region { x: 9, y: 1, size: FrameSize { width: 5, height: 20 } };
        let grown = region.grown(4, 8, SIZE);
        assert_eq!(grown, Region { x: 0, y: 0, size: FrameSize { width: 24, height: 23 } });
        assert!(grown.contains(&region) && !region.contains(&grown));
    }

    #[test]
    fn parts_are_taken_out_and_put_back() {
        let mut frame = Frame::new(SIZE);
        frame.pixels_mut().iter_mut().enumerate().for_each(|(i, p)| *p = [i as f32; 4]);
        let region = Region { x: 3, y: 2, size: FrameSize { width: 4, height: 5 } };
        let part = region.of(&frame);
        assert_eq!(part.pixel(0, 0), frame.pixel(3, 2));
        assert_eq!(part.pixel(3, 4), frame.pixel(6, 6));
        let mut other = Frame::new(SIZE);
        region.put(&part, &mut other);
        assert_eq!(other.pixel(6, 6), frame.pixel(6, 6));
        assert_eq!(other.pixel(7, 6), [0.0; 4]);
    }
}
