//! Channels of frames, clips, planning.

use crate::calls::*;
use fovolnet::{Device, Pipeline, RenderOverrides, SpeedSettings, VolumeSettings, open_volume};
use fovolnet_c::*;
use std::ptr::null_mut;

const SPARSE: &str =
    r#"{"sampling": "compact", "reconstruct": "wnet", "pb": 0.2, "frames": 3, "path": "turntable"}"#;

#[test]
fn sparse_clips_are_those_of_the_library() {
    let volume = VolumeHandle::named("head");
    let renderer = RendererHandle::showing(&volume, SPARSE);
    unsafe { ok(fovolnet_renderer_find_motion(renderer.0, 1)) };
    renderer.commit();
    let read = VolumeSettings { dims: Some([24; 3]), ..Default::default() };
    let opened = open_volume("head", &read).unwrap();
    let mut given: RenderOverrides = serde_json::from_str(SPARSE).unwrap();
    given.size = Some(fovolnet::core::FrameSize { width: 48, height: 32 });
    let speed = SpeedSettings { device: Some(Device::Cpu), threads: Some(2), ..Default::default() };
    let mut pipeline = Pipeline::new(&opened, &given.resolve().unwrap(), &speed).unwrap();
    pipeline.find_motion();
    for i in 0..3 {
        let (frame, expected) = (renderer.render(i), pipeline.render(i).unwrap());
        assert_eq!(frame.floats(FOVOLNET_RGBA32F), expected.frame.pixels().as_flattened(), "frame {i}");
        let (info, sparse) = (frame.info(), expected.sparse.as_ref().unwrap());
        assert_eq!((info.index, info.samples), (i, expected.samples as u64));
        assert!(info.total_ms > 0.0 && info.march_ms > 0.0 && info.marched_width == 48);
        assert_eq!(frame.floats(FOVOLNET_SAMPLE_RGB32F), sparse.colours().as_flattened());
        assert_eq!(frame.floats(FOVOLNET_SAMPLE_DEPTH32F), sparse.depths());
        let places = frame.read(FOVOLNET_SAMPLE_PIXELS16);
        let x = u16::from_ne_bytes([places[0], places[1]]);
        assert_eq!((places.len(), x), (4 * sparse.len(), sparse.pixels()[0].x));
        let mask = frame.read(FOVOLNET_MASK8);
        assert_eq!(mask.iter().filter(|marched| **marched == 1).count(), expected.mask.count());
        let picture = frame.floats(FOVOLNET_SPARSE_RGBA32F);
        assert_eq!(picture, expected.samples_picture().pixels().as_flattened());
        let depths = frame.floats(FOVOLNET_DEPTH32F);
        assert!(depths.iter().zip(&mask).all(|(depth, marched)| *marched == 1 || depth.is_infinite()));
        if i == 0 {
            let mut bytes = 0;
            let status = unsafe { fovolnet_frame_bytes(frame.0, FOVOLNET_MOTION32F, &raw mut bytes) };
            assert!(fails(status, FOVOLNET_ABSENT).contains("fovolnet_renderer_find_motion"));
        } else {
            let motion = expected.motion.as_ref().unwrap();
            assert_eq!(frame.floats(FOVOLNET_MOTION32F), motion.as_flattened());
        }
    }
    // After a cut the first frame is as it was.
    let first = RendererHandle::showing(&volume, SPARSE).render(0).read(FOVOLNET_RGBA8);
    unsafe { ok(fovolnet_renderer_reset(renderer.0)) };
    assert_eq!(renderer.render(0).read(FOVOLNET_RGBA8), first);
}

#[test]
fn every_pixel_can_have_a_depth() {
    let volume = VolumeHandle::named("head");
    let renderer = RendererHandle::showing(&volume, "{}");
    let full = renderer.render(0);
    let mut bytes = 0;
    let status = unsafe { fovolnet_frame_bytes(full.0, FOVOLNET_DEPTH32F, &raw mut bytes) };
    assert!(fails(status, FOVOLNET_ABSENT).contains("pb to 1"));
    unsafe {
        let json = c(r#"{"sampling": "compact", "pb": 1, "reconstruct": "none"}"#);
        ok(fovolnet_renderer_set_json(renderer.0, json.as_ptr()));
    }
    renderer.commit();
    let listed = renderer.render(0);
    assert_eq!(listed.read(FOVOLNET_RGBA8), full.read(FOVOLNET_RGBA8));
    let depths = listed.floats(FOVOLNET_DEPTH32F);
    assert!(depths.iter().any(|depth| depth.is_infinite()) && depths.iter().any(|depth| *depth < 4.0));
    let mut reference = null_mut();
    unsafe { ok(fovolnet_renderer_reference(renderer.0, 0, &raw mut reference)) };
    let reference = FrameHandle(reference);
    assert_eq!(reference.read(FOVOLNET_RGBA8), full.read(FOVOLNET_RGBA8));
}

#[test]
fn rows_may_have_gaps_and_be_upside_down() {
    let volume = VolumeHandle::named("marschner-lobb");
    let frame = RendererHandle::showing(&volume, "{}").render(0);
    let (tight, row) = (frame.read(FOVOLNET_RGBA8), 48 * 4);
    let pitch = row + 24;
    for sign in [1, -1isize] {
        let mut buffer = vec![7u8; 32 * pitch - 24];
        let read = |buffer: &mut [u8], bytes: usize, pitch: isize| unsafe {
            fovolnet_frame_read(frame.0, FOVOLNET_RGBA8, buffer.as_mut_ptr().cast(), bytes, pitch)
        };
        let bytes = buffer.len();
        ok(read(&mut buffer, bytes, sign * pitch as isize));
        for y in 0..32 {
            let at = pitch * if sign > 0 { y } else { 31 - y };
            assert_eq!(buffer[at..at + row], tight[y * row..(y + 1) * row]);
            assert!(buffer[at + row..].iter().take(24).all(|byte| *byte == 7));
        }
        let text = fails(read(&mut buffer, bytes - 1, sign * pitch as isize), FOVOLNET_ERROR_INVALID);
        assert!(text.contains(&format!("needs {bytes}")), "{text}");
        fails(read(&mut buffer, bytes, sign * 8), FOVOLNET_ERROR_INVALID);
        fails(read(&mut buffer, bytes, isize::MIN), FOVOLNET_ERROR_INVALID);
    }
    let mut bytes = 0;
    let status = unsafe { fovolnet_frame_bytes(frame.0, 11, &raw mut bytes) };
    assert!(fails(status, FOVOLNET_ERROR_INVALID).contains("no channel 11"));
}

#[test]
fn texts_are_shortened_to_their_buffer() {
    let volume = VolumeHandle::named("marschner-lobb");
    let renderer = RendererHandle::showing(&volume, "{}");
    let mut buffer = [1i8; 4];
    let mut length = 0;
    unsafe {
        ok(fovolnet_renderer_settings(renderer.0, buffer.as_mut_ptr().cast(), 4, &raw mut length));
        fails(fovolnet_renderer_settings(renderer.0, null_mut(), 0, null_mut()), FOVOLNET_ERROR_INVALID);
    }
    assert_eq!(buffer.map(|byte| byte as u8), *b"{\"d\0");
    assert!(length > 20);
    let gpu = text_of(|text, capacity, length| unsafe {
        fovolnet_renderer_gpu(renderer.0, text, capacity, length)
    });
    assert_eq!(gpu, "");
    text_of(|text, capacity, length| unsafe { fovolnet_renderer_notes(renderer.0, text, capacity, length) });
}

#[test]
fn planned_frames_have_their_size() {
    let volume = VolumeHandle::named("head");
    let renderer = RendererHandle::showing(&volume, r#"{"budget": 0.5}"#);
    for i in 0..4 {
        let info = renderer.render(i).info();
        assert_eq!((info.width, info.height), (48, 32));
    }
    renderer.set("light", "1,0,0");
    assert!(renderer.render(4).info().plan_ms >= 0.0);
    renderer.set("quality", "fixed");
    assert_eq!(renderer.render(5).info().plan_ms, 0.0);
}
