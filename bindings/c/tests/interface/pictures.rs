//! Pictures are those of the library, byte for byte.

use crate::calls::*;
use fovolnet::core::{Camera, FrameSize, Grid, Volume};
use fovolnet::{
    Device, OpenVolume, Pipeline, RenderOverrides, RenderSettings, RenderedFrame, Sampling, ShadowRays,
    SpeedSettings, VolumeSettings, open_volume,
};
use fovolnet_c::*;
use std::ffi::c_void;
use std::ptr::{null, null_mut};
use std::sync::atomic::{AtomicUsize, Ordering};

const SIZE: FrameSize = FrameSize { width: 48, height: 32 };

fn head() -> OpenVolume {
    open_volume("head", &VolumeSettings { dims: Some([24; 3]), ..Default::default() }).unwrap()
}

fn pipeline(volume: &OpenVolume, settings: &RenderSettings) -> Pipeline {
    let speed = SpeedSettings { device: Some(Device::Cpu), threads: Some(2), ..Default::default() };
    Pipeline::new(volume, settings, &speed).unwrap()
}

fn rendered(volume: &OpenVolume, settings: RenderSettings) -> RenderedFrame {
    pipeline(volume, &RenderSettings { size: SIZE, ..settings }).render(0).unwrap()
}

#[test]
fn flags_and_objects_make_the_pictures_of_the_library() {
    let volume = VolumeHandle::named("head");
    let renderer = RendererHandle::showing(&volume, r#"{"shadow-rays": 4}"#.replace('4', "\"4\"").as_str());
    let settings = RenderSettings { shadow_rays: "4".parse::<ShadowRays>().unwrap(), ..Default::default() };
    let expected = rendered(&head(), settings.clone());
    assert_eq!(renderer.render(0).read(FOVOLNET_RGBA8), expected.frame.to_rgba8());
    assert_eq!(renderer.render(0).read(FOVOLNET_RGB8), expected.frame.to_rgb8());

    let (camera, light, function) = (CameraHandle::new(), LightHandle::new(), TransferHandle::new());
    let (eye, towards) = ([0.4, 0.9, 1.5], [-1.0, 0.2, 0.4]);
    let points = [[0.2, 0.1, 0.3, 0.9, 0.0], [1.0, 1.0, 0.9, 0.2, 0.6]];
    unsafe {
        ok(fovolnet_camera_look_at(camera.0, eye.as_ptr(), [0.1, 0.0, 0.0].as_ptr(), null()));
        ok(fovolnet_camera_set_fovy(camera.0, 40.0));
        ok(fovolnet_camera_commit(camera.0));
        ok(fovolnet_light_set_towards(light.0, towards.as_ptr()));
        ok(fovolnet_light_commit(light.0));
        ok(fovolnet_transfer_function_set_points(function.0, points.as_ptr().cast(), 2));
        ok(fovolnet_transfer_function_commit(function.0));
        ok(fovolnet_renderer_set_camera(renderer.0, camera.0));
        ok(fovolnet_renderer_set_light(renderer.0, light.0));
        ok(fovolnet_renderer_set_transfer_function(renderer.0, function.0));
    }
    // Pending objects do not count yet.
    assert_eq!(renderer.render(0).read(FOVOLNET_RGBA8), expected.frame.to_rgba8());
    renderer.commit();
    let camera_of = |fovy| Camera::new(eye.into(), [0.1, 0.0, 0.0].into(), fovy).unwrap();
    let points = points.map(Into::into).to_vec();
    let settings = RenderSettings {
        camera: camera_of(40.0).into(),
        light: fovolnet::core::Light::try_from(towards).unwrap(),
        transfer_function: fovolnet::core::TransferFunction::new(points).unwrap().into(),
        ..settings
    };
    let expected = rendered(&head(), settings.clone());
    assert_eq!(renderer.render(0).read(FOVOLNET_RGBA8), expected.frame.to_rgba8());
    // An object that is committed again counts without another commit of the renderer.
    unsafe {
        ok(fovolnet_camera_set_fovy(camera.0, 25.0));
        ok(fovolnet_camera_commit(camera.0));
        let (mut seen, mut up, mut fovy) = ([0.0; 3], [0.0; 3], 0.0);
        ok(fovolnet_renderer_camera(
            renderer.0,
            0,
            seen.as_mut_ptr(),
            null_mut(),
            up.as_mut_ptr(),
            &raw mut fovy,
        ));
        assert_eq!((seen, up, fovy), (eye, [0.0, 1.0, 0.0], 25.0));
    }
    let expected = rendered(&head(), RenderSettings { camera: camera_of(25.0).into(), ..settings });
    assert_eq!(renderer.render(0).floats(FOVOLNET_RGBA32F), expected.frame.pixels().as_flattened());
}

#[test]
fn up_is_up_in_the_picture() {
    let volume = VolumeHandle::named("head");
    let renderer = RendererHandle::showing(&volume, r#"{"size": [32, 32], "shadows": "off"}"#);
    let seen = |up: [f64; 3]| {
        let camera = CameraHandle::new();
        unsafe {
            ok(fovolnet_camera_look_at(camera.0, [0.0, 0.0, 2.0].as_ptr(), [0.0; 3].as_ptr(), up.as_ptr()));
            ok(fovolnet_camera_commit(camera.0));
            ok(fovolnet_renderer_set_camera(renderer.0, camera.0));
        }
        renderer.commit();
        renderer.render(0).floats(FOVOLNET_RGBA32F)
    };
    let (upright, turned) = (seen([0.0, 1.0, 0.0]), seen([1.0, 0.0, 0.0]));
    // With +x up, column x of the upright picture is row 31 - x, from left to right.
    let at = |picture: &[f32], x: usize, y: usize| picture[(y * 32 + x) * 4];
    let mut error = 0.0f32;
    for (x, y) in (0..32).flat_map(|x| (0..32).map(move |y| (x, y))) {
        error = error.max((at(&upright, x, y) - at(&turned, y, 31 - x)).abs());
    }
    assert!(error < 0.02, "{error}");
    assert_ne!(upright, turned);
}

static RELEASED: AtomicUsize = AtomicUsize::new(0);

unsafe extern "C" fn count(user: *mut c_void) {
    RELEASED.fetch_add(user as usize, Ordering::SeqCst);
}

#[test]
fn voxels_are_shown_where_they_lie_and_released_once() {
    let values: Vec<u16> = (0..24 * 20 * 16).map(|i| ((i * 37) % 500) as u16).collect();
    let lent =
        FovolnetVoxels { release: Some(count), user: 5 as *mut c_void, ..voxels(&values, [24, 20, 16]) };
    let volume = VolumeHandle::new();
    unsafe {
        ok(fovolnet_volume_set_voxels(volume.0, &raw const lent));
        let bad = FovolnetVoxels { bytes: 1, ..lent };
        fails(fovolnet_volume_set_voxels(volume.0, &raw const bad), FOVOLNET_ERROR_INVALID);
        ok(fovolnet_volume_set(volume.0, c"range".as_ptr(), c"0,400".as_ptr()));
        ok(fovolnet_volume_commit(volume.0));
    }
    let renderer = RendererHandle::showing(&volume, "{}");
    drop(volume);
    let grid = Grid::new([24, 20, 16], [1.0; 3]).unwrap();
    let own = Volume::from_values(grid, values.clone()).unwrap().with_range([0.0, 400.0]).unwrap();
    let expected = rendered(&own.into(), RenderSettings::default());
    let frame = renderer.render(0);
    assert_eq!(frame.read(FOVOLNET_RGBA8), expected.frame.to_rgba8());
    assert_eq!(RELEASED.load(Ordering::SeqCst), 0);
    drop(renderer);
    // The frame needs no voxels.
    assert_eq!(RELEASED.load(Ordering::SeqCst), 5);
    assert_eq!(frame.info().width, 48);
}

#[test]
fn volumes_lie_over_each_other() {
    let (head, lobb) = (VolumeHandle::named("head"), VolumeHandle::new());
    let function = TransferHandle::new();
    unsafe {
        // 128 voxels a side, as flags open it.
        ok(fovolnet_volume_set_source(lobb.0, c"marschner-lobb".as_ptr()));
        ok(fovolnet_volume_commit(lobb.0));
        ok(fovolnet_transfer_function_set(function.0, c"viridis".as_ptr()));
        ok(fovolnet_transfer_function_commit(function.0));
        ok(fovolnet_volume_add_overlay(head.0, lobb.0, function.0));
        ok(fovolnet_volume_commit(head.0));
    }
    let renderer = RendererHandle::showing(&head, "{}");
    let overlay = vec!["marschner-lobb@viridis".parse().unwrap()];
    let read = VolumeSettings { dims: Some([24; 3]), overlay: Some(overlay), ..Default::default() };
    let expected = rendered(&open_volume("head", &read).unwrap(), RenderSettings::default());
    assert_eq!(renderer.render(0).read(FOVOLNET_RGBA8), expected.frame.to_rgba8());
    let mut info = unsafe { std::mem::zeroed::<FovolnetVolumeInfo>() };
    info.size = size_of::<FovolnetVolumeInfo>();
    unsafe {
        ok(fovolnet_volume_info(head.0, &raw mut info));
        assert_eq!((info.layers, info.dtype), (2, FOVOLNET_I16));
        ok(fovolnet_volume_clear_overlays(head.0));
        ok(fovolnet_volume_commit(head.0));
    }
    let alone = rendered(&self::head(), RenderSettings::default());
    assert_eq!(renderer.render(0).read(FOVOLNET_RGBA8), alone.frame.to_rgba8());
}

#[test]
fn two_volumes_in_memory_are_no_channels() {
    let values: Vec<u16> = (0..512).collect();
    let [below, above] = [VolumeHandle::new(), VolumeHandle::new()];
    let lent = voxels(&values, [8, 8, 8]);
    unsafe {
        for volume in [&above, &below] {
            ok(fovolnet_volume_set_voxels(volume.0, &raw const lent));
            ok(fovolnet_volume_commit(volume.0));
        }
        ok(fovolnet_volume_add_overlay(below.0, above.0, null()));
        ok(fovolnet_volume_commit(below.0));
    }
    let notes =
        text_of(|text, capacity, length| unsafe { fovolnet_volume_notes(below.0, text, capacity, length) });
    assert!(!notes.contains("channels"), "{notes}");
}

#[test]
fn patients_stand_upright() {
    let values: Vec<u16> = (0..16 * 16 * 16).map(|i| (i / 256 * 20) as u16).collect();
    let directions = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
    let volume = VolumeHandle::new();
    let lent = FovolnetVoxels { space: FOVOLNET_SPACE_PATIENT, directions, ..voxels(&values, [16, 16, 16]) };
    unsafe {
        ok(fovolnet_volume_set_voxels(volume.0, &raw const lent));
        ok(fovolnet_volume_commit(volume.0));
    }
    let renderer = RendererHandle::showing(&volume, r#"{"tf": "viridis"}"#);
    let upright = renderer.render(0).read(FOVOLNET_RGB8);
    renderer.set("orientation", "grid");
    assert_ne!(renderer.render(0).read(FOVOLNET_RGB8), upright);
    let text = text_of(|text, capacity, length| unsafe {
        fovolnet_renderer_settings(renderer.0, text, capacity, length)
    });
    let settings: RenderOverrides = {
        let mut all: serde_json::Value = serde_json::from_str(&text).unwrap();
        for speed in ["device", "threads"] {
            all.as_object_mut().unwrap().remove(speed).unwrap();
        }
        serde_json::from_value(all).unwrap()
    };
    assert_eq!(settings.orientation, Some(fovolnet::Orientation::Grid));
    assert_eq!(settings.resolve().unwrap().sampling, Sampling::Full);
}
