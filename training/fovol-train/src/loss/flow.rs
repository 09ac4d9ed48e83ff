//! Motion between frames: warping, confidence and block matching.

use super::ssim::gaussian;
use crate::network::layers;
use serde::{Deserialize, Serialize};
use tch::{Kind, Tensor};

/// Luma weights of red, green and blue (ITU-R BT.601), as in the authors' training code.
const GREY: [f64; 3] = [0.2989, 0.587, 0.114];
/// Side of the compared patches, in pixels.
const PATCH: i64 = 5;
/// Standard deviation of the Gaussian patch weights, in pixels.
const PATCH_SIGMA: f64 = 2.0;
/// Side of the median filter over motion that a coarser level passes on, in pixels.
const MEDIAN: i64 = 5;
/// Offsets evaluated at once.
const TOGETHER: usize = 25;
/// Lower bound of divisors.
const SMALLEST: f64 = 1e-12;

/// Source of the motion between frames.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum FlowSource {
    /// Motion of the renderer, which the clip provides.
    Exact,
    /// [`FlowSearch::single_level`] between the references, as in the authors' training.
    #[default]
    SingleLevel,
    /// [`FlowSearch::hierarchical`] between the references.
    Hierarchical,
}

impl FlowSource {
    /// The search that finds the motion, or `None` if the clip provides it.
    pub fn search(self) -> Option<FlowSearch> {
        match self {
            Self::Exact => None,
            Self::SingleLevel => Some(FlowSearch::single_level()),
            Self::Hierarchical => Some(FlowSearch::hierarchical()),
        }
    }
}

/// Samples `images` \[N, C, H, W\] at the positions that `motion` \[N, 2, H, W\] points to.
///
/// Motion is the offset in pixels to the previous position, x right, then y down. Interpolation is bilinear; the
/// result is 0 outside the frame and where the motion is NaN. The layer `Warp` of a plan does this at full resolution
/// (`fovol-net/src/cpu/warp.rs`).
pub fn warp(images: &Tensor, motion: &Tensor) -> Tensor {
    layers::warp(images, motion)
}

/// Confidence mask of the motion, as in DeepFovea: Σ_c |`reference` − warp(`previous`)| < `most`.
///
/// Frames are \[N, C, H, W\] and motion is \[N, 2, H, W\]. Returns booleans \[N, 1, H, W\].
pub fn confidence(reference: &Tensor, previous: &Tensor, motion: &Tensor, most: f64) -> Tensor {
    (reference - warp(previous, motion)).abs().sum_dim_intlist([1i64].as_slice(), true, None).lt(most)
}

/// Block matching in the manner of Hanika et al., "Fast temporal reprojection without motion vectors" (2021).
///
/// Each pixel takes the offset in a square window at which the grey pictures differ least. The cost is |a − b|,
/// summed over 5×5 pixels with Gaussian weights of σ = 2. The smallest of equally good offsets wins. The motion of a
/// coarser level is refined to subpixels and median-filtered; the next finer level starts from it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FlowSearch {
    /// Number of resolutions, each half the one before.
    pub levels: usize,
    /// Largest offset along each axis, in pixels of a level.
    pub radius: i64,
}

impl FlowSearch {
    /// Settings of the authors' training code: full resolution, 15×15 offsets.
    pub const fn single_level() -> Self {
        Self { levels: 1, radius: 7 }
    }

    /// Four resolutions with 5×5 offsets each; reaches 30 pixels in all.
    pub const fn hierarchical() -> Self {
        Self { levels: 4, radius: 2 }
    }

    /// Motion from `current` to `previous`, both \[N, 3, H, W\]: \[N, 2, H, W\] in whole pixels, x right, then y
    /// down. Has no gradient.
    pub fn motion(&self, current: &Tensor, previous: &Tensor) -> Tensor {
        tch::no_grad(|| self.at_level(1, &grey(current), &grey(previous)))
    }

    /// Motion at `level`, counted from 1, between grey pictures of that resolution.
    fn at_level(&self, level: usize, current: &Tensor, previous: &Tensor) -> Tensor {
        let start = if level < self.levels {
            let coarser = self.at_level(level + 1, &halved(current), &halved(previous));
            doubled(&coarser, current)
        } else {
            Tensor::cat(&[current, current], 1).zeros_like()
        };
        self.refined(current, previous, &start, level > 1)
    }

    /// Best offset of each pixel from `start` (whole pixels). If `is_coarse`, the result is refined to subpixels and
    /// median-filtered.
    fn refined(&self, current: &Tensor, previous: &Tensor, start: &Tensor, is_coarse: bool) -> Tensor {
        let offsets = self.offsets();
        let mut least = current.full_like(f64::INFINITY);
        let mut choice = current.zeros_like().to_kind(Kind::Int64);
        let mut distances = Vec::new();
        let window = Window::new(previous, start, self.radius);
        for (first, some) in (0..).step_by(TOGETHER).zip(offsets.chunks(TOGETHER)) {
            let distance = smoothed(&(current - window.at(some)).abs());
            for (i, distance) in (first..).zip(distance.split(1, 1)) {
                choice = choice.masked_fill(&distance.lt_tensor(&least), i);
                least = least.minimum(&distance);
            }
            if is_coarse {
                distances.push(distance);
            }
        }
        let table = Tensor::from_slice2(&offsets).to_kind(current.kind());
        let motion = start + looked_up(&table, &choice);
        if is_coarse { median(&(motion + between(&distances, &choice, &offsets))) } else { motion }
    }

    /// All offsets of the window, \[x, y\], smallest first.
    fn offsets(&self) -> Vec<[i64; 2]> {
        let range = -self.radius..=self.radius;
        let mut offsets: Vec<[i64; 2]> =
            range.clone().flat_map(|y| range.clone().map(move |x| [x, y])).collect();
        offsets.sort_by_key(|[x, y]| x * x + y * y);
        offsets
    }
}

/// Window of a picture around the positions that a motion points to.
///
/// Unlike [`warp`] it copies values without arithmetic, so that equal costs stay exactly equal.
struct Window {
    /// The picture row by row, with a margin of zeros: \[N, values\].
    numbers: Tensor,
    /// Index of the target of each pixel: \[N, 1, H, W\].
    at: Tensor,
    /// Values from one row to the next.
    stride: i64,
}

impl Window {
    /// Prepares offsets of up to `radius` around the targets of `motion` \[N, 2, H, W\] (whole pixels) in `images`
    /// \[N, 1, H, W\].
    fn new(images: &Tensor, motion: &Tensor, radius: i64) -> Self {
        let [n, _, height, width] = four(images);
        // From this distance on, no offset leads back into the picture.
        let beyond = radius + 1;
        let margin = beyond + radius;
        let padded = images.constant_pad_nd([margin; 4]);
        let stride = width + 2 * margin;
        let along = |axis: i64, count: i64, shape: [i64; 4]| {
            let positions = Tensor::arange(count, (Kind::Int64, images.device())).view(shape);
            let there = motion.narrow(1, axis, 1).to_kind(Kind::Int64) + positions;
            there.clamp(-beyond, count - 1 + beyond) + margin
        };
        let at = along(1, height, [1, 1, height, 1]) * stride + along(0, width, [1, 1, 1, width]);
        Self { numbers: padded.reshape([n, -1]), at, stride }
    }

    /// Values at each of `offsets`, \[x, y\]: \[N, offsets, H, W\]; 0 outside the picture.
    fn at(&self, offsets: &[[i64; 2]]) -> Tensor {
        let [n, _, height, width] = four(&self.at);
        let steps: Vec<i64> = offsets.iter().map(|[x, y]| y * self.stride + x).collect();
        let steps = Tensor::from_slice(&steps).to_device(self.at.device()).view([1, -1, 1, 1]);
        let at = (&self.at + steps).view([n, -1]);
        self.numbers.gather(1, &at, false).view([n, -1, height, width])
    }
}

/// Rows of `table` \[K, C\] selected by `choice` \[N, 1, H, W\]: \[N, C, H, W\].
fn looked_up(table: &Tensor, choice: &Tensor) -> Tensor {
    let [n, _, height, width] = four(choice);
    let rows = table.to_device(choice.device()).index_select(0, &choice.reshape([-1]));
    rows.view([n, height, width, -1]).permute([0, 3, 1, 2])
}

/// Subpixel position of the minimum around the chosen offset along each axis, in −½…½: \[N, 2, H, W\].
///
/// Absolute differences grow linearly away from their minimum, with one slope on both sides. The steeper of the two
/// observed slopes is used.
fn between(distances: &[Tensor], choice: &Tensor, offsets: &[[i64; 2]]) -> Tensor {
    let distances = Tensor::cat(distances, 1);
    let least = distances.gather(1, choice, false);
    let index = |x: i64, y: i64| offsets.iter().position(|&offset| offset == [x, y]).map(|at| at as i64);
    let along = [[1, 0], [0, 1]].map(|[dx, dy]| {
        // At the border of the window one of the two neighbours is unknown.
        let sides = |(at, &[x, y]): (usize, &[i64; 2])| match (index(x - dx, y - dy), index(x + dx, y + dy)) {
            (Some(before), Some(after)) => [before, after],
            _ => [at as i64; 2],
        };
        let table: Vec<[i64; 2]> = offsets.iter().enumerate().map(sides).collect();
        let sides = distances.gather(1, &looked_up(&Tensor::from_slice2(&table), choice), false);
        let (before, after) = (sides.narrow(1, 0, 1), sides.narrow(1, 1, 1));
        let slope = before.maximum(&after) - &least;
        (before - after) / (slope * 2.0).clamp_min(SMALLEST)
    });
    // A perfect match stays in place, even if a flat neighbourhood matches equally well.
    Tensor::cat(&along, 1).clamp(-0.5, 0.5) * least.gt(0.0).to_kind(least.kind())
}

/// Median of each component of `motion` around each pixel, with replicated borders.
fn median(motion: &Tensor) -> Tensor {
    let padded = motion.replication_pad2d([MEDIAN / 2; 4]);
    padded.unfold(2, MEDIAN, 1).unfold(3, MEDIAN, 1).flatten(-2, -1).median_dim(-1, false).0
}

/// Size of a four-dimensional tensor.
fn four(tensor: &Tensor) -> [i64; 4] {
    let size = tensor.size();
    std::array::from_fn(|i| size[i])
}

/// Grey pictures \[N, 1, H, W\] of RGB pictures.
fn grey(colour: &Tensor) -> Tensor {
    let shares = Tensor::from_slice(&GREY).to_kind(colour.kind()).to_device(colour.device());
    (colour * shares.view([1, 3, 1, 1])).sum_dim_intlist([1i64].as_slice(), true, None)
}

/// Downsamples to half the size, rounded up, by averages of the existing pixels.
fn halved(images: &Tensor) -> Tensor {
    images.avg_pool2d([2, 2], [2, 2], [0, 0], true, false, None)
}

/// Upsamples motion of half the resolution to the size of `like`, in whole pixels of that size.
fn doubled(motion: &Tensor, like: &Tensor) -> Tensor {
    let ([_, _, half_height, half_width], [_, _, height, width]) = (four(motion), four(like));
    let between = motion.upsample_bilinear2d([2 * half_height, 2 * half_width], false, 2.0, 2.0) * 2.0;
    between.narrow(2, 0, height).narrow(3, 0, width).round()
}

/// Sums `distances` \[N, K, H, W\] over the patch around each pixel; zero outside.
fn smoothed(distances: &Tensor) -> Tensor {
    let window = gaussian(PATCH, PATCH_SIGMA, distances);
    let window = window.view([1, 1, -1, 1]) * window.view([1, 1, 1, -1]);
    let count = distances.size()[1];
    let windows = window.expand([count, 1, PATCH, PATCH], false).contiguous();
    distances.conv2d::<Tensor>(&windows, None, 1, PATCH / 2, 1, count)
}

#[cfg(test)]
mod tests {
    use super::super::testing::{EXACT, pictures};
    use super::*;
    use tch::Device;

    const SINGLE: (Kind, Device) = (Kind::Float, Device::Cpu);

    /// Two pictures of one texture: the point at p in the first lies at p + (`x`, `y`) in the second.
    fn shifted([height, width]: [i64; 2], [x, y]: [i64; 2]) -> [Tensor; 2] {
        let [tall, wide] = [height + 64, width + 64];
        // Noise at several scales, like natural pictures.
        let noise = |size: i64| {
            let small = (pictures([2, tall / size, wide / size], 77.0, SINGLE) * 43758.547).frac();
            small.upsample_bilinear2d([tall, wide], false, None, None)
        };
        let large = noise(1) * 0.1 + noise(2) * 0.1 + noise(4) * 0.2 + noise(8) * 0.3 + noise(16) * 0.3;
        let part = |x: i64, y: i64| large.narrow(2, 32 + y, height).narrow(3, 32 + x, width);
        // The previous picture shows at p + offset what the current one shows at p.
        [part(0, 0), part(-x, -y)]
    }

    #[test]
    fn block_matching_finds_shifts() {
        let cases = [
            (FlowSearch::single_level(), 0.99, vec![[0, 0], [3, -2], [-7, 7], [6, 1]]),
            (FlowSearch::hierarchical(), 0.95, vec![[0, 0], [3, -2], [-13, 9], [20, -18]]),
        ];
        for (search, least, shifts) in cases {
            for shift in shifts {
                let [current, previous] = shifted([256, 240], shift);
                let motion = search.motion(&current, &previous);
                assert_eq!(motion.size(), [2, 2, 256, 240]);
                // Compare only where the search sees whole patches.
                let expected = Tensor::from_slice(&shift).to_kind(Kind::Float).view([1, 2, 1, 1]);
                let inner = motion.narrow(2, 64, 128).narrow(3, 64, 112);
                let right = inner.eq_tensor(&expected).all_dim(1, false).to_kind(Kind::Float);
                let share = right.mean(None).double_value(&[]);
                assert!(share > least, "{search:?} {shift:?}: {share}");
            }
        }
    }

    #[test]
    fn what_is_the_same_everywhere_does_not_move() {
        let flat = Tensor::full([1, 3, 33, 41], 0.3, SINGLE);
        for search in [FlowSearch::single_level(), FlowSearch::hierarchical()] {
            let motion = search.motion(&flat, &flat);
            assert_eq!(motion.size(), [1, 2, 33, 41]);
            assert_eq!(motion.abs().max().double_value(&[]), 0.0);
        }
    }

    #[test]
    fn following_the_motion_gives_what_is_there() {
        let [current, previous] = shifted([64, 64], [5, -3]);
        let motion = FlowSearch::single_level().motion(&current, &previous);
        let trusted = confidence(&current, &previous, &motion, 0.1).to_kind(Kind::Float);
        assert_eq!(trusted.size(), [2, 1, 64, 64]);
        assert!(trusted.narrow(2, 16, 32).narrow(3, 16, 32).mean(None).double_value(&[]) > 0.99);
        let still = motion.zeros_like();
        assert!(
            confidence(&current, &previous, &still, 0.1).to_kind(Kind::Float).mean(None).double_value(&[])
                < 0.5
        );
    }

    #[test]
    fn whole_steps_move_and_the_outside_is_zero() {
        let images = Tensor::arange_start(1, 13, EXACT).view([1, 1, 3, 4]);
        let motion = Tensor::from_slice(&[1.0, -2.0]).view([1, 2, 1, 1]).expand([1, 2, 3, 4], false);
        let moved = warp(&images, &motion);
        let expected =
            Tensor::from_slice(&[0., 0., 0., 0., 0., 0., 0., 0., 2., 3., 4., 0.]).view([1, 1, 3, 4]);
        assert!(moved.allclose(&expected, 0.0, 1e-12, false));
        let nowhere = warp(&images, &motion.full_like(f64::NAN));
        assert_eq!(nowhere.abs().max().double_value(&[]), 0.0);
    }
}
