//! Memory: how much is available, how much work will need, and failure when there is too little.
//!
//! Three safeguards follow each other:
//!
//! 1. Large work adds up its memory before it begins ([`Estimate`]) and is refused if that exceeds [`available()`]. The
//!    error lists the largest parts and tells how to need less.
//! 2. Large blocks come from [`zeroed`], [`reserve`] and their like, which return a [`Shortage`] on failure.
//! 3. Programs with the allocator [`ExitWhenExhausted`] end with one line when any other allocation fails, for example
//!    in a library. Without it Rust aborts them.

mod available;
mod estimate;
mod exhaustion;
mod reserve;
mod shortage;

pub use available::available;
pub use estimate::Estimate;
pub use exhaustion::{ExitWhenExhausted, before_exit, exit_with, refuse_allocation};
pub use reserve::{copied, reserve, zeroed};
pub use shortage::Shortage;

/// Advice for errors about a volume that is too large.
pub const SMALLER_VOLUME: &str = "--downsample 2 takes an eighth of the voxels";
/// Advice for errors about frames that are too large.
pub const SMALLER_FRAMES: &str = "a smaller --size needs less";
/// Advice for errors about large frames of a large volume.
pub const SMALLER_BOTH: &str =
    "--downsample 2 takes an eighth of the voxels, and a smaller --size needs less";
