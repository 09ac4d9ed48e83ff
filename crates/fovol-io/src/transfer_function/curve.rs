use super::colour_space::{Colour, Interpolation};
use super::warp::Warp;

/// One node of a colour or opacity curve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Node<T> {
    /// The data value.
    pub x: f64,
    /// Colour or opacity there.
    pub y: T,
    /// The way to the next node.
    pub warp: Warp,
}

/// Nodes in rising order of x; constant outside. At a node itself the segment on its left holds, as in VTK.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve<T> {
    nodes: Vec<Node<T>>,
    is_logarithmic: bool,
}

impl<T: Copy> Curve<T> {
    /// The curve through `nodes` in any order; none without nodes. A logarithmic one runs over log₁₀ x between them,
    /// unless the least x is not positive: VTK makes it linear then.
    pub fn new(mut nodes: Vec<Node<T>>, is_logarithmic: bool) -> Option<Self> {
        nodes.sort_by(|a, b| a.x.total_cmp(&b.x));
        let is_positive = nodes.first()?.x > 0.0;
        Some(Self { nodes, is_logarithmic: is_logarithmic && is_positive })
    }

    /// The first and the last x.
    pub fn range(&self) -> [f64; 2] {
        [self.nodes[0].x, self.nodes[self.nodes.len() - 1].x]
    }

    /// The number of nodes.
    pub fn len(&self) -> usize {
        self.nodes.len()
    }

    /// All x at which the curve may jump or bend sharply.
    pub fn breaks(&self) -> impl Iterator<Item = f64> + '_ {
        let bends = self.nodes.windows(2).filter_map(|pair| {
            let (a, b) = (pair[0].x, pair[1].x);
            let f = pair[0].warp.bend()?;
            Some(if self.is_logarithmic { a * (b / a).powf(f) } else { a + f * (b - a) })
        });
        self.nodes.iter().map(|node| node.x).chain(bends)
    }

    /// The value at `x`; `between(segment, a, b, share)` is a mixture of neighbours.
    fn at(&self, x: f64, between: impl Fn(usize, T, T, f64) -> T) -> T {
        let right = self.nodes.partition_point(|node| node.x < x);
        let Some(b) = self.nodes.get(right) else { return self.nodes[self.nodes.len() - 1].y };
        if right == 0 {
            return b.y;
        }
        let a = &self.nodes[right - 1];
        let s = match self.is_logarithmic {
            true => (x / a.x).log10() / (b.x / a.x).log10(),
            false => (x - a.x) / (b.x - a.x),
        };
        between(right - 1, a.y, b.y, a.warp.share(s))
    }
}

/// Opacity over data values.
pub type OpacityCurve = Curve<f64>;

impl OpacityCurve {
    /// The opacity at `x`.
    pub fn opacity(&self, x: f64) -> f64 {
        self.at(x, |_, a, b, f| a + f * (b - a))
    }
}

/// Colours over data values.
#[derive(Debug, Clone)]
pub struct ColourCurve {
    /// The nodes.
    pub nodes: Curve<Colour>,
    segments: Vec<super::colour_space::Segment>,
}

impl ColourCurve {
    /// `nodes` with colours between them as `space` has them.
    pub fn new(nodes: Curve<Colour>, space: Interpolation) -> Self {
        let segments = nodes.nodes.windows(2).map(|pair| space.segment(pair[0].y, pair[1].y)).collect();
        Self { nodes, segments }
    }

    /// The colour at `x`.
    pub fn colour(&self, x: f64) -> Colour {
        self.nodes.at(x, |segment, _, _, f| self.segments[segment].colour(f))
    }

    /// All x at which the curve may jump or bend sharply, those within segments among them.
    pub fn breaks(&self) -> impl Iterator<Item = f64> + '_ {
        let inner = self.nodes.nodes.windows(2).zip(&self.segments).flat_map(|(pair, segment)| {
            let (a, b) = (pair[0].x, pair[1].x);
            segment.bends().into_iter().map(move |f| a + f * (b - a))
        });
        self.nodes.breaks().chain(inner)
    }
}
