use crate::boundary::call;
use crate::committed::Committed;
use crate::handles::{hand_out, object, release};
use crate::pointers::numbers;
use crate::rotation::upright;
use crate::status::{Failure, FovolnetStatus};
use fovolnet::core::{Camera, Projection};
use glam::DVec3;

/// How a camera projects.
pub type FovolnetProjection = i32;
/// Rays from the eye.
pub const FOVOLNET_PERSPECTIVE: FovolnetProjection = 0;
/// Parallel rays. The picture is as high as the field of view at the target.
pub const FOVOLNET_ORTHOGRAPHIC: FovolnetProjection = 1;

/// A still camera in the world. There the box of the volume is centred at 0, and its longest side is 1.
pub struct FovolnetCamera(Committed<Parameters, Camera>);

/// Pending parameters.
#[derive(Clone)]
struct Parameters {
    eye: DVec3,
    target: DVec3,
    up: DVec3,
    fovy: f64,
    projection: Projection,
}

impl Default for Parameters {
    fn default() -> Self {
        let (eye, projection) = (DVec3::new(0.0, 0.0, 3.0), Projection::Perspective);
        Self { eye, target: DVec3::ZERO, up: DVec3::Y, fovy: 35.0, projection }
    }
}

impl Parameters {
    fn camera(&self) -> Result<Camera, Failure> {
        let camera = Camera::new(self.eye, self.target, self.fovy)?;
        let upright = upright(self.up)
            .ok_or_else(|| Failure::invalid("`up` has no length; give a direction, for example 0, 1, 0"))?;
        Ok(Camera { projection: self.projection, upright, ..camera })
    }
}

impl FovolnetCamera {
    /// Camera of the last commit.
    pub(crate) fn camera(&self) -> Result<Camera, Failure> {
        self.0.committed("camera")
    }
}

/// The function that makes cameras.
const MAKER: &str = "fovolnet_camera_new";

/// Makes a camera at 0, 0, 3 that looks at 0, with +y up and 35 degrees. Give the handle to fovolnet_camera_release in the end.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fovolnet_camera_new(camera: *mut *mut FovolnetCamera) -> FovolnetStatus {
    // SAFETY: see the rules at the top of the header.
    call(|| unsafe { hand_out(FovolnetCamera(Committed::default()), camera, "camera") })
}

/// Gives the handle back. NULL is fine; a handle that was released must not be used again.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fovolnet_camera_release(camera: *mut FovolnetCamera) {
    // SAFETY: see the rules at the top of the header.
    unsafe { release(camera) }
}

/// Sets the position of the eye, the point in the middle of the picture, and the direction that is up in it: three numbers each.
/// `up` may be NULL for +y.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fovolnet_camera_look_at(
    camera: *mut FovolnetCamera,
    eye: *const f64,
    target: *const f64,
    up: *const f64,
) -> FovolnetStatus {
    call(|| {
        // SAFETY: see the rules at the top of the header.
        let (eye, target) = unsafe { (numbers(eye, "eye")?.into(), numbers(target, "target")?.into()) };
        let up = match up.is_null() {
            true => DVec3::Y,
            // SAFETY: likewise.
            false => unsafe { numbers(up, "up")? }.into(),
        };
        // SAFETY: likewise.
        unsafe { object(camera, "camera", MAKER)? }.0.set(|pending| {
            (pending.eye, pending.target, pending.up) = (eye, target, up);
            Ok(())
        })
    })
}

/// Sets the vertical field of view in degrees, above 0 and below 180.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fovolnet_camera_set_fovy(
    camera: *mut FovolnetCamera,
    degrees: f64,
) -> FovolnetStatus {
    call(|| {
        // SAFETY: see the rules at the top of the header.
        unsafe { object(camera, "camera", MAKER)? }.0.set(|pending| {
            pending.fovy = degrees;
            Ok(())
        })
    })
}

/// Sets how the camera projects: FOVOLNET_PERSPECTIVE or FOVOLNET_ORTHOGRAPHIC.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fovolnet_camera_set_projection(
    camera: *mut FovolnetCamera,
    projection: FovolnetProjection,
) -> FovolnetStatus {
    call(|| {
        let projection = match projection {
            FOVOLNET_PERSPECTIVE => Projection::Perspective,
            FOVOLNET_ORTHOGRAPHIC => Projection::Orthographic,
            other => {
                return Err(Failure::invalid(format!(
                    "`projection` is {other}; use FOVOLNET_PERSPECTIVE or FOVOLNET_ORTHOGRAPHIC"
                )));
            }
        };
        // SAFETY: see the rules at the top of the header.
        unsafe { object(camera, "camera", MAKER)? }.0.set(|pending| {
            pending.projection = projection;
            Ok(())
        })
    })
}

/// Checks the pending parameters. Renderers use them from their next frame on.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fovolnet_camera_commit(camera: *mut FovolnetCamera) -> FovolnetStatus {
    call(|| {
        // SAFETY: see the rules at the top of the header.
        let camera = unsafe { object(camera, "camera", MAKER)? };
        camera.0.commit(camera.0.pending().camera()?);
        Ok(())
    })
}
