use crate::boundary::call;
use crate::committed::Committed;
use crate::handles::{hand_out, object, release};
use crate::pointers::numbers;
use crate::status::{Failure, FovolnetStatus};
use fovolnet::core::Light;

/// A directional light. Its share is what the setting "ambient" leaves.
pub struct FovolnetLight(Committed<[f64; 3], Light>);

impl FovolnetLight {
    /// Light of the last commit.
    pub(crate) fn light(&self) -> Result<Light, Failure> {
        self.0.committed("light")
    }
}

/// The function that makes lights.
const MAKER: &str = "fovolnet_light_new";

/// Makes a light from the usual direction. Give the handle to fovolnet_light_release in the end.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fovolnet_light_new(light: *mut *mut FovolnetLight) -> FovolnetStatus {
    call(|| {
        let made = FovolnetLight(Committed::default());
        made.0.set(|pending| {
            *pending = Light::default().direction().to_array();
            Ok(())
        })?;
        // SAFETY: see the rules at the top of the header.
        unsafe { hand_out(made, light, "light") }
    })
}

/// Gives the handle back. NULL is fine; a handle that was released must not be used again.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fovolnet_light_release(light: *mut FovolnetLight) {
    // SAFETY: see the rules at the top of the header.
    unsafe { release(light) }
}

/// Sets the direction from the scene towards the light: three numbers, of any length, in the world of the camera.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fovolnet_light_set_towards(
    light: *mut FovolnetLight,
    direction: *const f64,
) -> FovolnetStatus {
    call(|| {
        // SAFETY: see the rules at the top of the header.
        let direction = unsafe { numbers(direction, "direction")? };
        // SAFETY: likewise.
        unsafe { object(light, "light", MAKER)? }.0.set(|pending| {
            *pending = direction;
            Ok(())
        })
    })
}

/// Checks the pending direction. Renderers use it from their next frame on.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fovolnet_light_commit(light: *mut FovolnetLight) -> FovolnetStatus {
    call(|| {
        // SAFETY: see the rules at the top of the header.
        let light = unsafe { object(light, "light", MAKER)? };
        light.0.commit(Light::try_from(light.0.pending())?);
        Ok(())
    })
}
