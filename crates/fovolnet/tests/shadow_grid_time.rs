//! The time of cached shadows is known, and counts for the frame that waited for them.

use fovol_core::ShadowMode;
use fovolnet::{Device, Pipeline, RenderSettings, SpeedSettings, VolumeSettings, open_volume};

#[test]
fn the_making_of_cached_shadows_takes_time_that_counts() {
    let read = VolumeSettings { dims: Some([24; 3]), ..VolumeSettings::default() };
    let volume = open_volume("head", &read).unwrap();
    let settings =
        |shadows| RenderSettings { size: "32x24".parse().unwrap(), shadows, ..RenderSettings::default() };
    let speed = SpeedSettings { device: Some(Device::Cpu), ..SpeedSettings::default() };
    let mut pipeline = Pipeline::new(&volume, &settings(ShadowMode::Cached), &speed).unwrap();
    let ms = pipeline.shadow_grid_ms();
    assert!(ms > 0.0);
    let alone = pipeline.render(0).unwrap().timings;
    let with = alone.with_shadow_grid(ms);
    assert_eq!([with.march, with.total], [alone.march + ms, alone.total + ms]);
    assert_eq!([with.mask, with.reconstruct], [alone.mask, alone.reconstruct]);
    pipeline.change(&settings(ShadowMode::On)).unwrap();
    assert_eq!(pipeline.shadow_grid_ms(), 0.0);
}
