use crate::{CameraChoice, NamedView, RenderSettings, Result, WorldBox};
use fovol_core::{Camera, CameraPath};

/// Camera path that `settings` choose for the volume in `world`.
///
/// # Errors
/// A still camera that cannot be used.
pub fn camera_path(settings: &RenderSettings, world: &WorldBox) -> Result<CameraPath> {
    match &settings.camera {
        CameraChoice::Auto if settings.frames > 1 => Ok(turntable(settings, world)),
        CameraChoice::Auto => Ok(CameraPath::Still(default_view(settings, world))),
        CameraChoice::Turntable => Ok(turntable(settings, world)),
        CameraChoice::Still(camera) => {
            camera.check()?;
            Ok(CameraPath::Still(*camera))
        }
        CameraChoice::Along(path) => Ok(path.clone()),
    }
}

/// Vertical field of view of the default view, in degrees.
const FOVY: f64 = 35.0;
/// Elevation of the default view in degrees, for volumes of unknown orientation.
const LOOKS_DOWN: f64 = 20.0;

/// Turntable over all frames, beginning with the default view.
fn turntable(settings: &RenderSettings, world: &WorldBox) -> CameraPath {
    let degrees = settings.turn / f64::from(settings.frames);
    CameraPath::Turntable { start: default_view(settings, world), degrees }
}

/// View from the front or the named side that just fits the bounding sphere of the shown part into the frame.
fn default_view(settings: &RenderSettings, world: &WorldBox) -> Camera {
    let from_front = [0.0, if world.is_patient() { 0.0 } else { LOOKS_DOWN }];
    let [azimuth, elevation] = settings.view.map_or(from_front, NamedView::angles);
    let (centre, radius) = world.bounding_sphere();
    let size = settings.size;
    let height = (FOVY.to_radians() * 0.5).tan();
    let least = height.min(height * f64::from(size.width) / f64::from(size.height));
    // The cone of view touches the sphere, so its half angle has the sine radius/distance.
    let distance = (radius / least.atan().sin()).max(MIN_DISTANCE);
    let camera = Camera::on_sphere(azimuth, elevation, distance, FOVY);
    Camera { eye: centre + camera.eye, target: centre, ..camera }
}

/// Smallest distance of the camera, for shown parts that are extremely thin.
const MIN_DISTANCE: f64 = 1e-3;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::volume::cube;
    use fovol_core::FrameSize;
    use glam::DVec3;

    /// Whether the whole cube is inside the frame that `camera` sees.
    fn sees_all(camera: &Camera, size: FrameSize) -> bool {
        let rays = camera.rays(size);
        let [forward, right, up] = rays.axes();
        (0..8).all(|corner: i32| {
            let side = |axis: i32| f64::from(corner >> axis & 1) - 0.5;
            let way = DVec3::new(side(0), side(1), side(2)) - rays.origin();
            let depth = way.dot(forward);
            let across = [right, up].map(|axis| way.dot(axis) / axis.length_squared() / depth);
            depth > 0.0 && across.iter().all(|at| at.abs() <= 1.0)
        })
    }

    #[test]
    fn the_default_view_shows_everything_at_any_aspect() {
        for size in ["1280x720", "720x1280", "64x64", "900x30"] {
            let size: FrameSize = size.parse().unwrap();
            for frames in [1, 8] {
                let settings = RenderSettings { size, frames, ..RenderSettings::default() };
                let path = camera_path(&settings, &cube()).unwrap();
                assert!((0..frames).all(|i| sees_all(&path.camera(i), size)), "{size} {frames}");
            }
        }
        let camera = camera_path(&RenderSettings::default(), &cube()).unwrap().camera(0);
        let nearer = Camera { eye: camera.eye * 0.8, ..camera };
        assert!(!sees_all(&nearer, FrameSize::default()), "it does not waste the frame");
    }

    #[test]
    fn a_turntable_goes_once_round_over_its_frames() {
        let settings = RenderSettings { frames: 12, ..RenderSettings::default() };
        let path = camera_path(&settings, &cube()).unwrap();
        assert!((path.camera(12).eye - path.camera(0).eye).length() < 1e-9);
        assert!((path.camera(6).eye.x - path.camera(0).eye.x).abs() < 1e-9);
        let half = RenderSettings { turn: -180.0, camera: CameraChoice::Turntable, ..settings };
        let half = camera_path(&half, &cube()).unwrap();
        assert!(half.camera(3).eye.x < -1.0 && half.camera(12).eye.z < -1.0);
    }

    #[test]
    fn views_have_names() {
        let eye = |view| {
            let settings = RenderSettings { view: Some(view), ..RenderSettings::default() };
            camera_path(&settings, &cube()).unwrap().camera(0).eye.normalize()
        };
        assert!((eye(NamedView::Left) - DVec3::X).length() < 1e-9);
        assert!((eye(NamedView::Posterior) - DVec3::NEG_Z).length() < 1e-9);
        assert!((eye(NamedView::Superior) - DVec3::Y).length() < 1e-9);
    }
}
