//! Bare voxels out: the voxels alone, and a `.json` beside them where their name does not say it all.

use super::file_name::FileName;
use super::json;
use crate::volume::voxels::Voxels;
use crate::{Result, atomic};
use fovol_core::{Endian, Volume};
use std::path::{Path, PathBuf};

/// Writes `volume` as bare little-endian voxels: `.raw`, or `.raw.gz`.
///
/// # Errors
/// What the system said.
pub fn write(volume: &Volume, path: &Path) -> Result<()> {
    let voxels = Voxels::of(volume);
    atomic::write(path, |out| match path.extension().is_some_and(|e| e.eq_ignore_ascii_case("gz")) {
        true => {
            let mut packed = flate2::write::GzEncoder::new(out, flate2::Compression::default());
            voxels.write_to(&mut packed)?;
            packed.finish().map(|_| ())
        }
        false => voxels.write_to(out),
    })?;
    let said = FileName::of(path).said;
    let says_all = said.dims == Some(volume.grid().dims())
        && said.dtype == Some(voxels.dtype())
        && volume.placement().is_none()
        && volume.units().is_none()
        && said.endian != Some(Endian::Big)
        && said.spacing.unwrap_or([1.0; 3]) == volume.grid().spacing();
    let sidecar = sidecar_of(path);
    // An old sidecar would speak against the new voxels.
    if !says_all || sidecar.exists() {
        let file = path.file_name().unwrap_or_default().to_string_lossy();
        atomic::write_bytes(&sidecar, json::text(volume, voxels.dtype(), &file).as_bytes())?;
    }
    Ok(())
}

/// `x.json` for `x.raw`, `x.raw.json` for `x.raw.gz`.
fn sidecar_of(path: &Path) -> PathBuf {
    path.with_extension("json")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::volume::{Overrides, read};
    use fovol_core::Grid;

    fn volume(spacing: [f64; 3]) -> Volume {
        Volume::from_values(Grid::new([3, 1, 1], spacing).unwrap(), vec![1u16, 2, 3]).unwrap()
    }

    #[test]
    fn a_telling_name_needs_no_sidecar() {
        let folder = tempfile::tempdir().unwrap();
        for (name, spacing, files) in [
            ("a_3x1x1_uint16.raw", [1.0; 3], 1),
            ("b_3x1x1_uint16.raw", [1.0, 1.0, 2.0], 3),
            ("c_3x1x1_uint8.raw", [1.0; 3], 5),
            ("d.raw.gz", [0.1; 3], 7),
        ] {
            let path = folder.path().join(name);
            write(&volume(spacing), &path).unwrap();
            assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), files, "{name}");
            let back = read(&path, &Overrides::default()).unwrap();
            assert_eq!(back.grid(), volume(spacing).grid(), "{name}");
            assert_eq!(back.data(), volume(spacing).data(), "{name}");
        }
    }

    #[test]
    fn an_old_sidecar_is_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a_3x1x1_uint16.raw");
        std::fs::write(path.with_extension("json"), r#"{"dims": [1, 1, 1], "dtype": "u8"}"#).unwrap();
        write(&volume([1.0; 3]), &path).unwrap();
        assert_eq!(read(&path, &Overrides::default()).unwrap().grid().dims(), [3, 1, 1]);
    }
}
