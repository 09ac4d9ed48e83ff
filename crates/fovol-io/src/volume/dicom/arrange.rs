//! Where the slices of a stack lie: spacing, place, and what must be resampled to make a regular grid of them.

use super::header::Header;
use super::plane::{Place, Plane};
use super::resample::Resampling;
use super::stacks::median;
use crate::volume::affine::Affine;
use glam::DVec3;

/// Slices may lie this part of their distance beside a regular grid.
const IRREGULAR: f64 = 0.05;

/// Slices may slide so many pixels against each other.
const SLID: f64 = 0.5;

/// Resampled stacks have at most so many times as many slices: a few that nearly coincide ask for no more.
const MOST_SLICES: f64 = 16.0;

/// The grid of a stack.
pub struct Arrangement {
    /// Distance between voxels along x, y and z.
    pub spacing: [f64; 3],
    /// Where the grid lies, if the files say so.
    pub affine: Option<Affine>,
    /// How regular slices come from those that there are; none where they are regular.
    pub resampling: Option<Resampling>,
    /// What was found and assumed.
    pub notes: Vec<String>,
}

/// The grid of `planes`, sorted along the normal, of which `header` is one.
pub fn arranged(header: &Header, planes: &[Plane]) -> Arrangement {
    let mut notes = Vec::new();
    let [x, y] = planes[0].spacing;
    match header.spacing_from {
        Some("PixelSpacing") => {}
        Some(name) => {
            notes.push(format!("says no PixelSpacing; its {name} is taken for the distance of pixels"));
        }
        None => notes.push("says no distance between pixels; 1,1 is taken; --spacing says others".into()),
    }
    let places: Option<Vec<Place>> = planes.iter().map(|plane| plane.place).collect();
    let Some(places) = places else {
        let z = stated_spacing(header, planes, &mut notes);
        return Arrangement { spacing: [x, y, z], affine: None, resampling: None, notes };
    };
    let grid = along_normal(header, &places, &mut notes);
    let slides = slides(&places, [x, y]);
    let mut affine = affine(&places[0], [x, y, grid.spacing]);
    let resampling = resampling(header, &grid, slides, &mut notes);
    if let Some(resampling) = &resampling {
        let [before_x, before_y] = resampling.before();
        affine.origin -= affine.steps[0] * before_x + affine.steps[1] * before_y;
    }
    Arrangement { spacing: [x, y, grid.spacing], affine: Some(affine), resampling, notes }
}

fn affine(first: &Place, [x, y, z]: [f64; 3]) -> Affine {
    let steps = [first.along_x * x, first.along_y * y, first.normal() * z];
    Affine { steps, origin: first.position }
}

/// Regular slices along the normal.
struct Grid {
    spacing: f64,
    count: usize,
    /// Place of each picture in units of slices.
    at: Vec<f64>,
    is_regular: bool,
}

fn along_normal(header: &Header, places: &[Place], notes: &mut Vec<String>) -> Grid {
    let normal = places[0].normal();
    let heights: Vec<f64> =
        places.iter().map(|place| (place.position - places[0].position).dot(normal)).collect();
    let steps: Vec<f64> = heights.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let total = heights.last().copied().unwrap_or(0.0);
    let usual = median(&steps).filter(|&step| step > 0.0 && total.is_finite());
    let Some(usual) = usual else {
        let spacing = header.between.or(header.thickness).unwrap_or_else(|| {
            notes.push("says no thickness of its slice; 1 is taken; --spacing says others".into());
            1.0
        });
        return Grid { spacing, count: 1, at: vec![0.0], is_regular: true };
    };
    let even = total / steps.len() as f64;
    let is_regular =
        (0..).zip(&heights).all(|(i, height)| (height - f64::from(i) * even).abs() < IRREGULAR * even);
    if is_regular {
        let at = (0..places.len()).map(|slice| slice as f64).collect();
        return Grid { spacing: even, count: places.len(), at, is_regular };
    }
    let intervals = intervals(total, usual, steps.len());
    let spacing = total / intervals;
    notes.push(irregularity(&heights, &steps, spacing));
    let at = heights.iter().map(|height| height / spacing).collect();
    Grid { spacing, count: intervals as usize + 1, at, is_regular }
}

/// The number of intervals between regular slices over a length of `total`, of which there were `steps` with the usual
/// length `usual`.
fn intervals(total: f64, usual: f64, steps: usize) -> f64 {
    (total / usual).round().clamp(1.0, MOST_SLICES * steps.max(1) as f64)
}

/// The note on slices that are not regular.
fn irregularity(heights: &[f64], steps: &[f64], spacing: f64) -> String {
    let slots = |step: f64| (step / spacing).round();
    let is_gap = |&step: &f64| slots(step) >= 1.0 && (step / spacing - slots(step)).abs() < IRREGULAR;
    if steps.iter().all(is_gap) {
        let missing: f64 = steps.iter().map(|&step| slots(step) - 1.0).sum();
        let first = steps.iter().position(|&step| slots(step) > 1.0).unwrap_or(0);
        return format!(
            "{missing} slices are missing, the first {:.6} mm from the start; they are filled linearly between their neighbours",
            heights[first] + spacing
        );
    }
    let least = steps.iter().copied().fold(f64::INFINITY, f64::min);
    let most = steps.iter().copied().fold(0.0, f64::max);
    format!("its slices are {least:.6} to {most:.6} mm apart; they are resampled linearly to {spacing:.6} mm")
}

/// How far each slice is slid along x and y against the first, in pixels.
fn slides(places: &[Place], spacing: [f64; 2]) -> Vec<[f64; 2]> {
    let first = &places[0];
    let slid = |place: &Place| {
        let way: DVec3 = place.position - first.position;
        [way.dot(first.along_x) / spacing[0], way.dot(first.along_y) / spacing[1]]
    };
    places.iter().map(slid).collect()
}

fn resampling(
    header: &Header,
    grid: &Grid,
    mut slides: Vec<[f64; 2]>,
    notes: &mut Vec<String>,
) -> Option<Resampling> {
    let most = slides.iter().flatten().fold(0.0, |most: f64, slide| most.max(slide.abs()));
    let [nx, ny] = header.format.size;
    if most <= SLID {
        slides.fill([0.0; 2]);
    } else if most > 2.0 * nx.max(ny) as f64 {
        notes.push("its slices lie far beside each other, which is not shown".into());
        slides.fill([0.0; 2]);
    } else {
        let length = (grid.count.max(2) - 1) as f64 * grid.spacing;
        let way = slides.last().map_or(0.0, |[x, y]| x.hypot(*y)) * grid_pixel(header);
        notes.push(format!(
            "its slices are tilted by {:.1} degrees against their axis (gantry tilt); they are moved to where they lie",
            (way / length).atan().to_degrees()
        ));
    }
    let is_slid = slides.iter().flatten().any(|&slide| slide != 0.0);
    (!grid.is_regular || is_slid).then(|| Resampling::new(header.format.size, grid.count, &grid.at, slides))
}

/// The side of a pixel, for an angle in a note.
fn grid_pixel(header: &Header) -> f64 {
    header.planes.first().map_or(1.0, |plane| plane.spacing[1])
}

/// The distance between slices without positions, and the note that says where it is from.
fn stated_spacing(header: &Header, planes: &[Plane], notes: &mut Vec<String>) -> f64 {
    let locations: Option<Vec<f64>> = planes.iter().map(|plane| plane.location).collect();
    let steps: Vec<f64> = locations
        .unwrap_or_default()
        .windows(2)
        .map(|pair| (pair[1] - pair[0]).abs())
        .filter(|&step| step > 0.0)
        .collect();
    let found = [
        (median(&steps), "SliceLocation"),
        (header.between, "SpacingBetweenSlices"),
        (header.thickness, "SliceThickness"),
    ];
    let found = found.into_iter().find_map(|(spacing, name)| Some((spacing?, name)));
    let order = if header.planes.len() > 1 { "frames" } else { "InstanceNumber" };
    match found {
        Some((spacing, name)) => {
            notes.push(format!(
                "says no positions; slices are in the order of {order}, and {name} is taken for their distance"
            ));
            spacing
        }
        None => {
            notes.push(format!(
                "says no positions and no distance between slices; they are in the order of {order} and 1 apart; --spacing says others"
            ));
            1.0
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slices_that_nearly_coincide_do_not_make_many() {
        assert_eq!(intervals(5.0, 1e-9, 4), 64.0);
        assert_eq!(intervals(1e300, 1e-300, 4), 64.0);
        assert_eq!(intervals(12.0, 3.0, 3), 4.0);
        assert_eq!(intervals(1.0, 3.0, 1), 1.0);
    }
}
