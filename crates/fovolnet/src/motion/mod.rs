//! Motion of every pixel to its position in the last frame, estimated from sparse samples.
//!
//! Only samples have a distance. Between them it must be guessed, and where layers overlap a single distance is a guess
//! even at a sample. So each pixel has several depth hypotheses ([`DepthHypotheses`]). One is interpolated from the samples of
//! this frame. Others are the same surface moved nearer and farther. The last one also uses samples of earlier frames,
//! reprojected to this view ([`Depths`]).
//!
//! Each part of the frame prefers the guesses along whose motion the last frame best matches this frame's samples
//! ([`depth_confidence`]). This is plane sweeping from stereo vision, with few pixels of known colour.

mod depth_confidence;
mod depth_hypotheses;
mod depths;
mod weighed_motion;

#[cfg(feature = "gpu")]
pub(crate) use depth_confidence::TILE;
#[cfg(feature = "gpu")]
pub(crate) use depth_hypotheses::COUNT as GUESSES;
use depth_hypotheses::DepthHypotheses;
pub use depths::{Depths, Filled};
use fovol_core::{Camera, Frame, FrameSize, Region, Reprojection, SparseFrame};
use rayon::prelude::*;
use std::borrow::Cow;
use std::collections::VecDeque;
use weighed_motion::weighed_motion;

/// Number of frames before the last whose samples are used. Older samples no longer help: surfaces turn away and layers
/// shift.
pub const REMEMBERED: usize = 6;

/// Estimates the motion of every pixel of the frame `now`: the vector in pixels (x right, y down) to its position in
/// the `last` frame.
///
/// `to_last` maps pixels of this frame to the last one. `earlier` are the depths of frames before, each with the
/// mapping from there to this frame. Pixels whose rays met nothing do not move.
///
/// # Panics
/// If the frames differ in size.
pub fn motion(
    now: &SparseFrame,
    earlier: &[(Reprojection, &Depths)],
    to_last: &Reprojection,
    last: &Frame,
) -> Vec<[f32; 2]> {
    assert_eq!(now.size(), last.size(), "frames of one clip");
    let guesses = DepthHypotheses::new(&Depths::new(now), earlier);
    let beliefs = depth_confidence::believe(&guesses, now, to_last, last);
    weighed_motion(&guesses, &beliefs, to_last)
}

/// Motion of every pixel by `reprojection` at the distances of `filled`; none where the distance is unknown.
pub fn motion_of_depths(filled: &Filled, reprojection: &Reprojection) -> Vec<[f32; 2]> {
    depth_hypotheses::motion_of(filled.size(), reprojection, filled.inverse())
}

/// Estimates the motion of the frames of one clip, one after the other.
#[derive(Debug, Clone, Default)]
pub struct MotionFinder {
    /// Cameras and depths of the last frames, oldest first.
    seen: VecDeque<(Camera, Depths)>,
}

impl MotionFinder {
    /// Motion of the frame `now` of the camera `camera`, the next frame of the clip; see [`motion()`]. Without a full
    /// `last` frame it uses this frame's samples only. `None` for the first frame.
    pub fn find(&self, now: &SparseFrame, camera: &Camera, last: Option<&Frame>) -> Option<Vec<[f32; 2]>> {
        self.find_in(Region::whole(now.size()), now, camera, last)
    }

    /// Motion as in [`Self::find`], if nothing outside `region` is visible. Pixels outside do not move.
    pub fn find_in(
        &self,
        region: Region,
        now: &SparseFrame,
        camera: &Camera,
        last: Option<&Frame>,
    ) -> Option<Vec<[f32; 2]>> {
        let moves = |between: &Between<'_>| {
            let now = now.within(region);
            let Some(last) = last else {
                return motion_of_depths(&Depths::new(&now).filled(), &between.to_last());
            };
            let seen = self.seen.par_iter();
            let seen = seen.map(|(there, depths)| (between.from(there), depths.within(region)));
            let seen: Vec<_> = seen.collect();
            let earlier: Vec<_> = seen.iter().map(|(here, depths)| (*here, depths)).collect();
            motion(&now, &earlier, &between.to_last(), &part(region, last))
        };
        self.moved(region, now.size(), camera, moves)
    }

    /// Motion by `depths` alone, which are known at so many pixels that nothing needs to be guessed. Pixels outside `region`
    /// do not move. `None` for the first frame.
    pub fn find_by_depths(&self, region: Region, depths: &Depths, camera: &Camera) -> Option<Vec<[f32; 2]>> {
        let moves =
            |between: &Between<'_>| motion_of_depths(&depths.within(region).filled(), &between.to_last());
        self.moved(region, depths.size(), camera, moves)
    }

    /// Motion of a frame of `size` from what `moves` says of `region`. Nothing moves if the camera rests.
    fn moved(
        &self,
        region: Region,
        size: FrameSize,
        camera: &Camera,
        moves: impl FnOnce(&Between<'_>) -> Vec<[f32; 2]>,
    ) -> Option<Vec<[f32; 2]>> {
        let (last, _) = self.seen.back()?;
        if last == camera {
            return Some(vec![[0.0; 2]; size.pixels()]);
        }
        let found = moves(&Between { camera, last, region, size });
        if region == Region::whole(size) {
            return Some(found);
        }
        let mut everywhere = vec![[0.0; 2]; size.pixels()];
        region.put_part(&found, &mut everywhere, size.width);
        Some(everywhere)
    }

    /// Remembers the depths of the frame `sparse` of `camera`.
    pub fn remember(&mut self, camera: &Camera, sparse: &SparseFrame) {
        if self.seen.len() == REMEMBERED {
            self.seen.pop_front();
        }
        self.seen.push_back((*camera, Depths::new(sparse)));
    }

    /// Forgets all earlier frames, as after a cut.
    pub fn reset(&mut self) {
        self.seen.clear();
    }
}

/// Cameras of this frame and the last one, and the part of the frame whose motion is found.
struct Between<'a> {
    camera: &'a Camera,
    last: &'a Camera,
    region: Region,
    size: FrameSize,
}

impl Between<'_> {
    /// Mapping of the part from this frame to the last one.
    fn to_last(&self) -> Reprojection {
        self.mapping(self.camera, self.last)
    }

    /// Mapping of the part from a frame of the camera `there` to this one.
    fn from(&self, there: &Camera) -> Reprojection {
        self.mapping(there, self.camera)
    }

    fn mapping(&self, from: &Camera, to: &Camera) -> Reprojection {
        Reprojection::new(from, to, self.size).of_part(self.region.x, self.region.y)
    }
}

/// Copy of the part `region` of `frame`; borrowed if it is the whole frame.
fn part(region: Region, frame: &Frame) -> Cow<'_, Frame> {
    match region == Region::whole(frame.size()) {
        true => Cow::Borrowed(frame),
        false => Cow::Owned(region.of(frame)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fovol_core::{CameraPath, ControlPoint, Grid, Pixel, SampleList, Scene, TransferFunction, Volume};
    use fovol_render::cpu::{RenderOptions, Renderer, sparse_frame};
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
        let before = renderer.march_full(&last, size).0;
        let moves = motion_of_depths(
            &Depths::new(&sparse_frame(list, &marched)).filled(),
            &Reprojection::new(&camera, &last, size),
        );
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

    /// Mean squared error of the last frame along `motion` against `full`, over the pixels that show something.
    fn error(full: &Frame, last: &Frame, motion: &[[f32; 2]]) -> f32 {
        let width = full.size().width as usize;
        let [mut sum, mut shown] = [0.0, 0.0];
        for (i, (pixel, [dx, dy])) in full.pixels().iter().zip(motion).enumerate() {
            if pixel[0] < 0.05 {
                continue;
            }
            let (x, y) = ((i % width) as f32 + dx, (i / width) as f32 + dy);
            let seen = if x < 0.0
                || y < 0.0
                || x.round() as usize >= width
                || y.round() >= full.size().height as f32
            {
                1.0
            } else {
                last.pixel(x.round() as u32, y.round() as u32)[0]
            };
            sum += (pixel[0] - seen).powi(2);
            shown += 1.0;
        }
        sum / shown
    }

    /// Samples of a twentieth of the pixels, different ones in each frame.
    fn sampled(renderer: &Renderer, camera: &Camera, size: FrameSize, t: u32) -> SparseFrame {
        let pixels = (0..size.height).flat_map(|y| (0..size.width).map(move |x| (x, y)));
        let chosen =
            pixels.filter(|(x, y)| (x * 7 + y * 13 + t * 5).wrapping_mul(2_654_435_761) >> 16 & 31 == 0);
        let list = SampleList::new(size, chosen.map(|(x, y)| Pixel { x: x as u16, y: y as u16 }).collect());
        let (marched, _) = renderer.march_list(camera, &list);
        sparse_frame(list, &marched)
    }

    #[test]
    fn what_is_around_the_scene_changes_nothing() {
        let size = FrameSize::new(320, 240).unwrap();
        let renderer = renderer();
        let mut finder = MotionFinder::default();
        let [last, camera] = [0.0, 3.0].map(|turn| Camera::on_sphere(turn, 20.0, 4.5, 35.0));
        finder.remember(&last, &sampled(&renderer, &last, size, 0));
        let now = sampled(&renderer, &camera, size, 1);
        let before = renderer.march_full(&last, size).0;
        let region = renderer.visible_region(&camera, size).unwrap().grown(16, 16, size);
        assert!(region.pixels() * 2 < size.pixels());
        let [whole, part] = [Region::whole(size), region]
            .map(|region| finder.find_in(region, &now, &camera, Some(&before)).unwrap());
        let full = renderer.march_full(&camera, size).0;
        let [of_whole, of_part] = [&whole, &part].map(|motion| error(&full, &before, motion));
        assert!((of_part - of_whole).abs() < 0.1 * of_whole, "{of_part} {of_whole}");
    }

    #[test]
    fn earlier_samples_and_the_last_frame_make_motion_better() {
        let size = FrameSize::new(320, 240).unwrap();
        let renderer = renderer();
        let mut finder = MotionFinder::default();
        let mut last: Option<Frame> = None;
        let mut errors = [0.0; 2];
        for t in 0..8 {
            let camera = CameraPath::Orbit.camera(2 * t);
            let full = renderer.march_full(&camera, size).0;
            let now = sampled(&renderer, &camera, size, t);
            let found = finder.find(&now, &camera, last.as_ref());
            assert_eq!(found.is_some(), t > 0);
            if let (Some(found), Some(last)) = (found, &last) {
                let alone = finder.find(&now, &camera, None).unwrap();
                let [found, alone] = [found, alone].map(|motion| error(&full, last, &motion));
                errors.iter_mut().zip([found, alone]).for_each(|(sum, error)| *sum += error);
            }
            finder.remember(&camera, &now);
            last = Some(full);
        }
        assert!(errors[0] < 0.97 * errors[1], "{errors:?}");
    }

    /// Where depths are known nearly everywhere, they alone tell the motion better than guesses from few samples.
    #[test]
    fn many_depths_need_no_guesses() {
        let size = FrameSize::new(320, 240).unwrap();
        let renderer = renderer();
        let mut finder = MotionFinder::default();
        let [there, here] = [0, 4].map(|i| CameraPath::Orbit.camera(i));
        assert_eq!(
            finder.find_by_depths(
                Region::whole(size),
                &Depths::new(&sampled(&renderer, &here, size, 1)),
                &here
            ),
            None
        );
        finder.remember(&there, &sampled(&renderer, &there, size, 0));
        let last = renderer.march_full(&there, size).0;
        let full = renderer.march_full(&here, size).0;
        let now = sampled(&renderer, &here, size, 1);
        let every =
            (0..240).step_by(2).flat_map(|y| (0..320).step_by(2).map(move |x| Pixel { x, y })).collect();
        let list = SampleList::new(size, every);
        let marched = renderer.march_list(&here, &list).0;
        let distances: Vec<f32> = marched.iter().map(|ray| ray.depth).collect();
        let depths = Depths::new(&now).with((list.pixels(), &distances));
        let region = renderer.visible_region(&here, size).unwrap().grown(16, 16, size);
        let found = finder.find_by_depths(region, &depths, &here).unwrap();
        let guessed = finder.find(&now, &here, Some(&last)).unwrap();
        let [found, guessed] = [found, guessed].map(|motion| error(&full, &last, &motion));
        assert!(found < 0.95 * guessed, "{found} {guessed}");
    }

    #[test]
    fn a_still_camera_moves_nothing() {
        let size = FrameSize::new(8, 8).unwrap();
        let list = SampleList::new(size, vec![Pixel { x: 3, y: 3 }]);
        let now = &SparseFrame::new(list, vec![[0.0; 3]], vec![1.0]);
        let frame = Frame::new(size);
        let camera = CameraPath::Orbit.camera(0);
        let mut finder = MotionFinder::default();
        assert_eq!(finder.find(now, &camera, Some(&frame)), None);
        finder.remember(&camera, now);
        assert!(finder.find(now, &camera, Some(&frame)).unwrap().iter().all(|m| *m == [0.0; 2]));
        let moved = finder.find(now, &CameraPath::Orbit.camera(9), None).unwrap();
        assert!(moved.iter().all(|m| m[0].abs() > 0.01));
        finder.reset();
        assert_eq!(finder.find(now, &camera, None), None);
    }
}
