//! What a file says of its pictures.

use super::data_set::DataSet;
use super::file::DicomFile;
use super::functional_groups::{self, Groups};
use super::pixel_format::PixelFormat;
use super::plane::{Place, Plane};
use super::plane_attributes;
use super::segments::Segments;
use super::suv::{self, Suv};
use super::tags::{self, Tag};
use crate::volume::Source;
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
        let (_, spacing_from) = plane_attributes::spacing(measures);
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
    let first = plane_attributes::plane(set);
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
