//! Small pictures of the volumes that come with the program.

use crate::job::Job;
use anyhow::Result;
use eframe::egui::{ColorImage, Context, TextureHandle, TextureOptions};
use fovolnet::core::Frame;
use fovolnet::io::procedural::Procedural;
use fovolnet::{Device, Pipeline, RenderSettings, Sampling, SpeedSettings, VolumeSettings, open_volume};
use std::sync::mpsc::{Receiver, channel};

/// Width and height of a small picture, in pixels.
pub const SIZE: [u32; 2] = [160, 112];
/// Voxels along each side: enough for a small picture.
const SIDE: usize = 64;

/// Small pictures, one after the other as they are made.
#[derive(Default)]
pub struct Thumbnails {
    textures: Vec<(Procedural, TextureHandle)>,
    making: Option<Making>,
}

/// Pictures that are under way.
struct Making {
    job: Job<()>,
    made: Receiver<(Procedural, Frame)>,
}

impl Thumbnails {
    /// Takes what has been made; begins with it at the first call.
    pub fn update(&mut self, context: &Context) {
        if self.making.is_none() {
            let (send, receive) = channel();
            let (each, end) = (context.clone(), context.clone());
            let work = Job::start(
                "small pictures",
                move || end.request_repaint(),
                move |handle| {
                    for (i, kind) in Procedural::ALL.into_iter().enumerate() {
                        handle.progress(i as f64 / Procedural::ALL.len() as f64)?;
                        send.send((kind, picture(kind)?))?;
                        each.request_repaint();
                    }
                    Ok(())
                },
            );
            self.making = work.ok().map(|job| Making { job, made: receive });
        }
        let Some(making) = &self.making else { return };
        for (kind, frame) in making.made.try_iter() {
            let image = ColorImage::from_rgb(SIZE.map(|side| side as usize), &frame.to_rgb8());
            let texture = context.load_texture(kind.name(), image, TextureOptions::LINEAR);
            self.textures.push((kind, texture));
        }
    }

    /// The picture of `kind`, if it is made.
    pub fn of(&self, kind: Procedural) -> Option<&TextureHandle> {
        self.textures.iter().find(|(known, _)| *known == kind).map(|(_, texture)| texture)
    }

    /// Whether all are made, or nobody wants the rest.
    pub fn are_made(&self) -> bool {
        let cancelled = self.making.as_ref().is_some_and(|making| making.job.is_cancelled());
        cancelled || self.textures.len() == Procedural::ALL.len()
    }

    /// Ends what is under way: something else is looked at.
    pub fn stop(&mut self) {
        if let Some(making) = &self.making {
            making.job.cancel();
        }
    }
}

fn picture(kind: Procedural) -> Result<Frame> {
    let read = VolumeSettings { dims: Some([SIDE; 3]), ..VolumeSettings::default() };
    let settings = RenderSettings {
        size: Some(SIZE.try_into()?),
        sampling: Some(Sampling::Full),
        camera: Some([0.9, 0.7, 1.7, 0.0, 0.0, 0.0, 30.0]),
        ..RenderSettings::default()
    };
    // One thread, so that the window and whatever is opened meanwhile do not wait.
    let speed = SpeedSettings { threads: Some(1), device: Some(Device::Cpu), ..SpeedSettings::default() };
    let mut pipeline = Pipeline::new(&open_volume(kind.name(), &read)?, &settings, &speed)?;
    Ok(pipeline.render(0)?.frame)
}
