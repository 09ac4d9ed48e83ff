//! Which writer a file name asks for.

use super::{metaimage, nifti, nrrd, raw, vti};
use crate::{Error, Result};
use fovol_core::Volume;
use std::path::Path;

type Writer = fn(&Volume, &Path) -> Result<()>;

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

/// Writes `volume` to `path` in the format of its ending. Size, type, spacing and values are kept; of several
/// components the first is written; scaled values are written as floats.
///
/// # Errors
/// An unknown ending, a type that the format does not have, and what the system says; one line.
pub fn write(volume: &Volume, path: &Path) -> Result<()> {
    let name = path.file_name().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
    let found = WRITERS.iter().find(|(ending, _)| name.ends_with(ending));
    let (_, writer) = found.ok_or_else(|| {
        let endings: Vec<&str> = WRITERS.iter().map(|(ending, _)| *ending).collect();
        Error::unsupported(
            path,
            format!("no volume is written under this ending; use {}", endings.join(", ")),
        )
    })?;
    writer(volume, path)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::volume::{Overrides, read};
    use fovol_core::{Dtype, Endian, Grid, Rescale};
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
        if volume.rescale() == Rescale::IDENTITY {
            assert_eq!(back.dtype(), volume.dtype());
        }
        let [nx, ny, nz] = volume.grid().dims();
        for voxel in (0..nx * ny * nz).map(|i| [i % nx, i / nx % ny, i / nx / ny]) {
            let (new, old) = (back.value(voxel), volume.value(voxel));
            assert!(new == old || (new.is_nan() && old.is_nan()), "{voxel:?}: {new} was {old}");
        }
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

    #[test]
    fn unknown_endings_are_named() {
        let volume = Volume::from_values(Grid::new([1; 3], [1.0; 3]).unwrap(), vec![0u8]).unwrap();
        let error = write(&volume, Path::new("x.obj")).unwrap_err().to_string();
        assert!(error.contains("x.obj") && error.contains(".nrrd"), "{error}");
    }
}
