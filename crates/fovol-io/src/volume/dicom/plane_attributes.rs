//! Attributes of one picture: its place, the distance of its pixels, the scaling of its values.

use super::data_set::DataSet;
use super::plane::{Keys, Place, Plane, Scale};
use super::tags;
use glam::DVec3;

/// The picture of a file that has one.
pub fn plane(set: &DataSet<'_>) -> Plane {
    Plane {
        file: 0,
        frame: 0,
        instance: set.number(tags::INSTANCE_NUMBER),
        place: place(set.vector(tags::POSITION), set.vector(tags::ORIENTATION)),
        location: set.number(tags::SLICE_LOCATION),
        spacing: spacing(set).0,
        scale: scale(set),
        keys: keys(set),
    }
}

fn keys(set: &DataSet<'_>) -> Keys {
    let text = |tag| set.text(tag).unwrap_or_default();
    Keys {
        image_type: text(tags::IMAGE_TYPE),
        echo: format!("{}/{}", text(tags::ECHO_NUMBER), text(tags::ECHO_TIME)),
        stack: String::new(),
        diffusion: set.number(tags::DIFFUSION_B_VALUE).map_or(String::new(), |b| b.to_string()),
        segment: String::new(),
        temporal: set.number(tags::TEMPORAL_POSITION),
        trigger: set.number(tags::TRIGGER_TIME),
        acquisition: set.number(tags::ACQUISITION_NUMBER),
    }
}

/// Where a picture lies that has both attributes, with directions of length 1.
pub fn place(position: Option<[f64; 3]>, orientation: Option<[f64; 6]>) -> Option<Place> {
    let position = DVec3::from_array(position?);
    let [a, b, c, d, e, f] = orientation?;
    let along_x = DVec3::new(a, b, c).try_normalize()?;
    let along_y = DVec3::new(d, e, f).try_normalize()?;
    // Directions that span no plane are as good as none.
    (along_x.cross(along_y).length() > 0.5).then_some(Place { position, along_x, along_y })
}

/// Distance between pixels along x and y, and the attribute that states it.
pub fn spacing(set: &DataSet<'_>) -> ([f64; 2], Option<&'static str>) {
    let found = [
        (tags::PIXEL_SPACING, "PixelSpacing"),
        (tags::IMAGER_PIXEL_SPACING, "ImagerPixelSpacing"),
        (tags::NOMINAL_SCANNED_PIXEL_SPACING, "NominalScannedPixelSpacing"),
        (tags::PIXEL_ASPECT_RATIO, "PixelAspectRatio"),
    ];
    for (tag, name) in found {
        // The first number is the distance between rows.
        if let Some([between_rows, between_columns]) = set.vector::<2>(tag)
            && between_rows > 0.0
            && between_columns > 0.0
        {
            return match tag {
                tags::PIXEL_ASPECT_RATIO => ([1.0, between_rows / between_columns], Some(name)),
                _ => ([between_columns, between_rows], Some(name)),
            };
        }
    }
    ([1.0; 2], None)
}

/// The scaling of the values.
pub fn scale(set: &DataSet<'_>) -> Scale {
    let slope = set.number(tags::RESCALE_SLOPE).or_else(|| set.number(tags::DOSE_GRID_SCALING));
    Scale {
        // A slope of 0 would make every value the same; files that say so mean 1.
        slope: slope.filter(|&slope| slope != 0.0).unwrap_or(1.0),
        intercept: set.number(tags::RESCALE_INTERCEPT).unwrap_or(0.0),
    }
}
