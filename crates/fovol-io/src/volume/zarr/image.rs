//! An image of OME: the chosen level of resolution, placed in space.

use super::axes::Axes;
use super::chunks::Chunked;
use super::hierarchy::{Hierarchy, joined};
use super::json::Object;
use super::metadata::{Array, Node};
use super::ome::{self, Level, Multiscale, USUAL_AXES};
use super::part::Part;
use crate::Result;
use crate::volume::Overrides;
use crate::volume::channel_window::windowed;
use crate::volume::layout::placed;
use crate::volume::levels::noted;
use crate::volume::units::{metres, symbol};
use fovol_core::{Contents, Placement, Space, Volume};
use glam::{DMat3, DVec3};

/// An image in the group at `path`.
pub struct Image<'a> {
    /// The hierarchy that it is in.
    pub hierarchy: &'a Hierarchy<'a>,
    /// The path of its group.
    pub path: &'a str,
    /// The attributes of the group.
    pub attributes: &'a Object,
    /// Whether it is a label map.
    pub is_label: bool,
}

/// An array of a level.
struct Opened {
    path: String,
    array: Box<Array>,
}

impl Image<'_> {
    /// Reads the level `level`, else the finest that fits in memory. `contents` describes the arrays.
    ///
    /// # Errors
    /// Missing levels, axes that have no place in a volume, and the errors of [`Part::volume`].
    pub fn volume(&self, overrides: &Overrides, level: Option<usize>, contents: Contents) -> Result<Volume> {
        let metadata = ome::metadata(self.attributes);
        let image = Multiscale::of(metadata).map_err(|problem| self.malformed(&problem))?;
        let chosen = match overrides.level_of(self.hierarchy.source, image.levels.len())? {
            Some(flag) => Some(flag),
            None => level,
        };
        let (level, opened) = match chosen {
            Some(level) => (level, self.open(&image.levels[level])?),
            None => self.finest(&image)?,
        };
        let part = self.part(&image, &opened)?;
        let channels = ome::channels(metadata, part.counts()[1]);
        let contents = Contents {
            channels: channels.names,
            displays: channels.displays,
            levels: image.levels.len(),
            level,
            are_labels: self.is_label,
            labels: if self.is_label { ome::labels(metadata) } else { Vec::new() },
            ..contents
        };
        let geometry = Geometry::of(&image.levels[level], &image.units, part.axes.space);
        let volume = part.volume(overrides, geometry.spacing, contents)?.with_format("OME-Zarr");
        let volume = geometry.place(self.hierarchy, volume, overrides)?;
        Ok(windowed(noted(volume, level, chosen.is_some())))
    }

    fn malformed(&self, problem: &str) -> crate::Error {
        self.hierarchy.malformed(self.path, problem)
    }

    /// The array of `level`.
    fn open(&self, level: &Level) -> Result<Opened> {
        let missing = || self.malformed(&format!("has no array `{}` of a level; copy it whole", level.path));
        let path = joined(self.path, &level.path).ok_or_else(missing)?;
        match self.hierarchy.node(&path)? {
            Some(Node::Array(Ok(array))) => Ok(Opened { path, array }),
            Some(Node::Array(Err(problem))) => Err(self.hierarchy.malformed(&path, &problem)),
            _ => Err(missing()),
        }
    }

    /// The finest level that fits in memory, else the coarsest.
    fn finest(&self, image: &Multiscale) -> Result<(usize, Opened)> {
        let last = image.levels.len() - 1;
        for (number, level) in image.levels.iter().enumerate().take(last) {
            let opened = self.open(level)?;
            if self.part(image, &opened)?.fits() {
                return Ok((number, opened));
            }
        }
        Ok((last, self.open(&image.levels[last])?))
    }

    fn part<'b>(&'b self, image: &Multiscale, opened: &'b Opened) -> Result<Part<'b>> {
        let Opened { path, array } = opened;
        let axes = image.axes.clone().unwrap_or_else(|| {
            let missing = USUAL_AXES.len().saturating_sub(array.shape.len());
            USUAL_AXES[missing..].iter().map(|name| Some((*name).to_owned())).collect()
        });
        if axes.len() != array.shape.len() {
            return Err(self.malformed(&format!(
                "names {} axes, but its array `{path}` has {}; write it again",
                axes.len(),
                array.shape.len()
            )));
        }
        let axes = Axes::named(&axes, &array.shape).map_err(|problem| self.malformed(&problem))?;
        Ok(Part { chunked: Chunked { hierarchy: self.hierarchy, path, array }, axes })
    }
}

/// Distances of voxels, position of the first, and their unit.
struct Geometry {
    spacing: [f64; 3],
    origin: Option<[f64; 3]>,
    units: Option<String>,
    is_stated: bool,
    notes: Vec<String>,
}

impl Geometry {
    /// The geometry of `level`, whose axes have `units` and of which `space` are x, y, z.
    fn of(level: &Level, units: &[Option<String>], space: [Option<usize>; 3]) -> Self {
        let unit = |axis: Option<usize>| units.get(axis?)?.as_deref().map(symbol);
        let lead = space.into_iter().find_map(unit);
        let mut notes = Vec::new();
        let factors: [f64; 3] = std::array::from_fn(|at| match (unit(space[at]), lead) {
            (Some(own), Some(lead)) if own != lead => match (metres(own), metres(lead)) {
                (Some(own), Some(lead)) => own / lead,
                _ => {
                    notes.push(format!("its axes are in {lead} and {own}, which are taken as the same"));
                    1.0
                }
            },
            _ => 1.0,
        });
        let value = |values: &[f64], at: usize| {
            space[at].and_then(|axis| values.get(axis)).map(|value| value * factors[at])
        };
        let steps: [Option<f64>; 3] = std::array::from_fn(|at| value(&level.scale, at));
        let is_sound = |step: &f64| step.is_finite() && step.abs() > 0.0;
        if steps.iter().flatten().any(|step| !is_sound(step)) {
            notes.push("a scale of its axes is no distance, 1 is taken; --spacing X,Y,Z sets another".into());
        } else if steps.iter().flatten().any(|step| *step < 0.0) {
            notes.push("an axis descends; the voxels are shown in the order of the file".into());
        }
        // A slice is as thick as its pixels are wide.
        let usual = steps[0].filter(is_sound).map_or(1.0, f64::abs);
        let spacing = std::array::from_fn(|at| match (steps[at], space[at]) {
            (Some(step), _) if is_sound(&step) => step.abs(),
            (_, Some(_)) => 1.0,
            (_, None) => usual,
        });
        let origin: [f64; 3] = std::array::from_fn(|at| value(&level.translation, at).unwrap_or(0.0));
        let has_origin = !level.translation.is_empty() && origin.iter().all(|value| value.is_finite());
        Self {
            spacing,
            origin: has_origin.then_some(origin),
            units: lead.filter(|_| !level.scale.is_empty()).map(str::to_owned),
            is_stated: !level.scale.is_empty(),
            notes,
        }
    }

    /// `volume` at its place, with notes on doubts.
    fn place(&self, hierarchy: &Hierarchy<'_>, volume: Volume, overrides: &Overrides) -> Result<Volume> {
        let placement = match self.origin {
            Some(origin) => {
                let placement = Placement::new(DMat3::IDENTITY, DVec3::from_array(origin), Space::Other);
                Some(placement.map_err(|e| hierarchy.source.malformed(e.to_string()))?)
            }
            None => None,
        };
        let volume = placed(volume, placement, self.units.as_deref());
        if overrides.spacing.is_some() {
            return Ok(volume);
        }
        let volume = self.notes.iter().fold(volume, |volume, note| volume.with_note(note.as_str()));
        Ok(match self.is_stated {
            true => volume,
            false => volume.with_note("it states no spacing, 1 is taken; --spacing X,Y,Z sets another"),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn geometry(scale: &[f64], translation: &[f64], units: &[&str]) -> Geometry {
        let level = Level { path: String::new(), scale: scale.to_vec(), translation: translation.to_vec() };
        let units: Vec<_> = units.iter().map(|unit| Some((*unit).to_owned())).collect();
        Geometry::of(&level, &units, [Some(2), Some(1), Some(0)])
    }

    #[test]
    fn units_are_those_of_x() {
        let found =
            geometry(&[2000.0, 0.5, 0.25], &[100.0, 1.0, 2.0], &["nanometer", "micrometer", "micrometer"]);
        assert_eq!((found.spacing, found.units.as_deref()), ([0.25, 0.5, 2.0], Some("µm")));
        assert_eq!(found.origin, Some([2.0, 1.0, 0.1]));
        let found = geometry(&[2.0, 1.0, 1.0], &[], &["parsec", "furlong", "micrometer"]);
        assert_eq!((found.spacing, found.notes.len()), ([1.0, 1.0, 2.0], 2));
    }

    #[test]
    fn scales_that_are_no_distances_are_noted() {
        let found = geometry(&[0.0, -2.0, f64::NAN], &[f64::NAN, 0.0, 0.0], &[]);
        assert_eq!((found.spacing, found.origin, found.notes.len()), ([1.0, 2.0, 1.0], None, 1));
        assert!(!geometry(&[], &[], &[]).is_stated);
    }
}
