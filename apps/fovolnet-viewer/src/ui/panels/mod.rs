//! Panels for settings and statistics.

mod fields;
mod motion;
mod placement;
mod sampling;
mod scene;
mod statistics;

pub use motion::{budget, looks};
pub use placement::{cropping, standing};
pub use sampling::sampling;
pub use scene::scene;
pub use statistics::{HISTORY, statistics};
