//! Interactive viewer: renders a volume in a window with gaze-dependent sampling.
//!
//! [`Viewer`] is the window, and [`engine`] the thread that makes its frames. [`frame_producer`] is the work of that thread:
//! frames in motion that keep the frame rate ([`budget`]), and progressive refinement of still views ([`still`]). The
//! [`document`] holds everything that a picture depends on; it is a session of the command line.

pub mod autosave;
mod backdrop;
mod boundaries;
pub mod budget;
pub mod camera_motion;
mod colour_button;
pub mod commands;
pub mod dialogue;
pub mod display_mode;
pub mod document;
pub mod drawing_threads;
pub mod engine;
pub mod export;
pub mod export_form;
mod file_field;
pub mod files;
pub mod frame_producer;
pub mod gaze;
mod histogram;
pub mod job;
pub mod kept;
mod layout_form;
mod marks;
pub mod messages;
pub mod navigation;
pub mod no_window;
pub mod opened;
mod outline;
mod panels;
mod picture_view;
pub mod places;
pub mod quad;
mod range_slider;
pub mod screen;
mod start_page;
pub mod still;
pub mod surface;
mod text_field;
mod thumbnails;
pub mod timeline;
mod transfer_editor;
mod viewer;

pub use viewer::{Start, Viewer};

/// The examples of the README, for doctests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExamples;
