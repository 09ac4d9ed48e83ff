//! Dialogues and their forms.

mod answer;
mod camera_choice;
mod dialogue;
pub mod export_form;
pub(crate) mod file_field;
pub mod files;
pub(crate) mod layout_form;

pub use answer::{Answer, Next};
pub use dialogue::{Dialogue, FilePrompt};
