//! How a camera moves under somebody's hands. All of it keeps +y up.

use fovolnet::core::Camera;
use glam::DVec3;

/// How near to the poles an orbit comes, in degrees: straight above, right and left are not defined.
const HIGHEST: f64 = 89.0;
/// The nearest and farthest that a zoom goes, in world units; the longest side of a volume is 1.
const DISTANCES: [f64; 2] = [0.02, 50.0];

/// The camera turned about its target by (`right`, `up`) degrees.
pub fn orbit(camera: &Camera, right: f64, up: f64) -> Camera {
    let arm = camera.eye - camera.target;
    let distance = arm.length();
    let azimuth = arm.x.atan2(arm.z).to_degrees() + right;
    let elevation = (arm.y / distance).clamp(-1.0, 1.0).asin().to_degrees() + up;
    let turned = Camera::on_sphere(azimuth, elevation.clamp(-HIGHEST, HIGHEST), distance, camera.fovy);
    Camera { eye: camera.target + turned.eye, target: camera.target, ..*camera }
}

/// The camera moved sideways, so that what lies at its target moves by (`right`, `down`) heights of the picture.
pub fn pan(camera: &Camera, right: f64, down: f64) -> Camera {
    let (_, x, y) = camera.axes();
    let way = (y * down - x * right) * visible_height(camera);
    Camera { eye: camera.eye + way, target: camera.target + way, ..*camera }
}

/// The camera with the distance to its target multiplied by `factor`.
pub fn zoom(camera: &Camera, factor: f64) -> Camera {
    let arm = camera.eye - camera.target;
    let distance = (arm.length() * factor).clamp(DISTANCES[0], DISTANCES[1]);
    Camera { eye: camera.target + arm.normalize() * distance, ..*camera }
}

/// The camera moved by `way` = (right, up, forward) in world units, its target with it.
pub fn fly(camera: &Camera, way: DVec3) -> Camera {
    let (forward, right, up) = camera.axes();
    let way = right * way.x + up * way.y + forward * way.z;
    Camera { eye: camera.eye + way, target: camera.target + way, ..*camera }
}

/// The camera looking along an axis of the volume from where it is far away now; `towards` points from the target to the
/// eye.
pub fn look_from(camera: &Camera, towards: DVec3) -> Camera {
    let distance = (camera.eye - camera.target).length();
    let elevation = towards.normalize().y.asin().to_degrees().clamp(-HIGHEST, HIGHEST);
    let azimuth =
        if towards.x == 0.0 && towards.z == 0.0 { 0.0 } else { towards.x.atan2(towards.z).to_degrees() };
    let turned = Camera::on_sphere(azimuth, elevation, distance, camera.fovy);
    Camera { eye: camera.target + turned.eye, ..*camera }
}

/// How much of the world the height of the picture shows where the target is.
pub fn visible_height(camera: &Camera) -> f64 {
    2.0 * (camera.eye - camera.target).length() * (camera.fovy.to_radians() * 0.5).tan()
}

/// The numbers that settings take for `camera`.
pub fn numbers(camera: &Camera) -> [f64; 7] {
    let Camera { eye, target, fovy, .. } = camera;
    [eye.x, eye.y, eye.z, target.x, target.y, target.z, *fovy]
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
        // What was at the target is seen right of and below the middle now, as far as the hand moved.
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
