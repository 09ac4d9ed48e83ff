//! Cancelling. It ends all calls of a process, so this test is alone in its own.

// SAFETY of all calls here: handles are valid.
#![allow(clippy::undocumented_unsafe_blocks)]

mod common;

use common::*;
use fovolnet_c::*;
use std::ptr::null_mut;
use std::time::{Duration, Instant};

#[test]
fn other_threads_cancel_frames() {
    // Nothing is at work, so nothing happens.
    fovolnet_cancel();
    let volume = VolumeHandle::named("head");
    let renderer = RendererHandle::showing(&volume, "{}");
    let before = renderer.render(0).read(FOVOLNET_RGBA8);
    // Minutes of work.
    let json = c(r#"{"size": [8000, 6000], "step": 0.01}"#);
    unsafe { ok(fovolnet_renderer_set_json(renderer.0, json.as_ptr())) };
    renderer.commit();
    let started = Instant::now();
    std::thread::scope(|scope| {
        scope.spawn(|| {
            std::thread::sleep(Duration::from_millis(300));
            fovolnet_cancel();
        });
        let mut frame = null_mut();
        let status = unsafe { fovolnet_renderer_render(renderer.0, 0, &raw mut frame) };
        fails(status, FOVOLNET_CANCELLED);
        assert!(frame.is_null());
    });
    assert!(started.elapsed() < Duration::from_secs(20), "{:?}", started.elapsed());
    let json = c(r#"{"size": [48, 32], "step": null}"#);
    unsafe { ok(fovolnet_renderer_set_json(renderer.0, json.as_ptr())) };
    renderer.commit();
    assert_eq!(renderer.render(0).read(FOVOLNET_RGBA8), before);
}
