//! Where every pixel was in the last frame, as far as sparse samples tell.

use fovol_core::{Camera, Frame, Reprojection, SampleList};
use fovol_net::Fill;
use rayon::prelude::*;

/// For each pixel of the frame of `list` the way in pixels (x right, y down) to where it was in the frame of
/// `previous`: the `depths` of its pixels (see [`Marched::depth`]), with those between filled by pull-push, seen by both
/// cameras.
///
/// Nothing moves where no ray met anything, or where both cameras are the same.
///
/// # Panics
/// When there are not as many depths as pixels in the list.
///
/// [`Marched::depth`]: fovol_render::cpu::march::Marched
pub fn motion(list: &SampleList, depths: &[f32], camera: &Camera, previous: &Camera) -> Vec<[f32; 2]> {
    assert_eq!(list.len(), depths.len(), "one depth for every listed pixel");
    let size = list.size();
    if camera == previous {
        return vec![[0.0; 2]; size.pixels()];
    }
    let mut known = Frame::new(size);
    for (pixel, depth) in list.pixels().iter().zip(depths) {
        if depth.is_finite() {
            known.pixels_mut()[pixel.index(size.width)] = [1.0 / depth, 0.0, 0.0, 1.0];
        }
    }
    motion_of_depths(&known, &Reprojection::new(camera, previous, size))
}

/// The motion that `reprojection` gives the inverse distances in the red of `known`: those of its pixels with alpha 1,
/// filled between by pull-push. Nothing moves where there are none.
pub fn motion_of_depths(known: &Frame, reprojection: &Reprojection) -> Vec<[f32; 2]> {
    let filled = Fill::PullPush.reconstruct(known);
    let width = known.size().width as usize;
    let mut motion = vec![[0.0; 2]; known.size().pixels()];
    let rows = motion.par_chunks_mut(width).zip(filled.pixels().par_chunks(width)).enumerate();
    rows.for_each(|(y, (to, filled))| {
        for (x, (to, pixel)) in to.iter_mut().zip(filled).enumerate() {
            if pixel[0] > 0.0 {
                *to = reprojection.motion(x as f32, y as f32, pixel[0]);
            }
        }
    });
    motion
}

#[cfg(test)]
mod tests {
    use super::*;
    use fovol_core::{CameraPath, ControlPoint, FrameSize, Grid, Pixel, Scene, TransferFunction, Volume};
    use fovol_render::cpu::{RenderOptions, Renderer};
    use std::sync::Arc;

    /// Small balls at many depths.
    fn renderer() -> Renderer {
        let grid = Grid::new([48; 3], [1.0; 3]).unwrap();
        let centres: Vec<[f32; 3]> =
            (0..20u32).map(|i| [i * 7 % 20, i * 11 % 20, i].map(|c| 5.0 + 2.0 * c as f32)).collect();
        let mut values = Vec::new();
        for i in 0..grid.voxels() {
            let p = [i % 48, i / 48 % 48, i / 2304].map(|c| c as f32);
            let squared = |c: &[f32; 3]| (0..3).map(|a| (p[a] - c[a]).powi(2)).sum::<f32>();
            let nearest = centres.iter().map(squared).fold(f32::INFINITY, f32::min);
            values.push((255.0 * (-nearest / 6.0).exp()) as u8);
        }
        let point = |v, a| ControlPoint::new(v, [1.0; 3], a);
        let transfer = TransferFunction::new(vec![point(0.0, 0.0), point(0.2, 0.0), point(1.0, 0.8)]);
        let mut scene = Scene::new(Arc::new(Volume::from_values(grid, values).unwrap()), transfer.unwrap());
        scene.shading.shadows = fovol_core::ShadowMode::Off;
        Renderer::new(&scene, RenderOptions::default()).unwrap()
    }

    #[test]
    fn the_last_frame_moved_along_the_motion_is_this_frame() {
        let size = FrameSize::new(160, 120).unwrap();
        let renderer = renderer();
        let [last, camera] = [10, 18].map(|i| CameraPath::Orbit.camera(i));
        let every: Vec<Pixel> = (0..120).flat_map(|y| (0..160).map(move |x| Pixel { x, y })).collect();
        let list = SampleList::new(size, every);
        let (marched, _) = renderer.march_list(&camera, &list);
        let depths: Vec<f32> = marched.iter().map(|sample| sample.depth).collect();
        let moves = motion(&list, &depths, &camera, &last);
        let before = renderer.march_full(&last, size).0;
        let (mut still, mut moved, mut pixels) = (0.0, 0.0, 0);
        for (i, sample) in marched.iter().enumerate().filter(|(_, sample)| sample.opacity > 0.3) {
            let (x, y) = (i % 160, i / 160);
            let [dx, dy] = moves[i];
            let (px, py) = ((x as f32 + dx).round(), (y as f32 + dy).round());
            if px < 0.0 || py < 0.0 || px > 159.0 || py > 119.0 {
                continue;
            }
            still += (before.pixels()[i][0] - sample.colour[0]).abs();
            moved += (before.pixel(px as u32, py as u32)[0] - sample.colour[0]).abs();
            pixels += 1;
        }
        assert!(pixels > 500, "{pixels}");
        assert!(moved * 2.5 < still, "{moved} {still}");
    }

    #[test]
    fn a_still_camera_moves_nothing() {
        let size = FrameSize::new(8, 8).unwrap();
        let list = SampleList::new(size, vec![Pixel { x: 3, y: 3 }]);
        let camera = CameraPath::Orbit.camera(0);
        assert!(motion(&list, &[1.0], &camera, &camera).iter().all(|m| *m == [0.0; 2]));
        let moved = motion(&list, &[1.0], &camera, &CameraPath::Orbit.camera(9));
        assert!(moved.iter().all(|m| m[0].abs() > 0.01));
    }
}
