//! What the motion of pixels side by side has in common: those that have moved by the same whole pixels lie between others that
//! are side by side too, and can be moved together.

/// The whole pixels that the first of some pixels that have `moved` so far has moved by, and whether all of them have.
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

/// The row and the column of the first of the pixels that `count` of them from (`y`, `x`) on lie between if they have moved by these
/// `whole` pixels, in an image of `height` and `width`; none unless all of these, and those beside and below them, are inside.
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
