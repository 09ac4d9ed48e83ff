use crate::{Frame, FrameSize, Projection, RayBasis};
use glam::DVec3;
use rayon::prelude::*;

/// Rectangle of pixels of a frame; never empty.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Region {
    /// First column.
    pub x: u32,
    /// First row.
    pub y: u32,
    /// Width and height.
    pub size: FrameSize,
}

impl Region {
    /// Region of a whole frame of `size`.
    pub fn whole(size: FrameSize) -> Self {
        Self { x: 0, y: 0, size }
    }

    /// Smallest region of a frame of `size` with every pixel whose ray meets one of `boxes`.
    ///
    /// A box is given by its lowest and its highest corner. `None` if no ray meets a box. The whole frame if a box
    /// reaches from in front of the eye to behind it.
    pub fn of_boxes(
        rays: &RayBasis,
        boxes: impl IntoIterator<Item = [DVec3; 2]>,
        size: FrameSize,
    ) -> Option<Self> {
        let axes = rays.axes().map(|axis| axis / axis.length_squared());
        let seen = |way: DVec3| DVec3::from_array(axes.map(|axis| way.dot(axis)));
        let units = [DVec3::X, DVec3::Y, DVec3::Z].map(seen);
        let mut ends = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
        for [low, high] in boxes {
            let extent = (high - low).to_array();
            let edges = std::array::from_fn(|axis| units[axis] * extent[axis]);
            match Outline::of_box(seen(low - rays.origin()), edges, rays.projection()) {
                Outline::None => {}
                Outline::Everywhere => return Some(Self::whole(size)),
                Outline::Between(outline) => {
                    for (ends, more) in ends.iter_mut().zip(outline) {
                        *ends = [ends[0].min(more[0]), ends[1].max(more[1])];
                    }
                }
            }
        }
        // Rounded outwards, so that rays through corners count as inside.
        let along = |ends: [f64; 2], count: u32| {
            let [first, last] = ends.map(|at| (1.0 + at) * 0.5 * f64::from(count) - 0.5);
            let [first, end] =
                [first.floor(), last.ceil() + 1.0].map(|at| at.clamp(0.0, f64::from(count)) as u32);
            (first < end).then(|| [first, end - first])
        };
        let [x, width] = along(ends[0], size.width)?;
        let [y, height] = along(ends[1], size.height)?;
        Some(Self { x, y, size: FrameSize { width, height } })
    }

    /// Number of pixels.
    pub fn pixels(&self) -> usize {
        self.size.pixels()
    }

    /// Position of pixel (`x`, `y`) of the frame relative to the region's top left pixel; `None` outside the region.
    #[inline]
    pub fn inside(&self, x: u32, y: u32) -> Option<[u32; 2]> {
        let along = |at: u32, first: u32, length: u32| at.checked_sub(first).filter(|at| *at < length);
        Some([along(x, self.x, self.size.width)?, along(y, self.y, self.size.height)?])
    }

    /// Whether `other` lies completely in this region.
    pub fn contains(&self, other: &Self) -> bool {
        let ends = |region: &Self| [region.x + region.size.width, region.y + region.size.height];
        let (mine, others) = (ends(self), ends(other));
        self.x <= other.x && self.y <= other.y && others[0] <= mine[0] && others[1] <= mine[1]
    }

    /// Grows the region by `margin` pixels, and moves its edges outwards to multiples of `multiple`; clamped to a
    /// frame of `size`.
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

    /// Index range of each of the region's rows in an image of `width` columns, from the top.
    pub fn rows(self, width: u32) -> impl Iterator<Item = std::ops::Range<usize>> {
        let length = self.size.width as usize;
        (self.y..self.y + self.size.height).map(move |y| {
            let first = y as usize * width as usize + self.x as usize;
            first..first + length
        })
    }

    /// Copies the region out of `pixels`, in rows of `width`.
    pub fn part<T: Copy + Default + Send + Sync>(self, pixels: &[T], width: u32) -> Vec<T> {
        let mut part = vec![T::default(); self.size.pixels()];
        let rows = part.par_chunks_exact_mut(self.size.width as usize);
        rows.zip(pixels.par_chunks_exact(width as usize).skip(self.y as usize)).for_each(|(to, row)| {
            to.copy_from_slice(&row[self.x as usize..][..to.len()]);
        });
        part
    }

    /// Copies the region out of `frame`.
    pub fn of(self, frame: &Frame) -> Frame {
        let pixels = self.part(frame.pixels(), frame.size().width);
        Frame::from_pixels(self.size, pixels).expect("the part has as many pixels")
    }

    /// Copies `part`, which has the region's size, to the region's place in `pixels`, in rows of `width`.
    pub fn put_part<T: Copy + Send + Sync>(self, part: &[T], pixels: &mut [T], width: u32) {
        let rows = pixels.par_chunks_exact_mut(width as usize).skip(self.y as usize);
        rows.zip(part.par_chunks_exact(self.size.width as usize)).for_each(|(row, from)| {
            row[self.x as usize..][..from.len()].copy_from_slice(from);
        });
    }

    /// Frame of `size` with `part`, which has the region's size, in the region and the colour `around` elsewhere.
    pub fn framed(self, part: &Frame, around: [f32; 4], size: FrameSize) -> Frame {
        let mut pixels = vec![[0.0; 4]; size.pixels()];
        let columns = self.x as usize..(self.x + self.size.width) as usize;
        let rows = pixels.par_chunks_exact_mut(size.width as usize).enumerate();
        rows.for_each(|(y, row)| match y.checked_sub(self.y as usize) {
            Some(y) if y < self.size.height as usize => {
                row[..columns.start].fill(around);
                row[columns.clone()].copy_from_slice(&part.pixels()[y * columns.len()..][..columns.len()]);
                row[columns.end..].fill(around);
            }
            _ => row.fill(around),
        });
        Frame::from_pixels(size, pixels).expect("there are as many pixels")
    }
}

/// Bounding rectangle of a box in the picture.
enum Outline {
    /// Completely behind the eye.
    None,
    /// Range along x (right) and y (down), with −1 to 1 in the frame.
    Between([[f64; 2]; 2]),
    /// Unknown, because the box reaches from in front of the eye to behind it.
    Everywhere,
}

impl Outline {
    /// Outline of the box at `corner` with the given `edges`. Coordinates are depth, and right and up in units that
    /// reach the frame's edges at 1 times the depth, or at 1 with parallel rays.
    fn of_box(corner: DVec3, edges: [DVec3; 3], projection: Projection) -> Self {
        let (mut behind, mut ends) = (0, [[f64::INFINITY, f64::NEG_INFINITY]; 2]);
        for number in 0..8 {
            let ways = edges.iter().enumerate().filter(|(bit, _)| number >> bit & 1 == 1);
            let at = ways.fold(corner, |at, (_, edge)| at + edge);
            let depth = match projection {
                Projection::Perspective => at.x,
                Projection::Orthographic => 1.0,
            };
            if depth < 1e-6 {
                behind += 1;
                continue;
            }
            for (ends, at) in ends.iter_mut().zip([at.y / depth, -at.z / depth]) {
                *ends = [ends[0].min(at), ends[1].max(at)];
            }
        }
        match behind {
            0 => Self::Between(ends),
            8 => Self::None,
            _ => Self::Everywhere,
        }
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
            let region = Region::of_boxes(&rays, [[low, low + extent]], SIZE);
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
    fn what_is_not_seen_has_no_region_and_what_is_around_the_eye_the_whole_frame() {
        let rays = Camera::on_sphere(0.0, 0.0, 2.0, 30.0).rays(SIZE);
        let near = |centre: DVec3| [centre - 0.1, centre + 0.1];
        let seen =
            |centres: &[DVec3]| Region::of_boxes(&rays, centres.iter().map(|&centre| near(centre)), SIZE);
        assert_eq!(seen(&[]), None);
        let aside = DVec3::new(3.0, 0.0, 0.0);
        assert_eq!(seen(&[aside]), None);
        assert_eq!(seen(&[DVec3::Z * 3.0]), None);
        assert_eq!(seen(&[DVec3::Z * 2.0]), Some(Region::whole(SIZE)));
        let middle = seen(&[DVec3::ZERO]).unwrap();
        assert!(middle.pixels() < 60 && middle.x > 10 && middle.y > 6, "{middle:?}");
        let [left, right] = [-0.3, 0.3].map(|x| seen(&[DVec3::X * x]).unwrap());
        let both = seen(&[DVec3::X * 0.3, DVec3::X * -0.3]).unwrap();
        assert!(both.contains(&left) && both.contains(&right) && both.size.height == middle.size.height);
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
        let other = region.framed(&part, [0.5; 4], SIZE);
        assert_eq!(other.pixel(6, 6), frame.pixel(6, 6));
        for (x, y) in [(2, 6), (7, 6), (6, 1), (6, 7)] {
            assert_eq!(other.pixel(x, y), [0.5; 4]);
        }
    }
}
