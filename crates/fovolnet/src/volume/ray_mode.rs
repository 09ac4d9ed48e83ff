use crate::presets::otsu;
use crate::{Error, Mode, RenderSettings, Result};
use fovol_core::{RayMode, Volume};

/// Mode of rays through `volume` with `settings`.
///
/// # Errors
/// An isosurface of a value that is not shown.
pub fn ray_mode(volume: &Volume, settings: &RenderSettings) -> Result<RayMode> {
    Ok(match settings.mode {
        Mode::Composite => RayMode::Composite,
        Mode::Mip => RayMode::Mip,
        Mode::Minip => RayMode::Minip,
        Mode::Average => RayMode::Average,
        Mode::Isosurface => RayMode::Isosurface(display_value(volume, isovalue(volume, settings))?),
    })
}

/// Data value of the isosurface: the given one, else the threshold between the two main groups of values.
pub(super) fn isovalue(volume: &Volume, settings: &RenderSettings) -> f64 {
    settings.iso.unwrap_or_else(|| {
        let [lo, hi] = volume.range();
        lo + otsu(volume) * (hi - lo)
    })
}

fn display_value(volume: &Volume, value: f64) -> Result<f32> {
    let [lo, hi] = volume.range();
    if !(lo..=hi).contains(&value) {
        return Err(Error::Setting(format!(
            "no surface has the value {value} (--iso): values from {lo} to {hi} are shown; give one of them, or another --range LO,HI"
        )));
    }
    Ok(volume.normalised(value) as f32)
}

/// Note on an isosurface whose value was chosen by the program.
pub(crate) fn note(volume: &Volume, settings: &RenderSettings) -> Option<String> {
    let is_chosen = settings.mode == Mode::Isosurface && settings.iso.is_none();
    is_chosen.then(|| {
        let value = rounded(isovalue(volume, settings));
        format!("the isosurface is that of {value}, between the two main groups of values; --iso V chooses another")
    })
}

/// `value` with four digits.
fn rounded(value: f64) -> f64 {
    format!("{value:.3e}").parse().unwrap_or(value)
}

#[cfg(test)]
mod tests {
    use super::*;
    use fovol_core::Grid;

    fn volume() -> Volume {
        let values = (0..1000).map(|i| if i < 700 { -100.0 } else { 300.0f32 }).collect();
        Volume::from_values(Grid::new([10; 3], [1.0; 3]).unwrap(), values).unwrap()
    }

    #[test]
    fn isosurfaces_are_of_data_values() {
        let of = |iso| RenderSettings { mode: Mode::Isosurface, iso, ..Default::default() };
        assert_eq!(ray_mode(&volume(), &of(Some(200.0))).unwrap(), RayMode::Isosurface(0.75));
        let RayMode::Isosurface(between) = ray_mode(&volume(), &of(None)).unwrap() else { panic!() };
        assert!(between > 0.0 && between < 1.0);
        assert!(note(&volume(), &of(None)).unwrap().contains("--iso"));
        assert_eq!(note(&volume(), &of(Some(1.0))), None);
        let error = ray_mode(&volume(), &of(Some(301.0))).unwrap_err().to_string();
        assert!(error.contains("-100 to 300") && error.contains("--range"), "{error}");
        assert!(ray_mode(&volume(), &of(Some(f64::NAN))).is_err());
    }
}
