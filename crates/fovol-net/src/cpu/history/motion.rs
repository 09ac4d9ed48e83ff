//! Motion of neighbouring pixels. Pixels that move by equal whole pixels have neighbouring sources, so vectors can
//! move them together.

/// Returns the whole-pixel motion of the first of `moved`, and whether all others share it.
#[inline(always)]
pub fn whole_motion(moved: &[[f32; 2]]) -> ([f32; 2], bool) {
    let whole = [moved[0][0].floor(), moved[0][1].floor()];
    let mut is_alike = true;
    for moved in moved {
        let [x, y] = [moved[0] - whole[0], moved[1] - whole[1]];
        is_alike &= (0.0..1.0).contains(&x) & (0.0..1.0).contains(&y);
    }
    (whole, is_alike)
}

/// Returns row and column of the upper left source of `count` pixels from (`y`, `x`) on that move by `whole`
/// pixels. `None` if any of their bilinear sources lies outside an image of `height` and `width`.
#[inline(always)]
pub fn corner_of(
    count: usize,
    [y, x]: [usize; 2],
    whole: [f32; 2],
    [height, width]: [usize; 2],
) -> Option<[usize; 2]> {
    let [left, above] = [x as f32 + whole[0], y as f32 + whole[1]];
    let is_inside =
        left >= 0.0 && left + (count as f32) < width as f32 && above >= 0.0 && above + 1.0 < height as f32;
    is_inside.then_some([above as usize, left as usize])
}
