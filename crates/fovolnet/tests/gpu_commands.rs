//! Counts the commands that frames take on a GPU.
#![cfg(all(feature = "gpu", feature = "procedural"))]

use fovolnet::core::{CameraPath, ShadowMode};
use fovolnet::gpu::{AdapterRequest, Commands, Gpu};
use fovolnet::{
    Density, Guide, OpenDevice, Pipeline, Reconstruction, RenderSettings, Sampling, SpeedSettings, Viewpoint,
    VolumeSettings, open_volume,
};

/// Commands of the fourth frame for a window, when earlier frames are remembered.
fn commands(gpu: &Gpu, settings: &RenderSettings) -> Commands {
    let volume = open_volume("head", &VolumeSettings { dims: Some([24; 3]), ..Default::default() }).unwrap();
    let device = OpenDevice::Gpu(gpu.clone());
    let mut pipeline = Pipeline::on(device, &volume, settings, &SpeedSettings::default()).unwrap();
    let mut before = gpu.commands();
    for i in 0..4 {
        before = gpu.commands();
        let viewpoint = Viewpoint { camera: pipeline.camera(i), fovea: pipeline.fovea(i) };
        assert!(pipeline.display_from(i, &viewpoint).unwrap().is_some(), "the frame left the device");
    }
    gpu.commands().since(before)
}

/// Every command waits for the one before it, so that a large GPU spends its time on their number.
#[test]
#[ignore = "needs an adapter: cargo test --release --workspace -- --ignored"]
fn sparse_frames_take_few_commands() {
    let gpu = Gpu::open(&AdapterRequest::Any.or_environment()).unwrap();
    let settings = RenderSettings {
        size: "96x64".parse().unwrap(),
        camera: CameraPath::Orbit.into(),
        sampling: Sampling::Compact,
        reconstruction: Reconstruction::WNet,
        shadows: ShadowMode::On,
        guide: Guide::None.into(),
        density: Density::Fixed.into(),
        ..Default::default()
    };
    let found = commands(&gpu, &settings);
    println!("{found:?}");
    assert!(
        found.dispatches + found.indirect <= 60 && found.indirect <= 1 && found.passes <= 25,
        "{found:?}"
    );
}
