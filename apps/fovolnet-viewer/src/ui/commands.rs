//! Commands of menus and keys.

use crate::frames::display_mode::DisplayMode;
use eframe::egui::{Context, Key, KeyboardShortcut, Modifiers};

/// Command of a menu or key.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Command {
    /// Open a file.
    Open,
    /// Close the session.
    Close,
    /// Save the session to its file.
    Save,
    /// Save the session to another file.
    SaveAs,
    /// Write a picture.
    ExportPicture,
    /// Export a video of the path.
    ExportVideo,
    /// End the viewer.
    Quit,
    /// Undo the last change.
    Undo,
    /// Redo the change that was undone.
    Redo,
    /// Return to the start of the path.
    ResetView,
    /// Look from this direction at the volume.
    LookFrom([i8; 3]),
    /// Choose a display mode of the frame.
    Show(DisplayMode),
    /// Play the path, or pause.
    PlayOrPause,
    /// Add the view as a keyframe.
    AddKeyframe,
    /// Show or hide box, axes and scales.
    ToggleMarks,
    /// Show or hide the slices.
    ToggleSlices,
    /// Let drags measure lengths, or no longer.
    ToggleRuler,
    /// Remove all rulers.
    ClearRulers,
    /// Switch between light and dark theme.
    ToggleTheme,
    /// Show help for keys and mouse.
    Help,
}

/// Command with its name and shortcut.
#[derive(Debug, Clone, Copy)]
pub struct Entry {
    /// The command.
    pub command: Command,
    /// Name in the menu.
    pub name: &'static str,
    /// Keyboard shortcut.
    pub shortcut: Option<KeyboardShortcut>,
}

const fn entry(command: Command, name: &'static str, modifiers: Modifiers, key: Key) -> Entry {
    Entry { command, name, shortcut: Some(KeyboardShortcut::new(modifiers, key)) }
}

const NONE: Modifiers = Modifiers::NONE;
const SHIFT: Modifiers = Modifiers::SHIFT;
const CTRL: Modifiers = Modifiers::COMMAND;
const CTRL_SHIFT: Modifiers = Modifiers { shift: true, ..Modifiers::COMMAND };

/// Entries of the menu *File*.
pub const FILE: &[Entry] = &[
    entry(Command::Open, "Open…", CTRL, Key::O),
    entry(Command::Save, "Save session", CTRL, Key::S),
    entry(Command::SaveAs, "Save session as…", CTRL_SHIFT, Key::S),
    entry(Command::ExportPicture, "Export picture…", CTRL, Key::E),
    entry(Command::ExportVideo, "Export video…", CTRL_SHIFT, Key::E),
    entry(Command::Close, "Close", CTRL, Key::W),
    entry(Command::Quit, "Quit", CTRL, Key::Q),
];

/// Entries of the menu *Edit*. Where two shortcuts match, the one with more modifiers must come first.
pub const EDIT: &[Entry] = &[
    entry(Command::Redo, "Redo", CTRL_SHIFT, Key::Z),
    entry(Command::Undo, "Undo", CTRL, Key::Z),
    entry(Command::AddKeyframe, "Add keyframe", NONE, Key::K),
    entry(Command::PlayOrPause, "Play or pause", NONE, Key::Space),
];

/// Entries of the menu *View*.
pub const VIEW: &[Entry] = &[
    entry(Command::ResetView, "Reset view", NONE, Key::Home),
    entry(Command::LookFrom([0, 0, 1]), "From the front (+z)", NONE, Key::Num1),
    entry(Command::LookFrom([1, 0, 0]), "From the right (+x)", NONE, Key::Num3),
    entry(Command::LookFrom([0, 1, 0]), "From above (+y)", NONE, Key::Num7),
    entry(Command::LookFrom([0, 0, -1]), "From the back (−z)", CTRL, Key::Num1),
    entry(Command::LookFrom([-1, 0, 0]), "From the left (−x)", CTRL, Key::Num3),
    entry(Command::LookFrom([0, -1, 0]), "From below (−y)", CTRL, Key::Num7),
    entry(Command::Show(DisplayMode::Picture), "Show the picture", NONE, Key::F5),
    entry(Command::Show(DisplayMode::Samples), "Show the samples", NONE, Key::F6),
    entry(Command::Show(DisplayMode::Measured), "Show what is measured", NONE, Key::F7),
    entry(Command::Show(DisplayMode::Density), "Show the density", NONE, Key::F8),
    entry(Command::Show(DisplayMode::Difference), "Show the difference", NONE, Key::F9),
    entry(Command::ToggleMarks, "Box, axes and scales", NONE, Key::B),
    entry(Command::ToggleSlices, "Slices", NONE, Key::F4),
    entry(Command::ToggleRuler, "Ruler", NONE, Key::M),
    entry(Command::ClearRulers, "Clear rulers", SHIFT, Key::M),
    entry(Command::ToggleTheme, "Light or dark", NONE, Key::F10),
];

/// Entries of the menu *Help*.
pub const HELP: &[Entry] = &[entry(Command::Help, "Keys and mouse", NONE, Key::F1)];

/// Entries of all menus.
pub fn all() -> impl Iterator<Item = &'static Entry> {
    [FILE, EDIT, VIEW, HELP].into_iter().flatten()
}

/// Mouse gestures and keys that are not commands, with their descriptions.
pub const GESTURES: &[(&str, &str)] = &[
    ("Drag", "Turn the view"),
    ("Shift + drag, or middle button", "Move the view"),
    ("Wheel or pinch", "Nearer and farther"),
    ("W A S D, Q E", "Fly forward, left, back, right, down, up; faster with Shift"),
    ("L + drag", "Turn the light"),
    ("Double click", "Reset the view"),
    ("Drag in a slice", "Move the crosshair, or measure with the ruler"),
    ("Right button in a slice", "Window (sideways) and level (up and down); double click resets"),
    ("Wheel in a slice", "Next slices"),
    ("Drop a file", "Open it"),
    ("Pointer", "Where you look: sampled most densely"),
];

/// Commands whose shortcuts were pressed.
pub fn pressed(context: &Context) -> Vec<Command> {
    if context.text_edit_focused() {
        return Vec::new();
    }
    let mut commands: Vec<&Entry> = all().collect();
    // Shortcuts with Shift are tried first: Ctrl + Shift + S must not trigger Ctrl + S.
    commands.sort_by_key(|entry| !entry.shortcut.is_some_and(|keys| keys.modifiers.shift));
    context.input_mut(|input| {
        let asked = commands.iter().filter(|entry| {
            entry.shortcut.is_some_and(|keys| {
                // Plain keys must not react to combinations with modifiers.
                (keys.modifiers != NONE || !input.modifiers.any()) && input.consume_shortcut(&keys)
            })
        });
        asked.map(|entry| entry.command).collect()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_two_commands_share_a_key() {
        let entries: Vec<&Entry> = all().collect();
        for (i, a) in entries.iter().enumerate() {
            for b in &entries[i + 1..] {
                assert_ne!(a.shortcut, b.shortcut, "{} and {}", a.name, b.name);
                assert_ne!(a.command, b.command, "{} and {}", a.name, b.name);
            }
        }
    }
}
