//! Writes raw voxels, and a `.json` sidecar if the file name cannot state all their properties.

use super::file_name::FileName;
use super::json;
use super::sidecar;
use crate::volume::Source;
use crate::volume::detached::Beside;
use crate::volume::voxels::Voxels;
use crate::{Error, Result, atomic};
use fovol_core::{Endian, Volume};
use std::fs::File;
use std::io::{Read, Write};
use std::path::{Path, PathBuf};

/// Writes `volume` as raw little-endian voxels (`.raw` or `.raw.gz`), with a `.json` sidecar where one is needed.
///
/// Both files are complete before either gets its name.
///
/// # Errors
/// An existing `.json` that does not describe these voxels, unless `beside` permits overwriting it; errors of the
/// operating system.
pub fn write(volume: &Volume, path: &Path, beside: Beside) -> Result<()> {
    let voxels = Voxels::of(volume);
    let sidecar = sidecar(volume, &voxels, path, beside)?;
    let written =
        atomic::prepare(path, |out| match path.extension().is_some_and(|e| e.eq_ignore_ascii_case("gz")) {
            true => {
                let mut packed = flate2::write::GzEncoder::new(out, flate2::Compression::default());
                voxels.write_to(&mut packed)?;
                packed.finish().map(|_| ())
            }
            false => voxels.write_to(out),
        })?;
    let sidecar = sidecar.map(|(path, text)| atomic::prepare(&path, |out| out.write_all(text.as_bytes())));
    let sidecar = sidecar.transpose()?;
    match sidecar {
        Some(sidecar) => written.complete_before(sidecar),
        None => written.complete(),
    }
}

/// The sidecar that `voxels` of `volume` at `path` need, and its text.
fn sidecar(
    volume: &Volume,
    voxels: &Voxels<'_>,
    path: &Path,
    beside: Beside,
) -> Result<Option<(PathBuf, String)>> {
    let said = FileName::of(path).said;
    let says_all = said.dims == Some(volume.grid().dims())
        && said.dtype == Some(voxels.dtype())
        && volume.placement().is_none()
        && volume.units().is_none()
        && said.endian != Some(Endian::Big)
        && said.spacing.unwrap_or([1.0; 3]) == volume.grid().spacing();
    let sidecar = sidecar_of(path);
    let found = found(&sidecar, path);
    // An old sidecar would speak against the new voxels.
    if says_all && matches!(found, Found::Nothing | Found::Silent) {
        return Ok(None);
    }
    atomic::keep_input(&sidecar)?;
    if beside == Beside::Own && matches!(found, Found::Silent | Found::Foreign) {
        return Err(Error::InTheWay { path: sidecar, main: path.to_owned() });
    }
    let file = path.file_name().unwrap_or_default().to_string_lossy();
    let text = json::text(volume, voxels.dtype(), &file);
    Ok(Some((sidecar, text)))
}

/// The file at the path of the sidecar.
enum Found {
    Nothing,
    /// The sidecar of the file at the path of the voxels.
    Own,
    /// A file that readers of the voxels ignore.
    Silent,
    /// The sidecar of other voxels, which readers would mistake for the sidecar of these.
    Foreign,
}

/// Classifies the file at `sidecar`, beside the voxels at `raw`.
fn found(sidecar: &Path, raw: &Path) -> Found {
    if !sidecar.exists() {
        return Found::Nothing;
    }
    let source = if sidecar.is_file() { start_of(sidecar) } else { None };
    let Some((source, Ok(said))) = source.map(|source| (source.clone(), json::parse(&source))) else {
        return Found::Silent;
    };
    let is_named = said.file.as_deref().is_some_and(|file| Path::new(file).file_name() == raw.file_name());
    match sidecar::speaks_of(&source, &said, raw) {
        true if is_named || raw.exists() => Found::Own,
        true => Found::Foreign,
        false => Found::Silent,
    }
}

/// The start of `sidecar`, long enough to tell whether it is a sidecar; none if it cannot be read.
///
/// The file is not registered as an input, so it may be overwritten.
fn start_of(sidecar: &Path) -> Option<Source> {
    let mut bytes = Vec::new();
    File::open(sidecar).ok()?.take(json::LONGEST as u64 + 1).read_to_end(&mut bytes).ok()?;
    Some(Source::from_bytes(sidecar, bytes))
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
            write(&volume(spacing), &path, Beside::Own).unwrap();
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
        std::fs::write(&path, [1]).unwrap();
        std::fs::write(path.with_extension("json"), r#"{"dims": [1, 1, 1], "dtype": "u8"}"#).unwrap();
        write(&volume([1.0; 3]), &path, Beside::Own).unwrap();
        assert_eq!(read(&path, &Overrides::default()).unwrap().grid().dims(), [3, 1, 1]);
    }

    #[test]
    fn what_is_no_sidecar_of_these_voxels_stays() {
        let folder = tempfile::tempdir().unwrap();
        let other = r#"{"dims": [1, 1, 1], "dtype": "u8"}"#;
        let elsewhere = r#"{"file": "there.raw", "dims": [1, 1, 1], "dtype": "u8"}"#;
        std::fs::write(folder.path().join("there.raw"), [1]).unwrap();
        for (text, telling_is_written) in [("[1]", true), (elsewhere, true), (other, false)] {
            for (name, is_written) in [("a_3x1x1_uint16.raw", telling_is_written), ("b.raw", false)] {
                let path = folder.path().join(name);
                let json = path.with_extension("json");
                std::fs::write(&json, text).unwrap();
                let written = write(&volume([1.0; 3]), &path, Beside::Own);
                assert_eq!((written.is_ok(), path.exists()), (is_written, is_written), "{name} {text}");
                assert_eq!(std::fs::read_to_string(&json).unwrap(), text);
                if let Err(error) = written {
                    assert!(error.to_string().contains("--overwrite"), "{error}");
                    write(&volume([1.0; 3]), &path, Beside::All).unwrap();
                }
                assert_eq!(read(&path, &Overrides::default()).unwrap().grid().dims(), [3, 1, 1]);
                std::fs::remove_file(path).unwrap();
            }
        }
    }

    #[test]
    fn both_files_appear_or_none() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.raw");
        for room in 0..6 + 100 {
            crate::fault::after(room, || write(&volume([1.0; 3]), &path, Beside::Own)).unwrap_err();
            assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0, "{room}");
        }
    }
}
