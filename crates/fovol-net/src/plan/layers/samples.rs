use crate::plan::tensor::TensorSpec;

/// Channels of a point: premultiplied RGB and weight as of [`Join`](crate::plan::Join), then the offset of the point from the
/// centre of its pixel, x right and y down, −0.5 to below 0.5 pixels.
pub const POINT: usize = 6;

/// Checks that `tensor` holds a point for each pixel of the frame.
pub(super) fn check_points(tensor: &TensorSpec) -> Result<(), String> {
    match (tensor.channels, tensor.level) {
        (POINT, 0) => Ok(()),
        _ => Err(format!("`{}` holds no points of the frame's pixels", tensor.name)),
    }
}

/// Checks that `tensor` holds weighted pixels, or points, of the frame.
pub(super) fn check_known(tensor: &TensorSpec) -> Result<(), String> {
    match (tensor.channels, tensor.level) {
        (4 | POINT, 0) => Ok(()),
        _ => Err(format!("`{}` holds no weighted pixels of the frame", tensor.name)),
    }
}

/// Checks that `tensor` holds a picture of half the resolution.
pub(super) fn check_half(tensor: &TensorSpec) -> Result<(), String> {
    match (tensor.channels, tensor.level) {
        (3, 1) => Ok(()),
        _ => Err(format!("`{}` is no picture of half the resolution", tensor.name)),
    }
}
