//! Dialogues and their forms.

mod camera_choice;
pub mod dialogue;
pub mod export_form;
pub(crate) mod file_field;
pub mod files;
pub(crate) mod layout_form;
