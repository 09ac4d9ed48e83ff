use super::open::shown_range;
use crate::{OpenVolume, RenderSettings, RenderedFrame, presets};
use fovol_core::{Camera, FrameSize, Region, Volume};

/// Check whether anything is visible in the frames of a clip, and why not.
#[derive(Debug, Clone)]
pub struct Visibility {
    background: [f32; 3],
    shows: bool,
    /// Whether the box of the volume was in view.
    is_in_sight: bool,
}

/// Smallest visible difference: half a step of an 8-bit picture.
const SEEN: f32 = 0.5 / 255.0;

impl Visibility {
    /// Check for frames of `settings`, before the first one.
    pub fn new(settings: &RenderSettings) -> Self {
        let background = settings.background.map(|c| c as f32);
        Self { background, shows: false, is_in_sight: false }
    }

    /// Inspects the marched pixels of the frame `rendered`, and whether `camera` saw the box of `volume`. The camera is
    /// in the space of the box.
    pub fn look(&mut self, rendered: &RenderedFrame, camera: &Camera, volume: &Volume) {
        let differs = |p: [f32; 3]| (0..3).any(|c| (p[c] - self.background[c]).abs() > SEEN);
        self.shows = self.shows || rendered.sample_colours().any(differs);
        self.is_in_sight = self.is_in_sight || sees(camera, volume, rendered.frame.size());
    }

    /// Probable cause and remedy, as one line, if nothing of `volume` was visible.
    pub fn problem(&self, volume: &OpenVolume, settings: &RenderSettings) -> Option<String> {
        let cause = match self {
            Self { shows: true, .. } => return None,
            Self { is_in_sight: true, .. } => cause(volume, settings),
            _ => "the camera does not see the volume: it is centred at 0 and its longest side is 1".into(),
        };
        Some(format!("nothing shows; {cause}"))
    }
}

/// Whether the box of `volume` lies in a frame of `size`.
fn sees(camera: &Camera, volume: &Volume, size: FrameSize) -> bool {
    let half = volume.grid().world_extent() * 0.5;
    Region::of_boxes(&camera.rays(size), [[-half, half]], size).is_some()
}

/// Why nothing of `volume` is visible although its box is in view.
fn cause(volume: &OpenVolume, settings: &RenderSettings) -> String {
    if let Some(range) = volume.narrow_range() {
        return shown_range(&volume.volume, range);
    }
    let fovol_core::Statistics { min, max, .. } = *volume.volume.statistics();
    let [from, to] = [min, max].map(|value| volume.volume.normalised(value));
    match presets::chosen(settings, volume) {
        Ok(transfer) if transfer.max_opacity(0.0, 1.0) == 0.0 => {
            "the transfer function (--tf) has no opacity anywhere".into()
        }
        Ok(transfer) if transfer.max_opacity(from, to) == 0.0 && min < max => {
            format!(
                "the transfer function (--tf) has no opacity there: {}",
                shown_range(&volume.volume, [min, max])
            )
        }
        _ if settings.crop.is_some() => {
            "the part that --clip leaves is transparent; try it without, or another transfer function (--tf)"
                .into()
        }
        _ => "what the camera sees is transparent; try another transfer function (--tf) or --range LO,HI"
            .into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Device, Pipeline, Sampling, SpeedSettings, StillCamera, VolumeSettings, open_volume};

    /// Problem reported for one frame of a volume of 8³ voxels, made of repeated `bytes`, with `settings`.
    fn said(bytes: &[u8], settings: RenderSettings) -> Option<String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("v_8x8x8_uint8.raw");
        std::fs::write(&path, bytes.iter().cycle().take(512).copied().collect::<Vec<u8>>()).unwrap();
        let volume = open_volume(path.to_str().unwrap(), &VolumeSettings::default()).unwrap();
        let settings = RenderSettings {
            size: "32x24".parse().unwrap(),
            pb: 0.5,
            sampling: Sampling::Compact,
            ..settings
        };
        let speed = SpeedSettings { device: Some(Device::Cpu), ..Default::default() };
        let mut pipeline = Pipeline::new(&volume, &settings, &speed).unwrap();
        let mut visibility = Visibility::new(&settings);
        let rendered = pipeline.render(0).unwrap();
        let camera = pipeline.world().camera(&pipeline.camera(0));
        visibility.look(&rendered, &camera, &volume.volume);
        visibility.problem(&volume, &settings)
    }

    fn with_tf(tf: &str) -> RenderSettings {
        RenderSettings { transfer_function: tf.into(), ..Default::default() }
    }

    #[test]
    fn causes_are_told_apart() {
        assert_eq!(said(&[0, 255], with_tf("grey")), None);
        let opaque = r#"{"points":[[0,0,0,0,0],[0.5,1,1,1,0],[1,1,1,1,1]]}"#;
        let labels = said(&[0, 1, 2], with_tf(opaque)).unwrap();
        assert_eq!(
            labels,
            "nothing shows; values 0 to 2 are shown as 0 to 0.008 of the range; try --range 0,2"
        );
        let half = said(&[0, 120], with_tf(opaque)).unwrap();
        assert!(half.contains("no opacity there: values 0 to 120 are shown as 0 to 0.471"), "{half}");
        let none = said(&[0, 255], with_tf(r#"{"points":[[0,1,1,1,0]]}"#)).unwrap();
        assert!(none.contains("no opacity anywhere"), "{none}");
        for camera in [[0.0, 0.0, 3.0, 0.0, 0.0, 9.0, 35.0], [0.0, 0.0, 300.0, 200.0, 0.0, 0.0, 10.0]] {
            let camera = StillCamera::from(camera).camera();
            let away = said(&[0, 255], RenderSettings { camera: camera.into(), ..with_tf("grey") }).unwrap();
            assert!(away.contains("centred at 0 and its longest side is 1"), "{camera:?}: {away}");
        }
    }

    #[test]
    fn backgrounds_are_no_volume() {
        let grey = RenderSettings { background: [0.25; 3], ..with_tf(r#"{"points":[[0,1,1,1,0]]}"#) };
        assert!(said(&[0, 255], grey).is_some());
    }
}
