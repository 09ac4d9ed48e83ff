//! Positions at twice the resolution.

/// Returns the two positions, of `count`, between which position `i` at twice the resolution lies, and their
/// weights. Positions are pixel centres, replicated at the border.
#[inline(always)]
pub fn halves(i: usize, count: usize) -> [(usize, f32); 2] {
    let near = i / 2;
    let far = if i.is_multiple_of(2) { near.saturating_sub(1) } else { (near + 1).min(count - 1) };
    [(near, 0.75), (far, 0.25)]
}
