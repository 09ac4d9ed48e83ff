//! Memory: how much there is, how much work will need, and what happens when there is too little.
//!
//! Three nets lie one below the other:
//!
//! 1. Work that will need much adds it up before it begins ([`Estimate`]) and is refused where it cannot fit into what is
//!    [`available()`]. The error lists what is largest and says what needs less.
//! 2. Large memory is asked for by [`zeroed`], [`reserve`] and their like, which return a [`Shortage`] where there is none.
//! 3. Programs whose allocator is [`ExitWhenExhausted`] end with one line where anything else, a library of others for
//!    example, finds no memory. Without it Rust aborts them.

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

/// What needs less memory than a large volume.
pub const SMALLER_VOLUME: &str = "--downsample 2 takes an eighth of the voxels";
/// What needs less memory than large frames.
pub const SMALLER_FRAMES: &str = "a smaller --size needs less";
/// What needs less memory than large frames of a large volume.
pub const SMALLER_BOTH: &str =
    "--downsample 2 takes an eighth of the voxels, and a smaller --size needs less";
