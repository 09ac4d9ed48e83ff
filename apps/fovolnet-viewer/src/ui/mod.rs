//! User interface: panels, menus, dialogues.

pub mod commands;
pub mod dialogues;
pub mod messages;
pub(crate) mod panels;
pub mod picture;
pub mod slices;
pub(crate) mod start_page;
pub(crate) mod thumbnails;
pub mod timeline;
pub mod transfer;
pub mod widgets;
