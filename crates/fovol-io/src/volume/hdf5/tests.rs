use super::*;
use std::path::Path;

#[test]
fn files_that_are_none_say_so() {
    let error = parse(&Source::from_bytes(Path::new("a.h5"), b"text".to_vec()), &Overrides::default());
    assert!(error.unwrap_err().to_string().contains("does not begin like an HDF5 file"));
    assert!(is_hdf5(&[&[7; 1024][..], b"\x89HDF\r\n\x1a\n"].concat()));
    assert!(!is_hdf5(&[&[7; 700][..], b"\x89HDF\r\n\x1a\n"].concat()));
}

#[test]
fn signatures_alone_are_damaged_files() {
    let mut bytes = b"\x89HDF\r\n\x1a\n".to_vec();
    bytes.extend([0; 90]);
    let error = parse(&Source::from_bytes(Path::new("a.h5"), bytes), &Overrides::default()).unwrap_err();
    assert!(!error.to_string().contains('\n'), "{error}");
}
