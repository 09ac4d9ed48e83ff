//! Textures of slices, drawn anew only when something has changed.

use super::orientation::Lie;
use super::slice_pixels::Slice;
use super::value_window::ValueWindow;
use crate::session::opened::Opened;
use eframe::egui::{Context, TextureHandle, TextureOptions};
use fovolnet::core::{Interpolation, Volume};
use fovolnet::{Choice, RenderOverrides};
use std::sync::Arc;

/// Textures of the slice of one plane.
#[derive(Default)]
pub struct SliceTextures {
    base: Option<Drawn>,
    /// Overlays, the lowest first.
    over: Vec<Option<Drawn>>,
}

/// Texture, and all that it depends on.
struct Drawn {
    texture: TextureHandle,
    volume: Arc<Volume>,
    slice: Slice,
    /// Window, where greys are shown.
    window: Option<ValueWindow>,
    options: TextureOptions,
}

impl Drawn {
    fn shows(&self, volume: &Arc<Volume>, slice: Slice, window: Option<ValueWindow>) -> bool {
        Arc::ptr_eq(&self.volume, volume) && self.slice == slice && self.window == window
    }
}

impl SliceTextures {
    /// Draws what has changed of slice `number` of `opened`.
    pub fn draw(
        &mut self,
        context: &Context,
        opened: &Opened,
        (lie, number): (Lie, usize),
        window: ValueWindow,
    ) {
        let volume = &opened.volume.volume;
        let largest = context.input(|input| input.max_texture_side);
        let dims = volume.grid().dims();
        let every = [lie.right, lie.down].map(|way| dims[way.axis].div_ceil(largest));
        let slice = Slice { lie, number, every: every.into_iter().max().unwrap_or(1) };
        let settings = opened.document.settings();
        let options = options(volume, settings);
        let is_drawn = |drawn: &Option<Drawn>, volume, window, options| {
            drawn.as_ref().is_some_and(|d| d.shows(volume, slice, window) && d.options == options)
        };
        if !is_drawn(&self.base, volume, Some(window), options) {
            let image = opened.slice_colours.base(&opened.volume, slice, window);
            let texture = context.load_texture("slice", image, options);
            let volume = Arc::clone(volume);
            self.base = Some(Drawn { texture, volume, slice, window: Some(window), options });
        }
        self.over.resize_with(opened.volume.layers.len(), || None);
        for (number, drawn) in self.over.iter_mut().enumerate() {
            let volume = &opened.volume.layers[number].opened.volume;
            let options = self::options(volume, settings);
            if !is_drawn(drawn, volume, None, options) {
                *drawn = opened.slice_colours.over(&opened.volume, number, slice).map(|image| {
                    let texture = context.load_texture("overlay", image, options);
                    Drawn { texture, volume: Arc::clone(volume), slice, window: None, options }
                });
            }
        }
    }

    /// The textures, the lowest first.
    pub fn iter(&self) -> impl Iterator<Item = &TextureHandle> {
        self.base.iter().chain(self.over.iter().flatten()).map(|drawn| &drawn.texture)
    }
}

/// Filter between the voxels of `volume`: that of the picture.
fn options(volume: &Volume, settings: &RenderOverrides) -> TextureOptions {
    let interpolation = match settings.interpolation.and_then(Choice::fixed) {
        Some(chosen) => chosen,
        None if volume.is_label_map() => Interpolation::Nearest,
        None => Interpolation::Linear,
    };
    match interpolation {
        Interpolation::Linear => TextureOptions::LINEAR,
        Interpolation::Nearest => TextureOptions::NEAREST,
    }
}
