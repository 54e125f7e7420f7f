//! Settings that persist from session to session, and the folders for them.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::view_state::Navigation;
use crate::io;

/// Length of the list of recent files.
const RECENT: usize = 12;

/// The settings file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Settings {
    /// Dark theme.
    pub dark: bool,
    /// Scale of the interface relative to that of the system.
    pub ui_scale: f32,
    /// Whether z points up instead of y.
    pub z_up: bool,
    /// The mouse controls of the camera.
    pub navigation: Navigation,
    /// Recently opened files, newest first.
    pub recent: Vec<PathBuf>,
    /// Folder of the settings file; `None` (tests) stores nothing.
    #[serde(skip)]
    pub folder: Option<PathBuf>,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            dark: true,
            ui_scale: 1.0,
            z_up: false,
            navigation: Navigation::default(),
            recent: Vec::new(),
            folder: None,
        }
    }
}

/// `$variable/meniscus`, or `~/fallback/meniscus`.
fn base(variable: &str, fallback: &str) -> Option<PathBuf> {
    let set = |name: &str| std::env::var_os(name).filter(|v| !v.is_empty());
    set(variable)
        .map(PathBuf::from)
        .or_else(|| set("HOME").map(|home| Path::new(&home).join(fallback)))
        .map(|folder| folder.join("meniscus"))
}

/// Folder of the recovery files.
pub fn state_folder() -> Option<PathBuf> {
    base("XDG_STATE_HOME", ".local/state")
}

impl Settings {
    /// Reads the settings of the user, or returns the defaults if there are none. A damaged file
    /// gives the defaults and a message.
    pub fn load() -> (Self, Option<String>) {
        let Some(folder) = base("XDG_CONFIG_HOME", ".config") else {
            return (Self::default(), None);
        };
        Self::load_from(&folder)
    }

    /// [`Self::load`] from a given folder.
    pub fn load_from(folder: &Path) -> (Self, Option<String>) {
        let path = folder.join("settings.toml");
        let (mut settings, message) = match std::fs::read_to_string(&path) {
            Ok(text) => match toml::from_str::<Self>(&text) {
                Ok(settings) => (settings, None),
                Err(error) => (
                    Self::default(),
                    Some(format!(
                        "the settings file {} is damaged and was ignored: {}",
                        path.display(),
                        error.message()
                    )),
                ),
            },
            Err(_) => (Self::default(), None),
        };
        if !settings.ui_scale.is_finite() {
            settings.ui_scale = 1.0;
        }
        settings.ui_scale = settings.ui_scale.clamp(0.5, 3.0);
        settings.folder = Some(folder.to_owned());
        (settings, message)
    }

    /// Writes the settings. Errors are ignored, because the settings are not essential.
    pub fn save(&self) {
        let Some(folder) = &self.folder else { return };
        if let Ok(text) = toml::to_string(self)
            && std::fs::create_dir_all(folder).is_ok()
        {
            io::save_text(&folder.join("settings.toml"), &text).ok();
        }
    }

    /// Moves a file to the front of the list of recent files.
    pub fn remember(&mut self, path: &Path) {
        let path = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
        self.recent.retain(|p| *p != path);
        self.recent.insert(0, path);
        self.recent.truncate(RECENT);
        self.save();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settings_are_restored_and_damage_is_reported() {
        let folder = tempfile::tempdir().expect("a folder");
        let (mut settings, message) = Settings::load_from(folder.path());
        assert_eq!((settings.recent.len(), message), (0, None));
        settings.dark = false;
        settings.navigation = Navigation::Blender;
        for i in 0..20 {
            settings.remember(Path::new(&format!("/meshes/{i}.obj")));
        }
        settings.remember(Path::new("/meshes/15.obj"));
        let (again, message) = Settings::load_from(folder.path());
        assert_eq!((&again, message), (&settings, None));
        assert_eq!(again.recent.len(), RECENT);
        assert_eq!(again.recent[0], Path::new("/meshes/15.obj"));

        std::fs::write(folder.path().join("settings.toml"), "dark = perhaps").expect("written");
        let (defaults, message) = Settings::load_from(folder.path());
        assert!(defaults.dark && message.is_some_and(|m| m.contains("damaged")));
    }
}
