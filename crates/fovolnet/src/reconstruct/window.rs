//! Window of the frame that a network works on. Nothing needs reconstruction where the scene cannot be seen.

use crate::Result;
use fovol_core::{Frame, FrameSize, Region};
use fovol_net::cpu::{FrameInput, Network, State};

/// Least margin of a window around the visible region, in pixels: networks look at the surroundings of a pixel.
const LEAST_MARGIN: u32 = 16;
/// Margin of a new window in pixels, with room to move in.
const MARGIN: u32 = 32;
/// Edges of windows are multiples of this many pixels, or edges of the frame.
const GRID: u32 = 64;
/// Windows this many times larger than necessary are replaced, in tenths.
const TOO_LARGE: usize = 15;

/// Visible region of a frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Seen {
    /// Region of all pixels that may show more than the background; `None` if there are none.
    pub region: Option<Region>,
    /// Colour of all other pixels: red, green and blue.
    pub background: [f32; 3],
}

impl Seen {
    /// Assumes that all of a frame of `size` is visible.
    pub fn everything(size: FrameSize) -> Self {
        Self { region: Some(Region::whole(size)), background: [0.0; 3] }
    }

    /// Region of a frame of `size` in which pixels may move: the visible region with a margin.
    pub(crate) fn moving(&self, size: FrameSize) -> Region {
        self.region.map_or_else(|| Region::whole(size), |region| region.grown(MARGIN, GRID, size))
    }

    /// Colour of a pixel that shows the background.
    fn nothing(&self) -> [f32; 4] {
        let [r, g, b] = self.background;
        [r, g, b, 1.0]
    }
}

/// State of a network for one clip, in a window that follows the visible region.
#[derive(Debug, Clone)]
pub struct Windowed {
    size: FrameSize,
    /// `None` before the first frame, and after a frame in which nothing was visible.
    part: Option<Part>,
}

#[derive(Debug, Clone)]
struct Part {
    window: Region,
    state: State,
}

impl Windowed {
    /// State at the beginning of a clip of frames of `size`.
    pub fn new(size: FrameSize) -> Self {
        Self { size, part: None }
    }

    /// Forgets all earlier frames.
    pub fn reset(&mut self) {
        self.part = None;
    }

    /// Reconstructs `input`, the next frame of the clip.
    ///
    /// # Errors
    /// A frame or motion of another size than the clip's.
    pub fn reconstruct(&mut self, network: &Network, input: &FrameInput<'_>, seen: &Seen) -> Result<Frame> {
        let pixels = self.size.pixels();
        if input.sparse.size() != self.size || input.motion.is_some_and(|motion| motion.len() != pixels) {
            // The network returns the error with the sizes.
            return Ok(network.reconstruct(input, &mut network.state(self.size))?);
        }
        let Some(region) = seen.region else {
            self.part = None;
            return Ok(Frame::from_pixels(self.size, vec![seen.nothing(); pixels])?);
        };
        let mut part = self.follow(network, region)?;
        let frame = part.reconstruct(network, input, seen);
        self.part = Some(part);
        frame
    }

    /// Window around `region`: the last one, unless its margin is too small or it is much too large.
    fn follow(&mut self, network: &Network, region: Region) -> Result<Part> {
        let window = region.grown(MARGIN, GRID.max(network.plan().multiple() as u32), self.size);
        Ok(match self.part.take() {
            None => Part { window, state: network.try_state(window.size)? },
            Some(part) => {
                let has_room = part.window.contains(&region.grown(LEAST_MARGIN, 1, self.size));
                let is_too_large = part.window.pixels() * 10 > window.pixels() * TOO_LARGE;
                if has_room && !is_too_large { part } else { part.moved(network, window)? }
            }
        })
    }
}

impl Part {
    fn moved(self, network: &Network, window: Region) -> Result<Self> {
        let by = [(window.x, self.window.x), (window.y, self.window.y)];
        let by = by.map(|(to, from)| i64::from(to) - i64::from(from));
        Ok(Self { window, state: network.moved(self.state, window.size, by)? })
    }

    fn reconstruct(&mut self, network: &Network, input: &FrameInput<'_>, seen: &Seen) -> Result<Frame> {
        let size = input.sparse.size();
        if self.window == Region::whole(size) {
            return Ok(network.reconstruct(input, &mut self.state)?);
        }
        let sparse = input.sparse.within(self.window);
        let motion = input.motion.map(|motion| self.window.part(motion, size.width));
        let input = FrameInput { sparse: &sparse, motion: motion.as_deref() };
        let part = network.reconstruct(&input, &mut self.state)?;
        Ok(self.window.framed(&part, seen.nothing(), size))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fovol_core::SparseFrame;
    use fovol_net::Weights;
    use fovol_net::cpu::{Precision, Simd};
    use fovol_net::plan::Named;

    const SIZE: FrameSize = FrameSize { width: 320, height: 200 };
    const BACKGROUND: [f32; 3] = [0.2, 0.4, 0.6];

    fn network(named: Named) -> Network {
        let weights = Weights::random(&named.config(), 3).unwrap();
        let plan = named.config().plan().unwrap();
        Network::new(plan, &weights, Simd::best(), Precision::F32).unwrap()
    }

    fn seen(x: u32, y: u32) -> Seen {
        let region = Region { x, y, size: FrameSize { width: 40, height: 30 } };
        Seen { region: Some(region), background: BACKGROUND }
    }

    /// Frame with every fifth pixel sampled, and background outside the visible region.
    fn sparse(seen: &Seen, t: usize) -> SparseFrame {
        let mut frame = Frame::new(SIZE);
        frame.fill(seen.nothing());
        if let Some(region) = seen.region {
            for (i, pixel) in region.rows(SIZE.width).flatten().map(|at| (at, at % 7)) {
                frame.pixels_mut()[i] = [0.1 * pixel as f32, 0.5, 0.3, 1.0];
            }
        }
        let unsampled = |i: &usize| !(i + i / 320 * 3 + t).is_multiple_of(5);
        (0..SIZE.pixels()).filter(unsampled).for_each(|i| frame.pixels_mut()[i] = [0.0; 4]);
        SparseFrame::from(&frame)
    }

    #[test]
    fn what_cannot_be_seen_is_background() {
        let network = network(Named::WNetFast);
        let mut clip = Windowed::new(SIZE);
        for t in 0..4 {
            let seen = seen(130 + 20 * t, 60);
            let sparse = sparse(&seen, t as usize);
            let input = FrameInput { sparse: &sparse, motion: None };
            let frame = clip.reconstruct(&network, &input, &seen).unwrap();
            let window = clip.part.as_ref().unwrap().window;
            assert!(window.pixels() < SIZE.pixels() && window.contains(&seen.region.unwrap()));
            assert_eq!(frame.pixel(0, 0), [0.2, 0.4, 0.6, 1.0]);
            assert_eq!(frame.pixel(319, 199), [0.2, 0.4, 0.6, 1.0]);
            assert!(frame.pixels().iter().all(|p| p[3] == 1.0));
        }
        let nothing = Seen { region: None, ..seen(0, 0) };
        let sparse = sparse(&nothing, 0);
        let input = FrameInput { sparse: &sparse, motion: None };
        let frame = clip.reconstruct(&network, &input, &nothing).unwrap();
        assert!(frame.pixels().iter().all(|p| *p == [0.2, 0.4, 0.6, 1.0]) && clip.part.is_none());
    }

    #[test]
    fn a_window_that_moves_forgets_nothing() {
        for named in [Named::WNetFast, Named::WNetNarrow] {
            let network = network(named);
            let [mut whole, mut moving, mut anew] =
                [Windowed::new(SIZE), Windowed::new(SIZE), Windowed::new(SIZE)];
            let mut apart = [0.0; 2];
            for t in 0..4 {
                let sparse = sparse(&seen(100, 90), t);
                let input = FrameInput { sparse: &sparse, motion: None };
                let at = seen(100, if t < 3 { 100 } else { 70 });
                if t == 3 {
                    anew.reset();
                }
                let expected = whole.reconstruct(&network, &input, &Seen::everything(SIZE)).unwrap();
                let inside = Region { x: 112, y: 96, size: FrameSize { width: 16, height: 12 } };
                apart = [&mut moving, &mut anew].map(|clip| {
                    let found = clip.reconstruct(&network, &input, &at).unwrap();
                    let of = |i: usize| (0..3).map(move |c| (i, c));
                    let pixels = inside.rows(SIZE.width).flatten().flat_map(of);
                    pixels.map(|(i, c)| (expected.pixels()[i][c] - found.pixels()[i][c]).abs()).sum::<f32>()
                });
            }
            assert!(apart[0] < 0.5 * apart[1], "{named:?}: {apart:?}");
        }
    }

    #[test]
    fn frames_of_other_sizes_are_refused() {
        let network = network(Named::WNetFast);
        let mut clip = Windowed::new(SIZE);
        let other = SparseFrame::from(&Frame::new(FrameSize { width: 10, height: 10 }));
        let input = FrameInput { sparse: &other, motion: None };
        assert!(clip.reconstruct(&network, &input, &seen(0, 0)).is_err());
    }
}
