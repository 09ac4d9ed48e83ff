//! Cancelling. It ends all calls of a process, so this test is alone in its own.

use fovolnet_c::*;
use std::ffi::CStr;
use std::ptr::null_mut;
use std::time::{Duration, Instant};

/// A renderer that is used from one thread after another.
struct Renderer(*mut FovolnetRenderer);

impl Renderer {
    /// A renderer of a small head.
    fn new() -> Self {
        let (mut volume, mut renderer) = (null_mut(), null_mut());
        // SAFETY: all pointers are those that the header asks for.
        unsafe {
            assert_eq!(fovolnet_volume_new(&raw mut volume), FOVOLNET_OK);
            assert_eq!(fovolnet_volume_set_source(volume, c"head".as_ptr()), FOVOLNET_OK);
            assert_eq!(fovolnet_volume_commit(volume), FOVOLNET_OK);
            assert_eq!(fovolnet_renderer_new(&raw mut renderer), FOVOLNET_OK);
            assert_eq!(fovolnet_renderer_set_volume(renderer, volume), FOVOLNET_OK);
            fovolnet_volume_release(volume);
        }
        Self(renderer)
    }

    /// Changes settings, and renders a frame: the bytes of its picture, or the error.
    fn render(&self, settings: &CStr) -> Result<Vec<u8>, FovolnetStatus> {
        let (mut frame, mut bytes) = (null_mut(), 0);
        // SAFETY: as above; the buffer has as many bytes as the frame says.
        unsafe {
            assert_eq!(fovolnet_renderer_set_json(self.0, settings.as_ptr()), FOVOLNET_OK);
            assert_eq!(fovolnet_renderer_commit(self.0), FOVOLNET_OK);
            let status = fovolnet_renderer_render(self.0, 0, &raw mut frame);
            if status != FOVOLNET_OK {
                assert!(frame.is_null());
                return Err(status);
            }
            assert_eq!(fovolnet_frame_bytes(frame, FOVOLNET_RGBA8, &raw mut bytes), FOVOLNET_OK);
            let mut picture = vec![0u8; bytes];
            let read = fovolnet_frame_read(frame, FOVOLNET_RGBA8, picture.as_mut_ptr().cast(), bytes, 0);
            assert_eq!(read, FOVOLNET_OK);
            fovolnet_frame_release(frame);
            Ok(picture)
        }
    }
}

impl Drop for Renderer {
    fn drop(&mut self) {
        // SAFETY: it is not used again.
        unsafe { fovolnet_renderer_release(self.0) }
    }
}

#[test]
fn other_threads_cancel_frames() {
    // Nothing is at work, so nothing happens.
    fovolnet_cancel();
    let renderer = Renderer::new();
    let small = c"{\"size\": [48, 32], \"step\": null}";
    let before = renderer.render(small).unwrap();
    let started = Instant::now();
    std::thread::scope(|scope| {
        scope.spawn(|| {
            std::thread::sleep(Duration::from_millis(300));
            fovolnet_cancel();
        });
        // Minutes of work.
        let cancelled = renderer.render(c"{\"size\": [8000, 6000], \"step\": 0.01}");
        assert_eq!(cancelled, Err(FOVOLNET_CANCELLED));
    });
    assert!(started.elapsed() < Duration::from_secs(20), "{:?}", started.elapsed());
    assert_eq!(renderer.render(small).unwrap(), before);
}
