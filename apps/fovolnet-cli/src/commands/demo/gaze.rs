//! A gaze that wanders over the picture, but stays on the volume.

use anyhow::Result;
use fovolnet::Pipeline;
use fovolnet::core::{Fovea, FrameSize, Pixel, SampleList};
use std::array::from_fn;

/// Points along each side of the picture that are looked at for the volume.
const POINTS: u32 = 32;
/// Smallest opacity of a point on the volume.
const VISIBLE: f32 = 0.5;
/// Share of the way to the wandering gaze that the eye goes in a frame.
const PACE: f64 = 0.35;

/// Gaze of one frame after the other.
#[derive(Default)]
pub struct Gaze {
    last: Option<[f64; 2]>,
}

impl Gaze {
    /// Fovea of frame `i`. The gaze of the settings, which wanders over the picture, wanders over the volume's part of it.
    /// Where the volume has holes, the nearest point on it counts. The eye follows in small steps.
    ///
    /// # Errors
    /// A lost device.
    pub fn fovea(&mut self, pipeline: &mut Pipeline, i: u32) -> Result<Fovea> {
        let fovea = pipeline.fovea(i);
        let visible = visible(pipeline, i, grid(pipeline.size()))?;
        let Some([low, high]) = bounds(&visible) else { return Ok(fovea) };
        let aim = from_fn(|axis| low[axis] + fovea.gaze[axis] * (high[axis] - low[axis]));
        let from = self.last.unwrap_or(aim);
        let step: [f64; 2] = from_fn(|axis| from[axis] + PACE * (aim[axis] - from[axis]));
        let is_on_it = !self::visible(pipeline, i, vec![pixel(pipeline.size(), step)])?.is_empty();
        let gaze = if is_on_it { step } else { nearest(&visible, pipeline.size(), step) };
        self.last = Some(gaze);
        Ok(Fovea { gaze, ..fovea })
    }
}

/// Centres of those of `pixels` at which frame `i` shows the volume, as fractions of the picture.
fn visible(pipeline: &mut Pipeline, i: u32, pixels: Vec<Pixel>) -> Result<Vec<[f64; 2]>> {
    let size = pipeline.size();
    let rays = pipeline.march(&pipeline.camera(i), &SampleList::new(size, pixels.clone()))?;
    let visible = pixels.into_iter().zip(rays).filter(|(_, ray)| ray.opacity >= VISIBLE);
    Ok(visible.map(|(pixel, _)| centre(size, pixel)).collect())
}

/// Pixels all over the picture.
fn grid(size: FrameSize) -> Vec<Pixel> {
    let middle = |i: u32| (f64::from(i) + 0.5) / f64::from(POINTS);
    (0..POINTS * POINTS).map(|i| pixel(size, [middle(i % POINTS), middle(i / POINTS)])).collect()
}

/// Pixel at `place`, a fraction of the picture.
fn pixel(size: FrameSize, place: [f64; 2]) -> Pixel {
    let at = |part: f64, side: u32| (part * f64::from(side)).clamp(0.0, f64::from(side - 1)) as u16;
    Pixel { x: at(place[0], size.width), y: at(place[1], size.height) }
}

/// Centre of `pixel` as fractions of the picture.
fn centre(size: FrameSize, pixel: Pixel) -> [f64; 2] {
    let part = |at: u16, side: u32| (f64::from(at) + 0.5) / f64::from(side);
    [part(pixel.x, size.width), part(pixel.y, size.height)]
}

/// Least and greatest coordinates of `places`; `None` if there are none.
fn bounds(places: &[[f64; 2]]) -> Option<[[f64; 2]; 2]> {
    let first = *places.first()?;
    let wider = |[low, high]: [[f64; 2]; 2], place: &[f64; 2]| {
        [from_fn(|axis| low[axis].min(place[axis])), from_fn(|axis| high[axis].max(place[axis]))]
    };
    Some(places.iter().fold([first; 2], wider))
}

/// The one of `places` that is nearest to `point` in pixels; `point` itself if there are none.
fn nearest(places: &[[f64; 2]], size: FrameSize, point: [f64; 2]) -> [f64; 2] {
    let sides = [size.width, size.height].map(f64::from);
    let distance = |place: &[f64; 2]| (0..2).map(|a| ((place[a] - point[a]) * sides[a]).powi(2)).sum::<f64>();
    places.iter().copied().min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap_or(point)
}

#[cfg(test)]
mod tests {
    use super::*;
    use fovolnet::core::{GazePath, Grid, Volume};
    use fovolnet::{OpenVolume, RenderSettings, SpeedSettings};

    #[test]
    fn the_gaze_is_always_on_the_volume() {
        // An opaque block in one corner of empty space.
        let grid = Grid::new([24; 3], [1.0; 3]).unwrap();
        let is_inside = |i: usize| [i % 24, i / 24 % 24, i / 576].into_iter().all(|at| at > 14);
        let values = (0..grid.voxels()).map(|i| if is_inside(i) { 255u8 } else { 0 }).collect();
        let volume = OpenVolume::from(Volume::from_values(grid, values).unwrap());
        let settings = RenderSettings {
            size: FrameSize::new(96, 54).unwrap(),
            gaze: GazePath::Wander { seed: 0 },
            ..RenderSettings::default()
        };
        let mut pipeline = Pipeline::new(&volume, &settings, &SpeedSettings::default()).unwrap();
        let is_on_it = |pipeline: &mut Pipeline, i: u32, place: [f64; 2]| {
            !visible(pipeline, i, vec![pixel(pipeline.size(), place)]).unwrap().is_empty()
        };
        let (mut gaze, mut wanders_off) = (Gaze::default(), 0);
        for i in 0..12 {
            let wandering = pipeline.fovea(i).gaze;
            wanders_off += u32::from(!is_on_it(&mut pipeline, i, wandering));
            let found = gaze.fovea(&mut pipeline, i).unwrap().gaze;
            assert!(is_on_it(&mut pipeline, i, found), "frame {i}: {found:?}");
        }
        assert!(wanders_off > 0, "the wandering gaze never leaves the volume, so this shows nothing");
    }

    #[test]
    fn a_volume_of_which_nothing_shows_leaves_the_gaze_alone() {
        let grid = Grid::new([8; 3], [1.0; 3]).unwrap();
        let volume = OpenVolume::from(Volume::from_values(grid, vec![0u8; 512]).unwrap());
        let settings = RenderSettings { transfer_function: "grey".into(), ..RenderSettings::default() };
        let mut pipeline = Pipeline::new(&volume, &settings, &SpeedSettings::default()).unwrap();
        assert_eq!(Gaze::default().fovea(&mut pipeline, 0).unwrap(), pipeline.fovea(0));
    }
}
