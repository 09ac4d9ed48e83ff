//! A gaze that wanders over the picture, but stays on the volume.

use anyhow::Result;
use fovolnet::Pipeline;
use fovolnet::core::{Fovea, FrameSize, Pixel, SampleList};

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
    /// Fovea of frame `i`: on the way from the last gaze to the gaze of the settings, at the nearest point on the volume.
    ///
    /// # Errors
    /// A lost device.
    pub fn fovea(&mut self, pipeline: &mut Pipeline, i: u32) -> Result<Fovea> {
        let fovea = pipeline.fovea(i);
        let from = self.last.unwrap_or(fovea.gaze);
        let way: [f64; 2] = std::array::from_fn(|axis| from[axis] + PACE * (fovea.gaze[axis] - from[axis]));
        let size = pipeline.size();
        let pixels = candidates(size, way);
        let rays = pipeline.march(&pipeline.camera(i), &SampleList::new(size, pixels.clone()))?;
        let visible = pixels.into_iter().zip(rays).filter(|(_, ray)| ray.opacity >= VISIBLE);
        let gaze = nearest(visible.map(|(pixel, _)| place(size, pixel)), size, way).unwrap_or(way);
        self.last = Some(gaze);
        Ok(Fovea { gaze, ..fovea })
    }
}

/// Pixel at `way`, and a grid over the whole picture.
fn candidates(size: FrameSize, way: [f64; 2]) -> Vec<Pixel> {
    let at = |part: f64, side: u32| (part * f64::from(side)).clamp(0.0, f64::from(side - 1)) as u16;
    let pixel = |[x, y]: [f64; 2]| Pixel { x: at(x, size.width), y: at(y, size.height) };
    let middle = |i: u32| (f64::from(i) + 0.5) / f64::from(POINTS);
    let grid = (0..POINTS * POINTS).map(|i| pixel([middle(i % POINTS), middle(i / POINTS)]));
    std::iter::once(pixel(way)).chain(grid).collect()
}

/// Centre of `pixel` as fractions of the picture.
fn place(size: FrameSize, pixel: Pixel) -> [f64; 2] {
    let part = |at: u16, side: u32| (f64::from(at) + 0.5) / f64::from(side);
    [part(pixel.x, size.width), part(pixel.y, size.height)]
}

/// The one of `places` that is nearest to `way` in pixels.
fn nearest(places: impl Iterator<Item = [f64; 2]>, size: FrameSize, way: [f64; 2]) -> Option<[f64; 2]> {
    let sides = [size.width, size.height].map(f64::from);
    let distance = |place: &[f64; 2]| (0..2).map(|a| ((place[a] - way[a]) * sides[a]).powi(2)).sum::<f64>();
    places.min_by(|a, b| distance(a).total_cmp(&distance(b)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use fovolnet::core::{Grid, Volume};
    use fovolnet::{OpenVolume, RenderSettings, SpeedSettings};

    #[test]
    fn the_gaze_is_always_on_the_volume() {
        // An opaque block in one corner of empty space.
        let grid = Grid::new([24; 3], [1.0; 3]).unwrap();
        let is_inside = |i: usize| [i % 24, i / 24 % 24, i / 576].into_iter().all(|at| at > 14);
        let values = (0..grid.voxels()).map(|i| if is_inside(i) { 255u8 } else { 0 }).collect();
        let volume = OpenVolume::from(Volume::from_values(grid, values).unwrap());
        let settings = RenderSettings {
            size: Some(FrameSize::new(96, 54).unwrap()),
            gaze: Some("wander".into()),
            ..RenderSettings::default()
        };
        let mut pipeline = Pipeline::new(&volume, &settings, &SpeedSettings::default()).unwrap();
        let (mut gaze, mut wanders_off) = (Gaze::default(), 0);
        for i in 0..12 {
            let mut opacity = |[x, y]: [f64; 2]| {
                let pixel = Pixel { x: (x * 96.0) as u16, y: (y * 54.0) as u16 };
                let list = SampleList::new(pipeline.size(), vec![pixel]);
                let camera = pipeline.camera(i);
                pipeline.march(&camera, &list).unwrap()[0].opacity
            };
            wanders_off +=
                usize::from(opacity(fovolnet::core::GazePath::Wander { seed: 0 }.gaze(i)) < VISIBLE);
            let found = gaze.fovea(&mut pipeline, i).unwrap().gaze;
            let list = |[x, y]: [f64; 2]| vec![Pixel { x: (x * 96.0) as u16, y: (y * 54.0) as u16 }];
            let camera = pipeline.camera(i);
            let ray = pipeline.march(&camera, &SampleList::new(pipeline.size(), list(found))).unwrap();
            assert!(ray[0].opacity >= VISIBLE, "frame {i}: {found:?}");
        }
        assert!(wanders_off > 0, "the wandering gaze never leaves the volume, so this shows nothing");
    }
}
