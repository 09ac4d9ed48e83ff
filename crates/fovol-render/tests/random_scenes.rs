//! Any scene, on every instruction set: sound colours, and empty space left at once looks as marched through.
//!
//! `PROPTEST_CASES=10000` tries as many scenes.

use fovol_core::{
    Camera, ClipBox, ControlPoint, Frame, FrameSize, Grid, Integration, Light, Scene, ShadowMode,
    SurfaceShading, TransferFunction, Volume,
};
use fovol_render::cpu::{RenderOptions, Renderer, available_simd};
use glam::DVec3;
use proptest::prelude::*;
use std::sync::Arc;

/// How voxels are stored and what they hold.
#[derive(Debug, Clone)]
struct Voxels {
    dims: [usize; 3],
    spacing: [f64; 3],
    /// u8, i16, f32, and f32 with NaN.
    kind: usize,
    /// The share of voxels that are not 0.
    filled: f64,
    seed: u32,
}

impl Voxels {
    fn volume(&self) -> Volume {
        let grid = Grid::new(self.dims, self.spacing).unwrap();
        let mut state = self.seed;
        let mut random = move || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(state >> 8) / f64::from(1 << 24)
        };
        let values = (0..grid.voxels()).map(move |_| if random() < self.filled { random() } else { 0.0 });
        match self.kind {
            0 => Volume::from_values(grid, values.map(|v| (v * 255.0) as u8).collect::<Vec<_>>()),
            1 => Volume::from_values(grid, values.map(|v| (v * 4000.0) as i16 - 1024).collect::<Vec<_>>()),
            2 => Volume::from_values(grid, values.map(|v| v as f32).collect::<Vec<_>>()),
            _ => {
                let with_gaps = |v: f64| if v > 0.9 { f32::NAN } else { v as f32 };
                Volume::from_values(grid, values.map(with_gaps).collect::<Vec<_>>())
            }
        }
        .unwrap()
    }
}

fn voxels() -> impl Strategy<Value = Voxels> {
    let spacing = prop::array::uniform3(prop_oneof![3 => 0.5f64..2.0, 1 => Just(1.0), 1 => 1e-3f64..30.0]);
    let filled = prop_oneof![0.0f64..0.01, 0.0f64..1.0];
    (prop::array::uniform3(1usize..40), spacing, 0usize..4, filled, any::<u32>())
        .prop_map(|(dims, spacing, kind, filled, seed)| Voxels { dims, spacing, kind, filled, seed })
}

/// Points at any values, jumps included.
fn transfer() -> impl Strategy<Value = TransferFunction> {
    let point = (0u32..=20, prop::array::uniform3(0.0f64..=1.0), prop_oneof![Just(0.0), 0.0f64..=1.0]);
    prop::collection::vec(point, 1..8).prop_map(|mut points| {
        points.sort_by_key(|point| point.0);
        let points = points.into_iter().map(|(at, rgb, a)| ControlPoint::new(f64::from(at) / 20.0, rgb, a));
        TransferFunction::new(points.collect()).unwrap_or_else(|_| TransferFunction::grey_ramp(0.5))
    })
}

fn scene() -> impl Strategy<Value = Scene> {
    let light = prop::array::uniform3(-1i32..=1).prop_filter("no direction", |light| *light != [0; 3]);
    let clip = prop::option::weighted(0.3, prop::array::uniform3((0.0f64..0.45, 0.55f64..1.0)));
    let how = (0usize..3, any::<bool>(), any::<bool>(), 0.0f64..=1.0);
    (voxels(), transfer(), light, prop_oneof![Just(0.5), 0.1f64..3.0], clip, how).prop_map(
        |(voxels, transfer, light, step, clip, (shadows, gradient, fine, ambient))| {
            let mut scene = Scene::new(Arc::new(voxels.volume()), transfer);
            scene.step = step;
            scene.background = [0.2, 0.0, 0.4];
            scene.integration = if fine { Integration::Fine } else { Integration::Plain };
            scene.shading.ambient = ambient;
            scene.shading.shadows = [ShadowMode::On, ShadowMode::Off, ShadowMode::Cached][shadows];
            scene.shading.surface = if gradient { SurfaceShading::Gradient } else { SurfaceShading::Flat };
            scene.shading.light = Light::towards(light.map(f64::from).into()).unwrap();
            let ends = |i: usize| clip.map(|clip| DVec3::from_array(clip.map(|(low, high)| [low, high][i])));
            scene.clip = ends(0).zip(ends(1)).map(|(low, high)| {
                let dims = DVec3::from_array(voxels.dims.map(|d| d as f64));
                ClipBox::new(low * dims, high * dims, scene.volume.grid()).unwrap()
            });
            scene
        },
    )
}

fn camera() -> impl Strategy<Value = Camera> {
    let place = prop::array::uniform3(-1.5f64..1.5);
    let along_an_axis = (0usize..3, prop_oneof![Just(-1.4), Just(1.4)]).prop_map(|(axis, far)| {
        let mut eye = [0.0; 3];
        eye[axis] = far;
        eye
    });
    let eye = prop_oneof![2 => place, 1 => along_an_axis];
    (eye, 20.0f64..100.0)
        .prop_filter_map("eye at the target", |(eye, fovy)| Camera::new(eye.into(), DVec3::ZERO, fovy).ok())
}

fn is_sound(frame: &Frame) -> bool {
    frame.pixels().iter().flatten().all(|c| (0.0..=1.0001).contains(c))
}

/// The largest difference between the channels of two frames.
fn most_apart(a: &Frame, b: &Frame) -> f32 {
    let channels = a.pixels().iter().flatten().zip(b.pixels().iter().flatten());
    channels.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

fn config() -> ProptestConfig {
    let cases =
        if std::env::var_os("PROPTEST_CASES").is_some() { ProptestConfig::default().cases } else { 100 };
    ProptestConfig { cases, failure_persistence: None, ..Default::default() }
}

proptest! {
    #![proptest_config(config())]
    #[test]
    fn any_scene_is_sound_and_shows_the_same_when_empty_space_is_left_at_once(
        scene in scene(), camera in camera(), width in 1u32..70, height in 1u32..50,
    ) {
        let size = FrameSize::new(width, height).unwrap();
        for simd in available_simd() {
            let frames = [false, true].map(|skip_empty| {
                let renderer = Renderer::new(&scene, RenderOptions { simd, skip_empty }).unwrap();
                renderer.march_full(&camera, size).0
            });
            prop_assert!(frames.iter().all(is_sound), "{simd}");
            let most = most_apart(&frames[0], &frames[1]);
            prop_assert!(most <= 1e-3, "{simd}: {most}");
        }
    }
}
