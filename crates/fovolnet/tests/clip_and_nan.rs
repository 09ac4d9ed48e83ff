//! Crop boxes and colours of NaN from the settings.

use fovolnet::core::{
    Camera, CameraPath, FrameSize, Grid, Integration, Pixel, SampleList, ShadowMode, Volume,
};
use fovolnet::{
    Device, NanColour, OpenVolume, Pipeline, RenderOverrides, RenderSettings, SpeedSettings, presets,
};
use std::sync::Arc;

const SIZE: FrameSize = FrameSize { width: 48, height: 36 };

fn open(volume: Volume) -> OpenVolume {
    OpenVolume::of(Arc::new(volume), "made")
}

fn settings(tf: &str) -> RenderSettings {
    RenderSettings {
        size: SIZE,
        transfer_function: tf.into(),
        shadows: ShadowMode::Off,
        ..Default::default()
    }
}

fn pipeline(volume: &OpenVolume, settings: &RenderSettings) -> Pipeline {
    let speed = SpeedSettings { device: Some(Device::Cpu), ..Default::default() };
    Pipeline::new(volume, settings, &speed).unwrap()
}

/// Ray result at the centre of the picture of `camera`: red, green, blue, opacity and depth.
fn middle(pipeline: &mut Pipeline, camera: &Camera) -> [f64; 5] {
    let list = SampleList::new(SIZE, vec![Pixel { x: 24, y: 18 }]);
    let found = pipeline.march(camera, &list).unwrap()[0];
    let [r, g, b] = found.colour;
    [r, g, b, found.opacity, found.depth].map(f64::from)
}

#[test]
fn a_part_of_half_a_hundredth_has_the_opacity_of_that_length() {
    let grid = Grid::new([32; 3], [1.0; 3]).unwrap();
    let volume = open(Volume::from_values(grid, vec![128u8; 32 * 32 * 32]).unwrap());
    let white = r#"{"points":[[0,1,1,1,0.4],[1,1,1,1,0.4]]}"#;
    let camera = Camera::new([0.2, 0.1, 2.0].into(), [0.0; 3].into(), 20.0).unwrap();
    for (integration, step, most) in [(Integration::Fine, 0.5, 1e-4), (Integration::Plain, 0.01, 6e-3)] {
        for (from, to) in [(0.5, 0.505), (0.5, 0.53125), (0.2345, 0.9), (0.0, 1.0), (0.0001, 0.01)] {
            let settings = RenderSettings {
                crop: Some([0.0, 1.0, 0.0, 1.0, from, to].into()),
                integration,
                step,
                ..settings(white)
            };
            let ray = camera.rays(SIZE).ray(24, 18);
            let found = middle(&mut pipeline(&volume, &settings), &camera);
            let voxels = (to - from) * 32.0 / -ray.direction.z;
            let right = 1.0 - 0.6f64.powf(voxels);
            // Rays end once they are nearly opaque.
            let is_opaque = found[3] >= 0.999 && right >= 0.999;
            assert!(
                is_opaque || (found[3] - right).abs() < most,
                "{integration} {from} {to}: {} for {right}",
                found[3]
            );
            // The depth, where opacity passes one half or else the mean distance, lies within the part.
            let [near, far] = [to, from].map(|side| (ray.origin.z - (side - 0.5)) / -ray.direction.z);
            let voxel = 1.0 / 32.0;
            assert!(
                (near - 0.6 * voxel..far + 0.6 * voxel).contains(&found[4]),
                "{near} {far}: {}",
                found[4]
            );
        }
    }
}

#[test]
fn changed_parts_are_those_begun_with() {
    let grid = Grid::new([20, 30, 24], [1.0, 0.8, 1.2]).unwrap();
    let values = (0..grid.voxels()).map(|i| (i * 7 % 251) as u8).collect();
    let volume = open(Volume::from_values(grid, values).unwrap());
    let camera = CameraPath::Orbit.camera(40);
    let mut changed = pipeline(&volume, &settings("grey"));
    let pixels = (0..36).flat_map(|y| (0..48).map(move |x| Pixel { x, y }));
    let list = SampleList::new(SIZE, pixels.collect());
    let mut last = changed.march(&camera, &list).unwrap();
    for crop in [
        [0.0, 1.0, 0.0, 1.0, 0.001, 1.0],
        [0.41, 0.62, 0.0, 0.9, 0.1, 0.77],
        [0.41, 0.63, 0.0, 0.9, 0.1, 0.77],
    ] {
        let settings = RenderSettings { crop: Some(crop.into()), ..settings("grey") };
        changed.change(&settings).unwrap();
        let found = changed.march(&camera, &list).unwrap();
        assert_eq!(found, pipeline(&volume, &settings).march(&camera, &list).unwrap());
        assert_ne!(found, last);
        last = found;
    }
}

#[test]
fn nan_looks_as_was_said() {
    let folder = tempfile::tempdir().unwrap();
    let map = folder.path().join("map.json");
    let with = |nan: &str| {
        format!(
            r#"[{{"Name":"m","ColorSpace":"RGB","RGBPoints":[0,0,1,0,10,0,1,0],"Points":[0,0,0.5,0,10,0,0.5,0]{nan}}}]"#
        )
    };
    std::fs::write(&map, with(r#","NanColor":[1,0.5,0],"NanOpacity":0.25"#)).unwrap();
    let map = map.to_str().unwrap();
    let grid = Grid::new([8; 3], [1.0; 3]).unwrap();
    let value = |i: usize| if i.is_multiple_of(2) { f32::NAN } else { (i % 11) as f32 };
    let volume = open(Volume::from_values(grid, (0..512).map(value).collect()).unwrap());
    let camera = Camera::new([0.05, 0.02, 2.0].into(), [0.0; 3].into(), 20.0).unwrap();
    let along = -1.0 / camera.rays(SIZE).ray(24, 18).direction.z;
    // Every second voxel of a row is NaN, so everything between neighbours is NaN.
    let right = |a: f64| 1.0 - (1.0 - a).powf(8.0 * along);
    for (nan, [r, g, b, a]) in [
        (NanColour::default(), [0.0; 4]),
        (NanColour::File, [1.0, 0.5, 0.0, 0.25]),
        (NanColour::Colour([0.0, 0.2, 1.0, 0.1]), [0.0, 0.2, 1.0, 0.1]),
    ] {
        for integration in [Integration::Fine, Integration::Plain] {
            let settings = RenderSettings { nan, integration, step: 0.02, ..settings(map) };
            let found = middle(&mut pipeline(&volume, &settings), &camera);
            for (found, colour) in found.into_iter().zip([r, g, b, 1.0]) {
                let right = colour * right(a);
                assert!((found - right).abs() < 0.005, "{integration} {nan:?}: {found} for {right}");
            }
        }
    }
    let given = |nan| RenderOverrides { nan, tf: Some(map.into()), ..Default::default() };
    let notes = |nan| presets::notes(&given(nan), &volume).join("; ");
    assert!(notes(None).contains("(1,0.5,0,0.25) is left out; --nan file uses it"), "{}", notes(None));
    assert!(!notes(Some(NanColour::File)).contains("NaN"));
    std::fs::write(map, with("")).unwrap();
    assert!(!notes(None).contains("NaN") && notes(Some(NanColour::File)).contains("--nan R,G,B,A gives one"));
    // A volume without NaN needs no note.
    let whole = open(Volume::from_values(grid, (0..512).map(|i| i as f32).collect()).unwrap());
    assert!(!presets::notes(&given(Some(NanColour::File)), &whole).join("; ").contains("NaN"));
}
