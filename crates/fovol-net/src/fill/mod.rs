mod linear;
mod numbers;
mod pull_push;

use fovol_core::{Frame, SparseFrame};
pub use numbers::FilledNumbers;
use std::fmt;
use std::str::FromStr;

/// Reconstruction of a frame without training and history.
///
/// Sampled pixels keep their colours exactly; all others are filled. A frame without any sample becomes opaque black.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Fill {
    /// Pull-push: averages over growing squares (Gortler, Grzeszczuk, Szeliski, Cohen 1996).
    PullPush,
    /// Linear interpolation in the Delaunay triangulation of the samples. Outside it the nearest sample counts.
    Linear,
}

impl Fill {
    /// Reconstructs the full frame of `sparse`, with alpha 1 everywhere.
    pub fn reconstruct(self, sparse: &SparseFrame) -> Frame {
        match self {
            Self::PullPush => pull_push::pull_push(sparse),
            Self::Linear => linear::linear(sparse),
        }
    }
}

impl fmt::Display for Fill {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::PullPush => "pull-push",
            Self::Linear => "linear",
        })
    }
}

impl FromStr for Fill {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.to_ascii_lowercase().as_str() {
            "pull-push" => Ok(Self::PullPush),
            "linear" => Ok(Self::Linear),
            _ => Err(format!("`{text}` is no reconstruction; use pull-push or linear")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fovol_core::{FrameSize, Pixel, SampleList, SampleMask};
    use proptest::prelude::*;

    fn size(w: u32, h: u32) -> FrameSize {
        FrameSize::new(w, h).unwrap()
    }

    fn sparse(size: FrameSize, mask: &SampleMask, colour: impl Fn(u32, u32) -> [f32; 3]) -> SparseFrame {
        let every = (0..size.height).flat_map(|y| (0..size.width).map(move |x| [x, y]));
        let sampled: Vec<[u32; 2]> = every.filter(|[x, y]| mask.contains(*x, *y)).collect();
        let pixels = sampled.iter().map(|[x, y]| Pixel { x: *x as u16, y: *y as u16 }).collect();
        let colours = sampled.iter().map(|[x, y]| colour(*x, *y)).collect();
        SparseFrame::new(SampleList::new(size, pixels), colours, vec![1.0; sampled.len()])
    }

    #[test]
    fn no_sample_is_black_and_one_spreads_everywhere() {
        for fill in [Fill::PullPush, Fill::Linear] {
            let empty = SparseFrame::from(&Frame::new(size(7, 5)));
            assert!(fill.reconstruct(&empty).pixels().iter().all(|p| *p == [0.0, 0.0, 0.0, 1.0]), "{fill}");
            let one =
                sparse(size(13, 9), &SampleMask::from_fn(size(13, 9), |x, y| x == 3 && y == 2), |_, _| {
                    [0.25; 3]
                });
            for p in fill.reconstruct(&one).pixels() {
                assert!((p[0] - 0.25).abs() < 1e-6 && p[3] == 1.0, "{fill} {p:?}");
            }
        }
    }

    #[test]
    fn linear_meets_a_plane_inside_the_hull() {
        let size = size(40, 30);
        let corners = [(0, 0), (39, 0), (0, 29), (39, 29), (17, 11), (5, 22), (30, 9)];
        let plane =
            |x: u32, y: u32| [x as f32 * 0.02, y as f32 * 0.03, 0.1 + x as f32 * 0.01 + y as f32 * 0.005];
        let frame = sparse(size, &SampleMask::from_fn(size, |x, y| corners.contains(&(x, y))), plane);
        let full = Fill::Linear.reconstruct(&frame);
        for y in 0..30 {
            for x in 0..40 {
                let expected = plane(x, y);
                let found = full.pixel(x, y);
                assert!(
                    (0..3).all(|c| (found[c] - expected[c]).abs() < 1e-5),
                    "{x},{y}: {found:?} {expected:?}"
                );
            }
        }
    }

    #[test]
    fn samples_in_a_line_do_no_harm() {
        let size = size(20, 20);
        for mask in [SampleMask::from_fn(size, |x, _| x == 4), SampleMask::from_fn(size, |x, y| x == y)] {
            let full = Fill::Linear.reconstruct(&sparse(size, &mask, |_, y| [y as f32 / 20.0; 3]));
            assert!(full.pixels().iter().all(|p| p[3] == 1.0 && (0.0..=1.0).contains(&p[0])));
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(48))]
        #[test]
        fn samples_are_kept_and_the_rest_stays_in_range(
            w in 1u32..40, h in 1u32..40, seed in 0u32..1000, density in 1u32..60,
        ) {
            let size = size(w, h);
            let random = |x: u32, y: u32| (x.wrapping_mul(73_856_093) ^ y.wrapping_mul(19_349_663) ^ seed.wrapping_mul(83_492_791)).wrapping_mul(2_654_435_761) >> 8;
            let mask = SampleMask::from_fn(size, |x, y| random(x, y) % 100 < density);
            let frame = sparse(size, &mask, |x, y| [random(y, x) as f32 % 97.0 / 97.0, 0.5, 0.2]);
            for fill in [Fill::PullPush, Fill::Linear] {
                let full = fill.reconstruct(&frame);
                for (a, b) in frame.to_frame().pixels().iter().zip(full.pixels()) {
                    prop_assert!(a[3] == 0.0 || a == b);
                    prop_assert!(b[3] == 1.0 && b[..3].iter().all(|c| (-1e-5..=1.00001).contains(c)));
                }
            }
        }
    }
}
