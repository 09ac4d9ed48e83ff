use super::{RenderOverrides, RenderSettings, WeightsChoice};
use crate::{Error, Result};
use fovol_core::{ClipPlane, ClipPlanes, Light, ShadowMode};

impl RenderOverrides {
    /// Completes the settings with the defaults of [`RenderSettings::default`]. Files of camera paths and gaze are read
    /// here; those of transfer functions and weights are read when they are used.
    ///
    /// # Errors
    /// A file that cannot be read, a light without direction, two weights for one network.
    pub fn resolve(&self) -> Result<RenderSettings> {
        let usual = RenderSettings::default();
        let camera = match (&self.camera, &self.path) {
            (Some(camera), _) => camera.camera().into(),
            (None, Some(path)) => path.cameras()?,
            (None, None) => usual.camera,
        };
        let seed = self.seed.unwrap_or(usual.seed);
        let gaze = self.gaze.as_ref().map(|gaze| gaze.path(seed)).transpose()?;
        let light = self.light.map(Light::try_from).transpose()?;
        // Projections have no shadows.
        let shadows = self.shadows.filter(|_| self.mode().is_lit());
        let usual_shadows = if self.mode().is_lit() { usual.shadows } else { ShadowMode::Off };
        Ok(RenderSettings {
            size: self.size.unwrap_or(usual.size),
            frames: self.frames.unwrap_or(usual.frames),
            first_frame: self.first_frame.unwrap_or(usual.first_frame),
            camera,
            turn: self.turn.unwrap_or(usual.turn),
            view: self.view,
            orientation: self.orientation,
            projection: self.projection.unwrap_or(usual.projection),
            mode: self.mode(),
            iso: self.iso,
            transfer_function: self.tf.clone().unwrap_or(usual.transfer_function),
            transfer_range: self.tf_range,
            scale: self.scale.unwrap_or(usual.scale),
            nan: self.nan.unwrap_or(usual.nan),
            crop: self.clip,
            planes: self.planes()?,
            light: light.unwrap_or(usual.light),
            shadows: shadows.unwrap_or(usual_shadows),
            shadow_rays: self.shadow_rays.unwrap_or(usual.shadow_rays),
            shading: self.shading.unwrap_or(usual.shading),
            ambient: self.ambient.unwrap_or(usual.ambient),
            background: self.background.unwrap_or(usual.background),
            transparent: self.transparent.unwrap_or(usual.transparent),
            step: self.step.unwrap_or(usual.step),
            interpolation: self.interpolation.unwrap_or(usual.interpolation),
            integration: self.integration.unwrap_or(usual.integration),
            sampling: self.sampling(),
            pb: self.pb.unwrap_or(usual.pb),
            sigma: self.sigma.unwrap_or(usual.sigma),
            gaze: gaze.unwrap_or(usual.gaze),
            density: self.density.unwrap_or(usual.density),
            noise: self.noise.unwrap_or(usual.noise),
            seed,
            reconstruction: self.reconstruction(),
            guide: self.guide.unwrap_or(usual.guide),
            weights: self.weights_choice()?,
            precision: self.precision.unwrap_or(usual.precision),
        })
    }

    fn planes(&self) -> Result<ClipPlanes> {
        let planes = self.clip_plane.iter().flatten();
        let plane = |&[x, y, z, distance]: &[f64; 4]| ClipPlane { normal: [x, y, z].into(), distance };
        Ok(ClipPlanes::new(&planes.map(plane).collect::<Vec<_>>())?)
    }

    /// Weights of the network. Two may be named where no network needs any.
    fn weights_choice(&self) -> Result<WeightsChoice> {
        match (&self.weights, self.random_weights) {
            (Some(_), Some(_)) if self.reconstruction().default_network().is_some() => {
                Err(Error::Setting("--weights and --random-weights exclude each other; give one".into()))
            }
            (_, Some(random)) => Ok(WeightsChoice::Random(random)),
            (Some(name), None) => Ok(WeightsChoice::Named(name.clone())),
            (None, None) => Ok(WeightsChoice::Usual),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Mode, Reconstruction, Sampling};
    use fovol_core::GazePath;

    #[test]
    fn nothing_given_is_the_default() {
        assert_eq!(RenderOverrides::default().resolve().unwrap(), RenderSettings::default());
    }

    #[test]
    fn what_needs_sparse_pixels_gets_them() {
        let sampling = |given: RenderOverrides| given.resolve().unwrap().sampling;
        assert_eq!(sampling(RenderOverrides { frames: Some(1), ..Default::default() }), Sampling::Full);
        assert_eq!(sampling(RenderOverrides { frames: Some(2), ..Default::default() }), Sampling::Compact);
        assert_eq!(sampling(RenderOverrides { pb: Some(0.03), ..Default::default() }), Sampling::Compact);
        let none = RenderOverrides { reconstruct: Some(Reconstruction::None), ..Default::default() };
        assert_eq!(sampling(none), Sampling::Full);
    }

    #[test]
    fn projections_have_no_shadows() {
        let shadows = |mode| {
            let given = RenderOverrides { mode, shadows: Some(ShadowMode::Cached), ..Default::default() };
            given.resolve().unwrap().shadows
        };
        assert_eq!(shadows(Some(Mode::Mip)), ShadowMode::Off);
        assert_eq!(shadows(Some(Mode::Isosurface)), ShadowMode::Cached);
        let mip = RenderOverrides { mode: Some(Mode::Mip), ..Default::default() };
        assert_eq!(mip.resolve().unwrap().shadows, ShadowMode::Off);
    }

    #[test]
    fn planes_are_checked() {
        let planes = |planes: Vec<[f64; 4]>| {
            RenderOverrides { clip_plane: Some(planes), ..Default::default() }.resolve().map(|s| s.planes)
        };
        assert_eq!(planes(vec![[0.0, 1.0, 0.0, 0.1]; 6]).unwrap().as_slice().len(), 6);
        assert!(planes(vec![[0.0, 1.0, 0.0, 0.1]; 7]).unwrap_err().to_string().contains("at most 6"));
        assert!(planes(vec![[0.0; 4]]).unwrap_err().to_string().contains("normal"));
    }

    #[test]
    fn a_walk_follows_the_seed() {
        let given = RenderOverrides { gaze: Some("wander".into()), seed: Some(7), ..Default::default() };
        assert_eq!(given.resolve().unwrap().gaze, GazePath::Wander { seed: 7 });
    }

    #[test]
    fn two_weights_are_refused_where_a_network_needs_them() {
        let both = RenderOverrides {
            weights: Some("wnet-fast".into()),
            random_weights: Some("wnet-fast:3".parse().unwrap()),
            ..Default::default()
        };
        assert!(both.resolve().unwrap_err().to_string().contains("exclude each other"));
        let linear = RenderOverrides { reconstruct: Some("linear".parse().unwrap()), ..both };
        assert_eq!(linear.resolve().unwrap().sampling, Sampling::Compact);
    }
}
