//! Values of `override` constants of shaders.

use crate::plan::{Activation, Resize};

/// Converts a flag to the value of a constant.
pub fn flag(is_set: bool) -> f64 {
    f64::from(u8::from(is_set))
}

/// Converts flags to the bits of a constant, the first one lowest.
pub fn bits(are_set: &[bool]) -> f64 {
    are_set.iter().rev().fold(0.0, |all, is_set| 2.0 * all + flag(*is_set))
}

/// Number of `activation` in shaders.
pub fn activation_number(activation: Activation) -> f64 {
    match activation {
        Activation::None => 0.0,
        Activation::Relu => 1.0,
        Activation::Elu => 2.0,
    }
}

/// Number of `resize` in shaders.
pub fn resize_number(resize: Resize) -> u32 {
    match resize {
        Resize::Same => 0,
        Resize::Bilinear => 1,
        Resize::Nearest => 2,
    }
}
