//! Motion between frames: following it, trusting it, and finding it.

use super::ssim::gaussian;
use crate::network::layers;
use serde::{Deserialize, Serialize};
use tch::{Kind, Tensor};

/// The shares of red, green and blue in grey (ITU-R BT.601), which the authors' training code takes.
const GREY: [f64; 3] = [0.2989, 0.587, 0.114];
/// Pixels along each side of the patches that are compared …
const PATCH: i64 = 5;
/// … and standard deviation of their Gaussian weights, in pixels.
const PATCH_SIGMA: f64 = 2.0;
/// The median of so many positions along each axis is what a coarser resolution passes on.
const MEDIAN: i64 = 5;
/// Offsets looked at together.
const TOGETHER: usize = 25;
/// Divisors are at least this.
const SMALLEST: f64 = 1e-12;

/// Where the motion between frames comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum FlowSource {
    /// The clip brings it: what the renderer knows.
    Exact,
    /// [`FlowSearch::single_level`] between the references, which the authors trained with.
    #[default]
    SingleLevel,
    /// [`FlowSearch::hierarchical`] between the references.
    Hierarchical,
}

impl FlowSource {
    /// How the motion is found, if it is not given.
    pub fn search(self) -> Option<FlowSearch> {
        match self {
            Self::Exact => None,
            Self::SingleLevel => Some(FlowSearch::single_level()),
            Self::Hierarchical => Some(FlowSearch::hierarchical()),
        }
    }
}

/// `images` \[N, C, H, W\] read where `motion` \[N, 2, H, W\] leads: pixels to the previous position, x right, then y
/// down. Bilinear between pixel centres, 0 outside and where the motion is no number.
///
/// What the layer `Warp` of a plan does at full resolution (`fovol-net/src/cpu/warp.rs`).
pub fn warp(images: &Tensor, motion: &Tensor) -> Tensor {
    layers::warp(images, motion)
}

/// Where the motion leads to what is there now: Σ_c |`reference` − warp(`previous`)| < `most`, as in DeepFovea.
///
/// Frames are \[N, C, H, W\], the motion is \[N, 2, H, W\], the answer \[N, 1, H, W\] of booleans.
pub fn confidence(reference: &Tensor, previous: &Tensor, motion: &Tensor, most: f64) -> Tensor {
    (reference - warp(previous, motion)).abs().sum_dim_intlist([1i64].as_slice(), true, None).lt(most)
}

/// Block matching in the manner of Hanika et al., "Fast temporal reprojection without motion vectors" (2021).
///
/// For each pixel the offset is taken, of those in a square window, at which the grey pictures differ least: |a − b|,
/// summed over 5×5 pixels with Gaussian weights of σ = 2. Of equally good offsets the smallest wins. What a coarser
/// resolution finds is refined to fractions of its pixels and freed from outliers before a finer one begins there.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FlowSearch {
    /// Resolutions, each half the one before.
    pub levels: usize,
    /// The farthest offset along each axis, in pixels of a level.
    pub radius: i64,
}

impl FlowSearch {
    /// What the authors' training code runs: full resolution, 15×15 offsets.
    pub const fn single_level() -> Self {
        Self { levels: 1, radius: 7 }
    }

    /// Four resolutions with 5×5 offsets each, up to 30 pixels in all.
    pub const fn hierarchical() -> Self {
        Self { levels: 4, radius: 2 }
    }

    /// The motion from `current` to `previous`, both \[N, 3, H, W\]: whole pixels from each position to where it was,
    /// x right, then y down, \[N, 2, H, W\]. Nothing is differentiated.
    pub fn motion(&self, current: &Tensor, previous: &Tensor) -> Tensor {
        tch::no_grad(|| self.at_level(1, &grey(current), &grey(previous)))
    }

    /// The motion at `level`, counted from 1, between grey pictures of its resolution.
    fn at_level(&self, level: usize, current: &Tensor, previous: &Tensor) -> Tensor {
        let start = if level < self.levels {
            let coarser = self.at_level(level + 1, &halved(current), &halved(previous));
            doubled(&coarser, current)
        } else {
            Tensor::cat(&[current, current], 1).zeros_like()
        };
        self.refined(current, previous, &start, level > 1)
    }

    /// The best offset of each pixel from `start` (whole pixels); if the result `is_coarse`, to fractions of pixels
    /// and without outliers.
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

    /// All offsets of the window, \[x, y\], the smallest first.
    fn offsets(&self) -> Vec<[i64; 2]> {
        let range = -self.radius..=self.radius;
        let mut offsets: Vec<[i64; 2]> =
            range.clone().flat_map(|y| range.clone().map(move |x| [x, y])).collect();
        offsets.sort_by_key(|[x, y]| x * x + y * y);
        offsets
    }
}

/// What a picture shows around where a motion leads.
///
/// Unlike [`warp`] it does no arithmetic on what it reads: equal pixels stay equal, and ties are ties.
struct Window {
    /// The picture row by row, with a margin of zeros: \[N, numbers\].
    numbers: Tensor,
    /// Where in it each pixel leads: \[N, 1, H, W\].
    at: Tensor,
    /// Numbers from a row to the next.
    stride: i64,
}

impl Window {
    /// The window of offsets up to `radius` from where `motion` \[N, 2, H, W\] in whole pixels leads in `images`
    /// \[N, 1, H, W\].
    fn new(images: &Tensor, motion: &Tensor, radius: i64) -> Self {
        let [n, _, height, width] = four(images);
        // So far out lead all positions that no offset brings back.
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

    /// What lies at each of `offsets`, \[x, y\]: \[N, offsets, H, W\]; 0 outside the picture.
    fn at(&self, offsets: &[[i64; 2]]) -> Tensor {
        let [n, _, height, width] = four(&self.at);
        let steps: Vec<i64> = offsets.iter().map(|[x, y]| y * self.stride + x).collect();
        let steps = Tensor::from_slice(&steps).to_device(self.at.device()).view([1, -1, 1, 1]);
        let at = (&self.at + steps).view([n, -1]);
        self.numbers.gather(1, &at, false).view([n, -1, height, width])
    }
}

/// The rows of `table` \[K, C\] that `choice` \[N, 1, H, W\] names: \[N, C, H, W\].
fn looked_up(table: &Tensor, choice: &Tensor) -> Tensor {
    let [n, _, height, width] = four(choice);
    let rows = table.to_device(choice.device()).index_select(0, &choice.reshape([-1]));
    rows.view([n, height, width, -1]).permute([0, 3, 1, 2])
}

/// How far along each axis, in −½…½, distances are least between the offsets around the chosen one: \[N, 2, H, W\].
///
/// Absolute differences grow in proportion to the distance from where they are least, with one slope on both sides:
/// the steeper of the two that are seen.
fn between(distances: &[Tensor], choice: &Tensor, offsets: &[[i64; 2]]) -> Tensor {
    let distances = Tensor::cat(distances, 1);
    let least = distances.gather(1, choice, false);
    let index = |x: i64, y: i64| offsets.iter().position(|&offset| offset == [x, y]).map(|at| at as i64);
    let along = [[1, 0], [0, 1]].map(|[dx, dy]| {
        // At the border of the window one of both is not known.
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
    // What fits perfectly is not moved, although a flat neighbourhood may fit as well.
    Tensor::cat(&along, 1).clamp(-0.5, 0.5) * least.gt(0.0).to_kind(least.kind())
}

/// The median of each component of `motion` around each pixel; at borders the outermost pixels count again.
fn median(motion: &Tensor) -> Tensor {
    let padded = motion.replication_pad2d([MEDIAN / 2; 4]);
    padded.unfold(2, MEDIAN, 1).unfold(3, MEDIAN, 1).flatten(-2, -1).median_dim(-1, false).0
}

/// The lengths of a tensor of four dimensions.
fn four(tensor: &Tensor) -> [i64; 4] {
    let size = tensor.size();
    std::array::from_fn(|i| size[i])
}

/// Grey pictures \[N, 1, H, W\] of coloured ones.
fn grey(colour: &Tensor) -> Tensor {
    let shares = Tensor::from_slice(&GREY).to_kind(colour.kind()).to_device(colour.device());
    (colour * shares.view([1, 3, 1, 1])).sum_dim_intlist([1i64].as_slice(), true, None)
}

/// Half the size, rounded up, by averages of the pixels that there are.
fn halved(images: &Tensor) -> Tensor {
    images.avg_pool2d([2, 2], [2, 2], [0, 0], true, false, None)
}

/// The motion of half the resolution for pictures of the size of `like`, in its whole pixels.
fn doubled(motion: &Tensor, like: &Tensor) -> Tensor {
    let ([_, _, half_height, half_width], [_, _, height, width]) = (four(motion), four(like));
    let between = motion.upsample_bilinear2d([2 * half_height, 2 * half_width], false, 2.0, 2.0) * 2.0;
    between.narrow(2, 0, height).narrow(3, 0, width).round()
}

/// `distances` \[N, K, H, W\] summed over the patch around each pixel; outside there are none.
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

    /// Two pictures of one texture: what is at p in the first was at p + (`x`, `y`) in the second.
    fn shifted([height, width]: [i64; 2], [x, y]: [i64; 2]) -> [Tensor; 2] {
        let [tall, wide] = [height + 64, width + 64];
        // Noise of every size, as natural pictures have it.
        let noise = |size: i64| {
            let small = (pictures([2, tall / size, wide / size], 77.0, SINGLE) * 43758.547).frac();
            small.upsample_bilinear2d([tall, wide], false, None, None)
        };
        let large = noise(1) * 0.1 + noise(2) * 0.1 + noise(4) * 0.2 + noise(8) * 0.3 + noise(16) * 0.3;
        let part = |x: i64, y: i64| large.narrow(2, 32 + y, height).narrow(3, 32 + x, width);
        // What the previous picture has at p + o is what the current one has at p.
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
                // Where the search can see all that it compares.
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
