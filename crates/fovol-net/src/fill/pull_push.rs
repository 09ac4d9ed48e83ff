use fovol_core::{Frame, FrameSize};
use rayon::prelude::*;

/// Colours premultiplied by their weight, and the weight: one level of the pyramid.
struct Level {
    width: usize,
    height: usize,
    pixels: Vec<[f32; 4]>,
}

/// Rows of a level that one task works on.
const ROWS: usize = 32;

/// Pull: halve the picture, averaging what is known, until one pixel is left. Push: on the way back,
/// blend what is unknown with the coarser level (Gortler et al. 1996, weights saturating at 1).
pub fn pull_push(sparse: &Frame) -> Frame {
    let size = sparse.size();
    let mut levels = vec![level_of(sparse)];
    while levels[levels.len() - 1].pixels.len() > 1 {
        let coarser = pull(&levels[levels.len() - 1]);
        levels.push(coarser);
    }
    let mut coarse = levels.pop().expect("a frame has at least one pixel");
    for p in &mut coarse.pixels {
        *p = divided(*p);
    }
    while let Some(mut fine) = levels.pop() {
        push(&coarse, &mut fine);
        coarse = fine;
    }
    finished(size, coarse.pixels, sparse)
}

fn level_of(sparse: &Frame) -> Level {
    let size = sparse.size();
    let known = |p: &[f32; 4]| if p[3] > 0.5 { [p[0], p[1], p[2], 1.0] } else { [0.0; 4] };
    Level {
        width: size.width as usize,
        height: size.height as usize,
        pixels: sparse.pixels().par_iter().map(known).collect(),
    }
}

/// Half the size, rounded up: sums of 2×2 pixels, with the total weight cut to 1.
fn pull(fine: &Level) -> Level {
    let (width, height) = (fine.width.div_ceil(2), fine.height.div_ceil(2));
    let mut pixels = vec![[0.0f32; 4]; width * height];
    pixels.par_chunks_mut(width * ROWS).enumerate().for_each(|(chunk, rows)| {
        for (row, out) in rows.chunks_mut(width).enumerate() {
            let y = 2 * (chunk * ROWS + row);
            let top = &fine.pixels[y * fine.width..][..fine.width];
            let below =
                if y + 1 < fine.height { &fine.pixels[(y + 1) * fine.width..][..fine.width] } else { &[] };
            for (x, p) in out.iter_mut().enumerate() {
                let mut sum = top[2 * x];
                for other in
                    [top.get(2 * x + 1), below.get(2 * x), below.get(2 * x + 1)].into_iter().flatten()
                {
                    (0..4).for_each(|c| sum[c] += other[c]);
                }
                let scale = if sum[3] > 1.0 { 1.0 / sum[3] } else { 1.0 };
                *p = sum.map(|c| c * scale);
            }
        }
    });
    Level { width, height, pixels }
}

/// Blends every pixel of `fine` with the bilinear value of `coarse` by what its weight leaves open.
fn push(coarse: &Level, fine: &mut Level) {
    let width = fine.width;
    fine.pixels.par_chunks_mut(width * ROWS).enumerate().for_each(|(chunk, rows)| {
        for (row, out) in rows.chunks_mut(width).enumerate() {
            let (y0, y1, fy) = neighbours(chunk * ROWS + row, coarse.height);
            let above = &coarse.pixels[y0 * coarse.width..][..coarse.width];
            let below = &coarse.pixels[y1 * coarse.width..][..coarse.width];
            for (x, p) in out.iter_mut().enumerate() {
                if p[3] >= 1.0 {
                    continue;
                }
                let (x0, x1, fx) = neighbours(x, coarse.width);
                let open = 1.0 - p[3];
                for c in 0..3 {
                    let top = above[x0][c] + fx * (above[x1][c] - above[x0][c]);
                    let low = below[x0][c] + fx * (below[x1][c] - below[x0][c]);
                    p[c] += open * (top + fy * (low - top));
                }
                p[3] = 1.0;
            }
        }
    });
}

/// The two coarse pixels around the centre of fine pixel `i`, and how far between them it lies.
fn neighbours(i: usize, coarse: usize) -> (usize, usize, f32) {
    let nearest = i / 2;
    if i.is_multiple_of(2) {
        (nearest.saturating_sub(1), nearest, 0.75)
    } else {
        (nearest, (nearest + 1).min(coarse - 1), 0.25)
    }
}

fn divided(p: [f32; 4]) -> [f32; 4] {
    if p[3] > 0.0 { [p[0] / p[3], p[1] / p[3], p[2] / p[3], 1.0] } else { [0.0, 0.0, 0.0, 1.0] }
}

/// The frame of the finest level; samples exactly as they were.
fn finished(size: FrameSize, pixels: Vec<[f32; 4]>, sparse: &Frame) -> Frame {
    let mut frame = Frame::from_pixels(size, pixels).expect("the finest level has the size of the frame");
    frame.pixels_mut().par_iter_mut().zip(sparse.pixels()).for_each(|(p, s)| {
        *p = if s[3] > 0.5 { *s } else { [p[0], p[1], p[2], 1.0] };
    });
    frame
}
