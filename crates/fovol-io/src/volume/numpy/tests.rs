use super::*;
use std::io::Write;
use std::path::Path;

fn npy(descr: &str, is_fortran: bool, shape: &str, values: &[u8]) -> Vec<u8> {
    let order = if is_fortran { "True" } else { "False" };
    let text = format!("{{'descr': '{descr}', 'fortran_order': {order}, 'shape': {shape}, }}\n");
    [header::MAGIC, &[1, 0], &(text.len() as u16).to_le_bytes(), text.as_bytes(), values].concat()
}

fn read(name: &str, bytes: Vec<u8>, overrides: &Overrides) -> Result<Volume> {
    crate::volume::parse(&Source::from_bytes(Path::new(name), bytes), overrides)
}

/// A zip archive of `members`, deflated or stored.
fn zip(members: &[(&str, Vec<u8>)], is_deflated: bool) -> Vec<u8> {
    let (mut out, mut directory) = (Vec::new(), Vec::new());
    for (name, bytes) in members {
        let mut crc = flate2::Crc::new();
        crc.update(bytes);
        let mut packer = flate2::write::DeflateEncoder::new(Vec::new(), flate2::Compression::fast());
        packer.write_all(bytes).unwrap();
        let data = if is_deflated { packer.finish().unwrap() } else { bytes.clone() };
        let start = out.len() as u32;
        let method = if is_deflated { 8u16 } else { 0 };
        let mut common = vec![20, 0, 0, 0];
        common.extend(method.to_le_bytes());
        common.extend([0; 4]);
        for number in [crc.sum(), data.len() as u32, bytes.len() as u32] {
            common.extend(number.to_le_bytes());
        }
        common.extend((name.len() as u16).to_le_bytes());
        common.extend([0; 2]);
        out.extend([b"PK\x03\x04", common.as_slice(), name.as_bytes(), &data].concat());
        directory.extend([b"PK\x01\x02\x14\0", common.as_slice(), &[0; 10], &start.to_le_bytes()].concat());
        directory.extend(name.as_bytes());
    }
    let (at, count) = (out.len() as u32, (members.len() as u16).to_le_bytes());
    out.extend(&directory);
    out.extend([b"PK\x05\x06\0\0\0\0", &count[..], &count].concat());
    out.extend([&(directory.len() as u32).to_le_bytes()[..], &at.to_le_bytes(), &[0, 0]].concat());
    out
}

#[test]
fn both_orders_have_the_same_meaning() {
    // a[z, y, x] = 6 z + 3 y + x.
    let in_c: Vec<u8> = (0..12).collect();
    let in_fortran: Vec<u8> =
        (0..3).flat_map(|x| (0..2).flat_map(move |y| (0..2).map(move |z| 6 * z + 3 * y + x))).collect();
    for (is_fortran, values) in [(false, in_c), (true, in_fortran)] {
        let volume =
            read("a.npy", npy("|u1", is_fortran, "(2, 2, 3)", &values), &Overrides::default()).unwrap();
        assert_eq!(volume.grid().dims(), [3, 2, 2]);
        assert_eq!(volume.value([2, 0, 1]), 8.0);
        assert!(volume.notes()[0].contains("--spacing"));
    }
}

#[test]
fn times_and_components_are_chosen() {
    let overrides = Overrides { time: Some(1), ..Overrides::default() };
    let bytes = npy("|u1", false, "(3, 2, 2, 5)", &(0..60).collect::<Vec<u8>>());
    let volume = read("a.npy", bytes, &overrides).unwrap();
    assert_eq!((volume.value([0, 0, 0]), volume.contents().times), (20.0, 3));
    let bytes = npy("<u2", false, "(2, 2, 2, 3)", &[7; 48]);
    assert_eq!(read("a.npy", bytes, &Overrides::default()).unwrap().contents().components, 3);
}

#[test]
fn large_claims_and_missing_values_are_errors() {
    for shape in ["(2, 2, 3)", "(65536, 65536, 65536)", "(99999999, 9, 9)", "(18446744073709551615, 9, 9, 9)"]
    {
        let error = read("a.npy", npy("<f8", false, shape, &[0; 95]), &Overrides::default()).unwrap_err();
        assert!(!error.to_string().contains('\n'), "{error}");
    }
}

#[test]
fn archives_show_their_volume() {
    let flat = npy("|u1", false, "(9, 9)", &[3; 81]);
    let small = npy("|u1", false, "(2, 2, 2)", &[1; 8]);
    let large = npy("|u1", false, "(2, 2, 3)", &[2; 12]);
    let members = [
        ("flat.npy", flat.clone()),
        ("small.npy", small),
        ("large.npy", large),
        ("c.npy", npy("<c8", false, "(1,)", &[0; 8])),
    ];
    for is_deflated in [false, true] {
        let bytes = zip(&members, is_deflated);
        let volume = read("a.npz", bytes.clone(), &Overrides::default()).unwrap();
        assert_eq!((volume.value([0, 0, 0]), volume.contents().array_name()), (2.0, Some("large")));
        assert_eq!(volume.contents().arrays, ["flat", "small", "large"]);
        let chosen = |name: &str| Overrides { array: Some(name.into()), ..Overrides::default() };
        assert_eq!(read("a.npz", bytes.clone(), &chosen("small")).unwrap().value([0, 0, 0]), 1.0);
        let error = read("a.npz", bytes.clone(), &chosen("c")).unwrap_err().to_string();
        assert!(error.contains("complex"), "{error}");
        let error = read("a.npz", bytes.clone(), &chosen("gone")).unwrap_err().to_string();
        assert!(error.contains("flat, small, large, c"), "{error}");
        for cut in 0..bytes.len() {
            assert!(read("a.npz", bytes[..cut].to_vec(), &Overrides::default()).is_err(), "{cut}");
        }
    }
}

#[test]
fn damaged_members_are_noticed() {
    let bytes = zip(&[("a.npy", npy("|u1", false, "(2, 2, 30)", &[2; 120]))], true);
    let wrong = (0..bytes.len()).filter(|&at| {
        let mut bytes = bytes.clone();
        bytes[at] ^= 64;
        read("a.npz", bytes, &Overrides::default()).is_ok_and(|volume| volume.value([0, 0, 0]) != 2.0)
    });
    assert_eq!(wrong.count(), 0);
}
