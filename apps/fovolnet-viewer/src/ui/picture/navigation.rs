//! Camera navigation. All motions keep +y up.

use fovolnet::core::Camera;
use glam::DVec3;

/// Largest elevation of an orbit in degrees; at the poles, up and right are undefined.
const HIGHEST: f64 = 89.0;
/// Smallest and largest distance of a zoom, in world units; the longest side of a volume is 1.
const DISTANCES: [f64; 2] = [0.02, 50.0];

/// Orbits the camera about its target by (`right`, `up`) degrees.
pub fn orbit(camera: &Camera, right: f64, up: f64) -> Camera {
    let arm = camera.eye - camera.target;
    let distance = arm.length();
    let azimuth = arm.x.atan2(arm.z).to_degrees() + right;
    let elevation = (arm.y / distance).clamp(-1.0, 1.0).asin().to_degrees() + up;
    let turned = Camera::on_sphere(azimuth, elevation.clamp(-HIGHEST, HIGHEST), distance, camera.fovy);
    Camera { eye: camera.target + turned.eye, target: camera.target, ..*camera }
}

/// Moves the camera sideways, so that the target moves on the screen by (`right`, `down`) in heights of the picture.
pub fn pan(camera: &Camera, right: f64, down: f64) -> Camera {
    let (_, x, y) = camera.axes();
    let way = (y * down - x * right) * visible_height(camera);
    Camera { eye: camera.eye + way, target: camera.target + way, ..*camera }
}

/// Multiplies the distance to the target by `factor`.
pub fn zoom(camera: &Camera, factor: f64) -> Camera {
    let arm = camera.eye - camera.target;
    let distance = (arm.length() * factor).clamp(DISTANCES[0], DISTANCES[1]);
    Camera { eye: camera.target + arm.normalize() * distance, ..*camera }
}

/// Moves camera and target by `way` = (right, up, forward) in world units.
pub fn fly(camera: &Camera, way: DVec3) -> Camera {
    let (forward, right, up) = camera.axes();
    let way = right * way.x + up * way.y + forward * way.z;
    Camera { eye: camera.eye + way, target: camera.target + way, ..*camera }
}

/// Looks at the target from the direction `towards`, which points from the target to the eye; keeps the distance.
pub fn look_from(camera: &Camera, towards: DVec3) -> Camera {
    let distance = (camera.eye - camera.target).length();
    let elevation = towards.normalize().y.asin().to_degrees().clamp(-HIGHEST, HIGHEST);
    let azimuth =
        if towards.x == 0.0 && towards.z == 0.0 { 0.0 } else { towards.x.atan2(towards.z).to_degrees() };
    let turned = Camera::on_sphere(azimuth, elevation, distance, camera.fovy);
    Camera { eye: camera.target + turned.eye, ..*camera }
}

/// Height of the view at the target, in world units.
pub fn visible_height(camera: &Camera) -> f64 {
    2.0 * (camera.eye - camera.target).length() * (camera.fovy.to_radians() * 0.5).tan()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera() -> Camera {
        Camera::on_sphere(30.0, 20.0, 1.9, 35.0)
    }

    #[test]
    fn an_orbit_keeps_the_distance_and_stays_off_the_poles() {
        let turned = orbit(&camera(), 25.0, 500.0);
        assert!((turned.eye.length() - 1.9).abs() < 1e-9);
        assert!(turned.eye.y < 1.9 && turned.eye.y > 1.89);
        let back = orbit(&orbit(&camera(), 25.0, 10.0), -25.0, -10.0);
        assert!((back.eye - camera().eye).length() < 1e-9);
    }

    #[test]
    fn a_pan_moves_the_target_under_the_hand() {
        let moved = pan(&camera(), 0.25, 0.1);
        // The old target is now seen right of and below the centre, as far as the drag.
        let (forward, right, up) = moved.axes();
        let seen = camera().target - moved.eye;
        let height = 2.0 * seen.dot(forward) * (17.5f64).to_radians().tan();
        assert!((seen.dot(right) / height - 0.25).abs() < 1e-9);
        assert!((seen.dot(up) / height + 0.1).abs() < 1e-9);
    }

    #[test]
    fn zooms_end_before_the_target_and_flights_go_straight_on() {
        assert!(((zoom(&camera(), 0.5).eye).length() - 0.95).abs() < 1e-9);
        assert!((zoom(&camera(), 0.0).eye.length() - DISTANCES[0]).abs() < 1e-9);
        let flown = fly(&camera(), DVec3::new(0.0, 0.0, 0.3));
        assert!(((flown.eye - camera().eye).length() - 0.3).abs() < 1e-9);
        assert_eq!(flown.axes().0, camera().axes().0);
    }

    #[test]
    fn looks_along_axes_keep_the_distance() {
        for axis in [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z] {
            let seen = look_from(&camera(), axis);
            assert!((seen.eye.length() - 1.9).abs() < 1e-9);
            assert!(seen.eye.normalize().dot(axis) > 0.999);
            seen.check().unwrap();
        }
    }
}
