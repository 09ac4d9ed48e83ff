//! Selects the parser of a file by its first bytes, or by its name if the bytes identify no format.

use super::array_path::is_zarr;
#[cfg(feature = "dicom")]
use super::dicom;
#[cfg(feature = "zarr")]
use super::zarr;
use super::{
    Overrides, Source, legacy_vtk, metaimage, nanovdb, nifti, nrrd, numpy, raw, slice_folder, tiff_stack,
    vdb, vti,
};
#[cfg(feature = "hdf5")]
use super::{hdf5, netcdf};
#[cfg(not(all(feature = "dicom", feature = "zarr")))]
use crate::Error;
use crate::Result;
use fovol_core::Volume;
#[cfg(not(feature = "dicom"))]
use std::io::Read;
use std::ops::Range;
use std::path::Path;

/// Reads volume files of one format.
pub type Parser = fn(&Source, &Overrides) -> Result<Volume>;

/// The parser of `source`; none for raw voxels.
///
/// # Errors
/// A format that is known but not read.
pub fn parser_of(source: &Source) -> Result<Option<Parser>> {
    let (bytes, name) = (source.bytes(), name(source.path()));
    if nifti::header_beside(source.path()).is_some() {
        return Ok(Some(nifti::parse));
    }
    if let Some(parser) = by_content(bytes) {
        return Ok(Some(parser));
    }
    #[cfg(feature = "dicom")]
    if is_dicom(bytes) || is_dicom_name(&name) {
        return Ok(Some(dicom::parse));
    }
    #[cfg(feature = "zarr")]
    if zarr::is_archive(source) || is_zarr_name(&name) {
        return Ok(Some(zarr::parse_archive));
    }
    #[cfg(not(feature = "zarr"))]
    if is_zarr_name(&name) {
        return Err(source.unsupported(ZARR));
    }
    // Bare voxels may begin like anything, but hardly with a mark 128 bytes behind zeros.
    let marked = foreign_content(bytes).filter(|_| is_dicom(bytes) || !raw::is_bare(source));
    if let Some(problem) = marked {
        return Err(source.unsupported(problem));
    }
    if let Some(parser) = by_name(&name) {
        return Ok(Some(parser));
    }
    match foreign_name(&name) {
        Some(problem) => Err(source.unsupported(problem)),
        None => Ok(None),
    }
}

/// Whether a file called `name` has the ending of a format with a header.
pub fn is_name_with_header(name: &str) -> bool {
    by_name(&self::name(Path::new(name))).is_some()
}

/// Whether a decompressed file is of a known format rather than raw voxels.
///
/// `bytes` are the start of the decompressed data, `path` the compressed file.
pub fn is_known(bytes: &[u8], path: &Path) -> bool {
    by_content(bytes).is_some() || foreign_content(bytes).is_some() || by_name(&name(path)).is_some()
}

/// Reads the folder `path` as a volume; `None` if it has no slices and is none of Zarr.
///
/// # Errors
/// Damaged files.
pub fn read_folder(path: &Path, overrides: &Overrides) -> Result<Option<Volume>> {
    if is_zarr(path) {
        #[cfg(feature = "zarr")]
        return zarr::parse_folder(path, overrides).map(Some);
        #[cfg(not(feature = "zarr"))]
        return Err(Error::unsupported(path, ZARR));
    }
    #[cfg(feature = "dicom")]
    if dicom::is_in_folder(path)
        && let Some(volume) = dicom::parse_folder(path, overrides)?
    {
        return Ok(Some(volume));
    }
    if let Some(volume) = tiff_stack::parse_folder(path, overrides)? {
        return Ok(Some(volume));
    }
    if let Some(volume) = slice_folder::parse(path, overrides)? {
        return Ok(Some(volume));
    }
    #[cfg(feature = "dicom")]
    if let Some(volume) = dicom::parse_folder(path, overrides)? {
        return Ok(Some(volume));
    }
    #[cfg(not(feature = "dicom"))]
    if holds_dicom(path) {
        return Err(Error::unsupported(path, DICOM));
    }
    Ok(None)
}

/// Advice for a DICOM file, or a folder of them.
const DICOM: &str = "this program is built without the cargo feature `dicom`; convert the series to NIfTI, with `dcm2niix -z y -o OUT FOLDER` for one";

/// Number of files that are examined in a folder: a series lies in a folder of its own.
#[cfg(not(feature = "dicom"))]
const FILES_LOOKED_AT: usize = 16;

/// Whether files in the folder `path` are of DICOM.
#[cfg(not(feature = "dicom"))]
fn holds_dicom(path: &Path) -> bool {
    let entries = std::fs::read_dir(path).into_iter().flatten().flatten();
    let mut files = entries.map(|entry| entry.path()).filter(|path| path.is_file()).take(FILES_LOOKED_AT);
    files.any(|file| {
        let mut start = Vec::new();
        let opened = std::fs::File::open(&file);
        let is_read =
            opened.is_ok_and(|file| file.take(DICOM_MARK.end as u64).read_to_end(&mut start).is_ok());
        is_read && (is_dicom(&start) || is_dicom_name(&name(&file)))
    })
}

/// Position of the magic number in DICOM files, in bytes.
const DICOM_MARK: Range<usize> = 128..132;

fn is_dicom(bytes: &[u8]) -> bool {
    bytes.get(DICOM_MARK) == Some(b"DICM")
}

/// `name` is in lower case.
fn is_dicom_name(name: &str) -> bool {
    [".dcm", ".dicom"].iter().any(|ending| name.ends_with(ending)) || name == "dicomdir"
}

/// Whether it is the name of Zarr in an archive; `name` is in lower case.
fn is_zarr_name(name: &str) -> bool {
    [".zarr.zip", ".ozx"].iter().any(|ending| name.ends_with(ending))
}

fn by_content(bytes: &[u8]) -> Option<Parser> {
    match bytes {
        [b'N', b'R', b'R', b'D', b'0', b'0', b'0', _, ..] => Some(nrrd::parse),
        _ if bytes.starts_with(b"ObjectType") || bytes.starts_with(b"NDims") => Some(metaimage::parse),
        _ if nifti::is_nifti(bytes) => Some(nifti::parse),
        // Preambles of DICOM files may look like TIFF.
        _ if is_dicom(bytes) => None,
        _ if tiff_stack::is_tiff(bytes) => Some(tiff_stack::parse),
        _ if bytes.starts_with(legacy_vtk::MARK) => Some(legacy_vtk::parse),
        _ if vti::is_vti(bytes) => Some(vti::parse),
        _ if numpy::is_npy(bytes) => Some(numpy::parse),
        _ if numpy::is_npz(bytes) => Some(numpy::parse_npz),
        _ if vdb::is_vdb(bytes) => Some(vdb::parse),
        _ if nanovdb::is_nanovdb(bytes) => Some(nanovdb::parse),
        #[cfg(feature = "hdf5")]
        _ if hdf5::is_hdf5(bytes) => Some(hdf5::parse),
        #[cfg(feature = "hdf5")]
        _ if netcdf::is_classic(bytes) => Some(netcdf::parse),
        _ => None,
    }
}

/// `name` is in lower case.
fn by_name(name: &str) -> Option<Parser> {
    let ends = |endings: &[&str]| endings.iter().any(|ending| name.ends_with(ending));
    match name {
        _ if ends(&[".mha", ".mhd"]) => Some(metaimage::parse),
        _ if ends(&[".nrrd", ".nhdr"]) => Some(nrrd::parse),
        _ if ends(&[".nii", ".hdr"]) => Some(nifti::parse),
        _ if ends(&[".tif", ".tiff"]) => Some(tiff_stack::parse),
        _ if ends(&[".vti", ".vtr", ".pvti"]) => Some(vti::parse),
        _ if ends(&[".vtk"]) => Some(legacy_vtk::parse),
        _ if ends(&[".npy"]) => Some(numpy::parse),
        _ if ends(&[".npz"]) => Some(numpy::parse_npz),
        _ if ends(&[".vdb"]) => Some(vdb::parse),
        _ if ends(&[".nvdb"]) => Some(nanovdb::parse),
        #[cfg(feature = "hdf5")]
        _ if ends(&[".h5", ".hdf5", ".ims", ".nc", ".nc4"]) => Some(hdf5::parse),
        _ => None,
    }
}

/// Advice for programs that are built without these formats.
#[cfg(not(feature = "hdf5"))]
const HDF5: &str = "HDF5 and NetCDF are read only with the cargo feature `hdf5` of fovol-io; build with it, or convert one variable to NRRD or .npy";

/// Advice for programs that are built without Zarr.
#[cfg(not(feature = "zarr"))]
const ZARR: &str = "Zarr is read only with the cargo feature `zarr` of fovol-io; build with it, or convert one array to NRRD or .npy";

/// Advice for files of microscopes that their makers' programs write.
const MICROSCOPE: &str = "this format of a microscope is not read; convert it with `bioformats2raw IN OUT.zarr`, or with `bfconvert IN OUT.ome.tif` of bftools";

/// Advice for VTK's files of other data than images.
const VTK_XML: &str = "it is no image of VTK; make one of it in ParaView: Filters > Resample To Image, then File > Save Data as .vti";

/// Advice for formats that are known but not read, recognised by the first `bytes` of the file.
fn foreign_content(bytes: &[u8]) -> Option<&'static str> {
    Some(match bytes {
        _ if is_dicom(bytes) => DICOM,
        #[cfg(not(feature = "hdf5"))]
        [0x89, b'H', b'D', b'F', ..] | [b'C', b'D', b'F', 1 | 2 | 5, ..] => HDF5,
        [b'P', b'V', b'M', ..] | [b'D', b'D', b'S', b' ', b'v', ..] => {
            "PVM is not read; convert it to raw with pvm2raw of the V^3 package"
        }
        [0x89, b'P', b'N', b'G', ..] | [0xFF, 0xD8, 0xFF, ..] => {
            "it is one picture; name the folder that holds all slices"
        }
        [b'P', b'K', 3, 4, ..] | [b'7', b'z', 0xBC, 0xAF, ..] => {
            "it is an archive; unpack it and name a file in it"
        }
        _ if bytes.starts_with(b"ZISRAWFILE") || bytes.starts_with(b"\xDA\xCE\xBE\x0A") => MICROSCOPE,
        _ if vti::is_vtk_xml(bytes) => VTK_XML,
        _ => return None,
    })
}

/// Advice for formats that are known but not read, recognised by the file's `name` in lower case.
fn foreign_name(name: &str) -> Option<&'static str> {
    let ends = |endings: &[&str]| endings.iter().any(|ending| name.ends_with(ending));
    Some(match () {
        () if is_dicom_name(name) => DICOM,
        #[cfg(not(feature = "hdf5"))]
        () if ends(&[".h5", ".hdf5", ".ims", ".nc", ".nc4"]) => HDF5,
        () if ends(&[".vtu", ".vtp", ".vts", ".vtm", ".pvd", ".pvtu", ".pvtr"]) => VTK_XML,
        () if ends(&[".mgz", ".mgh"]) => {
            "MGH is not read; convert it to NIfTI, with `mri_convert IN.mgz OUT.nii.gz` of FreeSurfer for one"
        }
        () if ends(&[".czi", ".lif", ".nd2", ".oir", ".oib", ".vsi"]) => MICROSCOPE,
        () if ends(&[".slc", ".mnc", ".am"]) => "this format is not read; convert it to NRRD, NIfTI or raw",
        () => return None,
    })
}

/// The name of the file in lower case, without the ending of a compression.
fn name(path: &Path) -> String {
    let name = path.file_name().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
    let bare = [".gz", ".bz2"].iter().find_map(|ending| name.strip_suffix(ending));
    bare.map_or_else(|| name.clone(), str::to_owned)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kinds_that_are_not_read_say_what_to_do() {
        for (name, bytes) in [("b.am", vec![1; 9]), ("c.zip", b"PK\x03\x04".to_vec())] {
            let error = parser_of(&Source::from_bytes(Path::new(name), bytes)).unwrap_err().to_string();
            assert!(error.starts_with(name) && error.contains("; ") && !error.contains('\n'), "{error}");
        }
    }

    #[test]
    fn programs_that_convert_are_named() {
        for (name, program) in [
            ("wm.mgz", "mri_convert"),
            ("wm.MGH", "mri_convert"),
            ("cell.czi", "bioformats2raw"),
            ("cell.ND2", "bfconvert"),
        ] {
            let error = parser_of(&Source::from_bytes(Path::new(name), vec![1; 64])).unwrap_err().to_string();
            assert!(error.contains(program), "{error}");
        }
    }

    #[test]
    #[cfg(not(feature = "zarr"))]
    fn builds_without_zarr_name_the_feature() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("zarr.json"), "{}").unwrap();
        let of_folder = read_folder(folder.path(), &Overrides::default()).unwrap_err();
        let of_archive = parser_of(&Source::from_bytes(Path::new("a.zarr.zip"), b"PK\x03\x04".to_vec()));
        for error in [of_folder, of_archive.unwrap_err()] {
            assert!(error.to_string().contains("feature `zarr`"), "{error}");
        }
    }

    #[test]
    #[cfg(not(feature = "dicom"))]
    fn the_missing_feature_is_named() {
        let bytes = [b"II*\0", &[0; 124][..], b"DICM"].concat();
        let error = parser_of(&Source::from_bytes(Path::new("x.tif"), bytes)).unwrap_err().to_string();
        assert!(error.contains("feature `dicom`"), "{error}");
        let error = parser_of(&Source::from_bytes(Path::new("a.dcm"), vec![1; 64])).unwrap_err().to_string();
        assert!(error.contains("dcm2niix"), "{error}");
    }

    #[test]
    #[cfg(feature = "dicom")]
    fn dicom_files_that_begin_like_tiff_are_dicom() {
        let bytes = [b"II*\0", &[0; 124][..], b"DICM"].concat();
        let source = Source::from_bytes(Path::new("x.tif"), bytes);
        let parser = parser_of(&source).unwrap().unwrap();
        let error = parser(&source, &Overrides::default()).unwrap_err().to_string();
        assert!(error.contains("DICOM"), "{error}");
    }

    #[test]
    fn bare_voxels_have_no_parser() {
        assert!(parser_of(&Source::from_bytes(Path::new("x.raw"), vec![0; 9])).unwrap().is_none());
    }
}
