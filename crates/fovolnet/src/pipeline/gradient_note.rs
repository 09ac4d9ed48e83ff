use fovol_core::{Integration, Interpolation, Scene};

/// Note that the integration of `scene` is not the fine one, because its opacity depends on the gradient.
pub fn gradient_note(scene: &Scene) -> Option<String> {
    let would_be_fine = scene.integration == Integration::Fine
        && scene.interpolation == Interpolation::Linear
        && !scene.is_layered();
    (scene.has_gradient_opacity() && would_be_fine)
        .then(|| "opacity by gradient is integrated as --integration plain does".to_owned())
}
