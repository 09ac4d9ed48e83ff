use super::*;
use std::path::Path;

/// A file of one variable of bytes, `v(z, y, x)`, with coordinates of x, in version `version`.
fn file(version: u8, has_records: bool) -> Vec<u8> {
    let is_wide = version == 5;
    let count = |number: u64| match is_wide {
        true => number.to_be_bytes().to_vec(),
        false => (number as u32).to_be_bytes().to_vec(),
    };
    let tag = |number: u32| number.to_be_bytes().to_vec();
    let name = |text: &str| [count(text.len() as u64), format!("{text:\0<4}").into_bytes()].concat();
    let begin = |at: u64| match version {
        1 => (at as u32).to_be_bytes().to_vec(),
        _ => at.to_be_bytes().to_vec(),
    };
    let first = if has_records { 0 } else { 2 };
    let header = |values: u64| {
        let mut parts =
            vec![vec![b'C', b'D', b'F', version], count(if has_records { 2 } else { 0 }), tag(10), count(3)];
        for (axis, length) in [("z", first), ("y", 2), ("x", 3)] {
            parts.extend([name(axis), count(length)]);
        }
        parts.extend([tag(0), count(0), tag(11), count(2)]);
        parts.extend([name("x"), count(1), count(2), tag(12), count(1), name("unit"), tag(2), count(2)]);
        parts.extend([b"mm\0\0".to_vec(), tag(6), count(24), begin(values)]);
        parts.extend([name("v"), count(3), count(0), count(1), count(2), tag(0), count(0)]);
        parts.extend([tag(1), count(6), begin(values + 24)]);
        parts.concat()
    };
    let start = header(0).len() as u64;
    let coordinates = [1.0f64, 1.5, 2.0].into_iter().flat_map(f64::to_be_bytes);
    [header(start), coordinates.collect(), (0..12).collect()].concat()
}

fn read(bytes: Vec<u8>) -> Result<Volume> {
    crate::volume::parse(&Source::from_bytes(Path::new("a.nc"), bytes), &Overrides::default())
}

#[test]
fn every_version_is_read() {
    for version in [1, 2, 5] {
        for has_records in [false, true] {
            let volume = read(file(version, has_records)).unwrap();
            assert_eq!((volume.grid().dims(), volume.value([1, 1, 1])), ([3, 2, 2], 10.0), "CDF-{version}");
            assert_eq!(volume.grid().spacing(), [0.5; 3]);
            assert_eq!(volume.contents().array_name(), Some("v"));
        }
    }
}

#[test]
fn files_that_are_cut_short_are_errors_or_noted() {
    for has_records in [false, true] {
        let whole = file(1, has_records);
        for cut in 4..whole.len() {
            if let Ok(volume) = read(whole[..cut].to_vec()) {
                assert!(volume.notes().iter().any(|note| note.contains("cut short")), "{cut}");
            }
        }
    }
}
