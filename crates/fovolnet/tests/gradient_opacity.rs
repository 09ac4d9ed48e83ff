//! Opacity by gradient in pictures, sessions, notes and sparse frames.

use fovolnet::core::{Frame, FrameSize, Integration};
use fovolnet::{
    Device, OpenVolume, Pipeline, RenderOverrides, Session, SpeedSettings, VolumeSettings, open_volume,
};

const POINTS: &str = r#""points":[[0,0,0,0,0],[0.1,1,0.8,0.6,0],[0.2,1,0.8,0.6,0.1],[1,1,1,1,0.5]]"#;

fn borders() -> String {
    format!(r#"{{{POINTS},"gradient":[[0.02,0],[0.1,1]]}}"#)
}

fn head() -> OpenVolume {
    let read = VolumeSettings { dims: Some([32; 3]), ..VolumeSettings::default() };
    open_volume("head", &read).unwrap()
}

fn settings(tf: &str) -> RenderOverrides {
    RenderOverrides {
        size: Some(FrameSize { width: 96, height: 64 }),
        sampling: Some("full".parse().unwrap()),
        tf: Some(tf.into()),
        ..RenderOverrides::default()
    }
}

fn pipeline(settings: &RenderOverrides) -> Pipeline {
    Pipeline::new(&head(), &settings.resolve().unwrap(), &SpeedSettings::default()).unwrap()
}

fn picture(settings: &RenderOverrides) -> Frame {
    pipeline(settings).render(0).unwrap().frame
}

/// Mean of all colours of `frame`.
fn brightness(frame: &Frame) -> f32 {
    frame.pixels().iter().flat_map(|pixel| &pixel[..3]).sum::<f32>() / (3 * frame.pixels().len()) as f32
}

#[test]
fn pictures_show_less_and_notes_name_the_integration() {
    let [whole, borders] = [format!("{{{POINTS}}}"), borders()].map(|tf| settings(&tf));
    assert_ne!(picture(&whole), picture(&borders));
    let note = |settings: &RenderOverrides| {
        pipeline(settings).notes().iter().any(|note| note.contains("--integration plain"))
    };
    assert!(note(&borders) && !note(&whole));
    let plain = RenderOverrides { integration: Some(Integration::Plain), ..borders.clone() };
    assert!(!note(&plain) && picture(&plain) == picture(&borders));
}

#[test]
fn sessions_keep_it() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("session.toml");
    let file = folder.path().join("borders.json");
    std::fs::write(&file, borders()).unwrap();
    for tf in [borders(), file.display().to_string()] {
        let session = Session::new("head", VolumeSettings::default(), settings(&tf)).unwrap();
        session.write(&path).unwrap();
        let saved = Session::read(&path).unwrap();
        assert_eq!(picture(&saved.render), picture(&settings(&borders())));
    }
}

#[test]
fn a_pipeline_goes_over_to_it_and_back() {
    let [whole, borders] = [format!("{{{POINTS}}}"), borders()].map(|tf| settings(&tf));
    for shadows in ["on", "cached"] {
        let with = |settings: &RenderOverrides| RenderOverrides {
            shadows: Some(serde_json::from_value(shadows.into()).unwrap()),
            ..settings.clone()
        };
        let mut pipeline = pipeline(&with(&whole));
        for settings in [&borders, &whole, &borders] {
            pipeline.change(&with(settings).resolve().unwrap()).unwrap();
            assert_eq!(pipeline.render(0).unwrap().frame, picture(&with(settings)), "{shadows}");
        }
    }
}

#[test]
fn networks_rebuild_sparse_frames() {
    let mut render = settings(&borders());
    render.sampling = Some("compact".parse().unwrap());
    render.pb = Some(0.2);
    render.reconstruct = Some("wnet".parse().unwrap());
    for (shadows, guide) in
        [("on", "none"), ("on", "quarter"), ("on", "cached"), ("off", "none"), ("cached", "none")]
    {
        render.shadows = Some(serde_json::from_value(shadows.into()).unwrap());
        render.guide = Some(guide.parse().unwrap());
        let mut pipeline = pipeline(&render);
        let frame = (0..3).map(|frame| pipeline.render(frame).unwrap()).last().unwrap();
        let whole = pipeline.reference(2).unwrap();
        assert!(brightness(&whole) > 0.01);
        let psnr = fovolnet::metrics::psnr(&whole, &frame.frame).unwrap();
        assert!(psnr > 24.0, "{shadows} {guide}: {psnr}");
    }
}

#[test]
#[ignore = "needs an adapter: cargo test --release --workspace -- --ignored"]
fn the_processor_takes_the_place_of_a_gpu() {
    let device = Device::Gpu(None).open().unwrap();
    let expected = picture(&settings(&borders()));
    let [whole, borders] = [format!("{{{POINTS}}}"), borders()].map(|tf| settings(&tf).resolve().unwrap());
    let on = |settings, speed: &SpeedSettings| Pipeline::on(device.clone(), &head(), settings, speed);
    let required = SpeedSettings { device: Some(Device::Gpu(None)), ..SpeedSettings::default() };
    let error = on(&borders, &required).unwrap_err().to_string();
    assert!(error.contains("opacity by gradient") && error.contains("--device gpu"), "{error}");
    let mut pipeline = on(&borders, &SpeedSettings::default()).unwrap();
    let replaced =
        |pipeline: &Pipeline| pipeline.notes().iter().any(|note| note.contains("gradient is rendered on"));
    assert!(replaced(&pipeline) && pipeline.machine().gpu.is_none());
    assert_eq!(pipeline.render(0).unwrap().frame, expected);
    pipeline.change(&whole).unwrap();
    assert!(!replaced(&pipeline) && pipeline.machine().gpu.is_some());
    pipeline.change(&borders).unwrap();
    assert!(pipeline.machine().gpu.is_none());
    assert_eq!(pipeline.render(0).unwrap().frame, expected);
    let mut pipeline = on(&whole, &required).unwrap();
    assert!(pipeline.change(&borders).is_err() && pipeline.machine().gpu.is_some());
    pipeline.render(0).unwrap();
}
