//! Densities that follow the last frame.

use fovolnet::core::CameraPath;
use fovolnet::metrics::ClipQuality;
use fovolnet::{
    Choice, Density, Device, Guide, OpenVolume, Pipeline, RenderSettings, Sampling, SpeedSettings,
    VolumeSettings, open_volume,
};

fn head() -> OpenVolume {
    open_volume("head", &VolumeSettings { dims: Some([64; 3]), ..Default::default() }).unwrap()
}

fn settings(density: Density, guide: Guide) -> RenderSettings {
    RenderSettings {
        size: "400x300".parse().unwrap(),
        camera: CameraPath::Orbit.into(),
        sampling: Sampling::Compact,
        sigma: 0.0,
        density: density.into(),
        guide: guide.into(),
        ..Default::default()
    }
}

fn pipeline(settings: &RenderSettings) -> Pipeline {
    let speed = SpeedSettings { device: Some(Device::Cpu), ..Default::default() };
    Pipeline::new(&head(), settings, &speed).unwrap()
}

/// PSNR over frames 4 to 7, and the samples of each frame.
fn quality(settings: &RenderSettings) -> (f64, Vec<usize>) {
    let mut pipeline = pipeline(settings);
    let (mut quality, mut samples) = (ClipQuality::new(), Vec::new());
    for i in 0..8 {
        let rendered = pipeline.render(i).unwrap();
        samples.push(rendered.samples);
        if i >= 4 {
            quality.push(&pipeline.reference(i).unwrap(), &rendered.frame).unwrap();
        }
    }
    (quality.summary().unwrap().psnr, samples)
}

#[test]
fn the_same_number_of_samples_gives_better_frames() {
    for guide in [Guide::None, Guide::Quarter] {
        let [(fixed, all), (adaptive, some)] =
            [Density::Fixed, Density::Adaptive].map(|density| quality(&settings(density, guide)));
        assert!(adaptive > fixed + 1.0, "{guide}: {fixed} {adaptive}");
        assert_eq!(all[0], some[0]);
        // Adaptive masks have no samples where nothing can be seen.
        assert!(some[1..].iter().zip(&all[1..]).all(|(some, all)| some < all), "{some:?} {all:?}");
    }
}

#[test]
fn a_cut_forgets_where_samples_were_needed() {
    let mut pipeline = pipeline(&settings(Density::Adaptive, Guide::Quarter));
    let first = pipeline.render(3).unwrap();
    let second = pipeline.render(3).unwrap();
    assert_ne!(first.mask, second.mask);
    pipeline.reset();
    assert_eq!(pipeline.render(3).unwrap().mask, first.mask);
}

#[test]
fn auto_is_adaptive_for_the_default_network_alone() {
    let auto = RenderSettings { density: Choice::Auto, ..settings(Density::Fixed, Guide::None) };
    assert_eq!(auto.density_kind(), Density::Adaptive);
    let paper = fovolnet::WeightsChoice::Named("wnet-paper".into());
    for fixed in [
        RenderSettings { sampling: Sampling::Full, ..auto.clone() },
        RenderSettings { sampling: Sampling::Reject, ..auto.clone() },
        RenderSettings { sampling: Sampling::Direct, ..auto.clone() },
        RenderSettings { reconstruction: "linear".parse().unwrap(), ..auto.clone() },
        RenderSettings { reconstruction: "none".parse().unwrap(), ..auto.clone() },
        RenderSettings { weights: paper, ..auto },
    ] {
        assert_eq!(fixed.density_kind(), Density::Fixed, "{fixed:?}");
    }
}
