//! A pipeline with changed settings renders the same frames as a new pipeline with those settings.

use fovolnet::core::{
    Camera, CameraPath, ClipPlane, ClipPlanes, GazePath, Integration, Interpolation, Projection, ShadowMode,
    SurfaceShading,
};
use fovolnet::{
    Choice, Device, Mode, OpenVolume, Pipeline, Reconstruction, RenderSettings, Sampling, SpeedSettings,
    Viewpoint, VolumeSettings, WeightsChoice, open_volume,
};
use glam::DVec3;

fn head() -> OpenVolume {
    open_volume("head", &VolumeSettings { dims: Some([32; 3]), ..Default::default() }).unwrap()
}

fn pipeline(settings: &RenderSettings, device: &Device) -> Pipeline {
    let speed = SpeedSettings { device: Some(device.clone()), ..Default::default() };
    Pipeline::new(&head(), settings, &speed).unwrap()
}

fn begin() -> RenderSettings {
    RenderSettings {
        size: "61x43".parse().unwrap(),
        camera: CameraPath::Orbit.into(),
        sampling: Sampling::Compact,
        pb: 0.1,
        reconstruction: "pull-push".parse().unwrap(),
        ..Default::default()
    }
}

fn planes(planes: &[[f64; 4]]) -> ClipPlanes {
    let plane = |&[x, y, z, distance]: &[f64; 4]| ClipPlane { normal: [x, y, z].into(), distance };
    ClipPlanes::new(&planes.iter().map(plane).collect::<Vec<_>>()).unwrap()
}

/// Changes of one setting each, applied one after another.
fn changes() -> Vec<fn(&mut RenderSettings)> {
    vec![
        |settings| settings.reconstruction = Reconstruction::WNet,
        |settings| settings.weights = WeightsChoice::Random("wnet-fast:3".parse().unwrap()),
        |settings| settings.weights = WeightsChoice::Usual,
        |settings| settings.first_frame = 7,
        |settings| settings.transfer_function = "viridis".into(),
        |settings| settings.light = [-1.0, 0.2, 0.1].try_into().unwrap(),
        |settings| settings.shadows = ShadowMode::Cached,
        |settings| settings.shading = SurfaceShading::Gradient,
        |settings| settings.ambient = 0.6,
        |settings| settings.background = [0.1, 0.2, 0.3],
        |settings| settings.step = 0.8,
        |settings| settings.interpolation = Interpolation::Nearest.into(),
        |settings| settings.interpolation = Choice::Auto,
        |settings| settings.integration = Integration::Plain,
        |settings| settings.planes = planes(&[[0.3, -0.5, 0.8, -0.05]]),
        |settings| (settings.mode, settings.iso) = (Mode::Isosurface, Some(400.0)),
        |settings| settings.iso = Some(-300.0),
        |settings| settings.mode = Mode::Average,
        |settings| settings.projection = Projection::Orthographic,
        |settings| settings.mode = Mode::Composite,
        |settings| settings.pb = 0.2,
        |settings| settings.sigma = 0.1,
        |settings| settings.gaze = GazePath::Fixed([0.2, 0.3]),
        |settings| settings.noise = "blue".parse().unwrap(),
        |settings| settings.sampling = Sampling::Direct,
        |settings| settings.seed = 3,
        |settings| settings.camera = CameraPath::Flythrough.into(),
        |settings| settings.camera = Camera::at(DVec3::new(0.0, 1.0, 2.0), DVec3::ZERO, 30.0).into(),
        |settings| settings.crop = Some([0.0, 0.6, 0.1, 1.0, 0.0, 1.0].into()),
        |settings| settings.crop = Some([0.0, 0.6, 0.1, 1.0, 0.2, 0.9].into()),
        |settings| settings.planes = planes(&[[0.3, -0.5, 0.8, 0.0], [0.0, 1.0, 0.0, -0.2]]),
        |settings| settings.size = "40x50".parse().unwrap(),
        |settings| settings.sampling = Sampling::Full,
        |settings| settings.transparent = true,
        |settings| settings.transparent = false,
        |settings| settings.sampling = Sampling::Reject,
        |settings| settings.reconstruction = Reconstruction::None,
    ]
}

fn check(device: &Device) {
    let mut settings = begin();
    let mut changed = pipeline(&settings, device);
    let mut before = changed.render(0).unwrap();
    for (i, change) in changes().into_iter().enumerate() {
        change(&mut settings);
        changed.change(&settings).unwrap();
        changed.reset();
        let mut fresh = pipeline(&settings, device);
        assert_eq!(changed.size(), fresh.size());
        let first = settings.frame_numbers().start;
        for frame in [first, first + 1] {
            let (changed, fresh) = (changed.render(frame).unwrap(), fresh.render(frame).unwrap());
            assert_eq!(changed.mask, fresh.mask, "change {i}, frame {frame}");
            assert!(changed.frame == fresh.frame, "change {i}, frame {frame}");
            if frame == first {
                assert!(changed.frame != before.frame, "change {i} shows nothing");
                before = changed;
            }
        }
        assert!(changed.reference(5).unwrap() == fresh.reference(5).unwrap(), "change {i}");
    }
}

#[test]
fn every_change_shows_as_if_begun_so() {
    check(&Device::Cpu);
}

#[test]
#[ignore = "needs an adapter: cargo test --release --workspace -- --ignored"]
fn every_change_shows_on_a_gpu() {
    check(&Device::Gpu(None));
}

#[test]
fn a_change_that_cannot_be_made_changes_nothing() {
    let mut pipeline = pipeline(&begin(), &Device::Cpu);
    let before = pipeline.reference(0).unwrap();
    let wrong: [fn(&mut RenderSettings); 5] = [
        |settings| settings.crop = Some([0.5, 0.4, 0.0, 1.0, 0.0, 1.0].into()),
        |settings| settings.transfer_function = "no-such".into(),
        |settings| settings.step = -1.0,
        |settings| settings.camera = Camera::at(DVec3::ONE, DVec3::ONE, 30.0).into(),
        |settings| {
            settings.reconstruction = Reconstruction::WNet;
            settings.weights = WeightsChoice::Named("no-such".into());
            settings.background = [1.0; 3];
        },
    ];
    for change in wrong {
        let mut settings = begin();
        change(&mut settings);
        pipeline.change(&settings).unwrap_err();
        assert!(pipeline.reference(0).unwrap() == before);
    }
}

#[test]
fn a_part_looks_as_it_looks_in_the_whole() {
    use fovolnet::core::{Grid, Volume};
    use std::sync::Arc;
    // Only the part inside the crop box is not empty.
    let grid = Grid::new([20, 30, 24], [1.0, 0.8, 1.2]).unwrap();
    let value = |i: usize| {
        let [x, y, z] = [i % 20, i / 20 % 30, i / 600];
        if (5..10).contains(&x) && (8..20).contains(&y) && (6..20).contains(&z) {
            (100 + i % 97) as u8
        } else {
            0
        }
    };
    let volume = Volume::from_values(grid, (0..grid.voxels()).map(value).collect()).unwrap();
    let volume = OpenVolume::of(Arc::new(volume), "part");
    let whole = RenderSettings { transfer_function: "grey".into(), sampling: Sampling::Full, ..begin() };
    let part = RenderSettings { crop: Some([0.2, 0.55, 0.2, 0.7, 0.2, 0.9].into()), ..whole.clone() };
    let [whole, part] = [whole, part].map(|settings| {
        Pipeline::new(&volume, &settings, &SpeedSettings::default()).unwrap().render(4).unwrap().frame
    });
    let far = whole.pixels().iter().zip(part.pixels()).filter(|(a, b)| {
        // Steps begin where rays enter the box, so surfaces are hit a little earlier or later.
        (0..3).any(|c| (a[c] - b[c]).abs() > 0.1)
    });
    let (far, seen) = (far.count(), whole.pixels().iter().filter(|p| p[0] > 0.1).count());
    assert!(seen > 100 && far * 20 < seen, "{far} of {seen} differ");
}

#[test]
fn somebody_may_stand_anywhere() {
    let settings = RenderSettings { reconstruction: Reconstruction::WNet, ..begin() };
    let [mut here, mut there] = [(); 2].map(|()| pipeline(&settings, &Device::Cpu));
    for i in 0..3 {
        let viewpoint = Viewpoint { camera: CameraPath::Orbit.camera(i), fovea: settings.fovea(i).unwrap() };
        assert!(here.render(i).unwrap().frame == there.render_from(i, &viewpoint).unwrap().frame);
    }
    let list = here.render(3).unwrap().mask;
    let list = fovolnet::render::cpu::compact(&list);
    let marched = here.march(&CameraPath::Orbit.camera(3), &list).unwrap();
    let full = here.reference(3).unwrap();
    for (pixel, marched) in list.pixels().iter().zip(marched) {
        assert_eq!(full.pixel(pixel.x.into(), pixel.y.into())[..3], marched.colour);
    }
}
