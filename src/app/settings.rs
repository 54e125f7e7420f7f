//! Settings that persist from session to session, and the folders for them.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::view_state::Navigation;
use crate::io;
use crate::render::{Material, ViewMode};

/// Length of the list of recent files.
const RECENT: usize = 12;

/// Size of the window and of its panels in points, and which panels are open.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Layout {
    /// Size of the window.
    pub window: [f32; 2],
    /// Whether the left panel is open.
    pub left: bool,
    /// Whether the right panel is open.
    pub right: bool,
    /// Whether numbers and plots of the run are open; `None` opens them in a high window.
    pub details: Option<bool>,
    /// Width of the left panel that the user chose.
    pub left_width: Option<f32>,
    /// Width of the right panel that the user chose.
    pub right_width: Option<f32>,
    /// Height of the bottom panel with numbers and plots.
    pub bottom_height: Option<f32>,
}

impl Default for Layout {
    fn default() -> Self {
        Self {
            window: [1360.0, 860.0],
            left: true,
            right: true,
            details: None,
            left_width: None,
            right_width: None,
            bottom_height: None,
        }
    }
}

/// Height of the window from which numbers and plots are open by default.
const HIGH: f32 = 720.0;

impl Layout {
    /// Whether numbers and plots are open in a window of this height.
    pub fn shows_details(&self, height: f32) -> bool {
        self.details.unwrap_or(height >= HIGH)
    }
}

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
    /// The last view mode that was chosen; `None` before the first choice.
    pub view_mode: Option<ViewMode>,
    /// The material of shaded surfaces.
    pub material: Material,
    /// Whether the ground grid is drawn.
    pub grid: bool,
    /// Sizes and panels of the window.
    pub layout: Layout,
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
            view_mode: None,
            material: Material::default(),
            grid: false,
            layout: Layout::default(),
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
        if !settings
            .layout
            .window
            .iter()
            .all(|x| (100.0..1e5).contains(x))
        {
            settings.layout.window = Layout::default().window;
        }
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
        settings.view_mode = Some(ViewMode::Zebra);
        (settings.material, settings.grid) = (Material::Steel, true);
        settings.layout.window = [900.0, 600.0];
        settings.layout.details = Some(false);
        settings.layout.left_width = Some(240.0);
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
