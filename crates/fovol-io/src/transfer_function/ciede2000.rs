//! The colour difference CIEDE2000, and the shortest way from one colour to another by it.

use super::cie::{Colour, to_lab};
use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::f64::consts::{PI, TAU};

/// Colours along each axis of the RGB grid that ways lead through, as in VTK.
const SIDE: usize = 17;

/// The stops of the shortest way from `a` to `b` through an RGB grid of 17³ colours, with the share of the way that
/// lies before each. The ends are those of the grid too, as in VTK.
pub fn way(a: Colour, b: Colour) -> Vec<(f64, Colour)> {
    let colours = grid_way(nearest(a), nearest(b));
    if colours.len() < 2 {
        return vec![(0.0, colours[0]), (1.0, colours[0])];
    }
    let mut length = 0.0;
    let mut stops = vec![(0.0, colours[0])];
    for pair in colours.windows(2) {
        length += difference(to_lab(pair[0]), to_lab(pair[1]));
        stops.push((length, pair[1]));
    }
    if length > 0.0 {
        stops.iter_mut().for_each(|stop| stop.0 /= length);
    }
    stops
}

fn nearest(colour: Colour) -> usize {
    let [r, g, b] = colour.map(|c| ((c.clamp(0.0, 1.0) * (SIDE - 1) as f64) + 0.5) as usize);
    r + SIDE * (g + SIDE * b)
}

fn place(node: usize) -> [usize; 3] {
    [node % SIDE, node / SIDE % SIDE, node / (SIDE * SIDE)]
}

fn colour(node: usize) -> Colour {
    place(node).map(|i| i as f64 / (SIDE - 1) as f64)
}

/// A distance that is not negative, in the order of numbers.
#[derive(Clone, Copy, PartialEq)]
struct Distance(f64);

impl Eq for Distance {}

impl PartialOrd for Distance {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Distance {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.0.total_cmp(&other.0)
    }
}

/// Dijkstra's shortest way from `start` to `end`, found backwards, over the 26 neighbours of every colour.
fn grid_way(start: usize, end: usize) -> Vec<Colour> {
    let labs: Vec<Colour> = (0..SIDE.pow(3)).map(|node| to_lab(colour(node))).collect();
    let mut distances = vec![f64::INFINITY; labs.len()];
    let mut next = vec![end; labs.len()];
    distances[end] = 0.0;
    let mut front = BinaryHeap::from([(Reverse(Distance(0.0)), end)]);
    while let Some((Reverse(Distance(distance)), node)) = front.pop() {
        if node == start {
            break;
        }
        if distance > distances[node] {
            continue;
        }
        for neighbour in neighbours(node) {
            let longer = distance + difference(labs[node], labs[neighbour]);
            if longer < distances[neighbour] {
                (distances[neighbour], next[neighbour]) = (longer, node);
                front.push((Reverse(Distance(longer)), neighbour));
            }
        }
    }
    let mut node = start;
    let mut found = vec![colour(node)];
    while node != end {
        node = next[node];
        found.push(colour(node));
    }
    found
}

fn neighbours(node: usize) -> impl Iterator<Item = usize> {
    let around = |i: usize| i.saturating_sub(1)..=(i + 1).min(SIDE - 1);
    let [r, g, b] = place(node).map(around);
    b.flat_map(move |b| {
        let r = r.clone();
        g.clone().flat_map(move |g| r.clone().map(move |r| r + SIDE * (g + SIDE * b)))
    })
    .filter(move |&other| other != node)
}

/// ΔE₀₀ of two colours in L*a*b* (Sharma, Wu, Dalal, "The CIEDE2000 Color-Difference Formula", 2005).
pub fn difference([l1, a1, b1]: Colour, [l2, a2, b2]: Colour) -> f64 {
    let saturation = |chroma: f64| (chroma.powi(7) / (chroma.powi(7) + 25f64.powi(7))).sqrt();
    let g = 0.5 * (1.0 - saturation(0.5 * (a1.hypot(b1) + a2.hypot(b2))));
    let (a1, a2) = (a1 * (1.0 + g), a2 * (1.0 + g));
    let (c1, c2) = (a1.hypot(b1), a2.hypot(b2));
    let hue = |a: f64, b: f64| if a == 0.0 && b == 0.0 { 0.0 } else { b.atan2(a).rem_euclid(TAU) };
    let (h1, h2) = (hue(a1, b1), hue(a2, b2));
    let is_grey = c1 * c2 == 0.0;
    let turn = match h2 - h1 {
        _ if is_grey => 0.0,
        turn if turn > PI => turn - TAU,
        turn if turn < -PI => turn + TAU,
        turn => turn,
    };
    let mean_hue = match h1 + h2 {
        sum if is_grey => sum,
        sum if (h1 - h2).abs() <= PI => 0.5 * sum,
        sum if sum < TAU => 0.5 * (sum + TAU),
        sum => 0.5 * (sum - TAU),
    };
    let (mean_l, mean_c) = (0.5 * (l1 + l2), 0.5 * (c1 + c2));
    let degrees = f64::to_radians;
    let t = 1.0 - 0.17 * (mean_hue - degrees(30.0)).cos()
        + 0.24 * (2.0 * mean_hue).cos()
        + 0.32 * (3.0 * mean_hue + degrees(6.0)).cos()
        - 0.20 * (4.0 * mean_hue - degrees(63.0)).cos();
    let off = (mean_l - 50.0).powi(2);
    let lightness = (l2 - l1) / (1.0 + 0.015 * off / (20.0 + off).sqrt());
    let chroma = (c2 - c1) / (1.0 + 0.045 * mean_c);
    let hue = 2.0 * (c1 * c2).sqrt() * (0.5 * turn).sin() / (1.0 + 0.015 * mean_c * t);
    let blue = degrees(30.0) * (-((mean_hue - degrees(275.0)) / degrees(25.0)).powi(2)).exp();
    let rotation = -(2.0 * blue).sin() * 2.0 * saturation(mean_c);
    (lightness * lightness + chroma * chroma + hue * hue + rotation * chroma * hue).max(0.0).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn differences_are_those_of_the_paper() {
        // Pairs 1, 7, 17, 25 and 34 of table 1 of Sharma et al.
        for (a, b, expected) in [
            ([50.0, 2.6772, -79.7751], [50.0, 0.0, -82.7485], 2.0425),
            ([50.0, 0.0, 0.0], [50.0, -1.0, 2.0], 2.3669),
            ([50.0, 2.5, 0.0], [73.0, 25.0, -18.0], 27.1492),
            ([60.2574, -34.0099, 36.2677], [60.4626, -34.1751, 39.4387], 1.2644),
            ([2.0776, 0.0795, -1.135], [0.9033, -0.0636, -0.5514], 0.9082),
        ] {
            assert!((difference(a, b) - expected).abs() < 5e-5, "{a:?} {b:?}: {}", difference(a, b));
        }
    }

    #[test]
    fn ways_have_their_ends() {
        let (a, b) = ([0.0, 0.25, 0.875], [1.0, 0.375, 0.0]);
        let way = way(a, b);
        assert!(way.len() > 5 && way[0] == (0.0, a) && way[way.len() - 1].1 == b);
        assert!(way.windows(2).all(|pair| pair[0].0 < pair[1].0));
    }
}
