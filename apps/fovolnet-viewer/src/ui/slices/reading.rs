//! Value, voxel and position under the pointer, in words.

use super::placed_slice::within;
use fovolnet::OpenVolume;
use fovolnet::core::{Space, Volume};
use glam::DVec3;

/// Value, voxel and position at the continuous voxel number `at`, in one line; `None` outside the grid.
pub fn reading(opened: &OpenVolume, at: DVec3) -> Option<String> {
    let volume = &opened.volume;
    let voxel = within(at, volume.grid().dims())?;
    let mut parts = vec![match &opened.colours {
        Some(colours) => {
            let [r, g, b] = colours.each_ref().map(|channel| number(channel.value(voxel)));
            format!("colour {r}, {g}, {b}")
        }
        None => format!("value {}", value(volume, voxel)),
    }];
    for layer in &opened.layers {
        parts.push(format!("overlay {}", value(&layer.opened.volume, voxel)));
    }
    let [x, y, z] = voxel;
    parts.push(format!("voxel {x}, {y}, {z}"));
    parts.extend(position(volume, at));
    Some(parts.join("   "))
}

/// Value of `voxel`, with the name of its label.
fn value(volume: &Volume, voxel: [usize; 3]) -> String {
    let value = volume.value(voxel);
    let label = volume.contents().labels.iter().find(|label| label.value as f64 == value);
    match label {
        Some(label) => format!("{} ({})", number(value), label.name),
        None => number(value),
    }
}

/// Position of a continuous voxel number in the space of the file, or from the first voxel; `None` if the grid has only
/// voxels.
fn position(volume: &Volume, at: DVec3) -> Option<String> {
    let grid = volume.grid();
    let (space, position) = match volume.placement() {
        Some(placement) => {
            let name = if placement.space() == Space::Patient { "LPS " } else { "at " };
            (name, placement.position(at, grid))
        }
        None if volume.units().is_none() && grid.spacing() == [1.0; 3] => return None,
        None => ("at ", at * DVec3::from_array(grid.spacing())),
    };
    let unit = volume.units().map_or(String::new(), |unit| format!(" {unit}"));
    let [x, y, z] = position.to_array().map(|along| rounded(along, step_of(grid.spacing())));
    Some(format!("{space}{x}, {y}, {z}{unit}"))
}

/// Decimals that tell a tenth of the smallest `spacing` apart: 1 for millimetres.
fn step_of(spacing: [f64; 3]) -> usize {
    let least = spacing.into_iter().fold(f64::INFINITY, f64::min);
    (1.0 - least.log10().floor()).clamp(1.0, 9.0) as usize
}

/// `value` with `decimals`; never "-0.0".
fn rounded(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    let is_zero = text.chars().all(|c| matches!(c, '-' | '0' | '.'));
    if is_zero { text.replace('-', "") } else { text }
}

/// `value` without digits that say nothing.
fn number(value: f64) -> String {
    let size = value.abs();
    if value == value.round() && size < 1e15 {
        return format!("{value:.0}");
    }
    if !value.is_finite() {
        return value.to_string();
    }
    if !(1e-3..1e7).contains(&size) {
        return format!("{value:.4e}");
    }
    let text = format!("{value:.4}");
    text.trim_end_matches('0').to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use fovolnet::core::{Contents, Grid, Label, Placement, Rescale};
    use glam::DMat3;

    fn volume(spacing: [f64; 3]) -> Volume {
        let grid = Grid::new([3, 4, 2], spacing).unwrap();
        Volume::from_values(grid, (0..24i16).collect()).unwrap()
    }

    #[test]
    fn values_are_scaled_and_positions_are_of_the_patient() {
        let axes = DMat3::from_cols(DVec3::NEG_X, DVec3::NEG_Y, DVec3::Z);
        let placement = Placement::new(axes, DVec3::new(10.0, 20.0, -30.0), Space::Patient).unwrap();
        let volume = volume([0.5, 2.0, 3.0]).with_units("mm").with_placement(placement);
        let volume = volume.with_rescale(Rescale { slope: 0.25, intercept: -1024.0 }).unwrap();
        let text = reading(&volume.into(), DVec3::new(1.9, 3.2, 1.0)).unwrap();
        // Voxel (2, 3, 1) holds 23.
        assert_eq!(text, "value -1018.25   voxel 2, 3, 1   LPS 9.05, 13.60, -27.00 mm");
    }

    #[test]
    fn positions_without_a_patient_count_from_the_first_voxel() {
        let at = DVec3::new(2.0, 0.0, 1.0);
        let text = |volume: Volume| reading(&volume.into(), at).unwrap();
        assert_eq!(text(volume([1.0; 3])), "value 14   voxel 2, 0, 1");
        assert_eq!(text(volume([1.0; 3]).with_units("µm")), "value 14   voxel 2, 0, 1   at 2.0, 0.0, 1.0 µm");
        assert_eq!(text(volume([2.0, 2.0, 4.0])), "value 14   voxel 2, 0, 1   at 4.0, 0.0, 4.0");
        assert_eq!(reading(&volume([1.0; 3]).into(), DVec3::new(2.6, 0.0, 0.0)), None);
    }

    #[test]
    fn labels_are_named() {
        let label = Label { value: 14, name: "liver".into(), colour: None };
        let contents = Contents { labels: vec![label], ..Contents::default() };
        let volume = volume([1.0; 3]).with_contents(contents);
        let text = reading(&volume.into(), DVec3::new(2.0, 0.0, 1.0)).unwrap();
        assert!(text.starts_with("value 14 (liver)"), "{text}");
    }

    #[test]
    fn numbers_are_short() {
        let numbers = [0.0, 3.0, -0.5, 12.34567, 4.0e-5, f64::NAN, 1e9, 2.5e9 + 0.5];
        assert_eq!(
            numbers.map(number),
            ["0", "3", "-0.5", "12.3457", "4.0000e-5", "NaN", "1000000000", "2.5000e9"]
        );
        assert_eq!([rounded(-0.01, 1), rounded(-0.06, 1)], ["0.0", "-0.1"]);
    }
}
