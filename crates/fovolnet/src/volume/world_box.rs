//! Placement of a volume's box in world space.

use crate::{CropBox, Error, Orientation, RenderSettings, Result};
use fovol_core::{Camera, ClipPlanes, Space, Volume};
use glam::{DMat3, DVec3};

/// Box of a volume, and its orientation in world space.
///
/// Renderers work in the space of the box: centred at the origin, with sides along x, y and z, the longest of length 1.
/// World space is that space, or a rotation of it for patient orientation (mirrored if the grid is). Cameras and lights
/// are given in world space; [`Self::camera`] and [`Self::direction`] convert them to the box.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WorldBox {
    /// Orthogonal matrix from the box to the world.
    turn: DMat3,
    /// Half of each side of the box.
    half: DVec3,
    /// Lowest and highest corner of the shown part, in the space of the box.
    shown: [DVec3; 2],
    is_patient: bool,
}

impl WorldBox {
    /// Box of `volume` in the orientation that `settings` choose, with the part that they show.
    ///
    /// # Errors
    /// Patient orientation of a file that does not declare one.
    pub fn new(volume: &Volume, settings: &RenderSettings) -> Result<Self> {
        let is_patient = orientation(volume, settings)? == Orientation::Patient;
        let placement = volume.placement().filter(|_| is_patient);
        let half = volume.grid().world_extent() * 0.5;
        let ends = settings.crop.unwrap_or(CropBox::WHOLE).ends();
        let corner = |end: [f64; 3]| (DVec3::from_array(end) * 2.0 - 1.0) * half;
        Ok(Self {
            half,
            turn: placement.map_or(DMat3::IDENTITY, |placement| placement.world_from_box()),
            shown: ends.map(corner),
            is_patient,
        })
    }

    /// Whether the world has patient orientation.
    pub fn is_patient(&self) -> bool {
        self.is_patient
    }

    /// Converts `camera` from world space to the space of the box.
    pub fn camera(&self, camera: &Camera) -> Camera {
        camera.turned(&self.turn.transpose())
    }

    /// Converts planes from world space to the space of the box.
    pub fn planes(&self, world: &ClipPlanes) -> ClipPlanes {
        world.turned(&self.turn.transpose())
    }

    /// Converts a direction from world space to the space of the box.
    pub fn direction(&self, world: DVec3) -> DVec3 {
        self.turn.transpose() * world
    }

    /// Converts a point or direction from the space of the box to world space.
    pub fn to_world(&self, in_box: DVec3) -> DVec3 {
        self.turn * in_box
    }

    /// Corners of the whole box in world space. Bit a of a corner's index chooses its end along axis a of the grid.
    pub fn whole_corners(&self) -> [DVec3; 8] {
        self.corners([-self.half, self.half])
    }

    /// Corners of the shown part in world space, in the order of [`Self::whole_corners`].
    pub fn shown_corners(&self) -> [DVec3; 8] {
        self.corners(self.shown)
    }

    fn corners(&self, [low, high]: [DVec3; 2]) -> [DVec3; 8] {
        std::array::from_fn(|corner| {
            let end = |axis: usize| if corner >> axis & 1 == 1 { high[axis] } else { low[axis] };
            self.to_world(DVec3::new(end(0), end(1), end(2)))
        })
    }

    /// Centre and radius of the bounding sphere of the shown part, in world space.
    pub fn bounding_sphere(&self) -> (DVec3, f64) {
        let [low, high] = self.shown;
        (self.to_world((low + high) * 0.5), (high - low).length() * 0.5)
    }
}

/// Orientation that `settings` choose for `volume`; by default patient orientation for a volume in patient space.
fn orientation(volume: &Volume, settings: &RenderSettings) -> Result<Orientation> {
    let known = volume.placement().map(fovol_core::Placement::space);
    match settings.orientation {
        Some(Orientation::Patient) if known.is_none() => Err(Error::Setting(
            "the volume's file says no orientation, so --orientation patient is not known; leave it out"
                .into(),
        )),
        Some(chosen) => Ok(chosen),
        None if known == Some(Space::Patient) => Ok(Orientation::Patient),
        None => Ok(Orientation::Grid),
    }
}

/// Notes on the orientation of `volume` with `settings`: assumptions, and inexact display; one line each.
///
/// # Errors
/// Errors of [`WorldBox::new`].
pub(crate) fn notes(volume: &Volume, settings: &RenderSettings) -> Result<Vec<String>> {
    let mut notes = Vec::new();
    let Some(placement) = volume.placement() else { return Ok(notes) };
    let is_patient = orientation(volume, settings)? == Orientation::Patient;
    if is_patient && placement.space() == Space::Other {
        notes.push("the file names no patient axes; they are read as left, posterior, superior (LPS)".into());
    }
    if !is_patient && placement.is_left_handed() {
        notes
            .push("the grid is mirrored against its space; --orientation patient shows it unmirrored".into());
    }
    if is_patient && placement.shear() > 0.0 {
        notes.push(format!(
            "the grid is sheared by {:.1} degrees (gantry tilt) and shown at right angles; resample it to see its true shape",
            placement.shear()
        ));
    }
    Ok(notes)
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use fovol_core::{Grid, Placement};

    /// Cube of unknown orientation.
    pub(crate) fn cube() -> WorldBox {
        let volume = Volume::from_values(Grid::new([1; 3], [1.0; 3]).unwrap(), vec![0u8]).unwrap();
        WorldBox::new(&volume, &RenderSettings::default()).unwrap()
    }

    fn volume(placement: Option<Placement>) -> Volume {
        let grid = Grid::new([4, 2, 1], [1.0; 3]).unwrap();
        let volume = Volume::from_values(grid, vec![0u8; 8]).unwrap();
        placement.map_or(volume.clone(), |placement| volume.with_placement(placement))
    }

    fn ras(space: Space) -> Placement {
        let axes = DMat3::from_cols(DVec3::NEG_X, DVec3::NEG_Y, DVec3::Z);
        Placement::new(axes, DVec3::ZERO, space).unwrap()
    }

    #[test]
    fn patients_stand_upright_by_themselves_and_others_when_asked() {
        let settings = RenderSettings::default();
        let stands = |volume: &Volume, settings: &RenderSettings| WorldBox::new(volume, settings).unwrap();
        let patient = stands(&volume(Some(ras(Space::Patient))), &settings);
        assert!(patient.is_patient());
        // The x axis of the grid points to the patient's right, its z axis up.
        assert_eq!(patient.to_world(DVec3::X), DVec3::NEG_X);
        assert_eq!(patient.to_world(DVec3::Z), DVec3::Y);
        assert_eq!(patient.direction(DVec3::Y), DVec3::Z);
        let other = volume(Some(ras(Space::Other)));
        assert!(!stands(&other, &settings).is_patient());
        let asked = RenderSettings { orientation: Some(Orientation::Patient), ..settings.clone() };
        assert!(stands(&other, &asked).is_patient());
        assert!(notes(&other, &asked).unwrap()[0].contains("LPS"));
        let error = WorldBox::new(&volume(None), &asked).unwrap_err().to_string();
        assert!(error.contains("--orientation") && !error.contains('\n'), "{error}");
    }

    #[test]
    fn mirrored_and_sheared_grids_are_noted() {
        let tilted = DMat3::from_cols(DVec3::X, DVec3::Y, DVec3::new(0.0, 0.2, 1.0));
        let tilted = volume(Some(Placement::new(tilted, DVec3::ZERO, Space::Patient).unwrap()));
        assert!(notes(&tilted, &RenderSettings::default()).unwrap()[0].contains("11.3 degrees"));
        let mirrored = DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0));
        let mirrored = volume(Some(Placement::new(mirrored, DVec3::ZERO, Space::Other).unwrap()));
        assert!(notes(&mirrored, &RenderSettings::default()).unwrap()[0].contains("mirrored"));
    }

    #[test]
    fn the_sphere_surrounds_what_is_shown() {
        let settings =
            RenderSettings { crop: Some([0.5, 1.0, 0.0, 1.0, 0.0, 1.0].into()), ..Default::default() };
        let (centre, radius) = WorldBox::new(&volume(None), &settings).unwrap().bounding_sphere();
        assert_eq!(centre, DVec3::new(0.25, 0.0, 0.0));
        assert!((radius - 0.5 * (0.25f64 + 0.25 + 0.0625).sqrt()).abs() < 1e-12);
    }
}
