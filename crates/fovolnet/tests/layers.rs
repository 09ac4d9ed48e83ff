//! Several volumes in one picture, channels of a file, and voxels with colours.

use fovolnet::core::{Frame, FrameSize};
use fovolnet::{
    Error, OpenVolume, Pipeline, RenderOverrides, Session, SpeedSettings, VolumeSettings, open_volume,
};
use std::fs;
use std::path::Path;

fn settings() -> RenderOverrides {
    RenderOverrides {
        size: Some(FrameSize { width: 48, height: 32 }),
        sampling: Some("full".parse().unwrap()),
        tf: Some("grey".into()),
        ..RenderOverrides::default()
    }
}

fn picture(volume: &OpenVolume, settings: &RenderOverrides) -> Frame {
    Pipeline::new(volume, &settings.resolve().unwrap(), &SpeedSettings::default())
        .unwrap()
        .render(0)
        .unwrap()
        .frame
}

fn write(folder: &Path, name: &str, bytes: &[u8]) -> String {
    let path = folder.join(name);
    fs::write(&path, bytes).unwrap();
    path.display().to_string()
}

/// Bytes of a cube of 16³ voxels, `value` where `part` says so and 0 elsewhere.
fn cube(value: u8, part: impl Fn([usize; 3]) -> bool) -> Vec<u8> {
    let voxel = |i: usize| [i % 16, i / 16 % 16, i / 256];
    (0..4096).map(|i| if part(voxel(i)) { value } else { 0 }).collect()
}

fn read(overlay: &str) -> VolumeSettings {
    VolumeSettings { overlay: Some(vec![overlay.parse().unwrap()]), ..VolumeSettings::default() }
}

/// Sums of red, green and blue in the left and right half of `frame`.
fn halves(frame: &Frame) -> [[f32; 3]; 2] {
    let width = frame.size().width as usize;
    let mut sums = [[0.0; 3]; 2];
    for (at, pixel) in frame.pixels().iter().enumerate() {
        let half = usize::from(at % width >= width / 2);
        (0..3).for_each(|c| sums[half][c] += pixel[c]);
    }
    sums
}

const RED: &str = r#"{"points":[[0,1,0,0,0],[1,1,0,0,0.9]]}"#;

#[test]
fn an_overlay_lies_on_the_box_of_the_first_volume() {
    let folder = tempfile::tempdir().unwrap();
    let first = write(folder.path(), "a_16x16x16_uint8.raw", &cube(200, |[x, ..]| x < 8));
    let half: Vec<u8> = (0..512).map(|i| if i % 8 >= 4 { 255 } else { 0 }).collect();
    let second = write(folder.path(), "b_8x8x8_uint8.raw", &half);
    let volume = open_volume(&first, &read(&format!("{second}@{RED}"))).unwrap();
    assert_eq!(volume.layers[0].opened.volume.grid(), volume.volume.grid());
    assert!(
        volume.notes().iter().any(|note| note.contains("is stretched to the box of")),
        "{:?}",
        volume.notes()
    );
    let [left, right] = halves(&picture(&volume, &settings()));
    assert!(left[0] > 10.0 && (left[0] - left[2]).abs() < 0.2 * left[0], "{left:?}");
    assert!(right[0] > 10.0 && right[2] < 0.05 * right[0], "{right:?}");
}

#[test]
fn crops_cut_all_volumes_alike() {
    let folder = tempfile::tempdir().unwrap();
    let first = write(folder.path(), "a_16x16x16_uint8.raw", &cube(200, |[x, ..]| x < 8));
    let second = write(folder.path(), "b_16x16x16_uint8.raw", &cube(255, |[_, y, _]| y < 8));
    let volume = open_volume(&first, &read(&format!("{second}@{RED}"))).unwrap();
    let mut right = settings();
    right.clip = Some([0.5, 1.0, 0.0, 1.0, 0.0, 1.0].into());
    right.camera = Some("0,0,2,0,0,0,35".parse().unwrap());
    let [left, kept] = halves(&picture(&volume, &right));
    assert!(left == [0.0; 3] && kept[0] > 10.0 && kept[2] < 0.05 * kept[0], "{left:?} {kept:?}");
}

#[test]
fn sessions_hold_overlays_and_notice_their_changes() {
    let folder = tempfile::tempdir().unwrap();
    let first = write(folder.path(), "a_16x16x16_uint8.raw", &cube(200, |[x, ..]| x < 8));
    let second = write(folder.path(), "b_16x16x16_uint8.raw", &cube(255, |[_, y, _]| y < 8));
    let function = write(folder.path(), "red.json", RED.as_bytes());
    let session = Session::new(&first, read(&format!("{second}@{function}")), settings()).unwrap();
    let path = folder.path().join("session.toml");
    session.write(&path).unwrap();
    let before = picture(&open_volume(&session.volume, &session.read).unwrap(), &session.render);
    fs::remove_file(&function).unwrap();
    let saved = Session::read(&path).unwrap();
    assert!(saved.volume_is_unchanged().unwrap());
    let after = picture(&open_volume(&saved.volume, &saved.read).unwrap(), &saved.render);
    assert_eq!(before, after);
    fs::write(&second, cube(254, |[_, y, _]| y < 8)).unwrap();
    assert!(!saved.volume_is_unchanged().unwrap());
}

#[test]
fn coloured_voxels_have_their_colours() {
    let folder = tempfile::tempdir().unwrap();
    // The left half is green, the right half blue.
    let bytes: Vec<u8> = (0..4096).flat_map(|i| if i % 16 < 8 { [0, 250, 0] } else { [0, 0, 250] }).collect();
    let header = "NRRD0004\ntype: uint8\ndimension: 4\nsizes: 3 16 16 16\nkinds: RGB-color domain domain domain\nencoding: raw\n\n";
    let file = write(folder.path(), "colours.nrrd", &[header.as_bytes(), &bytes].concat());
    let volume = open_volume(&file, &VolumeSettings::default()).unwrap();
    assert!(volume.colours.is_some() && volume.notes().is_empty(), "{:?}", volume.notes());
    let [left, right] = halves(&picture(&volume, &settings()));
    assert!(left[1] > 10.0 && left[0] == 0.0 && left[2] < 0.05 * left[1], "{left:?}");
    assert!(right[2] > 5.0 && right[1] < 0.2 * right[2], "{right:?}");
    let one = VolumeSettings { component: Some("1".parse().unwrap()), ..Default::default() };
    let green = open_volume(&file, &one).unwrap();
    assert!(green.colours.is_none());
    let [left, right] = halves(&picture(&green, &settings()));
    assert!(left[0] > 10.0 && left[0] == left[1] && right[0] < 0.05 * left[0], "{left:?} {right:?}");
}

#[test]
fn networks_rebuild_sparse_frames_of_several_volumes() {
    let read = VolumeSettings {
        dims: Some([32; 3]),
        overlay: Some(vec!["marschner-lobb@viridis".parse().unwrap()]),
        ..VolumeSettings::default()
    };
    let volume = open_volume("head", &read).unwrap();
    let mut render = RenderOverrides {
        size: Some(FrameSize { width: 96, height: 64 }),
        pb: Some(0.2),
        reconstruct: Some("wnet".parse().unwrap()),
        sampling: Some("compact".parse().unwrap()),
        ..RenderOverrides::default()
    };
    for shadows in ["on", "off", "cached"] {
        render.shadows = Some(serde_json::from_value(shadows.into()).unwrap());
        let settings = render.resolve().unwrap();
        let mut pipeline = Pipeline::new(&volume, &settings, &SpeedSettings::default()).unwrap();
        let frame = (0..3).map(|frame| pipeline.render(frame).unwrap()).last().unwrap();
        let whole = pipeline.reference(2).unwrap();
        let psnr = fovolnet::metrics::psnr(&whole, &frame.frame).unwrap();
        assert!(psnr > 24.0, "{shadows}: {psnr}");
    }
}

#[test]
fn what_cannot_be_shown_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let first = write(folder.path(), "a_16x16x16_uint8.raw", &cube(200, |_| true));
    let said = |read: &VolumeSettings| open_volume(&first, read).unwrap_err();
    let many = VolumeSettings { overlay: Some(vec![first.parse().unwrap(); 4]), ..Default::default() };
    assert!(said(&many).to_string().contains("at most 4"));
    let missing = said(&read("nowhere.nii"));
    assert!(
        matches!(missing, Error::Io(_) | Error::Setting(_)) && missing.to_string().contains("nowhere.nii")
    );
    let rgb = VolumeSettings { component: Some("rgb".parse().unwrap()), ..Default::default() };
    assert!(said(&rgb).to_string().contains("leave out --component rgb"));
}
