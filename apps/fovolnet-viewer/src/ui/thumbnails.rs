//! Thumbnails of the built-in volumes.

use eframe::egui::{ColorImage, Context, TextureHandle, TextureOptions};
use fovolnet::io::image;
use fovolnet::io::procedural::Procedural;
use std::io::Cursor;
use std::path::Path;

macro_rules! pictures {
    ($($name:literal),* $(,)?) => {
        /// Made by `fovolnet render`; REPRODUCE.md has the command.
        const PICTURES: &[(&str, &[u8])] =
            &[$(($name, include_bytes!(concat!("../../assets/pictures/", $name, ".png")))),*];
    };
}

pictures!("vortices", "supernova", "head", "engine", "angiogram", "reptile", "plume", "marschner-lobb");

/// Thumbnails as textures.
#[derive(Default)]
pub struct Thumbnails(Vec<(&'static str, TextureHandle)>);

impl Thumbnails {
    /// Loads the textures, once.
    pub fn prepare(&mut self, context: &Context) {
        if self.0.is_empty() {
            self.0 = PICTURES.iter().map(|&(name, bytes)| (name, texture(context, name, bytes))).collect();
        }
    }

    /// Thumbnail of `kind`, if loaded.
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
