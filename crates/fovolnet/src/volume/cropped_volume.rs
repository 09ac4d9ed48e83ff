use crate::{CropBox, OpenVolume, Result};
use fovol_core::{Camera, ClipBox, Layer, Scene, Volume, VoxelColours};
use glam::DVec3;
use std::ops::Range;
use std::sync::Arc;

/// Part of a volume that is shown, as if the rest were empty.
///
/// The voxels that the part needs become a volume of their own. Its longest side is 1 like that of any other, so
/// cameras are converted to see the same. Rays are clipped to the exact sides of the part.
#[derive(Debug, Clone)]
pub struct CroppedVolume {
    volume: Arc<Volume>,
    colours: Option<VoxelColours>,
    /// Further volumes, and colours of their voxels.
    layers: Vec<(Arc<Volume>, Option<VoxelColours>)>,
    /// Exact part of `volume`; `None` for all of it.
    part: Option<ClipBox>,
    /// Centre of `volume` in the world space of the whole volume.
    centre: DVec3,
    /// Scale from the world space of the whole volume to that of `volume`.
    scale: f64,
}

/// Voxels kept beyond each side of the part: one for interpolation, and one more for gradients at its faces.
const BEYOND: usize = 2;

impl CroppedVolume {
    /// Crops `volume` to `crop`; `None` keeps the whole volume.
    ///
    /// # Errors
    /// Errors of [`CropBox::check`].
    pub fn new(opened: &OpenVolume, crop: Option<CropBox>) -> Result<Self> {
        let OpenVolume { volume, colours, layers, .. } = opened;
        let layers = layers.iter().map(|layer| (&layer.opened.volume, &layer.opened.colours));
        let whole = Self {
            volume: Arc::clone(volume),
            colours: colours.clone(),
            layers: layers.map(|(volume, colours)| (Arc::clone(volume), colours.clone())).collect(),
            part: None,
            centre: DVec3::ZERO,
            scale: 1.0,
        };
        let Some(crop) = crop else { return Ok(whole) };
        crop.check()?;
        let dims = DVec3::from_array(volume.grid().dims().map(|dim| dim as f64));
        let [low, high] = crop.ends().map(|end| DVec3::from_array(end) * dims);
        let kept: [Range<usize>; 3] = std::array::from_fn(|a| {
            let end = (high[a].ceil() as usize).saturating_add(BEYOND).min(volume.grid().dims()[a]);
            (low[a] as usize).saturating_sub(BEYOND)..end
        });
        let [start, end] = [kept.each_ref().map(|range| range.start), kept.each_ref().map(|range| range.end)]
            .map(|ends| DVec3::from_array(ends.map(|end| end as f64)));
        if (end - start) == dims {
            return Ok(Self { part: Some(ClipBox::new(low, high, volume.grid())?), ..whole });
        }
        let cut = volume.part(&kept)?;
        Ok(Self {
            part: Some(ClipBox::new(low - start, high - start, cut.grid())?),
            centre: volume.grid().grid_to_world((start + end) * 0.5),
            scale: cut.grid().smallest_voxel() / volume.grid().smallest_voxel(),
            volume: Arc::new(cut),
            colours: part_of_colours(whole.colours.as_ref(), &kept)?,
            layers: whole
                .layers
                .iter()
                .map(|(volume, colours)| {
                    Ok((Arc::new(volume.part(&kept)?), part_of_colours(colours.as_ref(), &kept)?))
                })
                .collect::<Result<_>>()?,
        })
    }

    /// Replaces the volume of `scene`, which shows the whole but for what planes cut away, by the part.
    #[must_use]
    pub fn of(&self, scene: Scene) -> Scene {
        let planes = scene.clip_box().planes().moved(self.centre, self.scale);
        let clip = self.part.map(|part| part.with_planes(planes)).or(scene.clip);
        let of_layers = scene.layers.into_iter().zip(&self.layers);
        let layers = of_layers.map(|(layer, (volume, colours))| Layer {
            volume: Arc::clone(volume),
            colours: colours.clone(),
            ..layer
        });
        let (volume, colours) = (Arc::clone(&self.volume), self.colours.clone());
        Scene { volume, colours, layers: layers.collect(), clip, ..scene }
    }

    /// Converts `camera` from the world space of the whole volume to that of the part.
    pub fn camera(&self, camera: &Camera) -> Camera {
        let moved = |point: DVec3| (point - self.centre) * self.scale;
        Camera { eye: moved(camera.eye), target: moved(camera.target), ..*camera }
    }

    /// Converts `distance` from the origin of a ray of `camera` from the space of the part to that of the whole volume;
    /// `camera` is in the latter.
    pub fn distance(&self, distance: f32, camera: &Camera) -> f32 {
        let [whole, part] = [*camera, self.camera(camera)].map(|camera| {
            let rays = camera.rays(fovol_core::FrameSize::default());
            (camera.eye - rays.origin()).dot(camera.axes().0)
        });
        // Parallel rays begin before or behind the eye, elsewhere in each space.
        ((f64::from(distance) - part) / self.scale + whole) as f32
    }
}

fn part_of_colours(colours: Option<&VoxelColours>, kept: &[Range<usize>; 3]) -> Result<Option<VoxelColours>> {
    let Some(colours) = colours else { return Ok(None) };
    let [r, g, b] = colours.each_ref().map(|channel| channel.part(kept));
    Ok(Some([Arc::new(r?), Arc::new(g?), Arc::new(b?)]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use fovol_core::{Grid, Projection};

    fn volume() -> Arc<Volume> {
        let grid = Grid::new([10, 20, 5], [1.0, 0.5, 2.0]).unwrap();
        Arc::new(Volume::from_values(grid, (0..1000u16).collect()).unwrap())
    }

    #[test]
    fn parts_keep_the_voxels_that_they_need_and_their_colours() {
        let whole = volume();
        let clip = CroppedVolume::new(
            &OpenVolume::of(whole.clone(), "test"),
            Some([0.51, 0.54, 0.0, 1.0, 0.9, 1.0].into()),
        )
        .unwrap();
        // Voxel 5 and two on either side. Along z voxel 4 and the two before it.
        assert_eq!(clip.volume.grid().dims(), [5, 20, 3]);
        assert_eq!(clip.volume.range(), whole.range());
        assert_eq!(clip.volume.value([2, 7, 1]), whole.value([5, 7, 3]));
        let [low, high] = clip.part.unwrap().in_voxels();
        for (found, right) in low.into_iter().chain(high).zip([1.6, -0.5, 2.0, 1.9, 19.5, 2.5]) {
            assert!((found - right).abs() < 1e-6, "{found} for {right}");
        }
        let all = CroppedVolume::new(&OpenVolume::of(whole.clone(), "test"), Some(CropBox::WHOLE)).unwrap();
        assert!(Arc::ptr_eq(&all.volume, &whole) && all.part == Some(ClipBox::whole(whole.grid())));
    }

    #[test]
    fn cameras_see_the_same_places() {
        let whole = volume();
        let clip = CroppedVolume::new(
            &OpenVolume::of(whole.clone(), "test"),
            Some([0.4, 0.5, 0.25, 0.75, 0.4, 0.8].into()),
        )
        .unwrap();
        let world = DVec3::new(0.1, -0.2, 0.3);
        let seen = clip.camera(&Camera::at(world, DVec3::ZERO, 30.0)).eye;
        let (whole_at, part_at) = (whole.grid().world_to_grid(world), clip.volume.grid().world_to_grid(seen));
        assert!((part_at + DVec3::new(2.0, 3.0, 0.0) - whole_at).length() < 1e-9);
        let away = |camera: &Camera| camera.eye.distance(camera.target) as f32;
        let camera = Camera::at(world, DVec3::ZERO, 30.0);
        assert!((clip.distance(away(&clip.camera(&camera)), &camera) - away(&camera)).abs() < 1e-6);
    }

    #[test]
    fn parallel_rays_meet_points_at_the_distances_of_the_whole() {
        let whole = volume();
        let clip = CroppedVolume::new(
            &OpenVolume::of(whole.clone(), "test"),
            Some([0.4, 0.5, 0.25, 0.75, 0.4, 0.8].into()),
        )
        .unwrap();
        let camera = Camera::at(DVec3::new(0.1, -0.2, 0.3), DVec3::new(0.0, 0.1, -0.1), 30.0);
        let camera = Camera { projection: Projection::Orthographic, ..camera };
        let point = DVec3::new(0.02, 0.03, -0.04);
        let away = |camera: &Camera, point: DVec3| {
            let rays = camera.rays(fovol_core::FrameSize::default());
            (point - rays.origin()).dot(camera.axes().0) as f32
        };
        let in_part = away(&clip.camera(&camera), (point - clip.centre) * clip.scale);
        assert!((clip.distance(in_part, &camera) - away(&camera, point)).abs() < 1e-5);
    }

    #[test]
    fn sides_that_are_none_are_refused() {
        let none = CropBox { sides: [[0.0, 1.0], [0.5, 0.2], [0.0, 1.0]] };
        assert!(CroppedVolume::new(&OpenVolume::of(volume(), "test"), Some(none)).is_err());
    }
}
