//! Which parser a file belongs to: by its first bytes where they tell, else by its name.

use super::{Overrides, Source, legacy_vtk, metaimage, nifti, nrrd, tiff_stack, vti};
use crate::{Error, Result};
use fovol_core::Volume;
use std::io::Read;
use std::ops::Range;
use std::path::Path;

/// Reads one kind of volume file.
pub type Parser = fn(&Source, &Overrides) -> Result<Volume>;

/// The parser of `source`; none for bare voxels.
///
/// # Errors
/// A file of a kind that is known but not read.
pub fn parser_of(source: &Source) -> Result<Option<Parser>> {
    if nifti::header_beside(source.path()).is_some() {
        return Ok(Some(nifti::parse));
    }
    if let Some(parser) = by_content(source.bytes()).or_else(|| by_name(&name(source.path()))) {
        return Ok(Some(parser));
    }
    match foreign(source.bytes(), &name(source.path())) {
        Some(problem) => Err(source.unsupported(problem)),
        None => Ok(None),
    }
}

/// Reads a folder as a volume.
///
/// # Errors
/// A folder that holds no volume.
pub fn read_folder(path: &Path, overrides: &Overrides) -> Result<Volume> {
    if [".zattrs", ".zgroup", ".zarray", "zarr.json"].iter().any(|file| path.join(file).is_file()) {
        return Err(Error::unsupported(path, "Zarr is not read yet; convert one array to NRRD or NIfTI"));
    }
    if let Some(volume) = tiff_stack::parse_folder(path, overrides)? {
        return Ok(volume);
    }
    if holds_dicom(path) {
        return Err(Error::unsupported(path, DICOM));
    }
    Err(Error::unsupported(path, "it is a folder without slices; name a volume file"))
}

/// What to do with DICOM files, one or a folder of them.
const DICOM: &str = "DICOM is not read yet; convert the series to NIfTI, with dcm2niix for one";

/// Files of a folder that are looked into: series lie in folders of their own.
const FILES_LOOKED_AT: usize = 16;

/// Whether files in the folder `path` are of DICOM.
fn holds_dicom(path: &Path) -> bool {
    let entries = std::fs::read_dir(path).into_iter().flatten().flatten();
    let mut files = entries.map(|entry| entry.path()).filter(|path| path.is_file()).take(FILES_LOOKED_AT);
    files.any(|file| {
        let mut start = Vec::new();
        let opened = std::fs::File::open(&file);
        let is_read =
            opened.is_ok_and(|file| file.take(DICOM_MARK.end as u64).read_to_end(&mut start).is_ok());
        is_read && is_dicom(&start, &name(&file))
    })
}

/// Where DICOM files say what they are.
const DICOM_MARK: Range<usize> = 128..132;

/// `name` is in lower case.
fn is_dicom(bytes: &[u8], name: &str) -> bool {
    let ends = [".dcm", ".dicom"].iter().any(|ending| name.ends_with(ending));
    bytes.get(DICOM_MARK) == Some(b"DICM") || ends || name == "dicomdir"
}

fn by_content(bytes: &[u8]) -> Option<Parser> {
    match bytes {
        [b'N', b'R', b'R', b'D', b'0', b'0', b'0', _, ..] => Some(nrrd::parse),
        _ if bytes.starts_with(b"ObjectType") || bytes.starts_with(b"NDims") => Some(metaimage::parse),
        _ if nifti::is_nifti(bytes) => Some(nifti::parse),
        _ if tiff_stack::is_tiff(bytes) => Some(tiff_stack::parse),
        _ if bytes.starts_with(legacy_vtk::MARK) => Some(legacy_vtk::parse),
        _ => None,
    }
}

/// `name` is in lower case.
fn by_name(name: &str) -> Option<Parser> {
    let ends = |endings: &[&str]| endings.iter().any(|ending| name.ends_with(ending));
    match name {
        _ if ends(&[".mha", ".mhd"]) => Some(metaimage::parse),
        _ if ends(&[".nrrd", ".nhdr"]) => Some(nrrd::parse),
        _ if ends(&[".nii", ".nii.gz", ".hdr", ".hdr.gz"]) => Some(nifti::parse),
        _ if ends(&[".tif", ".tiff"]) => Some(tiff_stack::parse),
        _ if ends(&[".vti"]) => Some(vti::parse),
        _ if ends(&[".vtk"]) => Some(legacy_vtk::parse),
        _ => None,
    }
}

/// What is wrong with files of kinds that are known but not read.
fn foreign(bytes: &[u8], name: &str) -> Option<&'static str> {
    let ends = |endings: &[&str]| endings.iter().any(|ending| name.ends_with(ending));
    Some(match bytes {
        _ if is_dicom(bytes, name) => DICOM,
        [0x89, b'H', b'D', b'F', ..] | [b'C', b'D', b'F', 1 | 2 | 5, ..] => {
            "HDF5 and NetCDF are not read yet; convert one variable to NRRD or raw, with h5py or xarray for one"
        }
        _ if ends(&[".h5", ".hdf5", ".nc"]) => {
            "HDF5 and NetCDF are not read yet; convert one variable to NRRD or raw, with h5py or xarray for one"
        }
        [b'P', b'V', b'M', ..] | [b'D', b'D', b'S', b' ', b'v', ..] => {
            "PVM is not read; convert it to raw with pvm2raw of the V^3 package"
        }
        [0x89, b'P', b'N', b'G', ..] | [0xFF, 0xD8, 0xFF, ..] => {
            "it is a picture; put its slices into a TIFF stack"
        }
        [b'P', b'K', 3, 4, ..] | [b'7', b'z', 0xBC, 0xAF, ..] => {
            "it is an archive; unpack it and name a file in it"
        }
        _ if ends(&[".vtu", ".vtp", ".vts", ".vtr", ".vtm", ".pvd", ".pvti"]) => {
            "only image data is read of VTK's XML files; resample it to .vti, in ParaView for one"
        }
        _ if ends(&[".vdb", ".slc", ".mnc", ".mgz", ".mgh", ".czi", ".lif", ".am"]) => {
            "this format is not read; convert it to NRRD, NIfTI or raw"
        }
        _ => return None,
    })
}

fn name(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().to_ascii_lowercase()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kinds_that_are_not_read_say_what_to_do() {
        let mut dicom = vec![0; 128];
        dicom.extend(b"DICM");
        for (name, bytes) in
            [("a", dicom), ("b", b"\x89HDF\r\n\x1a\n".to_vec()), ("c.zip", b"PK\x03\x04".to_vec())]
        {
            let error = parser_of(&Source::from_bytes(Path::new(name), bytes)).unwrap_err().to_string();
            assert!(error.starts_with(name) && error.contains("; ") && !error.contains('\n'), "{error}");
        }
    }

    #[test]
    fn folders_of_dicom_are_told_what_to_do() {
        let folder = tempfile::tempdir().unwrap();
        let said = || read_folder(folder.path(), &Overrides::default()).unwrap_err().to_string();
        std::fs::write(folder.path().join("notes.txt"), "of the scan").unwrap();
        assert!(said().contains("without slices"), "{}", said());
        let slice = [&[0; 128][..], b"DICM", &[0; 9]].concat();
        std::fs::write(folder.path().join("IM0001"), slice).unwrap();
        assert!(said().contains("dcm2niix"), "{}", said());
    }

    #[test]
    fn bare_voxels_have_no_parser() {
        assert!(parser_of(&Source::from_bytes(Path::new("x.raw"), vec![0; 9])).unwrap().is_none());
    }
}
