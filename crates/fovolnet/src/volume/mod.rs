//! Volumes: opening, cropping, placing them in the world, and what may hide them.

mod cropped_volume;
mod layers;
mod open;
mod ray_mode;
mod scene;
mod time_clip;
mod visibility;
mod world_box;

pub use cropped_volume::CroppedVolume;
pub use layers::open_volume;
pub use open::{OpenLayer, OpenVolume, open_single_volume};
pub(crate) use ray_mode::note as isosurface_note;
pub use scene::scene;
pub use time_clip::TimeClip;
pub use visibility::Visibility;
pub use world_box::WorldBox;
pub(crate) use world_box::notes as orientation_notes;
#[cfg(test)]
pub(crate) use world_box::tests::cube;
