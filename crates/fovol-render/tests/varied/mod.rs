//! Scenes in every mode, with planes and parallel rays.

use crate::{gaps, scenes};
use fovol_core::{
    Camera, ClipBox, ClipPlane, ClipPlanes, Integration, Interpolation, Projection, RayMode, Scene,
    ShadowMode, SurfaceShading, Volume,
};
use std::sync::Arc;

/// Largest difference of a channel: at edges of surfaces a ray may meet or miss by rounding alone.
pub const MOST: f32 = 1.0;

/// Calls `compare` with a name, a scene and cameras, for every mode and for composited scenes with planes.
pub fn scenes(mut compare: impl FnMut(&str, &Scene, &[Camera])) {
    let volumes = scenes::volumes().into_iter().chain([("gaps", gaps::volume())]);
    for (name, volume) in volumes {
        for (mode, scene) in modes(Arc::new(volume)) {
            compare(&format!("{name}, {mode}"), &scene, &cameras());
        }
    }
}

fn modes(volume: Arc<Volume>) -> Vec<(String, Scene)> {
    let mut scene = Scene::new(volume, scenes::transfer().with_nan([0.9, 0.1, 0.2, 0.3]).unwrap());
    scene.background = [0.1, 0.2, 0.3];
    let projections = [RayMode::Mip, RayMode::Minip, RayMode::Average];
    let mut all: Vec<(String, Scene)> = Vec::new();
    for mode in projections.into_iter().chain([RayMode::Isosurface(0.35)]) {
        all.push((format!("{mode:?}"), Scene { mode, ..scene.clone() }));
    }
    for shadows in [ShadowMode::On, ShadowMode::Cached] {
        let mut nearest = Scene { interpolation: Interpolation::Nearest, ..scene.clone() };
        nearest.shading.shadows = shadows;
        nearest.shading.surface = SurfaceShading::Gradient;
        nearest.integration = Integration::Fine;
        all.push((format!("nearest, {shadows:?}"), nearest));
    }
    scene.transfer_function = scene.transfer_function.without_nan();
    all.push(("mip without the colour of NaN".into(), Scene { mode: RayMode::Mip, ..scene.clone() }));
    let planes = [([0.6, 0.3, -0.74], -0.12), ([-0.2, 0.9, 0.1], -0.3)];
    let planes = planes.map(|(normal, distance)| ClipPlane { normal: normal.into(), distance });
    let clip = ClipBox::whole(scene.volume.grid()).with_planes(ClipPlanes::new(&planes).unwrap());
    scene.clip = Some(clip);
    all.push(("cut isosurface".into(), Scene { mode: RayMode::Isosurface(0.2), ..scene.clone() }));
    for integration in [Integration::Plain, Integration::Fine] {
        for shadows in [ShadowMode::On, ShadowMode::Cached] {
            scene.integration = integration;
            scene.shading.shadows = shadows;
            scene.shading.surface = SurfaceShading::Gradient;
            all.push((format!("cut, {integration} {shadows:?}"), scene.clone()));
        }
    }
    all
}

fn cameras() -> [Camera; 3] {
    let [outside, inside, _] = scenes::cameras();
    [outside, inside, Camera { projection: Projection::Orthographic, ..outside }]
}
