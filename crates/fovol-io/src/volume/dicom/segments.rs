//! Segments of a segmentation: their numbers, names and colours.

use super::data_set::DataSet;
use super::tags;
use super::text::shown;
use fovol_core::Label;

/// How voxels are written.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Kind {
    /// A frame of bits for each segment and slice.
    Binary,
    /// A frame for each segment and slice of parts, up to this number for all of a voxel.
    Fractional(f64),
    /// Frames of segment numbers.
    LabelMap,
}

/// The segments of a file.
#[derive(Debug, Clone, PartialEq)]
pub struct Segments {
    /// How voxels are written.
    pub kind: Kind,
    /// Number, name and colour of each.
    pub labels: Vec<Label>,
}

/// The class of segmentations, and of those that are label maps.
const SEGMENTATION: &str = "1.2.840.10008.5.1.4.1.1.66.4";
const LABEL_MAP: &str = "1.2.840.10008.5.1.4.1.1.66.7";

impl Segments {
    /// The segments of a file, if it is a segmentation.
    pub fn of(set: &DataSet<'_>) -> Option<Self> {
        let class = set.text(tags::SOP_CLASS)?;
        if class != SEGMENTATION && class != LABEL_MAP {
            return None;
        }
        let kind = match set.text(tags::SEGMENTATION_TYPE).as_deref() {
            _ if class == LABEL_MAP => Kind::LabelMap,
            Some("LABELMAP") => Kind::LabelMap,
            Some("FRACTIONAL") => Kind::Fractional(
                set.number(tags::MAXIMUM_FRACTION).filter(|&most| most > 0.0).unwrap_or(255.0),
            ),
            _ => Kind::Binary,
        };
        let labels = set.items(tags::SEGMENTS).iter().filter_map(label).collect();
        Some(Self { kind, labels })
    }
}

fn label(segment: &DataSet<'_>) -> Option<Label> {
    let value = segment.whole::<u16>(tags::SEGMENT_NUMBER)?;
    let name = segment.text(tags::SEGMENT_LABEL).unwrap_or_else(|| value.to_string());
    let colour = segment.vector(tags::SEGMENT_COLOUR).map(rgb_of_lab);
    Some(Label { value: i64::from(value), name: shown(&name, 64), colour })
}

/// The sRGB colour of CIELab as DICOM writes it (PS3.3 C.10.7.1.1): 0 to 65535 for L of 0 to 100, and a and b of -128 to 127.
fn rgb_of_lab([lightness, a, b]: [f64; 3]) -> [u8; 3] {
    let [l, a, b] = [lightness * 100.0 / 65535.0, a * 255.0 / 65535.0 - 128.0, b * 255.0 / 65535.0 - 128.0];
    let y = (l + 16.0) / 116.0;
    let unfolded =
        |t: f64| if t > 6.0 / 29.0 { t.powi(3) } else { 3.0 * (6.0f64 / 29.0).powi(2) * (t - 4.0 / 29.0) };
    // The white point of profile connection spaces is D50.
    let [x, y, z] = [0.9642 * unfolded(y + a / 500.0), unfolded(y), 0.8249 * unfolded(y - b / 200.0)];
    // From D50 to linear sRGB, with Bradford's adaptation to D65.
    let linear = [
        3.133_856_1 * x - 1.616_866_7 * y - 0.490_614_6 * z,
        -0.978_768_4 * x + 1.916_141_5 * y + 0.033_454_0 * z,
        0.071_945_3 * x - 0.228_991_4 * y + 1.405_242_7 * z,
    ];
    linear.map(|c| {
        let c = c.clamp(0.0, 1.0);
        let curved = if c <= 0.003_130_8 { 12.92 * c } else { 1.055 * c.powf(1.0 / 2.4) - 0.055 };
        (curved * 255.0).round() as u8
    })
}

#[cfg(test)]
mod tests {
    use super::rgb_of_lab;

    #[test]
    fn colours_of_lab() {
        assert_eq!(rgb_of_lab([0.0, 32896.0, 32896.0]), [0, 0, 0]);
        assert_eq!(rgb_of_lab([65535.0, 32896.0, 32896.0]), [255, 255, 255]);
        // Red of sRGB: L 54.29, a 80.81, b 69.89 under D50.
        let lab =
            [54.29 / 100.0 * 65535.0, (80.81 + 128.0) / 255.0 * 65535.0, (69.89 + 128.0) / 255.0 * 65535.0];
        let [red, green, blue] = rgb_of_lab(lab);
        assert!(red >= 254 && green <= 3 && blue <= 3, "{red} {green} {blue}");
    }
}
