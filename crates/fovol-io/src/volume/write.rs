//! Which writer a file name asks for.

use super::detached::Beside;
use super::{metaimage, nifti, nrrd, raw, vti};
use crate::{Error, Result};
use fovol_core::{Rescale, Space, Volume};
use glam::{DMat3, DVec3};
use std::path::Path;

type Writer = fn(&Volume, &Path, Beside) -> Result<()>;

/// The endings that [`write`] knows, and who writes them.
const WRITERS: &[(&str, Writer)] = &[
    (".raw", raw::write),
    (".raw.gz", raw::write),
    (".nrrd", nrrd::write),
    (".nhdr", nrrd::write),
    (".mha", metaimage::write),
    (".mhd", metaimage::write),
    (".nii", nifti::write),
    (".nii.gz", nifti::write),
    (".vti", vti::write),
];

/// Writes `volume` to `path` in the format of its extension, and returns notes on lost properties, one line each.
///
/// The file keeps size, type, spacing, values, orientation, origin and unit. Of several components, only the one shown
/// is written. NIfTI keeps the scaling of values; other formats store scaled values as floats.
///
/// Some formats use two files. The second has the same stem, and overwrites only a file that was written for the first;
/// see [`write_with`].
///
/// # Errors
/// An unknown extension, a type that the format lacks, another output's file at the second path, and errors of the
/// operating system. The message is one line, and nothing is written.
pub fn write(volume: &Volume, path: &Path) -> Result<Vec<String>> {
    write_with(volume, path, Beside::Own)
}

/// Writes `volume` to `path`, see [`write()`]; `beside` says which second files may be overwritten.
///
/// # Errors
/// Those of [`write()`].
pub fn write_with(volume: &Volume, path: &Path, beside: Beside) -> Result<Vec<String>> {
    let name = path.file_name().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
    let found = WRITERS.iter().find(|(ending, _)| name.ends_with(ending));
    let (_, writer) = found.ok_or_else(|| {
        let endings: Vec<&str> = WRITERS.iter().map(|(ending, _)| *ending).collect();
        Error::unsupported(
            path,
            format!("no volume is written under this ending; use {}", endings.join(", ")),
        )
    })?;
    writer(volume, path, beside)?;
    Ok(lost(volume, &name))
}

/// Notes on the properties of `volume` that a file called `name` cannot store, one line each.
fn lost(volume: &Volume, name: &str) -> Vec<String> {
    let is = |endings: &[&str]| endings.iter().any(|ending| name.ends_with(ending));
    let (is_nifti, is_meta, is_vti) = (is(&[".nii", ".nii.gz"]), is(&[".mha", ".mhd"]), is(&[".vti"]));
    let mut notes = Vec::new();
    if let Some(placement) = volume.placement() {
        let is_patient = placement.space() == Space::Patient;
        let is_turned = placement.directions() != DMat3::IDENTITY;
        if is_nifti && !is_patient && (is_turned || placement.origin() != DVec3::ZERO) {
            notes.push("NIfTI has coordinates of patients alone; orientation and origin are left out".into());
        }
        if is_meta && !is_patient && is_turned {
            notes.push("MetaImage has orientations of patients alone; the orientation is left out".into());
        }
        if is_vti && is_patient {
            notes.push(
                "VTK images do not say that axes are a patient's; read it with --orientation patient".into(),
            );
        }
    }
    if let Some(units) = volume.units()
        && (is_vti || is_nifti && nifti::units_code(units) == 0)
    {
        notes.push(format!("the format has no such unit; {} is left out", one_line(units)));
    }
    if volume.rescale() != Rescale::IDENTITY && !is_nifti {
        let Rescale { slope, intercept } = volume.rescale();
        notes.push(format!(
            "the format has no scaling; values are written times {slope} plus {intercept}, as floats"
        ));
    }
    let contents = volume.contents();
    if let Some(array) = contents.array_name().filter(|_| !is_vti) {
        notes.push(format!("the format has no names of arrays; `{}` is left out", one_line(array)));
    }
    let parts = [
        (contents.arrays.len(), "arrays"),
        (contents.channels.len(), "channels"),
        (contents.times, "time points"),
        (contents.components, "components"),
    ];
    notes.extend(
        parts
            .iter()
            .filter(|(count, _)| *count > 1)
            .map(|(count, what)| format!("one of {count} {what} is written")),
    );
    notes
}

/// `text` without characters that would end a line of a header.
pub fn one_line(text: &str) -> String {
    text.chars().filter(|c| !c.is_control()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::volume::{Overrides, read};
    use fovol_core::{Contents, Dtype, Endian, Grid, Placement};
    use proptest::prelude::*;
    use std::sync::Arc;

    /// Any small volume: size, spacing, type, byte order, components, offset, scaling.
    fn volumes() -> impl Strategy<Value = Volume> {
        let dims = prop::array::uniform3(1usize..6);
        let spacing = prop::array::uniform3(prop_oneof![Just(1.0), 1e-6f64..1e6]);
        let dtype = prop::sample::select(Dtype::ALL.to_vec());
        let endian = prop::sample::select(vec![Endian::Little, Endian::Big]);
        let rescale = prop_oneof![
            3 => Just(Rescale::IDENTITY),
            1 => (0.01f64..10.0, -100.0f64..100.0).prop_map(|(slope, intercept)| Rescale { slope, intercept }),
        ];
        let layout = (dims, spacing, dtype, endian, 1usize..4, 0usize..9, rescale);
        layout.prop_flat_map(|(dims, spacing, dtype, endian, components, offset, rescale)| {
            let length = dims.iter().product::<usize>() * components * dtype.size() + offset;
            prop::collection::vec(any::<u8>(), length).prop_map(move |bytes| {
                let grid = Grid::new(dims, spacing).unwrap();
                Volume::with_layout(grid, dtype, endian, components, Arc::new(bytes), offset)
                    .and_then(|volume| volume.with_rescale(rescale))
                    .unwrap()
            })
        })
    }

    /// Writes `volume` and reads it back; what the format cannot hold must be said, not lost.
    fn goes_round(volume: &Volume, ending: &str, has_half: bool) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(format!("v{ending}"));
        let is_half = volume.dtype() == Dtype::F16 && volume.rescale() == Rescale::IDENTITY;
        if is_half && !has_half {
            let error = write(volume, &path).unwrap_err().to_string();
            assert!(error.contains("half") && !error.contains('\n'), "{error}");
            assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
            return;
        }
        write(volume, &path).unwrap();
        let back = read(&path, &Overrides::default()).unwrap();
        assert_eq!(back.grid(), volume.grid());
        assert_eq!(back.components(), 1);
        if volume.rescale() == Rescale::IDENTITY || has_scaling(ending, volume) {
            assert_eq!(back.dtype(), volume.dtype());
        }
        let [nx, ny, nz] = volume.grid().dims();
        for voxel in (0..nx * ny * nz).map(|i| [i % nx, i / nx % ny, i / nx / ny]) {
            let (new, old) = (back.value(voxel), volume.value(voxel));
            assert!(new == old || (new.is_nan() && old.is_nan()), "{voxel:?}: {new} was {old}");
        }
    }

    /// Whether the format keeps integers and their scaling.
    fn has_scaling(ending: &str, volume: &Volume) -> bool {
        ending.starts_with(".nii") && volume.dtype() != Dtype::F16
    }

    /// `volume` with the spacing that NIfTI-1 can hold.
    fn single_spacing(volume: Volume) -> Volume {
        let spacing = volume.grid().spacing().map(|spacing| f64::from(spacing as f32));
        volume.with_spacing(spacing).unwrap()
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        #[test]
        fn raw_goes_round(volume in volumes()) {
            goes_round(&volume, ".raw", true);
        }

        #[test]
        fn packed_raw_goes_round(volume in volumes()) {
            goes_round(&volume, ".raw.gz", true);
        }

        #[test]
        fn nrrd_goes_round(volume in volumes()) {
            goes_round(&volume, ".nrrd", false);
        }

        #[test]
        fn detached_nrrd_goes_round(volume in volumes()) {
            goes_round(&volume, ".nhdr", false);
        }

        #[test]
        fn metaimage_goes_round(volume in volumes()) {
            goes_round(&volume, ".mha", false);
        }

        #[test]
        fn detached_metaimage_goes_round(volume in volumes()) {
            goes_round(&volume, ".mhd", false);
        }

        #[test]
        fn nifti_goes_round(volume in volumes()) {
            goes_round(&single_spacing(volume), ".nii", false);
        }

        #[test]
        fn packed_nifti_goes_round(volume in volumes()) {
            goes_round(&single_spacing(volume), ".nii.gz", false);
        }

        #[test]
        fn vti_goes_round(volume in volumes()) {
            goes_round(&volume, ".vti", false);
        }
    }

    /// Directions of a turned, mirrored or slightly sheared grid, an origin and a space.
    fn placements() -> impl Strategy<Value = Placement> {
        let angles = prop::array::uniform3(-3.0f64..3.0);
        let origin = prop::array::uniform3(-200.0f64..200.0);
        (angles, origin, any::<bool>(), any::<bool>(), prop_oneof![Just(0.0), 0.0f64..0.3]).prop_map(
            |([a, b, c], origin, is_mirrored, is_patient, shear)| {
                let mut axes = DMat3::from_euler(glam::EulerRot::XYZ, a, b, c);
                axes.z_axis = if is_mirrored { -axes.z_axis } else { axes.z_axis } + shear * axes.y_axis;
                let space = if is_patient { Space::Patient } else { Space::Other };
                Placement::new(axes, DVec3::from_array(origin), space).unwrap()
            },
        )
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(48))]

        #[test]
        fn places_go_round(placement in placements(), spacing in prop::array::uniform3(0.1f64..9.0)) {
            let grid = Grid::new([2, 3, 4], spacing).unwrap();
            let volume = Volume::from_values(grid, (0..24u8).collect::<Vec<_>>()).unwrap();
            let volume = volume.with_placement(placement).with_units("mm");
            let folder = tempfile::tempdir().unwrap();
            let is_patient = placement.space() == Space::Patient;
            for ending in ["nrrd", "nhdr", "mha", "mhd", "nii", "nii.gz", "vti", "raw"] {
                let path = folder.path().join(format!("v_{}.{ending}", ending.replace('.', "")));
                let notes = write(&volume, &path).unwrap().join("|");
                let back = read(&path, &Overrides::default()).unwrap();
                let is_lost = !is_patient && (ending.starts_with("nii") || ending.starts_with("mh"));
                prop_assert_eq!(is_lost, notes.contains("alone"), "{}: {}", ending, notes);
                prop_assert_eq!(back.units(), if ending == "vti" { None } else { Some("mm") }, "{}", ending);
                if is_lost {
                    prop_assert!(!back.placement().is_some_and(|p| p.space() == Space::Patient), "{}", ending);
                    continue;
                }
                let found = back.placement().copied().unwrap();
                let difference = (found.directions() - placement.directions()).to_cols_array();
                prop_assert!(difference.iter().all(|d| d.abs() < 1e-5), "{}: {:?}", ending, found);
                prop_assert!((found.origin() - placement.origin()).length() < 1e-3, "{}", ending);
                if ending != "vti" {
                    prop_assert_eq!(found.space(), placement.space(), "{}", ending);
                }
            }
        }
    }

    #[test]
    fn what_a_format_cannot_hold_is_said() {
        let folder = tempfile::tempdir().unwrap();
        let grid = Grid::new([2, 1, 1], [1.0; 3]).unwrap();
        let contents = Contents { arrays: vec!["<t & \"p\">".into(), "v".into()], ..Contents::default() };
        let volume = Volume::from_values(grid, vec![1i16, 2]).unwrap();
        let volume = volume.with_rescale(Rescale { slope: 0.5, intercept: 1.0 }).unwrap();
        let volume = volume.with_contents(contents).with_units("parsec");
        let written = |name: &str| {
            let path = folder.path().join(name);
            let notes = write(&volume, &path).unwrap().join("|");
            (notes, read(&path, &Overrides::default()).unwrap())
        };
        let (notes, back) = written("v.nii");
        assert!(
            notes.contains("`<t & \"p\">` is left out") && notes.contains("parsec is left out"),
            "{notes}"
        );
        assert!(notes.contains("one of 2 arrays") && !notes.contains("scaling"), "{notes}");
        assert_eq!((back.dtype(), back.value([1, 0, 0])), (Dtype::I16, 2.0));
        let (notes, back) = written("v.vti");
        assert!(notes.contains("times 0.5 plus 1") && !notes.contains("names of arrays"), "{notes}");
        assert_eq!((back.contents().array_name(), back.value([1, 0, 0])), (Some("<t & \"p\">"), 2.0));
    }

    #[test]
    fn unknown_endings_are_named() {
        let volume = Volume::from_values(Grid::new([1; 3], [1.0; 3]).unwrap(), vec![0u8]).unwrap();
        let error = write(&volume, Path::new("x.obj")).unwrap_err().to_string();
        assert!(error.contains("x.obj") && error.contains(".nrrd"), "{error}");
    }
}
