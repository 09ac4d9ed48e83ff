//! Calls as C makes them.

use fovolnet_c::*;
use std::ffi::{CStr, CString};
use std::ptr::{null, null_mut};

/// Text of the last error of this thread.
pub fn last_error() -> String {
    // SAFETY: the text ends in NUL.
    unsafe { CStr::from_ptr(fovolnet_last_error()) }.to_str().unwrap().to_owned()
}

/// Checks that a call succeeded.
#[track_caller]
pub fn ok(status: FovolnetStatus) {
    assert_eq!(status, FOVOLNET_OK, "{}", last_error());
}

/// Checks that a call failed, with a text of one line.
#[track_caller]
pub fn fails(status: FovolnetStatus, expected: FovolnetStatus) -> String {
    let text = last_error();
    assert_eq!(status, expected, "{text}");
    assert!(!text.is_empty() && !text.contains('\n'), "{text}");
    text
}

pub fn c(text: &str) -> CString {
    CString::new(text).unwrap()
}

/// Text that `write` writes, first asked for its length.
pub fn text_of(write: impl Fn(*mut std::ffi::c_char, usize, *mut usize) -> FovolnetStatus) -> String {
    let mut length = usize::MAX;
    ok(write(null_mut(), 0, &raw mut length));
    let mut buffer = vec![1u8; length + 1];
    ok(write(buffer.as_mut_ptr().cast(), buffer.len(), null_mut()));
    assert_eq!(buffer.pop(), Some(0));
    String::from_utf8(buffer).unwrap()
}

/// Handle that is released in the end.
macro_rules! handle {
    ($name:ident, $type:ty, $new:path, $release:path) => {
        pub struct $name(pub *mut $type);

        impl $name {
            pub fn new() -> Self {
                let mut handle = null_mut();
                // SAFETY: the address is that of a variable.
                ok(unsafe { $new(&raw mut handle) });
                Self(handle)
            }
        }

        impl Drop for $name {
            fn drop(&mut self) {
                // SAFETY: it is released once.
                unsafe { $release(self.0) };
            }
        }
    };
}

handle!(VolumeHandle, FovolnetVolume, fovolnet_volume_new, fovolnet_volume_release);
handle!(RendererHandle, FovolnetRenderer, fovolnet_renderer_new, fovolnet_renderer_release);
handle!(CameraHandle, FovolnetCamera, fovolnet_camera_new, fovolnet_camera_release);
handle!(LightHandle, FovolnetLight, fovolnet_light_new, fovolnet_light_release);
handle!(
    TransferHandle,
    FovolnetTransferFunction,
    fovolnet_transfer_function_new,
    fovolnet_transfer_function_release
);

impl VolumeHandle {
    /// Committed volume of a procedural name, with 24³ voxels.
    pub fn named(name: &str) -> Self {
        let volume = Self::new();
        // SAFETY: the handle and the texts are valid.
        unsafe {
            ok(fovolnet_volume_set_source(volume.0, c(name).as_ptr()));
            ok(fovolnet_volume_set(volume.0, c"dims".as_ptr(), c"24,24,24".as_ptr()));
            ok(fovolnet_volume_commit(volume.0));
        }
        volume
    }
}

impl RendererHandle {
    /// Committed renderer of `volume` on the CPU, with small frames and more settings.
    pub fn showing(volume: &VolumeHandle, json: &str) -> Self {
        let renderer = Self::new();
        // SAFETY: the handles and the texts are valid.
        unsafe {
            ok(fovolnet_renderer_set_volume(renderer.0, volume.0));
            ok(fovolnet_renderer_set_json(
                renderer.0,
                c(r#"{"size": [48, 32], "device": "cpu", "threads": 2}"#).as_ptr(),
            ));
            ok(fovolnet_renderer_set_json(renderer.0, c(json).as_ptr()));
        }
        renderer.commit();
        renderer
    }

    pub fn set(&self, name: &str, value: &str) {
        // SAFETY: the handle and the texts are valid.
        ok(unsafe { fovolnet_renderer_set(self.0, c(name).as_ptr(), c(value).as_ptr()) });
        self.commit();
    }

    pub fn commit(&self) {
        // SAFETY: the handle is valid.
        ok(unsafe { fovolnet_renderer_commit(self.0) });
    }

    pub fn render(&self, i: u32) -> FrameHandle {
        let mut frame = null_mut();
        // SAFETY: the handle is valid.
        ok(unsafe { fovolnet_renderer_render(self.0, i, &raw mut frame) });
        FrameHandle(frame)
    }
}

/// Frame that is released in the end.
pub struct FrameHandle(pub *mut FovolnetFrame);

impl Drop for FrameHandle {
    fn drop(&mut self) {
        // SAFETY: it is released once.
        unsafe { fovolnet_frame_release(self.0) };
    }
}

impl FrameHandle {
    pub fn info(&self) -> FovolnetFrameInfo {
        // SAFETY: zeros are valid numbers.
        let mut info: FovolnetFrameInfo = unsafe { std::mem::zeroed() };
        info.size = size_of::<FovolnetFrameInfo>();
        // SAFETY: the handle is valid, and the size is right.
        ok(unsafe { fovolnet_frame_info(self.0, &raw mut info) });
        info
    }

    /// Bytes of a channel.
    pub fn read(&self, channel: FovolnetChannel) -> Vec<u8> {
        let mut bytes = 0;
        // SAFETY: the handle is valid.
        ok(unsafe { fovolnet_frame_bytes(self.0, channel, &raw mut bytes) });
        let mut buffer = vec![0u8; bytes];
        // SAFETY: the buffer has so many bytes.
        ok(unsafe { fovolnet_frame_read(self.0, channel, buffer.as_mut_ptr().cast(), bytes, 0) });
        buffer
    }

    pub fn floats(&self, channel: FovolnetChannel) -> Vec<f32> {
        let bytes = self.read(channel);
        bytes.chunks_exact(4).map(|b| f32::from_ne_bytes([b[0], b[1], b[2], b[3]])).collect()
    }
}

/// Voxels of `values`, without a callback.
pub fn voxels(values: &[u16], dims: [u64; 3]) -> FovolnetVoxels {
    FovolnetVoxels {
        size: size_of::<FovolnetVoxels>(),
        data: values.as_ptr().cast(),
        bytes: size_of_val(values),
        dims,
        spacing: [1.0; 3],
        dtype: FOVOLNET_U16,
        components: 0,
        meaning: FOVOLNET_VALUES,
        space: FOVOLNET_SPACE_NONE,
        directions: [0.0; 9],
        origin: [0.0; 3],
        name: null(),
        release: None,
        user: null_mut(),
    }
}
