//! Export of pictures and videos, with pixels equal to those of the command line for the same session.

use crate::job::Handle;
use crate::session::camera_motion::CameraMotion;
use crate::session::kept;
use anyhow::{Context, Result};
use fovolnet::core::{Frame, FrameSize};
use fovolnet::io::image::{self, Alpha};
use fovolnet::io::video::VideoWriter;
use fovolnet::{OpenVolume, Pipeline, RenderSettings, Sampling, Session, SpeedSettings};
use std::path::{Path, PathBuf};

/// Settings of an export.
#[derive(Debug, Clone, PartialEq)]
pub struct Export {
    /// Output file.
    pub path: PathBuf,
    /// Size of the frames.
    pub size: FrameSize,
    /// Whether every pixel is rendered; otherwise sampled and reconstructed as in the session.
    pub is_full: bool,
    /// Whether the session is written beside the output.
    pub with_session: bool,
    /// Picture or video.
    pub kind: Kind,
}

/// Kind of an export.
#[derive(Debug, Clone, PartialEq)]
pub enum Kind {
    /// PNG picture.
    Picture {
        /// Whether the background is transparent; every pixel is rendered then.
        is_transparent: bool,
    },
    /// Clip from the first frame of the camera motion on.
    Video {
        /// Camera motion.
        course: CameraMotion,
        /// Number of frames.
        frames: u32,
        /// Frames a second.
        fps: u32,
    },
}

impl Export {
    /// Session from which `fovolnet render` makes identical pixels.
    pub fn session(&self, session: &Session) -> Session {
        let mut session = session.clone();
        let render = &mut session.render;
        render.size = Some(self.size);
        if self.is_full {
            render.sampling = Some(Sampling::Full.into());
        }
        render.transparent = None;
        match &self.kind {
            Kind::Picture { is_transparent } => {
                render.frames = None;
                if *is_transparent {
                    (render.transparent, render.sampling) = (Some(true), Some(Sampling::Full.into()));
                }
            }
            Kind::Video { course, frames, .. } => {
                (render.frames, render.first_frame) = (Some(*frames), None);
                course.apply(render);
            }
        }
        session
    }

    /// Files that the export writes.
    pub fn files(&self) -> Vec<PathBuf> {
        let beside = self.with_session.then(|| session_beside(&self.path));
        [self.path.clone()].into_iter().chain(beside).collect()
    }

    /// Runs the export; returns a message that names the output.
    ///
    /// # Errors
    /// An output that the viewer has read, invalid render settings, files that cannot be written, or cancellation.
    pub fn run(
        &self,
        session: &Session,
        volume: &OpenVolume,
        speed: &SpeedSettings,
        handle: &Handle,
    ) -> Result<String> {
        kept::check(&self.path, |_| false)?;
        let session = self.session(session);
        let settings = session.render.resolve()?;
        let written = match &self.kind {
            Kind::Picture { is_transparent } => {
                let frame = picture(volume, &settings, speed)?;
                handle.progress(0.9)?;
                let alpha = if *is_transparent { Alpha::Keep } else { Alpha::Drop };
                image::write_png(&self.path, &frame, alpha)?;
                self.path.clone()
            }
            Kind::Video { fps, .. } => video(&self.path, volume, &settings, speed, *fps, handle)?,
        };
        if self.with_session {
            let beside = session_beside(&written);
            kept::check(&beside, |path| Session::read(path).is_ok())?;
            session.write(&beside)?;
        }
        let place = written.display();
        Ok(if written == self.path {
            format!("{place} is written")
        } else {
            format!("{place} is written: for other formats install ffmpeg")
        })
    }
}

/// Session file beside the output `written`. It appends to the full name, so that it cannot overwrite a user's
/// session.
pub fn session_beside(written: &Path) -> PathBuf {
    let mut name = written.as_os_str().to_owned();
    name.push(".toml");
    name.into()
}

/// Output file of a clip requested as `path`: always y4m without ffmpeg.
pub fn video_file(path: PathBuf, has_ffmpeg: bool) -> PathBuf {
    if has_ffmpeg { path } else { path.with_extension("y4m") }
}

/// Size of `frames` frames of `size` as y4m without the file header: three bytes per pixel, and six per frame.
pub fn y4m_bytes(size: FrameSize, frames: u32) -> u64 {
    u64::from(frames) * (3 * size.pixels() as u64 + 6)
}

/// Renders the first frame of a session.
fn picture(volume: &OpenVolume, settings: &RenderSettings, speed: &SpeedSettings) -> Result<Frame> {
    let mut pipeline = Pipeline::new(volume, settings, speed)?;
    Ok(pipeline.render(settings.first_frame)?.frame)
}

/// Writes the frames of `settings`. Returns the file, which may have another format than requested.
fn video(
    path: &Path,
    volume: &OpenVolume,
    settings: &RenderSettings,
    speed: &SpeedSettings,
    fps: u32,
    handle: &Handle,
) -> Result<PathBuf> {
    let mut pipeline = Pipeline::new(volume, settings, speed)?;
    let mut video = VideoWriter::create(path, pipeline.size(), fps)?;
    let numbers = settings.frame_numbers();
    let count = f64::from(numbers.end - numbers.start);
    for i in numbers.clone() {
        handle.progress(f64::from(i - numbers.start) / count)?;
        video.push(&pipeline.render(i)?.frame)?;
    }
    video.finish().context("the clip cannot be finished")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::job::Job;
    use fovolnet::{PathChoice, RenderOverrides, VolumeSettings, open_volume};

    fn run(export: Export, session: Session) -> Result<String> {
        let job = Job::start(
            "exporting",
            || (),
            move |handle| {
                let volume = open_volume(&session.volume, &session.read)?;
                export.run(&session, &volume, &SpeedSettings::default(), handle)
            },
        )?;
        loop {
            if let Some(result) = job.take() {
                return result;
            }
            std::thread::sleep(std::time::Duration::from_millis(1));
        }
    }

    fn session() -> Session {
        let read = VolumeSettings { dims: Some([24; 3]), ..VolumeSettings::default() };
        let render = RenderOverrides {
            camera: Some([0.3, 0.5, 1.7, 0.0, 0.0, 0.0, 35.0].into()),
            path: Some(PathChoice::Flythrough),
            ..RenderOverrides::default()
        };
        Session::new("head", read, render).unwrap()
    }

    #[test]
    fn pictures_are_those_of_the_session_beside_them() {
        let folder = tempfile::tempdir().unwrap();
        for (is_full, is_transparent) in [(true, false), (false, false), (true, true), (false, true)] {
            let path = folder.path().join(format!("{is_full}-{is_transparent}.png"));
            let size = "70x50".parse().unwrap();
            let kind = Kind::Picture { is_transparent };
            let export = Export { path: path.clone(), size, is_full, with_session: true, kind };
            run(export.clone(), session()).unwrap();
            assert!(export.files().iter().all(|file| file.is_file()) && export.files().len() == 2);
            let beside = Session::read(&session_beside(&path)).unwrap();
            let settings = beside.render.resolve().unwrap();
            assert_eq!(settings.transparent, is_transparent);
            let volume = open_volume(&beside.volume, &beside.read).unwrap();
            let mut pipeline = Pipeline::new(&volume, &settings, &SpeedSettings::default()).unwrap();
            let replayed = folder.path().join("replayed.png");
            let alpha = if is_transparent { Alpha::Keep } else { Alpha::Drop };
            image::write_png(&replayed, &pipeline.render(0).unwrap().frame, alpha).unwrap();
            assert_eq!(std::fs::read(&path).unwrap(), std::fs::read(&replayed).unwrap());
        }
    }

    #[test]
    fn an_opaque_export_of_a_transparent_session_is_opaque() {
        let mut session = session();
        session.render.transparent = Some(true);
        let kind = Kind::Picture { is_transparent: false };
        let size = "8x8".parse().unwrap();
        let export = Export { path: "a.png".into(), size, is_full: false, with_session: true, kind };
        assert_eq!(export.session(&session).render.transparent, None);
    }

    #[test]
    fn a_session_that_was_saved_is_not_the_one_beside_an_export() {
        assert_eq!(session_beside(Path::new("a/head.png")), Path::new("a/head.png.toml"));
        assert_eq!(video_file("a/head.mp4".into(), false), Path::new("a/head.y4m"));
        assert_eq!(video_file("a/head.mp4".into(), true), Path::new("a/head.mp4"));
    }

    #[test]
    fn videos_follow_their_course_and_say_what_is_wrong() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("clip.y4m");
        let size = "32x24".parse().unwrap();
        let clip = |course| Export {
            path: path.clone(),
            size,
            is_full: false,
            with_session: true,
            kind: Kind::Video { course, frames: 3, fps: 25 },
        };
        let along = clip(CameraMotion::Path(PathChoice::Flythrough));
        run(along.clone(), session()).unwrap();
        let frames = fovolnet::io::video::read(&path).unwrap();
        assert_eq!(frames.len(), 3);
        assert_ne!(frames[0], frames[2]);
        let length = std::fs::metadata(&path).unwrap().len();
        assert!(length - y4m_bytes(size, 3) < 100, "{length}");
        assert!(session_beside(&path).is_file());
        let still = clip(CameraMotion::Still([0.3, 0.5, 1.7, 0.0, 0.0, 0.0, 35.0].into()));
        let error = run(still.clone(), session()).unwrap_err().to_string();
        assert!(error.contains("another name"), "what was read is not replaced: {error}");
        let path = folder.path().join("still.y4m");
        run(Export { is_full: true, path: path.clone(), ..still }, session()).unwrap();
        let frames = fovolnet::io::video::read(&path).unwrap();
        assert_eq!(frames[0], frames[2]);
        let nowhere = Export { path: folder.path().join("no/such/clip.y4m"), ..along };
        assert!(run(nowhere, session()).is_err());
    }
}
