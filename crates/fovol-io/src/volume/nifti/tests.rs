use super::*;
use crate::volume::detached::Beside;
use crate::volume::{Overrides, read};
use fovol_core::{Dtype, Endian, Grid};
use std::fs;

/// Reads `source` without choices.
fn parse(source: &Source) -> Result<Volume> {
    super::parse(source, &Overrides::default())
}

/// A NIfTI-1 header of a pair with these fields; nothing else is set.
fn header(endian: Endian, dims: &[i16], code: i16) -> Vec<u8> {
    let mut bytes = vec![0; 348];
    put(&mut bytes, endian, 0, 348i32.to_le_bytes());
    put(&mut bytes, endian, 70, code.to_le_bytes());
    for (axis, &dim) in [dims.len() as i16].iter().chain(dims).enumerate() {
        put(&mut bytes, endian, 40 + 2 * axis, dim.to_le_bytes());
    }
    bytes[344..348].copy_from_slice(b"ni1\0");
    bytes
}

fn put<const N: usize>(bytes: &mut [u8], endian: Endian, at: usize, mut value: [u8; N]) {
    if endian == Endian::Big {
        value.reverse();
    }
    bytes[at..at + N].copy_from_slice(&value);
}

fn put_float(bytes: &mut [u8], at: usize, value: f32) {
    put(bytes, Endian::Little, at, value.to_le_bytes());
}

/// The header with its voxels behind it, as one file.
fn single(mut header: Vec<u8>, voxels: &[u8]) -> Source {
    header[344..348].copy_from_slice(b"n+1\0");
    header.extend([0; 4]);
    header.extend_from_slice(voxels);
    Source::from_bytes(Path::new("x.nii"), header)
}

fn gzip(bytes: &[u8]) -> Vec<u8> {
    use std::io::Write;
    let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    packed.write_all(bytes).unwrap();
    packed.finish().unwrap()
}

#[test]
fn both_byte_orders_and_no_copy() {
    for (endian, voxels) in [(Endian::Little, [1, 0, 2, 0]), (Endian::Big, [0, 1, 0, 2])] {
        let source = single(header(endian, &[2, 1, 1], 4), &voxels);
        let volume = parse(&source).unwrap();
        assert_eq!((volume.dtype(), volume.value([1, 0, 0])), (Dtype::I16, 2.0));
        assert_eq!(volume.data().as_ptr(), source.bytes()[352..].as_ptr());
    }
}

#[test]
fn every_type_is_known_and_complex_refused() {
    let one = |code| parse(&single(header(Endian::Little, &[1, 1, 1], code), &[0; 8]));
    for (code, dtype, components) in [
        (2, Dtype::U8, 1),
        (4, Dtype::I16, 1),
        (8, Dtype::I32, 1),
        (16, Dtype::F32, 1),
        (64, Dtype::F64, 1),
        (128, Dtype::U8, 3),
        (256, Dtype::I8, 1),
        (512, Dtype::U16, 1),
        (768, Dtype::U32, 1),
        (1024, Dtype::I64, 1),
        (1280, Dtype::U64, 1),
        (2304, Dtype::U8, 4),
    ] {
        let volume = one(code).unwrap();
        assert_eq!((volume.dtype(), volume.components()), (dtype, components), "{code}");
    }
    for (code, word) in [(32, "complex"), (1792, "complex"), (1536, "128-bit"), (1, "bits"), (77, "77")] {
        let error = one(code).unwrap_err().to_string();
        assert!(error.contains(word) && !error.contains('\n'), "{error}");
    }
}

#[test]
fn scaling_spacing_and_orientation() {
    let mut bytes = header(Endian::Little, &[1, 1, 1], 4);
    for (axis, spacing) in [(1, -2.0), (2, 0.0), (3, 0.5)] {
        put_float(&mut bytes, 76 + 4 * axis, spacing);
    }
    put_float(&mut bytes, 112, 2.0);
    put_float(&mut bytes, 116, -1.0);
    put(&mut bytes, Endian::Little, 254, 1i16.to_le_bytes());
    put_float(&mut bytes, 280, 0.1);
    let volume = parse(&single(bytes.clone(), &[3, 0])).unwrap();
    assert_eq!(volume.grid().spacing(), [2.0, 1.0, 0.5]);
    assert_eq!(volume.value([0; 3]), 5.0);
    assert_eq!(volume.placement(), None);
    assert!(volume.notes()[0].contains("span no space"), "{:?}", volume.notes());

    for slope in [0.0, f32::NAN] {
        put_float(&mut bytes, 112, slope);
        assert_eq!(parse(&single(bytes.clone(), &[3, 0])).unwrap().value([0; 3]), 3.0);
    }
    put_float(&mut bytes, 112, 1.0);
    put_float(&mut bytes, 116, f32::NAN);
    assert!(parse(&single(bytes, &[3, 0])).unwrap_err().to_string().contains("scl_inter"));
}

#[test]
fn the_first_of_several_volumes() {
    let volume = parse(&single(header(Endian::Little, &[1, 1, 2, 3], 2), &[7, 8, 0, 0, 0, 0])).unwrap();
    assert_eq!((volume.grid().dims(), volume.data()), ([1, 1, 2], &[7, 8][..]));
    assert_eq!(volume.contents().times, 3);
}

#[test]
fn vectors_lie_along_axis_five() {
    let mut bytes = header(Endian::Little, &[1, 1, 2, 2, 3], 2);
    put(&mut bytes, Endian::Little, 68, 1007i16.to_le_bytes());
    let source = single(bytes, &(0..12).collect::<Vec<u8>>());
    let read = |time, component| {
        crate::volume::parse(&source, &Overrides { time, component, ..Overrides::default() })
    };
    let volume = read(None, None).unwrap();
    assert_eq!((volume.contents().times, volume.contents().components), (2, 3));
    assert_eq!(volume.data(), [0, 1]);
    assert_eq!(read(Some(1), None).unwrap().data(), [2, 3]);
    assert_eq!(read(Some(1), Some(2)).unwrap().data(), [10, 11]);
    assert!(read(Some(2), None).unwrap_err().to_string().ends_with("it has 2 time points, 0 to 1"));
    assert!(read(None, Some(3)).unwrap_err().to_string().ends_with("it has 3 components, 0 to 2"));
}

#[test]
fn colours_and_labels_are_known() {
    let volume = parse(&single(header(Endian::Little, &[1, 1, 1], 128), &[1, 2, 3])).unwrap();
    assert!(volume.contents().are_colours && !volume.contents().are_labels);
    let mut bytes = header(Endian::Little, &[1, 1, 1], 2);
    put(&mut bytes, Endian::Little, 68, 1002i16.to_le_bytes());
    assert!(parse(&single(bytes, &[1])).unwrap().contents().are_labels);
}

#[test]
fn pairs_are_found_from_either_half() {
    let header = header(Endian::Little, &[2, 1, 1], 2);
    let plain = (header.clone(), vec![5u8, 6]);
    let packed = (gzip(&plain.0), gzip(&plain.1));
    for (hdr, img, (first, second)) in [
        ("a.hdr", "a.img", &plain),
        ("a.hdr.gz", "a.img.gz", &packed),
        ("A.HDR", "A.IMG", &plain),
        ("a.hdr", "a.img.gz", &(plain.0.clone(), packed.1.clone())),
    ] {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join(hdr), first).unwrap();
        fs::write(folder.path().join(img), second).unwrap();
        for name in [hdr, img] {
            let volume = read(&folder.path().join(name), &Overrides::default()).unwrap();
            assert_eq!(volume.data(), [5, 6], "{name} of {hdr} and {img}");
        }
        fs::remove_file(folder.path().join(img)).unwrap();
        let error = read(&folder.path().join(hdr), &Overrides::default()).unwrap_err().to_string();
        assert!(error.contains(".img; put it beside"), "{error}");
    }
}

#[test]
fn broken_headers_are_one_line_errors() {
    let sound = header(Endian::Little, &[2, 2, 2], 2);
    let with = |at: usize, bytes: &[u8]| {
        let mut header = sound.clone();
        header[at..at + bytes.len()].copy_from_slice(bytes);
        single(header, &[0; 8])
    };
    for (what, source) in [
        ("no length", with(0, &[0; 4])),
        ("no axes", with(40, &[0, 0])),
        ("too many axes", with(40, &[8, 0])),
        ("no voxels", with(42, &[0, 0])),
        ("negative size", with(42, &[0xFF, 0xFF])),
        ("too few bytes", with(42, &[3, 0])),
        ("offset inside the header", with(108, &100f32.to_le_bytes())),
        ("negative offset", with(108, &(-1e30f32).to_le_bytes())),
        ("offset beyond everything", with(108, &f32::INFINITY.to_le_bytes())),
        ("empty", Source::from_bytes(Path::new("x.nii"), vec![])),
        ("short", Source::from_bytes(Path::new("x.nii"), sound[..200].to_vec())),
        ("short gzip", Source::from_bytes(Path::new("x.nii.gz"), gzip(&sound[..200]))),
    ] {
        let error = parse(&source).err().unwrap_or_else(|| panic!("{what} was read")).to_string();
        assert!(error.starts_with("x.nii") && !error.contains('\n'), "{error}");
    }
}

#[test]
fn huge_sizes_and_odd_spacings_make_it_nifti_2() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("v.nii");
    for (dims, spacing, format) in [
        ([32767, 1, 1], 1.0, "NIfTI-1"),
        ([32768, 1, 1], 1.0, "NIfTI-2"),
        ([1, 1, 1], 1e300, "NIfTI-2"),
        ([1, 1, 1], 1e-60, "NIfTI-2"),
    ] {
        let grid = Grid::new(dims, [spacing; 3]).unwrap();
        let volume = Volume::from_values(grid, vec![9u8; dims[0]]).unwrap();
        write(&volume, &path, Beside::Own).unwrap();
        let back = read(&path, &Overrides::default()).unwrap();
        assert_eq!((back.format(), back.grid()), (format, &grid));
        assert_eq!(back.data(), volume.data());
    }
}

#[test]
fn real_files() {
    let Some(data) = crate::test_data() else { return };
    let formats = data.join("formats");
    for (name, dims, dtype) in [
        ("nifti_rs/27/float32.nii", [3, 3, 3], Dtype::F32),
        ("nifti_rs/27/uint64.nii", [3, 3, 3], Dtype::U64),
        ("nifti_rs/27/int8.nii", [3, 3, 3], Dtype::I8),
        ("nifti_rs/minimal.nii", [64, 64, 10], Dtype::U8),
        ("nifti_rs/minimal.hdr", [64, 64, 10], Dtype::U8),
        ("nifti_rs/minimal.img.gz", [64, 64, 10], Dtype::U8),
        ("nibabel/anatomical.nii", [33, 41, 25], Dtype::I16),
        ("nibabel/example4d.nii.gz", [128, 96, 24], Dtype::I16),
    ] {
        let path = formats.join(name);
        if !path.is_file() {
            println!("skipped: no {}", path.display());
            continue;
        }
        let volume = read(&path, &Overrides::default()).unwrap();
        assert_eq!((volume.grid().dims(), volume.dtype()), (dims, dtype), "{name}");
    }
}
