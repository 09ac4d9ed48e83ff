//! Mistakes of callers become errors that say how to mend them.

use crate::calls::*;
use fovolnet_c::*;
use std::ptr::{null, null_mut};

#[test]
fn null_is_an_error_everywhere() {
    let numbers = [0.0f64; 5];
    let (mut size, mut used) = (0usize, 0u32);
    let some = c"{}".as_ptr();
    let statuses = unsafe {
        [
            fovolnet_volume_new(null_mut()),
            fovolnet_volume_set_source(null_mut(), some),
            fovolnet_volume_set_voxels(null_mut(), null()),
            fovolnet_volume_set(null_mut(), some, some),
            fovolnet_volume_set_json(null_mut(), some),
            fovolnet_volume_unset(null_mut(), some),
            fovolnet_volume_add_overlay(null_mut(), null(), null()),
            fovolnet_volume_clear_overlays(null_mut()),
            fovolnet_volume_commit(null_mut()),
            fovolnet_volume_info(null(), null_mut()),
            fovolnet_volume_notes(null(), null_mut(), 0, &raw mut size),
            fovolnet_transfer_function_new(null_mut()),
            fovolnet_transfer_function_set(null_mut(), some),
            fovolnet_transfer_function_set_points(null_mut(), numbers.as_ptr(), 1),
            fovolnet_transfer_function_set_range(null_mut(), 0.0, 1.0),
            fovolnet_transfer_function_set_gradient(null_mut(), numbers.as_ptr(), 1),
            fovolnet_transfer_function_commit(null_mut()),
            fovolnet_camera_new(null_mut()),
            fovolnet_camera_look_at(null_mut(), numbers.as_ptr(), numbers.as_ptr(), null()),
            fovolnet_camera_set_fovy(null_mut(), 30.0),
            fovolnet_camera_set_projection(null_mut(), FOVOLNET_ORTHOGRAPHIC),
            fovolnet_camera_commit(null_mut()),
            fovolnet_light_new(null_mut()),
            fovolnet_light_set_towards(null_mut(), numbers.as_ptr()),
            fovolnet_light_commit(null_mut()),
            fovolnet_renderer_new(null_mut()),
            fovolnet_renderer_set(null_mut(), some, some),
            fovolnet_renderer_set_json(null_mut(), some),
            fovolnet_renderer_unset(null_mut(), some),
            fovolnet_renderer_settings(null(), null_mut(), 0, &raw mut size),
            fovolnet_renderer_set_size(null_mut(), 8, 8),
            fovolnet_renderer_set_volume(null_mut(), null()),
            fovolnet_renderer_set_transfer_function(null_mut(), null()),
            fovolnet_renderer_set_camera(null_mut(), null()),
            fovolnet_renderer_set_light(null_mut(), null()),
            fovolnet_renderer_find_motion(null_mut(), 1),
            fovolnet_renderer_commit(null_mut()),
            fovolnet_renderer_render(null_mut(), 0, null_mut()),
            fovolnet_renderer_reference(null_mut(), 0, null_mut()),
            fovolnet_renderer_reset(null_mut()),
            fovolnet_renderer_camera(null_mut(), 0, null_mut(), null_mut(), null_mut(), null_mut()),
            fovolnet_renderer_notes(null_mut(), null_mut(), 0, &raw mut size),
            fovolnet_renderer_gpu(null_mut(), null_mut(), 0, &raw mut size),
            fovolnet_frame_info(null(), null_mut()),
            fovolnet_frame_bytes(null(), FOVOLNET_RGBA8, &raw mut size),
            fovolnet_frame_read(null(), FOVOLNET_RGBA8, null_mut(), 0, 0),
            fovolnet_reconstructor_new(8, 8, c"{\"reconstruct\": \"pull-push\"}".as_ptr(), null_mut()),
            fovolnet_reconstructor_reconstruct(null_mut(), null(), null_mut(), 0),
            fovolnet_reconstructor_reset(null_mut()),
            fovolnet_reconstructor_uses_motion(null(), &raw mut used),
        ]
    };
    for (number, status) in statuses.into_iter().enumerate() {
        assert_eq!(status, FOVOLNET_ERROR_INVALID, "call {number}");
    }
    unsafe {
        fovolnet_volume_release(null_mut());
        fovolnet_transfer_function_release(null_mut());
        fovolnet_camera_release(null_mut());
        fovolnet_light_release(null_mut());
        fovolnet_renderer_release(null_mut());
        fovolnet_frame_release(null_mut());
        fovolnet_reconstructor_release(null_mut());
    }
    assert_eq!(fovolnet_abi_version(), FOVOLNET_ABI_VERSION);
}

#[test]
fn texts_and_structs_are_checked() {
    let volume = VolumeHandle::new();
    let invalid = |status| fails(status, FOVOLNET_ERROR_INVALID);
    unsafe {
        assert!(invalid(fovolnet_volume_set(volume.0, null(), null())).contains("`name` is NULL"));
        let bytes = [0xffu8, 0];
        let text = invalid(fovolnet_volume_set(volume.0, bytes.as_ptr().cast(), c"".as_ptr()));
        assert!(text.contains("UTF-8"), "{text}");
        let text = invalid(fovolnet_volume_set(volume.0, c"dim".as_ptr(), c"1,1,1".as_ptr()));
        assert!(text.contains("did you mean dims?"), "{text}");
        assert!(invalid(fovolnet_volume_commit(volume.0)).contains("fovolnet_volume_set_source"));
        ok(fovolnet_volume_set_source(volume.0, c"no/such.raw".as_ptr()));
        ok(fovolnet_volume_set(volume.0, c"time".as_ptr(), c"all".as_ptr()));
        assert!(invalid(fovolnet_volume_commit(volume.0)).contains("one time point"));
        ok(fovolnet_volume_unset(volume.0, c"time".as_ptr()));
        let text = fails(fovolnet_volume_commit(volume.0), FOVOLNET_ERROR_FILE);
        assert!(text.contains("no/such.raw"), "{text}");
        let mut info: FovolnetVolumeInfo = std::mem::zeroed();
        let text = invalid(fovolnet_volume_info(volume.0, &raw mut info));
        assert!(text.contains("fovolnet_volume_commit"), "{text}");
        let volume = VolumeHandle::named("marschner-lobb");
        assert!(invalid(fovolnet_volume_info(volume.0, null_mut())).contains("FovolnetVolumeInfo"));
        let text = invalid(fovolnet_volume_info(volume.0, &raw mut info));
        assert!(text.contains("sizeof(FovolnetVolumeInfo)"), "{text}");
        // A newer program may know more fields.
        info.size = size_of::<FovolnetVolumeInfo>() + 64;
        ok(fovolnet_volume_info(volume.0, &raw mut info));
        assert_eq!((info.dims, info.layers, info.size), ([24; 3], 1, size_of::<FovolnetVolumeInfo>() + 64));
        let text = invalid(fovolnet_volume_add_overlay(volume.0, volume.0, null()));
        assert!(text.contains("over itself"), "{text}");
    }
}

#[test]
fn voxels_are_checked() {
    let volume = VolumeHandle::new();
    let values = [0u16; 24];
    let right = voxels(&values, [4, 3, 2]);
    let refused = |voxels: FovolnetVoxels| {
        fails(unsafe { fovolnet_volume_set_voxels(volume.0, &raw const voxels) }, FOVOLNET_ERROR_INVALID)
    };
    assert!(refused(FovolnetVoxels { size: 8, ..right }).contains("sizeof(FovolnetVoxels)"));
    assert!(refused(FovolnetVoxels { data: null(), ..right }).contains("`voxels->data`"));
    assert!(refused(FovolnetVoxels { bytes: 47, ..right }).contains("48"));
    assert!(refused(FovolnetVoxels { bytes: usize::MAX, ..right }).contains("too large"));
    assert!(refused(FovolnetVoxels { dtype: 12, ..right }).contains("FOVOLNET_F64"));
    assert!(refused(FovolnetVoxels { meaning: FOVOLNET_COLOURS, ..right }).contains("colours have 3 or 4"));
    assert!(refused(FovolnetVoxels { meaning: 7, ..right }).contains("FOVOLNET_LABELS"));
    assert!(refused(FovolnetVoxels { space: 3, ..right }).contains("FOVOLNET_SPACE_NONE"));
    refused(FovolnetVoxels { space: FOVOLNET_SPACE_PATIENT, ..right });
    refused(FovolnetVoxels { dims: [4, 3, 0], ..right });
    refused(FovolnetVoxels { dims: [u64::MAX; 3], ..right });
    refused(FovolnetVoxels { spacing: [1.0, 0.0, 1.0], ..right });
    unsafe {
        ok(fovolnet_volume_set_voxels(volume.0, &raw const right));
        ok(fovolnet_volume_set(volume.0, c"array".as_ptr(), c"ct".as_ptr()));
        let text = fails(fovolnet_volume_commit(volume.0), FOVOLNET_ERROR_INVALID);
        assert!(text.contains("fovolnet_volume_unset"), "{text}");
        ok(fovolnet_volume_unset(volume.0, c"array".as_ptr()));
        ok(fovolnet_volume_commit(volume.0));
    }
}

#[test]
fn objects_are_checked_when_they_are_committed() {
    let (camera, light, function) = (CameraHandle::new(), LightHandle::new(), TransferHandle::new());
    let invalid = |status| fails(status, FOVOLNET_ERROR_INVALID);
    unsafe {
        ok(fovolnet_camera_set_fovy(camera.0, 180.0));
        assert!(invalid(fovolnet_camera_commit(camera.0)).contains("field of view"));
        assert!(invalid(fovolnet_camera_set_projection(camera.0, 2)).contains("FOVOLNET_ORTHOGRAPHIC"));
        let zero = [0.0; 3];
        ok(fovolnet_light_set_towards(light.0, zero.as_ptr()));
        invalid(fovolnet_light_commit(light.0));
        let points = [0.5, 0.0, 0.0, 0.0, 0.0, 0.2, 0.0, 0.0, 0.0, 0.0];
        ok(fovolnet_transfer_function_set_points(function.0, points.as_ptr(), 2));
        assert!(invalid(fovolnet_transfer_function_commit(function.0)).contains("sort the points"));
        let renderer = RendererHandle::new();
        let mut frame = null_mut();
        let text = invalid(fovolnet_renderer_render(renderer.0, 0, &raw mut frame));
        assert!(text.contains("fovolnet_renderer_commit"), "{text}");
        renderer.commit();
        let text = invalid(fovolnet_renderer_render(renderer.0, 0, &raw mut frame));
        assert!(text.contains("fovolnet_renderer_set_volume"), "{text}");
        ok(fovolnet_renderer_set_json(renderer.0, c"{\"iso\": 3, \"mode\": \"mip\"}".as_ptr()));
        invalid(fovolnet_renderer_set_size(renderer.0, 0, 8));
        let volume = VolumeHandle::named("marschner-lobb");
        let renderer = RendererHandle::showing(&volume, "{}");
        ok(fovolnet_renderer_set_camera(renderer.0, camera.0));
        renderer.commit();
        let text = invalid(fovolnet_renderer_render(renderer.0, 0, &raw mut frame));
        assert!(text.contains("fovolnet_camera_commit") && frame.is_null(), "{text}");
    }
}
