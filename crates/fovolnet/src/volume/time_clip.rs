//! Clips over the time points of a volume.

use super::layers::open_volume;
use super::open::OpenVolume;
use crate::{Error, Mode, RenderSettings, Result, TransferChoice, VolumeSettings, presets};
use fovol_core::Dtype;
use std::thread::JoinHandle;

/// Volumes of a clip over time. While one is rendered, the next is read.
#[derive(Debug)]
pub struct TimeClip {
    source: String,
    read: VolumeSettings,
    points: Vec<usize>,
    /// First frame of the clip, and number of frames.
    frames: (u32, u32),
    shown: usize,
    ahead: Option<(usize, JoinHandle<Result<OpenVolume>>)>,
}

impl TimeClip {
    /// Clip of the time points that `read` chooses of `source`, whose first is `opened`; `None` if it chooses one point.
    /// Frames of `settings` are spread over the time points.
    ///
    /// # Errors
    /// Time points that are not there.
    pub fn new(
        source: &str,
        read: &VolumeSettings,
        opened: &OpenVolume,
        settings: &RenderSettings,
    ) -> Result<Option<Self>> {
        let Some(points) = points(read, opened)? else { return Ok(None) };
        let mut read = read.clone();
        // Colours keep their meaning through the clip.
        if read.shown_range().is_none() && opened.volume.dtype() != Dtype::U8 && opened.colours.is_none() {
            read.range = Some(opened.volume.range());
        }
        Ok(Some(Self {
            source: source.to_owned(),
            read,
            shown: points[0],
            points,
            frames: (settings.first_frame, settings.frames.max(1)),
            ahead: None,
        }))
    }

    /// Number of frames of a clip that shows every time point once; `None` if `read` chooses one point.
    ///
    /// # Errors
    /// Time points that are not there.
    pub fn length(read: &VolumeSettings, opened: &OpenVolume) -> Result<Option<u32>> {
        Ok(points(read, opened)?.map(|points| u32::try_from(points.len()).unwrap_or(u32::MAX)))
    }

    /// `settings` with everything that follows from `opened`, the first volume, so that it stays through the clip: the
    /// transfer function and the value of an isosurface.
    ///
    /// # Errors
    /// A transfer function that cannot be read.
    pub fn settled(settings: &RenderSettings, opened: &OpenVolume) -> Result<RenderSettings> {
        let mut settings = settings.clone();
        if settings.transfer_function == TransferChoice::Auto {
            settings.transfer_function = presets::of_choice(&TransferChoice::Auto, opened)?.into();
        }
        if settings.mode == Mode::Isosurface {
            settings.iso = Some(super::ray_mode::isovalue(&opened.volume, &settings));
        }
        Ok(settings)
    }

    /// Volume of frame `i`, unless it is that of the frame before.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub fn volume_of(&mut self, i: u32) -> Result<Option<OpenVolume>> {
        let point = self.point_of(i);
        if point == self.shown {
            self.read_ahead();
            return Ok(None);
        }
        let opened = match self.ahead.take() {
            Some((ahead, reading)) if ahead == point => reading
                .join()
                .unwrap_or_else(|_| Err(Error::Setting(format!("time point {point} could not be read"))))?,
            _ => self.open(point)?,
        };
        self.shown = point;
        self.read_ahead();
        Ok(Some(opened))
    }

    /// Time point of frame `i`.
    fn point_of(&self, i: u32) -> usize {
        let (first, frames) = self.frames;
        let place = i.saturating_sub(first).min(frames - 1) as usize;
        self.points[place * self.points.len() / frames as usize]
    }

    fn open(&self, point: usize) -> Result<OpenVolume> {
        open_volume(&self.source, &self.read_at(point))
    }

    fn read_at(&self, point: usize) -> VolumeSettings {
        VolumeSettings { time: Some(point.into()), ..self.read.clone() }
    }

    /// Begins to read the time point after the shown one.
    fn read_ahead(&mut self) {
        let next = self.points.iter().copied().find(|point| *point > self.shown);
        let Some(next) = next.filter(|next| self.ahead.as_ref().is_none_or(|(ahead, _)| ahead != next))
        else {
            return;
        };
        let (source, read) = (self.source.clone(), self.read_at(next));
        self.ahead = Some((next, std::thread::spawn(move || open_volume(&source, &read))));
    }
}

fn points(read: &VolumeSettings, opened: &OpenVolume) -> Result<Option<Vec<usize>>> {
    let Some(time) = read.time else { return Ok(None) };
    Ok(time.clip(opened.volume.contents().times)?.map(Iterator::collect))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::RenderOverrides;

    fn series(folder: &std::path::Path) -> String {
        for time in 0..4u8 {
            std::fs::write(folder.join(format!("t{time}_2x2x2_uint8.raw")), [10 * time; 8]).unwrap();
        }
        folder.join("t*_2x2x2_uint8.raw").display().to_string()
    }

    /// Values of the volumes of all frames.
    fn values(time: &str, frames: u32) -> Vec<f64> {
        let folder = tempfile::tempdir().unwrap();
        let source = series(folder.path());
        let read = VolumeSettings { time: Some(time.parse().unwrap()), ..Default::default() };
        let opened = open_volume(&source, &read).unwrap();
        let settings = RenderOverrides { frames: Some(frames), first_frame: Some(7), ..Default::default() };
        let settings = settings.resolve().unwrap();
        let mut clip = TimeClip::new(&source, &read, &opened, &settings).unwrap().unwrap();
        let mut shown = opened.volume.value([0; 3]);
        let frames = settings.frame_numbers().map(|i| {
            shown = clip.volume_of(i).unwrap().map_or(shown, |opened| opened.volume.value([0; 3]));
            shown
        });
        frames.collect()
    }

    #[test]
    fn frames_are_spread_over_the_time_points() {
        assert_eq!(values("all", 4), [0.0, 10.0, 20.0, 30.0]);
        assert_eq!(values("1..", 6), [10.0, 10.0, 20.0, 20.0, 30.0, 30.0]);
        assert_eq!(values("all", 2), [0.0, 20.0]);
        assert_eq!(values("2..2", 2), [20.0, 20.0]);
    }

    #[test]
    fn single_time_points_are_no_clip() {
        let folder = tempfile::tempdir().unwrap();
        let source = series(folder.path());
        let read = VolumeSettings { time: Some(2.into()), ..Default::default() };
        let opened = open_volume(&source, &read).unwrap();
        assert_eq!(opened.volume.value([0; 3]), 20.0);
        assert_eq!(TimeClip::length(&read, &opened).unwrap(), None);
        let read = VolumeSettings { time: Some("1..7".parse().unwrap()), ..Default::default() };
        assert!(TimeClip::length(&read, &opened).unwrap_err().to_string().contains("4 time points"));
    }
}
