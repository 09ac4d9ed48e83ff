//! Persistent state of the viewer: recent files and preferences.

use crate::session::autosave::Autosaves;
use fovolnet::io::atomic;
use fovolnet::{Error, Result};
use serde::{Deserialize, Serialize};
use std::io::Write;
use std::path::{Path, PathBuf};

/// Most recent files remembered.
const RECENT: usize = 10;

/// Folder of the persistent state.
#[derive(Debug, Clone)]
pub struct Places {
    folder: Option<PathBuf>,
}

/// Preferences of the user.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, rename_all = "kebab-case")]
pub struct Preferences {
    /// Recent volumes and sessions, latest first.
    pub recent: Vec<String>,
    /// Frame rate to keep in motion; 0 disables the frame budget.
    pub rate: f64,
    /// Whether still views are refined to full frames.
    pub converges: bool,
    /// Whether box, axes and scales are drawn.
    pub marks: bool,
    /// Whether slices are shown beside the picture.
    pub slices: bool,
    /// Whether the theme is dark.
    pub dark: bool,
}

impl Default for Preferences {
    fn default() -> Self {
        Self { recent: Vec::new(), rate: 12.0, converges: true, marks: true, slices: false, dark: true }
    }
}

impl Preferences {
    /// Moves `source` to the front of the recent files.
    pub fn remember(&mut self, source: &str) {
        self.recent.retain(|known| known != source);
        self.recent.insert(0, source.to_owned());
        self.recent.truncate(RECENT);
    }
}

impl Places {
    /// Folder of this user: `FOVOLNET_STATE`, or the system's folder for application state.
    pub fn of_user() -> Self {
        let home = || std::env::var_os("HOME").map(PathBuf::from);
        let folder = match std::env::var_os("FOVOLNET_STATE") {
            Some(folder) => Some(folder.into()),
            None if cfg!(target_os = "windows") => {
                std::env::var_os("LOCALAPPDATA").map(|folder| Path::new(&folder).join("fovolnet"))
            }
            None if cfg!(target_os = "macos") => {
                home().map(|home| home.join("Library/Application Support/fovolnet"))
            }
            None => std::env::var_os("XDG_STATE_HOME")
                .map(PathBuf::from)
                .or_else(|| home().map(|home| home.join(".local/state")))
                .map(|folder| folder.join("fovolnet")),
        };
        Self { folder }
    }

    /// State in `folder`; without a folder, nothing is remembered.
    pub fn in_folder(folder: Option<PathBuf>) -> Self {
        Self { folder }
    }

    /// Stored preferences, or the defaults if they are missing or unreadable.
    pub fn preferences(&self) -> Preferences {
        self.file("viewer.toml")
            .and_then(|file| std::fs::read_to_string(file).ok())
            .and_then(|text| toml::from_str(&text).ok())
            .unwrap_or_default()
    }

    /// Stores `preferences`.
    ///
    /// # Errors
    /// Errors of the file system.
    pub fn set_preferences(&self, preferences: &Preferences) -> Result<()> {
        let text = toml::to_string(preferences)
            .map_err(|e| Error::Setting(format!("the preferences cannot be written: {e}")))?;
        self.write("viewer.toml", &text)
    }

    /// Autosaves in this folder.
    pub fn autosaves(&self) -> Autosaves {
        Autosaves::in_folder(self.folder.clone())
    }

    fn file(&self, name: &str) -> Option<PathBuf> {
        self.folder.as_ref().map(|folder| folder.join(name))
    }

    fn write(&self, name: &str, text: &str) -> Result<()> {
        let Some(folder) = &self.folder else { return Ok(()) };
        atomic::make_folder(folder)?;
        atomic::write(&folder.join(name), |out| out.write_all(text.as_bytes()))?;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tastes_and_files_are_remembered() {
        let folder = tempfile::tempdir().unwrap();
        let places = Places::in_folder(Some(folder.path().join("new")));
        let mut preferences = places.preferences();
        assert_eq!(preferences, Preferences::default());
        for source in ["a", "b", "a"] {
            preferences.remember(source);
        }
        preferences.rate = 30.0;
        places.set_preferences(&preferences).unwrap();
        assert_eq!(places.preferences(), preferences);
        assert_eq!(preferences.recent, ["a", "b"]);
        for i in 0..30 {
            preferences.remember(&i.to_string());
        }
        assert_eq!(preferences.recent.len(), RECENT);
        std::fs::write(folder.path().join("new/viewer.toml"), "rate = \"often\"").unwrap();
        assert_eq!(places.preferences(), Preferences::default());
    }
}
