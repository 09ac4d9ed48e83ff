//! What a file says of its pictures.

use super::data_set::DataSet;
use super::file::DicomFile;
use super::functional_groups::{self, Groups};
use super::pixel_format::PixelFormat;
use super::plane::{Keys, Place, Plane, Scale};
use super::segments::Segments;
use super::suv::{self, Suv};
use super::tags::{self, Tag};
use crate::volume::Source;
use glam::DVec3;
use std::path::{Path, PathBuf};

/// More frames than this are a mistake or malice.
const MOST_FRAMES: usize = 1 << 16;

/// Attributes of a file with pictures, but for the pictures.
pub struct Header {
    /// Where the file is.
    pub path: PathBuf,
    /// The series it belongs to.
    pub series: String,
    /// Words for the series.
    pub description: String,
    /// Kind of scanner: CT, MR, PT…
    pub modality: String,
    /// What identifies the file.
    pub instance: String,
    /// Its segments, if it is a segmentation.
    pub segments: Option<Segments>,
    /// Layout of pixels.
    pub format: PixelFormat,
    /// Its pictures.
    pub planes: Vec<Plane>,
    /// Which attribute states the distance between pixels; none where nothing does.
    pub spacing_from: Option<&'static str>,
    /// Distance between slices, if stated.
    pub between: Option<f64>,
    /// Thickness of slices, if stated.
    pub thickness: Option<f64>,
    /// The stored number that stands for no data.
    pub padding: Option<f64>,
    /// The factor of standardised uptake.
    pub suv: Option<Suv>,
}

impl Header {
    /// The header of the file in `source`; none if it has no pictures.
    ///
    /// # Errors
    /// Damaged files, and pixels of kinds that are not read.
    pub fn read(source: &Source) -> crate::Result<Option<Self>> {
        let file = DicomFile::open(source)?;
        let set = file.data_set();
        if let Some(at) = set.damage {
            return Err(source
                .malformed(format!("it is damaged {at} bytes from its start; copy or download it again")));
        }
        if file.is_directory || set.pixels().is_none() {
            return Ok(None);
        }
        let header = Self::of(source.path(), &set).map_err(|e| source.malformed(e))?;
        Ok(Some(header))
    }

    fn of(path: &Path, set: &DataSet<'_>) -> Result<Self, String> {
        let text = |tag| set.text(tag).unwrap_or_default();
        let groups = Groups::of(set);
        let measures = groups.shared(tags::PIXEL_MEASURES);
        let measures = measures.as_ref().unwrap_or(set);
        let (_, spacing_from) = spacing(measures);
        Ok(Self {
            path: path.to_owned(),
            series: text(tags::SERIES_UID),
            description: text(tags::SERIES_DESCRIPTION),
            modality: text(tags::MODALITY),
            instance: text(tags::SOP_INSTANCE),
            segments: Segments::of(set),
            format: PixelFormat::of(set)?,
            planes: planes(set, &groups)?,
            spacing_from,
            between: positive(measures, tags::SPACING_BETWEEN_SLICES),
            thickness: positive(measures, tags::SLICE_THICKNESS),
            padding: set.number(tags::PIXEL_PADDING),
            suv: suv::of(set),
        })
    }
}

fn positive(set: &DataSet<'_>, tag: Tag) -> Option<f64> {
    // Nuclear medicine states negative distances for slices in opposite order.
    set.number(tag).map(f64::abs).filter(|&length| length > 0.0)
}

/// The frames of a file.
fn planes(set: &DataSet<'_>, groups: &Groups<'_>) -> Result<Vec<Plane>, String> {
    let count = set.whole::<usize>(tags::FRAMES).unwrap_or(1).max(1);
    if count > MOST_FRAMES {
        return Err(format!("it claims {count} frames, more than {MOST_FRAMES}; mend its header"));
    }
    if !groups.is_empty() {
        return Ok((0..count).map(|frame| functional_groups::plane(set, groups, frame)).collect());
    }
    let first = plane(set);
    let offsets = set.numbers(tags::GRID_FRAME_OFFSETS, count);
    let slides = |frame: usize| offsets.get(frame).copied().filter(|_| offsets.len() == count);
    let placed = |frame: usize| {
        let place = first.place.and_then(|place| match (slides(frame), count) {
            (_, 1) => Some(place),
            // Offsets are relative to the first frame, or absolute along the normal.
            (Some(slide), _) => {
                Some(Place { position: place.position + place.normal() * (slide - offsets[0]), ..place })
            }
            (None, _) => None,
        });
        Plane { frame, place, ..first.clone() }
    };
    Ok((0..count).map(placed).collect())
}

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
