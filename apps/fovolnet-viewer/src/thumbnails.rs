//! Small pictures of the volumes that come with the program.

use eframe::egui::{ColorImage, Context, TextureHandle, TextureOptions};
use fovolnet::io::image;
use fovolnet::io::procedural::Procedural;
use std::io::Cursor;
use std::path::Path;

macro_rules! pictures {
    ($($name:literal),* $(,)?) => {
        /// As `fovolnet render` makes them; REPRODUCE.md has the command.
        const PICTURES: &[(&str, &[u8])] =
            &[$(($name, include_bytes!(concat!("../assets/pictures/", $name, ".png")))),*];
    };
}

pictures!("vortices", "supernova", "head", "engine", "angiogram", "reptile", "plume", "marschner-lobb");

/// Small pictures, ready to be drawn.
#[derive(Default)]
pub struct Thumbnails(Vec<(&'static str, TextureHandle)>);

impl Thumbnails {
    /// Makes them ready, once.
    pub fn prepare(&mut self, context: &Context) {
        if self.0.is_empty() {
            self.0 = PICTURES.iter().map(|&(name, bytes)| (name, texture(context, name, bytes))).collect();
        }
    }

    /// The picture of `kind`, if they are ready.
    pub fn of(&self, kind: Procedural) -> Option<&TextureHandle> {
        self.0.iter().find(|(name, _)| *name == kind.name()).map(|(_, texture)| texture)
    }
}

fn texture(context: &Context, name: &str, bytes: &[u8]) -> TextureHandle {
    let frame = image::decode(Path::new(name), Cursor::new(bytes)).expect("a test reads them all");
    let size = [frame.size().width as usize, frame.size().height as usize];
    let image = ColorImage::from_rgb(size, &frame.to_rgb8());
    context.load_texture(name, image, TextureOptions::LINEAR)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_volume_has_a_picture() {
        let mut thumbnails = Thumbnails::default();
        thumbnails.prepare(&Context::default());
        for kind in Procedural::ALL {
            let texture = thumbnails.of(kind).expect("a picture of it");
            assert_eq!(texture.size(), [160, 112]);
        }
    }
}
