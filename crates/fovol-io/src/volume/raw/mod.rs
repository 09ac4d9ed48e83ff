//! Bare voxels: size and type come from the user, from a sidecar, or from the file name.

mod dat;
mod description;
mod file_name;
mod gzip;
mod json;
mod sidecar;
mod write;
mod xml;

use super::{Overrides, Source};
use crate::Result;
use description::Description;
use file_name::FileName;
use fovol_core::Volume;
use sidecar::Found;
pub use write::write;

/// Reads `source` as raw voxels, with or without gzip, or as their sidecar.
///
/// # Errors
/// Size or type unknown, or fewer bytes than they need.
pub fn parse(source: &Source, overrides: &Overrides) -> Result<Volume> {
    let name = FileName::of(source.path());
    let volume = read(source, overrides, name.said.clone())?;
    let volume = name.unclear.iter().fold(volume, |volume, word| {
        volume.with_note(format!(
            "`{word}` in the file's name is not understood; --dims, --dtype or --spacing say it"
        ))
    });
    Ok(match (overrides.dims, name.said.dims) {
        (Some(said), Some(named)) if said != named => volume.with_note(contradiction(said, named)),
        _ => volume,
    })
}

/// The message for `--dims` that differ from the dims in the file's name.
fn contradiction([x, y, z]: [usize; 3], [nx, ny, nz]: [usize; 3]) -> String {
    format!("--dims {x},{y},{z} contradicts the file's name, {nx}x{ny}x{nz}")
}

fn read(source: &Source, overrides: &Overrides, named: Description) -> Result<Volume> {
    let user = Description::of_user(overrides);
    if let Some(reader) = sidecar::reader_of(source) {
        let said = user.or(reader(source)?);
        return said.volume(&voxels_of(source, &said)?);
    }
    if user.dims.is_some() && user.dtype.is_some() {
        return user.or(named).volume(source);
    }
    match sidecar::beside(source, overrides)? {
        Found::Volume(volume) => Ok(*volume),
        Found::Description(said) => user.or(*said).or(named).volume(source),
        Found::Nothing if overrides.dims.is_none() && named.dims.is_none() && !is_bare(source) => {
            Err(source.unsupported(
                "it is of no known kind; convert it to NRRD, NIfTI, MetaImage, .vti or TIFF, or give --dims and --dtype of bare voxels",
            ))
        }
        Found::Nothing => user.or(named).volume(source),
    }
}

/// Whether the file name is that of raw voxels.
pub fn is_bare(source: &Source) -> bool {
    let name = source.path().file_name().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
    let name = name.strip_suffix(".gz").unwrap_or(&name);
    [".raw", ".bin", ".dat", ".zraw"].iter().any(|ending| name.ends_with(ending))
}

/// The data file of a sidecar: the one it names, else the one with the same stem.
fn voxels_of(sidecar: &Source, said: &Description) -> Result<Source> {
    if let Some(file) = &said.file {
        return sidecar.sibling(file);
    }
    let beside = |ending: &str| Some(sidecar.path().with_extension(ending)).filter(|path| path.is_file());
    match beside("raw").or_else(|| beside("raw.gz")) {
        Some(path) => Source::open(&path),
        None => Err(sidecar.malformed("it names no data file, and no .raw of its name lies beside it")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fovol_core::{Dtype, Endian};
    use std::fs;
    use std::path::{Path, PathBuf};

    fn folder(files: &[(&str, &[u8])]) -> (tempfile::TempDir, impl Fn(&str) -> PathBuf + use<>) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().to_owned();
        for (name, bytes) in files {
            fs::write(path.join(name), bytes).unwrap();
        }
        (folder, move |name| path.join(name))
    }

    fn read(path: &Path) -> Result<Volume> {
        crate::volume::read(path, &Overrides::default())
    }

    #[test]
    fn every_sidecar_is_found_beside_the_voxels() {
        let sidecars = [
            ("v.dat", "ObjectFileName: v.raw\nResolution: 2 1 1\nFormat: USHORT\nByteOrder: BigEndian\n"),
            ("v.json", r#"{"dims": [2, 1, 1], "dtype": "u16", "endian": "big"}"#),
            (
                "v.nhdr",
                "NRRD0004\ntype: ushort\nsizes: 2 1 1\nendian: big\nencoding: raw\ndata file: v.raw\n",
            ),
            (
                "v.mhd",
                "NDims = 3\nDimSize = 2 1 1\nElementType = MET_USHORT\nElementByteOrderMSB = True\nElementDataFile = v.raw\n",
            ),
            (
                "v.vvd",
                "<VoreenData><RawData filename=\"v.raw\" format=\"uint16\" x=\"2\" y=\"1\" z=\"1\" /><a key='LittleEndian'/></VoreenData>",
            ),
        ];
        for (name, text) in sidecars {
            let (_kept, at) = folder(&[("v.raw", &[0, 1, 0, 2]), (name, text.as_bytes())]);
            let beside = read(&at("v.raw")).unwrap();
            let direct = read(&at(name)).unwrap();
            assert_eq!(beside.grid(), direct.grid(), "{name}");
            let expected = if name == "v.vvd" { 512.0 } else { 2.0 };
            assert_eq!([beside.value([1, 0, 0]), direct.value([1, 0, 0])], [expected; 2], "{name}");
        }
    }

    #[test]
    fn users_outdo_sidecars_and_sidecars_names() {
        let json = br#"{"dims": [3, 1, 1], "dtype": "u8"}"#;
        let (_kept, at) = folder(&[("v_2x1x1_int16.raw", &[1, 2, 3, 4]), ("v_2x1x1_int16.json", json)]);
        assert_eq!(read(&at("v_2x1x1_int16.raw")).unwrap().grid().dims(), [3, 1, 1]);
        let overrides = Overrides {
            dims: Some([1, 1, 2]),
            dtype: Some(Dtype::U16),
            endian: Some(Endian::Big),
            ..Overrides::default()
        };
        let volume = crate::volume::read(&at("v_2x1x1_int16.raw"), &overrides).unwrap();
        assert_eq!((volume.grid().dims(), volume.value([0, 0, 1])), ([1, 1, 2], 772.0));
    }

    #[test]
    fn a_sidecar_of_another_file_is_left_alone() {
        let json = br#"{"file": "other.raw", "dims": [4, 1, 1], "dtype": "u8"}"#;
        let (_kept, at) = folder(&[("v.raw", &[1, 2, 3, 4]), ("other.raw", &[9; 4]), ("v.json", json)]);
        let error = read(&at("v.raw")).unwrap_err().to_string();
        assert!(error.contains("size is not known"), "{error}");
        assert_eq!(read(&at("v.json")).unwrap().value([0, 0, 0]), 9.0);
    }

    #[test]
    fn json_of_other_programs_is_passed_over() {
        let dat = b"RawFile: v.raw\nResolution: 2 1 1\nFormat: UINT8\n";
        let (_kept, at) =
            folder(&[("v.raw", &[1, 2]), ("v.json", b"{\"Manufacturer\": \"x\"}"), ("v.dat", dat)]);
        assert_eq!(read(&at("v.raw")).unwrap().data(), [1, 2]);
        assert!(read(&at("v.json")).unwrap_err().to_string().contains("no description"));
    }

    #[test]
    fn packed_voxels_are_unpacked_and_counted() {
        let packed = packed(&[1, 2, 3, 4]);
        let (_kept, at) = folder(&[("a_4x1x1_uint8.raw.gz", &packed), ("b_5x1x1_uint8.raw.gz", &packed)]);
        assert_eq!(read(&at("a_4x1x1_uint8.raw.gz")).unwrap().data(), [1, 2, 3, 4]);
        assert!(
            read(&at("b_5x1x1_uint8.raw.gz")).unwrap_err().to_string().contains("ends before the 5 bytes")
        );
    }

    /// The notes of, or the error from, the file at `path` read with `dims`.
    fn noted(path: &Path, dims: [usize; 3]) -> std::result::Result<String, String> {
        let overrides = Overrides { dims: Some(dims), dtype: Some(Dtype::U8), ..Overrides::default() };
        let volume = crate::volume::read(path, &overrides).map_err(|e| e.to_string())?;
        Ok(volume.notes().join("|"))
    }

    fn packed(bytes: &[u8]) -> Vec<u8> {
        use std::io::Write;
        let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
        packed.write_all(bytes).unwrap();
        packed.finish().unwrap()
    }

    #[test]
    fn dims_that_may_be_wrong_are_noted() {
        let (_kept, at) =
            folder(&[("v_3x2x1_u8.raw", &[7; 6]), ("w.raw", &[7; 6]), ("w.raw.gz", &packed(&[7; 6]))]);
        assert_eq!(noted(&at("v_3x2x1_u8.raw"), [3, 2, 1]).unwrap(), "");
        assert_eq!(
            noted(&at("v_3x2x1_u8.raw"), [2, 3, 1]).unwrap(),
            "--dims 2,3,1 contradicts the file's name, 3x2x1"
        );
        for name in ["w.raw", "w.raw.gz"] {
            let note = noted(&at(name), [2, 1, 2]).unwrap();
            assert!(note.ends_with("has 2 bytes more than 2x1x2 u8 needs; are the dims right?"), "{note}");
        }
    }

    #[test]
    fn too_large_dims_are_told_what_there_is() {
        let (_kept, at) = folder(&[("w.raw", &[7; 6]), ("w.raw.gz", &packed(&[7; 6]))]);
        for name in ["w.raw", "w.raw.gz"] {
            let error = noted(&at(name), [4, 4, 4]).unwrap_err();
            assert!(
                error.contains("--dims 4,4,4 needs 64 bytes, the file has 6; check --dims and --dtype"),
                "{error}"
            );
        }
    }

    #[test]
    fn missing_voxels_are_named() {
        let (_kept, at) = folder(&[
            ("v.json", br#"{"dims": [4, 1, 1], "dtype": "u8"}"#),
            ("w.dat", b"RawFile: gone.raw\nResolution: 1 1 1\nFormat: UINT8\n"),
        ]);
        assert!(read(&at("v.json")).unwrap_err().to_string().contains("names no data file"));
        assert!(read(&at("w.dat")).unwrap_err().to_string().contains("gone.raw"));
    }
}
