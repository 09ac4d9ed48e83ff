//! Decompresses files of any format from gzip or bzip2, recognised by content.

use super::decompress::{Compression, beginning, decompress_all};
use super::{Source, format, nifti};
use crate::Result;

/// Bytes at the start of a file that identify its format.
const BEGINNING: usize = 4 << 10;

/// Largest compression ratio: bzip2 packs zeros best, 45 MB into a thousand bytes.
const BYTES_PER_BYTE: usize = 1 << 16;

/// Decompresses `source`, and keeps its name.
///
/// None if it is not compressed, or if its reader decompresses it: raw voxels, and NIfTI with gzip.
///
/// # Errors
/// Damaged data.
pub fn unpacked(source: &Source) -> Result<Option<Source>> {
    let bytes = source.bytes();
    let compression = match bytes {
        [0x1F, 0x8B, ..] => Compression::Gzip,
        [b'B', b'Z', b'h', b'1'..=b'9', ..] => Compression::Bzip2,
        _ => return Ok(None),
    };
    let start = beginning(bytes, compression, BEGINNING);
    let is_nifti = compression == Compression::Gzip && nifti::is_nifti(&start) && is_named_nifti(source);
    if is_nifti || nifti::header_beside(source.path()).is_some() || !format::is_known(&start, source.path()) {
        return Ok(None);
    }
    let limit = bytes.len().saturating_mul(BYTES_PER_BYTE);
    let unpacked = decompress_all(source, bytes, compression, limit)?;
    Ok(Some(Source::from_bytes(source.path(), unpacked)))
}

fn is_named_nifti(source: &Source) -> bool {
    let name = source.path().file_name().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
    [".nii.gz", ".hdr.gz", ".img.gz"].iter().any(|ending| name.ends_with(ending))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::volume::{Overrides, parse};
    use std::io::Write;
    use std::path::Path;

    const NRRD: &[u8] = b"NRRD0004\ntype: uint8\nsizes: 2 1 1\nencoding: raw\n\n\x07\x09";
    const VTI: &[u8] = br#"<?xml version="1.0"?><VTKFile type="ImageData" version="1.0" byte_order="LittleEndian"><ImageData WholeExtent="0 1 0 0 0 0" Origin="0 0 0" Spacing="1 1 1"><Piece Extent="0 1 0 0 0 0"><PointData Scalars="a"><DataArray type="UInt8" Name="a" format="ascii">7 9</DataArray></PointData></Piece></ImageData></VTKFile>"#;

    fn gzip(bytes: &[u8]) -> Vec<u8> {
        let mut out = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
        out.write_all(bytes).unwrap();
        out.finish().unwrap()
    }

    fn bzip2(bytes: &[u8]) -> Vec<u8> {
        let mut out = bzip2::write::BzEncoder::new(Vec::new(), bzip2::Compression::fast());
        out.write_all(bytes).unwrap();
        out.finish().unwrap()
    }

    /// A NIfTI file of two voxels.
    fn nifti() -> Vec<u8> {
        let mut bytes = vec![0u8; 352];
        bytes[..4].copy_from_slice(&348i32.to_le_bytes());
        for (at, value) in [(40, 3i16), (42, 2), (44, 1), (46, 1), (70, 2), (72, 8)] {
            bytes[at..at + 2].copy_from_slice(&value.to_le_bytes());
        }
        bytes[108..112].copy_from_slice(&352f32.to_le_bytes());
        bytes[344..348].copy_from_slice(b"n+1\0");
        bytes.extend([7, 9]);
        bytes
    }

    #[test]
    fn content_counts_before_names() {
        for bytes in [NRRD.to_vec(), VTI.to_vec(), nifti()] {
            for packed in [gzip(&bytes), bzip2(&bytes)] {
                for name in ["x", "x.gz", "x.vti.gz", "x.nii.gz", "x.nii.bz2", "scan"] {
                    let volume =
                        parse(&Source::from_bytes(Path::new(name), packed.clone()), &Overrides::default());
                    let volume = volume.unwrap_or_else(|e| panic!("{name}: {e}"));
                    assert_eq!([0, 1].map(|x| volume.value([x, 0, 0])), [7.0, 9.0], "{name}");
                }
            }
        }
    }

    #[test]
    fn bare_voxels_are_unpacked_where_the_length_fits() {
        let overrides = Overrides {
            dims: Some([40, 10, 10]),
            dtype: Some(fovol_core::Dtype::U8),
            ..Overrides::default()
        };
        let source = Source::from_bytes(Path::new("v.raw"), gzip(&[5; 4000]));
        assert_eq!(parse(&source, &overrides).unwrap().value([3, 0, 0]), 5.0);
    }

    #[test]
    fn damage_is_said() {
        let packed = gzip(&[NRRD, &[0; 9999]].concat());
        let source = Source::from_bytes(Path::new("x"), packed[..packed.len() - 9].to_vec());
        let error = parse(&source, &Overrides::default()).unwrap_err().to_string();
        assert!(error.contains("damaged"), "{error}");
    }
}
