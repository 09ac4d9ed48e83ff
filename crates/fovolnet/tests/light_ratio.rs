//! Frames whose light ratio is reconstructed.

use fovolnet::core::{CameraPath, Integration, ShadowMode, SurfaceShading};
use fovolnet::metrics::psnr;
use fovolnet::{
    Device, Guide, OpenVolume, Pipeline, Reconstruction, RenderSettings, Sampling, SpeedSettings,
    VolumeSettings, open_volume,
};

fn volume(name: &str) -> OpenVolume {
    open_volume(name, &VolumeSettings { dims: Some([48; 3]), ..Default::default() }).unwrap()
}

/// Settings of frames whose pixels are finer than voxels.
fn settings(guide: Guide) -> RenderSettings {
    RenderSettings {
        size: "400x300".parse().unwrap(),
        camera: CameraPath::Orbit.into(),
        sampling: Sampling::Compact,
        background: [0.1, 0.3, 0.2],
        guide: guide.into(),
        ..Default::default()
    }
}

fn pipeline(settings: &RenderSettings) -> Pipeline {
    pipeline_of(&volume("head"), settings)
}

fn pipeline_of(volume: &OpenVolume, settings: &RenderSettings) -> Pipeline {
    let speed = SpeedSettings { device: Some(Device::Cpu), ..Default::default() };
    let mut pipeline = Pipeline::new(volume, settings, &speed).unwrap();
    pipeline.keep_guide();
    pipeline
}

/// PSNR of frame 5 against the reference.
fn quality(settings: &RenderSettings) -> f64 {
    quality_of(pipeline(settings))
}

fn quality_of(mut pipeline: Pipeline) -> f64 {
    let frames: Vec<_> = (0..6).map(|i| pipeline.render(i).unwrap().frame).collect();
    psnr(&pipeline.reference(5).unwrap(), &frames[5]).unwrap()
}

#[test]
fn a_denser_guide_is_better_and_none_the_worst() {
    for (shading, least) in [(SurfaceShading::Flat, 4.0), (SurfaceShading::Gradient, 0.5)] {
        let of = |guide| quality(&RenderSettings { shading, ..settings(guide) });
        let [none, quarter, full] = [Guide::None, Guide::Quarter, Guide::Full].map(of);
        assert!(quarter > none + least && full > quarter + 0.5, "{shading:?}: {none} {quarter} {full}");
    }
}

/// In haze a guide with cached shadows already knows most of the light.
#[test]
fn cached_shadows_make_a_better_guide_in_haze() {
    let haze = volume("vortices");
    let of = |guide| {
        let settings = RenderSettings { transfer_function: "head".into(), ..settings(guide) };
        quality_of(pipeline_of(&haze, &settings))
    };
    let [quarter, cached] = [Guide::Quarter, Guide::Cached].map(of);
    assert!(cached > quarter + 2.0, "{quarter} {cached}");
}

#[test]
fn few_shadow_rays_are_almost_as_good_and_every_run_is_the_same() {
    for integration in [Integration::Plain, Integration::Fine] {
        let settings = |rays: &str| RenderSettings {
            integration,
            shadow_rays: rays.parse().unwrap(),
            ..settings(Guide::Quarter)
        };
        let [exact, many, one] = ["exact", "32", "1"].map(|rays| quality(&settings(rays)));
        assert!(many > exact - 1.0 && one < exact - 5.0, "{integration}: {exact} {many} {one}");
        let [first, again] = [(); 2].map(|()| pipeline(&settings("8")).render(3).unwrap().frame);
        assert_eq!(first.pixels(), again.pixels());
    }
}

#[test]
fn any_method_fills_light_ratios() {
    for how in ["linear", "pull-push", "deepfovea"] {
        let how: Reconstruction = how.parse().unwrap();
        let of = |guide| quality(&RenderSettings { reconstruction: how, ..settings(guide) });
        let [none, quarter] = [Guide::None, Guide::Quarter].map(of);
        assert!(quarter > none + 3.0, "{how}: {none} {quarter}");
    }
}

#[test]
fn without_shadows_a_full_guide_is_the_frame() {
    let linear = "linear".parse().unwrap();
    let settings =
        RenderSettings { shadows: ShadowMode::Off, reconstruction: linear, ..settings(Guide::Full) };
    let mut pipeline = pipeline(&settings);
    for i in 0..2 {
        let rendered = pipeline.render(i).unwrap();
        let reference = pipeline.reference(i).unwrap();
        let all = rendered.frame.pixels().iter().flatten().zip(reference.pixels().iter().flatten());
        let most = all.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(most < 1e-4, "{most}");
        let marched = rendered.guide_samples + rendered.samples;
        assert!(marched > 20_000 && marched <= 400 * 300, "{marched}");
    }
}

#[test]
fn every_sampling_has_a_guide_and_samples_stay_exact() {
    for sampling in [Sampling::Compact, Sampling::Reject, Sampling::Direct] {
        let settings = RenderSettings { sampling, pb: 0.1, ..settings(Guide::Quarter) };
        let mut pipeline = pipeline(&settings);
        let rendered = pipeline.render(3).unwrap();
        let sparse = rendered.sparse.as_ref().unwrap();
        for (pixel, colour) in sparse.pixels().iter().zip(sparse.colours()) {
            let shown = rendered.frame.pixel(pixel.x.into(), pixel.y.into());
            assert_eq!(shown[..3], colour[..], "{sampling} {pixel:?}");
        }
        let reference = pipeline.reference(3).unwrap();
        assert!(psnr(&reference, &rendered.frame).unwrap() > 25.0, "{sampling}");
        let kept = rendered.guide.unwrap();
        let guide = kept.guide.to_frame(reference.size());
        assert!(guide.pixels().iter().any(|p| p[3] > 0.9) && kept.ratio.pixels().iter().any(|p| p[0] < 0.9));
    }
}

#[test]
fn auto_means_a_quarter_with_shadows_and_the_default_network() {
    let auto = RenderSettings { guide: fovolnet::Choice::Auto, ..settings(Guide::None) };
    let of = |settings: RenderSettings| settings.guide_kind();
    assert_eq!(of(auto.clone()), Guide::Quarter);
    assert_eq!(of(RenderSettings { shadows: ShadowMode::Cached, ..auto.clone() }), Guide::None);
    assert_eq!(of(RenderSettings { shadows: ShadowMode::Off, ..auto.clone() }), Guide::None);
    assert_eq!(of(RenderSettings { sampling: Sampling::Full, ..auto.clone() }), Guide::None);
    let linear = "linear".parse().unwrap();
    assert_eq!(of(RenderSettings { reconstruction: linear, ..auto.clone() }), Guide::None);
    let paper = fovolnet::WeightsChoice::Named("wnet-paper".into());
    assert_eq!(of(RenderSettings { weights: paper, ..auto }), Guide::None);
    assert_eq!(of(settings(Guide::Full)), Guide::Full);
}
