//! Point of the volume that a picture shows at a place.

use anyhow::Result;
use fovolnet::Pipeline;
use fovolnet::core::{Camera, Pixel, SampleList};
use glam::DVec3;

/// Point of the volume that a picture shows at a place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ShownPoint {
    /// Place in the picture, as fractions from its top left.
    pub at: [f64; 2],
    /// Camera of the picture.
    pub camera: Camera,
    /// Where opacity passes one half, in world space; `None` where the picture is more transparent.
    pub point: Option<DVec3>,
}

/// Opacity above which the picture shows a point.
const OPAQUE: f32 = 0.5;

impl ShownPoint {
    /// Marches the one pixel at the place `at` of the picture that `pipeline` makes for `camera`.
    ///
    /// # Errors
    /// A device that is lost.
    pub fn find(pipeline: &mut Pipeline, camera: &Camera, at: [f64; 2]) -> Result<Self> {
        let size = pipeline.size();
        let along = |part: f64, side: u32| (part * f64::from(side)).clamp(0.0, f64::from(side - 1)) as u16;
        let pixel = Pixel { x: along(at[0], size.width), y: along(at[1], size.height) };
        let marched = pipeline.march(camera, &SampleList::new(size, vec![pixel]))?;
        let ray = camera.rays(size).ray(pixel.x.into(), pixel.y.into());
        let shown = marched.first().filter(|ray| ray.opacity >= OPAQUE && ray.depth.is_finite());
        let point = shown.map(|shown| ray.origin + ray.direction * f64::from(shown.depth));
        Ok(Self { at, camera: *camera, point })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fovolnet::core::{Grid, Volume};
    use fovolnet::{Device, OpenVolume, RenderSettings, SpeedSettings};

    #[test]
    fn the_face_of_an_opaque_cube_is_found() {
        let volume = Volume::from_values(Grid::new([16; 3], [1.0; 3]).unwrap(), vec![200u8; 4096]).unwrap();
        let opened: OpenVolume = volume.into();
        let opaque = r#"{"points":[[0,0,0,0,0],[0.1,1,1,1,1]]}"#;
        let settings = RenderSettings {
            size: "64x48".parse().unwrap(),
            transfer_function: opaque.into(),
            ..RenderSettings::default()
        };
        let speed = SpeedSettings { device: Some(Device::Cpu), ..SpeedSettings::default() };
        let mut pipeline = Pipeline::new(&opened, &settings, &speed).unwrap();
        let front = Camera::on_sphere(0.0, 0.0, 2.0, 35.0);
        for projection in [fovolnet::core::Projection::Perspective, fovolnet::core::Projection::Orthographic]
        {
            let camera = Camera { projection, ..front };
            let middle = ShownPoint::find(&mut pipeline, &camera, [0.5; 2]).unwrap();
            let point = middle.point.unwrap();
            assert!(point.x.abs() < 0.03 && point.y.abs() < 0.03, "{point}");
            // The first voxel behind the face is at +z.
            assert!((point.z - 0.5).abs() < 1.5 / 16.0, "{point}");
        }
        let beside = ShownPoint::find(&mut pipeline, &front, [0.01; 2]).unwrap();
        assert_eq!(beside.point, None);
        assert_eq!(beside.camera, front);
    }
}
