//! Interactive viewer: renders a volume in a window with gaze-dependent sampling.
//!
//! [`run`] is the command. [`Viewer`] is the window. A thread ([`frames::engine`]) makes its frames: frames in motion that keep the frame rate
//! ([`fovolnet::Planner`]), and progressive refinement of still views ([`frames::still`]). The [`session::document`] holds
//! everything that a picture depends on; it is a session of the command line.

pub mod frames;
pub mod job;
mod program;
pub mod session;
pub mod ui;
mod viewer;
pub mod window;

pub use program::run;
pub use viewer::{Start, Viewer};

/// The examples of the README, for doctests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExamples;
