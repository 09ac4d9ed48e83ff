//! Panels for settings and statistics.

mod fields;
mod mode;
mod motion;
mod placement;
mod planes;
mod sampling;
mod scene;
mod statistics;

pub use mode::{mode, projection};
pub use motion::{budget, looks};
pub use placement::{cropping, standing};
pub use planes::planes;
pub use sampling::sampling;
pub use scene::scene;
pub use statistics::{HISTORY, statistics};
