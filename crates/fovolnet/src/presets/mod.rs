//! Transfer functions: presets, colour maps and automatic ones.

mod automatic;
mod catalogue;
mod channel_colour;
mod chosen;
mod label_colours;
mod notes;

pub use automatic::automatic;
pub(crate) use automatic::otsu;
pub(crate) use catalogue::is_name;
pub use catalogue::{Kind, kinds, names, text};
pub(crate) use chosen::of_choice;
pub use chosen::{chosen, find};
#[cfg(feature = "files")]
pub(crate) use chosen::{json_of_file, of_json};
pub use label_colours::{ShownLabel, labels, of_labels};
pub use notes::notes;
