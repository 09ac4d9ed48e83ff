//! Scenes of several volumes at the same points, and of voxels with colours.

use crate::gaps;
use crate::scenes::{transfer, volumes};
use fovol_core::{Interpolation, Layer, RayMode, Scene, Volume};
use std::sync::Arc;

/// Scenes of the first and third volume of [`volumes`], which have the same dimensions, and of one with gaps.
pub fn scenes() -> Vec<(&'static str, Scene)> {
    let [bytes, _, floats]: [Arc<Volume>; 3] =
        volumes().into_iter().map(|(_, volume)| Arc::new(volume)).collect::<Vec<_>>().try_into().unwrap();
    let gaps = Arc::new(gaps::volume());
    let layer = |volume: &Arc<Volume>, interpolation| Layer {
        volume: Arc::clone(volume),
        transfer_function: transfer().with_range(Some([0.2, 0.9])).unwrap().over([0.0, 1.0]),
        colours: None,
        interpolation,
    };
    let (linear, nearest) = (Interpolation::Linear, Interpolation::Nearest);
    let mut scene = Scene::new(Arc::clone(&bytes), transfer());
    scene.background = [0.1, 0.2, 0.3];
    let two = Scene { layers: vec![layer(&floats, linear)], ..scene.clone() };
    let four = Scene {
        layers: vec![layer(&floats, linear), layer(&bytes, nearest), layer(&floats, nearest)],
        ..scene.clone()
    };
    let colours = Some([Arc::clone(&bytes), Arc::clone(&floats), Arc::clone(&bytes)]);
    let coloured = Scene { colours: colours.clone(), ..scene.clone() };
    let mut both = Scene { colours: colours.clone(), ..two.clone() };
    both.layers[0].colours = colours;
    let mut with_gaps = Scene { volume: Arc::clone(&gaps), ..scene.clone() };
    with_gaps.transfer_function = transfer().with_nan([0.9, 0.1, 0.2, 0.3]).unwrap();
    with_gaps.layers = vec![layer(&gaps, linear)];
    vec![
        ("two", two),
        ("four", four),
        ("coloured", coloured),
        ("coloured layers", both),
        ("with gaps", with_gaps),
    ]
}

/// [`scenes`] without colours of voxels, in every projection.
pub fn projections() -> Vec<(String, Scene)> {
    let uncoloured = scenes().into_iter().filter(|(name, _)| !name.contains("coloured"));
    let in_modes = uncoloured.flat_map(|(name, scene)| {
        [RayMode::Mip, RayMode::Minip, RayMode::Average]
            .map(|mode| (format!("{name} {mode:?}"), Scene { mode, ..scene.clone() }))
    });
    in_modes.collect()
}
