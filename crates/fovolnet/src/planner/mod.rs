//! Planner: chooses, frame by frame, how frames are made within a budget.
//!
//! A frame can be made in several [`Way`]s, at several sizes and steps. The planner knows two things of each. Its cost is
//! counted work times learned rates. Its error is measured: a few hundred probe pixels are marched exactly, and compared
//! with what each way shows there. Among those that fit the budget it takes the one with the least error.

mod candidate;
mod costs;
#[cfg(feature = "files")]
mod engine;
mod errors;
#[cfg(feature = "files")]
mod frame_maker;
mod frame_plan;
mod freedom;
mod limit;
#[cfg(feature = "files")]
mod planned_pipeline;
mod planning;
mod probes;
mod running_error;
mod scatter;
mod shown_error;
mod sizes;
mod survey;
mod taps;
mod way;

pub use candidate::Candidate;
#[cfg(feature = "files")]
pub use engine::{Engine, Wanted};
#[cfg(feature = "files")]
pub use frame_maker::FrameMaker;
pub use frame_plan::{FramePlan, PlannedFrames};
pub use freedom::Freedom;
pub use limit::Limit;
#[cfg(feature = "files")]
pub use planned_pipeline::PlannedPipeline;
pub use planning::{MadeFrame, Planner};
pub use probes::Shown;
pub use way::Way;
