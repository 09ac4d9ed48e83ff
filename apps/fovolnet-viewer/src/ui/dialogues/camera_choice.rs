//! Choice of the camera motion of a clip.

use crate::session::camera_motion::CameraMotion;
use crate::ui::picture::navigation;
use eframe::egui::{ComboBox, Ui};
use fovolnet::core::{Camera, Keyframe};
use fovolnet::{PathChoice, RenderOverrides};

/// Choices for the camera motion of a clip.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Way {
    /// Along the session's own path.
    Keyframes,
    /// Turntable with the whole volume in view.
    Turntable,
    /// Default orbit.
    Orbit,
    /// Default fly-through.
    Flythrough,
    /// Orbit around the target, from the current view.
    OrbitFromHere,
    /// The current view, without motion.
    Still,
}

impl Way {
    fn name(self) -> &'static str {
        match self {
            Self::Keyframes => "along the keyframes",
            Self::Turntable => "turntable",
            Self::Orbit => "orbit",
            Self::Flythrough => "fly-through",
            Self::OrbitFromHere => "orbit from here",
            Self::Still => "stands still",
        }
    }
}

/// Form control for the camera motion of a clip.
#[derive(Debug)]
pub(crate) struct CameraChoice {
    way: Way,
    camera: Camera,
    /// Path of the session, if it has keyframes.
    path: Option<PathChoice>,
}

impl CameraChoice {
    /// Initial choice for a session with the settings `render` that is seen from `camera`.
    ///
    /// The session's path is the default. Without one, a turntable; if the user has moved the camera, an orbit from
    /// the current view, because a still view would give identical frames.
    pub fn new(render: &RenderOverrides, camera: Camera) -> Self {
        let way = match render.path {
            Some(PathChoice::Turntable) => Way::Turntable,
            Some(PathChoice::Orbit) => Way::Orbit,
            Some(PathChoice::Flythrough) => Way::Flythrough,
            Some(PathChoice::Toml(_)) => Way::Keyframes,
            None if render.camera.is_some() => Way::OrbitFromHere,
            None => Way::Turntable,
        };
        Self { way, camera, path: render.path.clone().filter(|_| way == Way::Keyframes) }
    }

    /// Camera motion of a clip of `frames` frames.
    pub fn course(&self, frames: u32) -> CameraMotion {
        match self.way {
            Way::Keyframes => CameraMotion::Path(self.path.clone().unwrap_or(PathChoice::Turntable)),
            Way::Turntable => CameraMotion::Path(PathChoice::Turntable),
            Way::Orbit => CameraMotion::Path(PathChoice::Orbit),
            Way::Flythrough => CameraMotion::Path(PathChoice::Flythrough),
            Way::OrbitFromHere => CameraMotion::Path(orbit_from(&self.camera, frames)),
            Way::Still => CameraMotion::Still((&self.camera).into()),
        }
    }

    /// Whether all frames would be equal.
    pub fn stands_still(&self) -> bool {
        self.way == Way::Still
    }

    /// Shows the list of choices.
    pub fn ui(&mut self, ui: &mut Ui) {
        let keyframes = self.path.is_some().then_some(Way::Keyframes);
        let others = [Way::Turntable, Way::Orbit, Way::Flythrough, Way::OrbitFromHere, Way::Still];
        let label = ui.label("Camera").id;
        let list = ComboBox::from_id_salt("course").selected_text(self.way.name()).show_ui(ui, |ui| {
            for way in keyframes.into_iter().chain(others) {
                ui.selectable_value(&mut self.way, way, way.name());
            }
        });
        list.response.labelled_by(label);
    }
}

/// Keyframes of a full turn. With this many, the spline approximates a circle to a few hundred-thousandths.
const TURN: i32 = 36;

/// Path once around the target of `camera` in `frames` frames, starting there. It loops smoothly.
fn orbit_from(camera: &Camera, frames: u32) -> PathChoice {
    let key = |i: i32| {
        let part = f64::from(i) / f64::from(TURN);
        Keyframe {
            frame: part * f64::from(frames.max(1)),
            camera: navigation::orbit(camera, 360.0 * part, 0.0),
        }
    };
    // One keyframe before and one after, since a spline slows down at its ends.
    let keys: Vec<Keyframe> = (-1..=TURN + 1).map(key).collect();
    PathChoice::through(&keys)
}

#[cfg(test)]
mod tests {
    use super::*;
    use fovolnet::StillCamera;
    use glam::DVec3;

    fn camera() -> Camera {
        Camera::new(DVec3::new(0.9, 0.7, 1.1), DVec3::new(0.1, 0.0, -0.1), 30.0).unwrap()
    }

    #[test]
    fn an_orbit_from_here_begins_here_and_goes_round_evenly() {
        let fovolnet::CameraChoice::Along(path) = orbit_from(&camera(), 100).cameras().unwrap() else {
            panic!("keyframes are a path")
        };
        assert!((path.camera(0).eye - camera().eye).length() < 1e-9);
        assert!((path.camera(100).eye - camera().eye).length() < 1e-9);
        let arm = |i| path.camera(i).eye - camera().target;
        for i in 0..100 {
            assert!((arm(i).length() - arm(0).length()).abs() < 1e-4, "{i}");
            let step = (arm(i + 1) - arm(i)).length() / (arm(1) - arm(0)).length();
            assert!((step - 1.0).abs() < 0.02, "{i}: {step}");
            assert!((path.camera(i).target - camera().target).length() < 1e-9 && path.camera(i).fovy == 30.0);
        }
    }

    #[test]
    fn what_a_clip_begins_with_moves() {
        let way = |path: Option<&str>, camera: Option<StillCamera>| {
            let path = path.map(PathChoice::from);
            let render = RenderOverrides { path, camera, ..RenderOverrides::default() };
            CameraChoice::new(&render, self::camera()).way
        };
        let free = Some(StillCamera::from(&camera()));
        assert_eq!(way(None, None), Way::Turntable);
        assert_eq!(way(Some("orbit"), None), Way::Orbit);
        assert_eq!(way(None, free), Way::OrbitFromHere);
        assert_eq!(way(Some("flythrough"), free), Way::Flythrough);
        assert_eq!(way(Some("[[keyframe]]"), free), Way::Keyframes);
    }
}
