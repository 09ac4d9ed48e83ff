//! Pictures and videos for others, made as the command line makes them of the same session.

use crate::job::Handle;
use anyhow::{Context, Result};
use fovolnet::core::{Frame, FrameSize};
use fovolnet::io::image::{self, Alpha};
use fovolnet::io::video::VideoWriter;
use fovolnet::{OpenVolume, Pipeline, RenderSettings, Sampling, Session, SpeedSettings};
use std::path::{Path, PathBuf};

/// What is made of a session.
#[derive(Debug, Clone, PartialEq)]
pub struct Export {
    /// Where it goes.
    pub path: PathBuf,
    /// Its size.
    pub size: FrameSize,
    /// Whether every pixel is measured; sampled and reconstructed as the session says otherwise.
    pub is_full: bool,
    /// Whether the session is written beside it.
    pub with_session: bool,
    /// A picture, or a video.
    pub kind: Kind,
}

/// A picture, or a video.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// A PNG picture.
    Picture {
        /// Whether the background is left out.
        is_transparent: bool,
    },
    /// A clip of the session's path, from its first frame on.
    Video {
        /// How many frames.
        frames: u32,
        /// Frames a second.
        fps: u32,
    },
}

impl Export {
    /// The session that `fovolnet render` makes the same pixels of.
    pub fn session(&self, session: &Session) -> Session {
        let mut session = session.clone();
        let render = &mut session.render;
        render.size = Some(self.size);
        if self.is_full {
            render.sampling = Some(Sampling::Full);
        }
        match self.kind {
            Kind::Picture { .. } => render.frames = None,
            Kind::Video { frames, .. } => {
                render.frames = Some(frames);
                render.first_frame = None;
                if render.path.is_some() {
                    // The path is what the clip shows, not where somebody stands.
                    render.camera = None;
                }
            }
        }
        session
    }

    /// Makes it; the message says where it is.
    ///
    /// # Errors
    /// Settings that cannot be rendered with, files that cannot be written, an end that was asked for.
    pub fn run(
        &self,
        session: &Session,
        volume: &OpenVolume,
        speed: &SpeedSettings,
        handle: &Handle,
    ) -> Result<String> {
        let session = self.session(session);
        let written = match self.kind {
            Kind::Picture { is_transparent } => {
                let frame = match is_transparent {
                    true => transparent(volume, &session.render, speed, handle)?,
                    false => picture(volume, &session.render, speed)?,
                };
                handle.progress(0.9)?;
                let alpha = if is_transparent { Alpha::Keep } else { Alpha::Drop };
                image::write_png(&self.path, &frame, alpha)?;
                self.path.clone()
            }
            Kind::Video { fps, .. } => video(&self.path, volume, &session.render, speed, fps, handle)?,
        };
        if self.with_session {
            session.write(&self.path.with_extension("toml"))?;
        }
        let place = written.display();
        Ok(if written == self.path {
            format!("{place} is written")
        } else {
            format!("{place} is written: for other formats install ffmpeg")
        })
    }
}

/// The first frame of a session.
fn picture(volume: &OpenVolume, settings: &RenderSettings, speed: &SpeedSettings) -> Result<Frame> {
    let mut pipeline = Pipeline::new(volume, settings, speed)?;
    Ok(pipeline.render(settings.first_frame.unwrap_or(0))?.frame)
}

/// The same without its background: what is seen before black and before white tells how much of it shows through, as
/// compositing adds it in proportion.
fn transparent(
    volume: &OpenVolume,
    settings: &RenderSettings,
    speed: &SpeedSettings,
    handle: &Handle,
) -> Result<Frame> {
    let before = |background: f64| {
        let settings = RenderSettings { background: Some([background; 3]), ..settings.clone() };
        picture(volume, &settings, speed)
    };
    let black = before(0.0)?;
    handle.progress(0.45)?;
    let white = before(1.0)?;
    let mut frame = Frame::new(black.size());
    let pairs = black.pixels().iter().zip(white.pixels());
    for (out, (black, white)) in frame.pixels_mut().iter_mut().zip(pairs) {
        let shows_through = (0..3).map(|c| white[c] - black[c]).sum::<f32>() / 3.0;
        let alpha = (1.0 - shows_through).clamp(0.0, 1.0);
        let [r, g, b] = std::array::from_fn(|c| if alpha > 0.0 { black[c] / alpha } else { 0.0 });
        *out = [r, g, b, alpha];
    }
    Ok(frame)
}

/// Writes the frames of `settings`; where they lie, which is another file where the format is not at hand.
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
    use fovolnet::{VolumeSettings, open_volume};

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
        let render = RenderSettings {
            camera: Some([0.3, 0.5, 1.7, 0.0, 0.0, 0.0, 35.0]),
            path: Some("flythrough".into()),
            ..RenderSettings::default()
        };
        Session::new("head", read, render).unwrap()
    }

    #[test]
    fn pictures_are_those_of_the_session_beside_them() {
        let folder = tempfile::tempdir().unwrap();
        for (is_full, name) in [(true, "full.png"), (false, "sparse.png")] {
            let path = folder.path().join(name);
            let size = "70x50".parse().unwrap();
            let kind = Kind::Picture { is_transparent: false };
            let export = Export { path: path.clone(), size, is_full, with_session: true, kind };
            run(export, session()).unwrap();
            let beside = Session::read(&path.with_extension("toml")).unwrap();
            let volume = open_volume(&beside.volume, &beside.read).unwrap();
            let mut pipeline = Pipeline::new(&volume, &beside.render, &SpeedSettings::default()).unwrap();
            let replayed = folder.path().join("replayed.png");
            image::write_png(&replayed, &pipeline.render(0).unwrap().frame, Alpha::Drop).unwrap();
            assert_eq!(std::fs::read(&path).unwrap(), std::fs::read(&replayed).unwrap());
        }
    }

    #[test]
    fn transparent_pictures_before_a_background_are_the_opaque_ones() {
        let folder = tempfile::tempdir().unwrap();
        let export = |name: &str, is_transparent| Export {
            path: folder.path().join(name),
            size: "60x40".parse().unwrap(),
            is_full: true,
            with_session: false,
            kind: Kind::Picture { is_transparent },
        };
        let mut session = session();
        session.render.background = Some([0.2, 0.4, 0.8]);
        run(export("opaque.png", false), session.clone()).unwrap();
        run(export("transparent.png", true), session).unwrap();
        let read = |name: &str| image::read(&folder.path().join(name)).unwrap();
        let (opaque, transparent) = (read("opaque.png"), read("transparent.png"));
        assert_eq!(transparent.pixel(0, 0)[3], 0.0);
        assert!(transparent.pixels().iter().any(|p| p[3] > 0.9));
        for (o, t) in opaque.pixels().iter().zip(transparent.pixels()) {
            for c in 0..3 {
                let over = t[c] * t[3] + [0.2, 0.4, 0.8][c] * (1.0 - t[3]);
                assert!((over - o[c]).abs() < 2.5 / 255.0, "{o:?} {t:?}");
            }
        }
    }

    #[test]
    fn videos_follow_the_path_and_say_what_is_wrong() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("clip.y4m");
        let kind = Kind::Video { frames: 3, fps: 25 };
        let size = "32x24".parse().unwrap();
        let export = Export { path: path.clone(), size, is_full: false, with_session: true, kind };
        run(export.clone(), session()).unwrap();
        let frames = fovolnet::io::video::read(&path).unwrap();
        assert_eq!(frames.len(), 3);
        assert_ne!(frames[0], frames[2]);
        let nowhere = Export { path: folder.path().join("no/such/clip.y4m"), ..export };
        assert!(run(nowhere, session()).is_err());
    }
}
