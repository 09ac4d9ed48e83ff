//! Transfer functions of label maps.

use fovol_core::{ControlPoint, Label, TransferFunction, Volume};

/// Opacity of a voxel of a label: the outermost voxels hide those behind, but edges stay soft.
const OPACITY: f64 = 0.9;
/// Most different values that are looked for.
const MOST: usize = 4096;

/// A label of a label map, and its appearance.
#[derive(Debug, Clone, PartialEq)]
pub struct ShownLabel {
    /// Value of its voxels.
    pub value: f64,
    /// Name in the file; empty if it has none.
    pub name: String,
    /// Red, green and blue, 0…1.
    pub colour: [f64; 3],
    /// Opacity of a voxel, 0…1; 0 hides the label.
    pub opacity: f64,
}

impl ShownLabel {
    /// Opacity of labels that are not hidden.
    pub const OPACITY: f64 = OPACITY;
}

/// Labels of `volume` in the order of their values, each in the colour of its file or one of ten. Empty if `volume` is no label
/// map, or has too many. Label 0 is background and left out.
pub fn labels(volume: &Volume) -> Vec<ShownLabel> {
    if !volume.is_label_map() {
        return Vec::new();
    }
    let values = volume.distinct_values(MOST).unwrap_or_default();
    let shown = |(number, &value): (usize, &f64)| ShownLabel {
        value,
        name: declared(volume, value).map_or(String::new(), |label| label.name.clone()),
        colour: colour(volume, value, number),
        opacity: OPACITY,
    };
    values.iter().filter(|value| **value != 0.0).enumerate().map(shown).collect()
}

/// A transfer function that shows `labels` at their data values. `None` without labels.
pub fn of_labels(labels: &[ShownLabel]) -> Option<TransferFunction> {
    let mut points: Vec<ControlPoint> = Vec::new();
    for ShownLabel { value, colour, opacity, .. } in labels {
        for (end, opacity) in [(-0.5, 0.0), (-0.5, *opacity), (0.5, *opacity), (0.5, 0.0)] {
            points.push(ControlPoint::new(value + end, *colour, opacity));
        }
    }
    let (first, last) = (points.first()?.value, points.last()?.value);
    points.iter_mut().for_each(|point| point.value = (point.value - first) / (last - first));
    TransferFunction::new(points).ok()?.with_range(Some([first, last])).ok()
}

/// A colour for each label of `volume`. `None` if there are no labels, or too many.
pub fn label_colours(volume: &Volume) -> Option<TransferFunction> {
    of_labels(&labels(volume))
}

fn declared(volume: &Volume, value: f64) -> Option<&Label> {
    volume.contents().labels.iter().find(|label| label.value as f64 == value)
}

/// Colour of the label of `value`, the `number`th from 0 on.
fn colour(volume: &Volume, value: f64, number: usize) -> [f64; 3] {
    let [r, g, b] = declared(volume, value).and_then(|label| label.colour).unwrap_or_else(|| {
        let colours = colorous::TABLEAU10;
        let colour = colours[number % colours.len()];
        [colour.r, colour.g, colour.b]
    });
    [r, g, b].map(|channel| f64::from(channel) / 255.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use fovol_core::{Contents, Grid};

    fn volume(values: Vec<u8>) -> Volume {
        Volume::from_values(Grid::new([values.len() / 2, 2, 1], [1.0; 3]).unwrap(), values).unwrap()
    }

    #[test]
    fn labels_have_their_own_colours_and_nothing_between_them() {
        let volume = volume(vec![0, 0, 3, 3, 0, 1, 1, 3]);
        let label = |value, colour| Label { value, name: "liver".into(), colour };
        let contents = Contents { labels: vec![label(3, Some([255, 0, 51]))], ..Contents::default() };
        let volume = volume.with_contents(contents);
        let transfer = label_colours(&volume).unwrap().over(volume.range());
        let at = |value: f64| transfer.evaluate(value / 255.0);
        assert_eq!((at(0.0)[3], at(2.0)[3], at(4.0)[3]), (0.0, 0.0, 0.0));
        let near = |a: [f64; 4], b: [f64; 4]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-9);
        assert!(near(at(3.0), [1.0, 0.0, 0.2, OPACITY]), "{:?}", at(3.0));
        assert!(near(at(2.6), at(3.4)) && at(1.0)[3] == OPACITY);
    }

    #[test]
    fn neighbouring_labels_touch_without_blending() {
        let volume = volume(vec![0, 1, 2, 5, 0, 5, 1, 2]);
        let transfer = label_colours(&volume).unwrap().over(volume.range());
        let at = |value: f64| transfer.evaluate(value / 255.0);
        assert_ne!(at(1.49), at(1.51));
        assert_eq!((at(1.49), at(1.51)), (at(1.0), at(2.0)));
    }

    #[test]
    fn scans_have_none() {
        assert!(label_colours(&volume((0..80).map(|i| i * 3).collect())).is_none());
    }

    #[test]
    fn hidden_labels_are_transparent() {
        let volume = volume(vec![0, 0, 3, 3, 0, 1, 1, 3]);
        let mut shown = labels(&volume);
        assert_eq!(shown.iter().map(|label| label.value).collect::<Vec<_>>(), [1.0, 3.0]);
        shown[0].opacity = 0.0;
        let transfer = of_labels(&shown).unwrap().over(volume.range());
        let opacity = |value: f64| transfer.evaluate(value / 255.0)[3];
        assert_eq!((opacity(1.0), opacity(3.0)), (0.0, OPACITY));
        assert!(of_labels(&[]).is_none());
    }
}
