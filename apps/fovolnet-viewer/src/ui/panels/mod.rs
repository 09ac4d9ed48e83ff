//! Panels for settings and statistics.

mod data;
mod fields;
mod labels;
mod mode;
mod motion;
mod placement;
mod planes;
mod sampling;
mod scene;
mod slices;
mod statistics;

pub use data::{data, has_parts};
pub use labels::labels;
pub use mode::{mode, projection};
pub use motion::{budget, looks};
pub use placement::{cropping, standing};
pub use planes::planes;
pub use sampling::sampling;
pub use scene::scene;
pub use slices::slices;
pub use statistics::{HISTORY, statistics};
