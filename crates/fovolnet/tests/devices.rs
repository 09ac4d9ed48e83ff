//! The pipeline on a graphics processor makes what it makes on the processor.
#![cfg(feature = "gpu")]

use fovolnet::core::{Frame, ShadowMode};
use fovolnet::net::Fill;
use fovolnet::{
    Device, OpenVolume, Pipeline, Reconstruction, RenderSettings, Sampling, SpeedSettings, VolumeSettings,
    open_volume,
};

fn head() -> OpenVolume {
    open_volume("head", &VolumeSettings { dims: Some([40; 3]), ..Default::default() }).unwrap()
}

fn pipeline(settings: &RenderSettings, device: Device) -> Pipeline {
    let speed = SpeedSettings { device: Some(device), ..Default::default() };
    Pipeline::new(&head(), settings, &speed).unwrap()
}

/// The largest difference of any channel.
fn difference(a: &Frame, b: &Frame) -> f32 {
    let pairs = a.pixels().iter().flatten().zip(b.pixels().iter().flatten());
    pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

fn settings(sampling: Sampling, reconstruct: Reconstruction) -> RenderSettings {
    RenderSettings {
        size: Some("83x47".parse().unwrap()),
        sampling: Some(sampling),
        reconstruct: Some(reconstruct),
        pb: Some(0.1),
        sigma: Some(0.1),
        shadows: Some(ShadowMode::On),
        ..Default::default()
    }
}

#[test]
#[ignore = "needs an adapter: cargo test --release --workspace -- --ignored"]
fn frames_are_those_of_the_processor() {
    for sampling in Sampling::ALL {
        for reconstruct in [
            Reconstruction::None,
            Reconstruction::Fill(Fill::PullPush),
            Reconstruction::Fill(Fill::Linear),
            Reconstruction::WNet,
        ] {
            let settings = settings(sampling, reconstruct);
            let mut both = [Device::Cpu, Device::Gpu(None)].map(|device| pipeline(&settings, device));
            for pipeline in &mut both {
                pipeline.find_motion();
            }
            assert!(both[0].machine().gpu.is_none() && both[1].machine().gpu.is_some());
            for i in 0..3 {
                let name = format!("{sampling:?} {reconstruct:?} {i}");
                let [cpu, gpu] = both.each_mut().map(|pipeline| pipeline.render(i).unwrap());
                assert_eq!(cpu.mask, gpu.mask, "{name}");
                assert_eq!((cpu.samples, cpu.lost), (gpu.samples, gpu.lost), "{name}");
                assert!(difference(&cpu.sparse, &gpu.sparse) <= 2.0 / 255.0, "{name}");
                // Networks may tell old from new otherwise where a depth differs.
                assert!(difference(&cpu.frame, &gpu.frame) <= 8.0 / 255.0, "{name}");
                assert_eq!(cpu.motion.is_some(), gpu.motion.is_some(), "{name}");
            }
            let [cpu, gpu] = both.each_mut().map(|pipeline| pipeline.reference(7).unwrap());
            assert!(difference(&cpu, &gpu) <= 2.0 / 255.0, "{sampling:?}");
        }
    }
}

#[test]
#[ignore = "needs an adapter: cargo test --release --workspace -- --ignored"]
fn software_is_announced() {
    let settings = settings(Sampling::Compact, Reconstruction::None);
    let made = pipeline(&settings, Device::Gpu(None));
    let software = made.machine().gpu.unwrap().contains("llvmpipe");
    assert_eq!(made.notes().iter().any(|note| note.contains("program on the processor")), software);
    if software {
        // What `auto` never takes.
        assert_eq!(pipeline(&settings, Device::Auto).machine().gpu, None);
    }
}

#[test]
fn a_device_that_is_not_there_is_an_error() {
    let speed =
        SpeedSettings { device: Some(Device::Gpu(Some("no such device".into()))), ..Default::default() };
    let error = Pipeline::new(&head(), &RenderSettings::default(), &speed).unwrap_err();
    assert!(error.to_string().starts_with("no GPU can be used: "), "{error}");
}
