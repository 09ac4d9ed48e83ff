//! Files that are made here, element by element.

use super::*;
use fovol_core::Dtype;
use std::path::PathBuf;

/// An element in explicit little-endian form.
fn element(tag: tags::Tag, value: &[u8]) -> Vec<u8> {
    let [group, number] = [(tag.number >> 16) as u16, tag.number as u16].map(u16::to_le_bytes);
    let mut value = value.to_vec();
    if value.len() % 2 == 1 {
        value.push(if &tag.vr == b"UI" || &tag.vr == b"OW" { 0 } else { b' ' });
    }
    let length = match &tag.vr {
        b"OW" | b"SQ" => [&[0, 0][..], &(value.len() as u32).to_le_bytes()].concat(),
        _ => (value.len() as u16).to_le_bytes().to_vec(),
    };
    [&group[..], &number, &tag.vr, &length, &value].concat()
}

fn word(tag: tags::Tag, number: u16) -> Vec<u8> {
    element(tag, &number.to_le_bytes())
}

/// A slice of 3x2 pixels of 16 bits at the height `z`, with elements that come `more`.
fn slice(series: &str, z: f64, first: u16, more: &[Vec<u8>]) -> Vec<u8> {
    let meta = element(tags::TRANSFER_SYNTAX, b"1.2.840.10008.1.2.1");
    let mut parts = vec![vec![0; 128], b"DICM".to_vec(), meta];
    let pixels: Vec<u8> = (first..first + 6).flat_map(u16::to_le_bytes).collect();
    let mut elements = vec![
        element(tags::SOP_INSTANCE, format!("{series}.{z}").as_bytes()),
        element(tags::MODALITY, b"CT"),
        element(tags::SERIES_DESCRIPTION, b"made here"),
        element(tags::SERIES_UID, series.as_bytes()),
        element(tags::INSTANCE_NUMBER, b"1"),
        element(tags::POSITION, format!("1\\2\\{z}").as_bytes()),
        element(tags::ORIENTATION, b"1\\0\\0\\0\\1\\0"),
        word(tags::SAMPLES_PER_PIXEL, 1),
        element(tags::PHOTOMETRIC, b"MONOCHROME2"),
        word(tags::ROWS, 2),
        word(tags::COLUMNS, 3),
        element(tags::PIXEL_SPACING, b"0.5\\0.75"),
        word(tags::BITS_ALLOCATED, 16),
        word(tags::BITS_STORED, 16),
        word(tags::HIGH_BIT, 15),
        word(tags::PIXEL_REPRESENTATION, 0),
        element(tags::PIXELS, &pixels),
    ];
    // Elements stand in the order of their tags; later ones replace earlier ones.
    for element in more {
        elements.retain(|other| other[..4] != element[..4]);
        elements.push(element.clone());
    }
    elements.sort_by_key(|element| [element[1], element[0], element[3], element[2]]);
    parts.append(&mut elements);
    parts.concat()
}

fn folder(files: &[Vec<u8>]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (number, file) in files.iter().enumerate() {
        std::fs::write(folder.path().join(format!("{number}")), file).unwrap();
    }
    folder
}

fn read(folder: &tempfile::TempDir, overrides: &Overrides) -> Volume {
    crate::volume::read(folder.path(), overrides).unwrap()
}

fn notes(volume: &Volume) -> String {
    volume.notes().join("|")
}

#[test]
fn slices_are_sorted_by_their_positions() {
    let folder =
        folder(&[slice("1.2", 4.0, 200, &[]), slice("1.2", 0.0, 0, &[]), slice("1.2", 2.0, 100, &[])]);
    let volume = read(&folder, &Overrides::default());
    assert_eq!((volume.grid().dims(), volume.grid().spacing()), ([3, 2, 3], [0.75, 0.5, 2.0]));
    assert_eq!([0, 1, 2].map(|z| volume.value([2, 1, z])), [5.0, 105.0, 205.0]);
    assert_eq!(volume.placement().unwrap().origin().to_array(), [1.0, 2.0, 0.0]);
    assert_eq!((volume.units(), volume.dtype()), (Some("mm"), Dtype::U16));
    assert!(volume.notes().is_empty(), "{}", notes(&volume));
}

#[test]
fn intercepts_are_added_where_they_fit() {
    let scale = [element(tags::RESCALE_SLOPE, b"1"), element(tags::RESCALE_INTERCEPT, b"-1024")];
    let folder = folder(&[slice("1.2", 0.0, 0, &scale), slice("1.2", 1.0, 9, &scale)]);
    let volume = read(&folder, &Overrides::default());
    assert_eq!((volume.dtype(), volume.value([0, 0, 1])), (Dtype::I16, -1015.0));
}

#[test]
fn scales_that_differ_make_floats() {
    let files = [1.0, 0.5]
        .map(|slope| slice("1.2", slope, 2, &[element(tags::RESCALE_SLOPE, slope.to_string().as_bytes())]));
    let volume = read(&folder(&files), &Overrides::default());
    assert_eq!((volume.dtype(), [0, 1].map(|z| volume.value([0, 0, z]))), (Dtype::F32, [1.0, 2.0]));
}

#[test]
fn one_file_of_a_series_is_read_alone() {
    let folder = folder(&[slice("1.2", 0.0, 0, &[]), slice("1.2", 1.0, 9, &[]), slice("1.3", 1.0, 9, &[])]);
    let volume = crate::volume::read(&folder.path().join("0"), &Overrides::default()).unwrap();
    assert_eq!(volume.grid().dims(), [3, 2, 1]);
    assert!(notes(&volume).contains("one of 2 files of its series"), "{}", notes(&volume));
}

#[test]
fn series_can_be_chosen() {
    let folder = folder(&[slice("1.2", 0.0, 7, &[]), slice("1.3", 0.0, 0, &[]), slice("1.3", 1.0, 9, &[])]);
    let volume = read(&folder, &Overrides::default());
    assert_eq!(volume.grid().dims(), [3, 2, 2]);
    assert!(
        notes(&volume).contains("has 1 other volume (1: CT 3x2x1 (made here)); number 2"),
        "{}",
        notes(&volume)
    );
    for name in ["1", "1.2"] {
        let overrides = Overrides { series: Some(name.into()), ..Overrides::default() };
        assert_eq!(read(&folder, &overrides).value([0, 0, 0]), 7.0);
    }
    let overrides = Overrides { series: Some("3".into()), ..Overrides::default() };
    let error = crate::volume::read(folder.path(), &overrides).unwrap_err().to_string();
    assert!(
        error.contains("--series 3 is not there; it has 1: CT 3x2x1") && !error.contains('\n'),
        "{error}"
    );
    let list = series(folder.path()).unwrap();
    assert_eq!((list.len(), list[1].uid.as_str(), list[1].dims), (2, "1.3", [3, 2, 2]));
}

#[test]
fn times_and_copies() {
    let at = |z: f64, time: &str, first: u16| {
        let number = element(tags::TEMPORAL_POSITION, time.as_bytes());
        let instance = element(tags::SOP_INSTANCE, format!("9.{z}.{time}").as_bytes());
        slice("1.2", z, first, &[number, instance])
    };
    let files = [at(0.0, "2", 20), at(0.0, "1", 0), at(1.0, "1", 10), at(1.0, "2", 30), at(1.0, "2", 30)];
    let folder = folder(&files);
    let overrides = Overrides { time: Some(1), ..Overrides::default() };
    let volume = read(&folder, &overrides);
    assert_eq!((volume.contents().times, [0, 1].map(|z| volume.value([0, 0, z]))), (2, [20.0, 30.0]));
    assert!(notes(&volume).contains("1 pictures are copies"), "{}", notes(&volume));
}

#[test]
fn missing_slices_are_filled_and_said() {
    let files = [0, 1, 2, 4, 5].map(|z| slice("1.2", f64::from(z), 10 * z as u16, &[]));
    let volume = read(&folder(&files), &Overrides::default());
    assert_eq!((volume.grid().dims()[2], volume.value([0, 0, 3])), (6, 30.0));
    assert!(notes(&volume).contains("1 slices are missing, the first 3"), "{}", notes(&volume));
}

#[test]
fn nobody_is_named() {
    let secret = |number: u32, vr: &[u8; 2]| element(tags::Tag { number, vr: *vr }, b"Secret^Person");
    let more = [secret(0x0010_0010, b"PN"), secret(0x0010_0020, b"LO"), secret(0x0008_0080, b"LO")];
    let mut files = [0.0, 1.5, 2.0].map(|z| slice("1.2", z, 1, &more)).to_vec();
    let volume = read(&folder(&files), &Overrides::default());
    assert!(!format!("{volume:?} {}", notes(&volume)).contains("Secret"));
    files.iter_mut().for_each(|file| file.truncate(file.len() - 4));
    let error = crate::volume::read(folder(&files).path(), &Overrides::default()).unwrap_err().to_string();
    assert!(error.contains("copy or download it again") && !error.contains("Secret"), "{error}");
}

#[test]
fn sizes_that_no_file_holds_take_no_memory() {
    let huge = [word(tags::ROWS, 65535), word(tags::COLUMNS, 65535), element(tags::FRAMES, b"60000")];
    let source = Source::from_bytes(&PathBuf::from("x.dcm"), slice("1.2", 0.0, 0, &huge));
    let error = parse(&source, &Overrides::default()).unwrap_err().to_string();
    assert!(error.contains("too few for 60000 frames"), "{error}");
}

#[test]
fn what_is_no_picture_says_so() {
    let parse = |bytes: Vec<u8>| {
        parse(&Source::from_bytes(&PathBuf::from("x.dcm"), bytes), &Overrides::default())
            .unwrap_err()
            .to_string()
    };
    assert!(parse(b"text".to_vec()).contains("no DICOM file"));
    let report = [&[0; 128][..], b"DICM", &element(tags::TRANSFER_SYNTAX, b"1.2.840.10008.1.2.1")].concat();
    assert!(parse(report).contains("without pictures"));
    let video =
        [&[0; 128][..], b"DICM", &element(tags::TRANSFER_SYNTAX, b"1.2.840.10008.1.2.4.102")].concat();
    assert!(parse(video).contains("a video"));
}
