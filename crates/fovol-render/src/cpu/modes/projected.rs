use crate::scene::RayResult;
use fovol_core::TransferFunction;

/// The result of a ray that shows the single display `value` (or NaN) at `depth`. Its opacity is that of one voxel,
/// whatever the length of the ray.
pub fn projected(transfer: &TransferFunction, background: [f32; 3], value: f64, depth: f32) -> RayResult {
    let [r, g, b, opacity] = transfer.evaluate(value).map(|channel| channel as f32);
    if opacity == 0.0 {
        return RayResult::nothing(background);
    }
    let unshadowed = [r, g, b].map(|channel| opacity * channel);
    let colour = std::array::from_fn(|c| unshadowed[c] + (1.0 - opacity) * background[c]);
    RayResult { colour, unshadowed, opacity, depth }
}
