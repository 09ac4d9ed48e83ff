//! Reference frames: every pixel marched, with exact shadows.

use fovolnet::core::ShadowMode;
use fovolnet::render::cpu::compact;
use fovolnet::{Device, Pipeline, RenderSettings, Sampling, SpeedSettings, VolumeSettings, open_volume};

fn pipeline(settings: &RenderSettings) -> Pipeline {
    let volume = open_volume("head", &VolumeSettings { dims: Some([32; 3]), ..Default::default() }).unwrap();
    let speed = SpeedSettings { device: Some(Device::Cpu), ..Default::default() };
    Pipeline::new(&volume, settings, &speed).unwrap()
}

fn with(shadows: ShadowMode) -> RenderSettings {
    RenderSettings {
        size: "61x43".parse().unwrap(),
        sampling: Sampling::Compact,
        reconstruction: "pull-push".parse().unwrap(),
        shadows,
        ..Default::default()
    }
}

fn full(settings: RenderSettings) -> RenderSettings {
    RenderSettings { sampling: Sampling::Full, ..settings }
}

#[test]
fn shadows_are_exact_where_those_of_frames_are_cached() {
    let exact = pipeline(&full(with(ShadowMode::On))).render(3).unwrap().frame;
    let mut cached = pipeline(&with(ShadowMode::Cached));
    assert!(pipeline(&with(ShadowMode::On)).reference(3).unwrap() == exact);
    for _ in 0..2 {
        assert!(cached.reference(3).unwrap() == exact);
    }
    let full_cached = pipeline(&full(with(ShadowMode::Cached))).render(3).unwrap().frame;
    assert!(full_cached != exact, "both look alike, so nothing is tested");
}

#[test]
fn frames_keep_their_cached_shadows() {
    let [mut once, mut often] = [(); 2].map(|()| pipeline(&with(ShadowMode::Cached)));
    for i in 0..3 {
        let expected = once.render(i).unwrap().frame;
        assert!(often.render(i).unwrap().frame == expected, "{i}");
        often.reference(i).unwrap();
    }
}

#[test]
fn references_follow_changes_of_the_scene() {
    let mut settings = with(ShadowMode::Cached);
    let mut changed = pipeline(&settings);
    let changes: [fn(&mut RenderSettings); 5] = [
        |settings| settings.transfer_function = "viridis".into(),
        |settings| settings.light = [-1.0, 0.2, 0.1].try_into().unwrap(),
        |settings| settings.step = 0.8,
        |settings| settings.shadows = ShadowMode::Off,
        |settings| settings.shadows = ShadowMode::Cached,
    ];
    let mut before = changed.reference(0).unwrap();
    for (i, change) in changes.into_iter().enumerate() {
        change(&mut settings);
        changed.change(&settings).unwrap();
        let reference = changed.reference(0).unwrap();
        let shadows = match settings.shadows {
            ShadowMode::Off => ShadowMode::Off,
            _ => ShadowMode::On,
        };
        let fresh = pipeline(&RenderSettings { shadows, ..settings.clone() }).reference(0);
        assert!(reference == fresh.unwrap(), "change {i}");
        assert!(reference != before, "change {i} shows nothing");
        before = reference;
    }
}

#[test]
fn without_shadows_references_have_none_either() {
    let off = pipeline(&full(with(ShadowMode::Off))).render(0).unwrap().frame;
    assert!(pipeline(&with(ShadowMode::Off)).reference(0).unwrap() == off);
}

#[test]
fn transparent_references_have_exact_shadows() {
    let transparent = |shadows| RenderSettings { transparent: true, ..full(with(shadows)) };
    let exact = pipeline(&transparent(ShadowMode::On)).render(0).unwrap().frame;
    let mut cached = pipeline(&transparent(ShadowMode::Cached));
    assert!(cached.render(0).unwrap().frame != exact);
    assert!(cached.reference(0).unwrap() == exact);
}

#[test]
fn single_pixels_are_those_of_the_reference() {
    let mut cached = pipeline(&with(ShadowMode::Cached));
    let list = compact(&cached.render(0).unwrap().mask);
    let camera = cached.camera(0);
    let marched = cached.march_reference(&camera, &list).unwrap();
    let reference = cached.reference(0).unwrap();
    for (pixel, marched) in list.pixels().iter().zip(marched) {
        assert_eq!(reference.pixel(pixel.x.into(), pixel.y.into())[..3], marched.colour);
    }
}
