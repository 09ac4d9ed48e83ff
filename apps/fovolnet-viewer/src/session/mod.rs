//! The open session: document, cached data, autosaves, exports, and the state of the user.

pub mod autosave;
pub mod camera_motion;
pub mod document;
pub mod export;
pub mod kept;
pub mod opened;
pub mod places;
