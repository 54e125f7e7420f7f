//! What is looked at and how; never saved as work, never undone.

use super::report::{ReportFile, ReportView};
use crate::mesh::{DVec3, LoopId};
use crate::refine::{BoundaryRule, Hold, Method};
use crate::render::{Camera, ViewStyle};

/// How the mouse moves the camera.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Navigation {
    /// Left drag turns, middle or Ctrl+left drag moves, wheel zooms.
    #[default]
    MeshLab,
    /// Middle drag turns, Shift+middle moves, Ctrl+middle and wheel zoom.
    Blender,
    /// Middle drag turns, right or Ctrl+middle drag moves, wheel zooms.
    Cad,
    /// Two fingers turn, with Shift they move, with Ctrl or a pinch they zoom; left drag turns.
    Trackpad,
}

impl Navigation {
    /// All presets.
    pub const ALL: [Self; 4] = [Self::MeshLab, Self::Blender, Self::Cad, Self::Trackpad];

    /// Name in the menu.
    pub fn title(self) -> &'static str {
        match self {
            Self::MeshLab => "MeshLab",
            Self::Blender => "Blender",
            Self::Cad => "CAD",
            Self::Trackpad => "Trackpad",
        }
    }

    /// What the mouse does, in one sentence.
    pub fn about(self) -> &'static str {
        match self {
            Self::MeshLab => "left drag turns, middle (or Ctrl+left) drag moves, wheel zooms",
            Self::Blender => "middle drag turns, with Shift moves, with Ctrl zooms; wheel zooms",
            Self::Cad => "middle drag turns, right (or Ctrl+middle) drag moves, wheel zooms",
            Self::Trackpad => {
                "two fingers turn, with Shift move, pinch or Ctrl zooms; left drag turns"
            }
        }
    }
}

/// What Enter does with what is selected.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Task {
    /// A patch of its own for each.
    #[default]
    Fill,
    /// One surface that joins them all.
    Blend,
    /// Selected faces are erased and filled anew, or faired.
    Repair,
    /// Every triangle becomes four, on a smooth surface through the given vertices.
    Refine,
}

/// A bridge whose ends are being clicked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bridging {
    /// The first end, once it was clicked.
    pub from: Option<DVec3>,
    /// Rim edges it is wide.
    pub width: usize,
}

/// What the mouse does to the selection of faces.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Tool {
    /// Paints.
    #[default]
    Brush,
    /// Takes what is within a drawn line.
    Lasso,
    /// A click takes a place, another widens it.
    Grow,
}

/// How the mesh is refined.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Refining {
    /// Times every triangle becomes four.
    pub levels: usize,
    /// How new vertices are placed.
    pub method: Method,
    /// What later levels keep passing.
    pub hold: Hold,
    /// Boundaries and sharp edges between their vertices.
    pub boundary: BoundaryRule,
    /// Whether edges above an angle stay sharp.
    pub sharp: bool,
    /// The angle, degrees.
    pub sharp_angle: f64,
    /// Whether the edges chosen for the report stay sharp.
    pub chosen_edges: bool,
    /// Whether the rim of the selected faces stays sharp.
    pub selection_rim: bool,
    /// Energy and tension by the edge length of the mesh instead of those of the controls.
    pub own_energy: bool,
    /// Only the selected faces.
    pub selected_only: bool,
    /// Methods shown beside it.
    pub beside: [Option<Method>; 2],
}

impl Default for Refining {
    fn default() -> Self {
        Self {
            levels: 3,
            method: Method::default(),
            hold: Hold::default(),
            boundary: BoundaryRule::default(),
            sharp: false,
            sharp_angle: 40.0,
            chosen_edges: false,
            selection_rim: false,
            own_energy: true,
            selected_only: false,
            beside: [None; 2],
        }
    }
}

/// How faces are selected.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Selecting {
    /// With what.
    pub tool: Tool,
    /// Radius of the brush, in points of the screen.
    pub brush: f32,
    /// Whether the lasso takes hidden faces too.
    pub through: bool,
}

impl Default for Selecting {
    fn default() -> Self {
        Self {
            tool: Tool::default(),
            brush: 24.0,
            through: false,
        }
    }
}

/// A dialog over the window; only one at a time.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Modal {
    /// None.
    #[default]
    None,
    /// Asks for a path to open or to write.
    Path(PathPrompt),
    /// Unsaved changes: save, discard or stay?
    Unsaved(AfterUnsaved),
    /// A recovery file was found.
    Recover(Vec<std::path::PathBuf>),
    /// Settings of a picture.
    Picture(PictureSettings),
}

/// What a path is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PathUse {
    /// A mesh or project to open.
    Open,
    /// Where to save the mesh or project.
    SaveAs,
    /// Where to write the patches alone.
    ExportPatch,
    /// A mesh to measure distances to.
    Reference,
    /// Where to write the report.
    Report(ReportFile),
}

/// A typed path.
#[derive(Clone, Debug, PartialEq)]
pub struct PathPrompt {
    /// What for.
    pub purpose: PathUse,
    /// As typed so far.
    pub text: String,
}

/// What was about to happen when unsaved changes were found.
#[derive(Clone, Debug, PartialEq)]
pub enum AfterUnsaved {
    /// The window was to close.
    Close,
    /// Another file was to be opened.
    Open(std::path::PathBuf),
    /// A sample was to be opened.
    Sample(String),
    /// Files were to be chosen from.
    AskOpen,
}

/// What is to be pictured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PictureKind {
    /// One picture of the viewport.
    Still,
    /// A full turn around the pivot.
    Turntable,
    /// The kept states of the run.
    Flow,
}

/// How a sequence is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PictureFormat {
    /// PNG; sequences are numbered.
    Png,
    /// Animated GIF.
    Gif,
    /// Animated PNG.
    Apng,
}

/// Settings of a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct PictureSettings {
    /// What.
    pub kind: PictureKind,
    /// How it is stored.
    pub format: PictureFormat,
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Without a background.
    pub transparent: bool,
    /// With rims and selection.
    pub overlays: bool,
    /// Pictures of a turntable.
    pub frames: usize,
    /// Pictures a second.
    pub fps: f64,
    /// Where to.
    pub path: String,
}

impl Default for PictureSettings {
    fn default() -> Self {
        Self {
            kind: PictureKind::Still,
            format: PictureFormat::Png,
            width: 1920,
            height: 1200,
            transparent: false,
            overlays: false,
            frames: 72,
            fps: 24.0,
            path: "meniscus.png".into(),
        }
    }
}

/// Side windows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Windows {
    /// The load report.
    pub report: bool,
    /// The log.
    pub log: bool,
    /// The shortcut sheet.
    pub help: bool,
    /// Frame times and memory.
    pub diagnostics: bool,
    /// Theme, scale, navigation.
    pub settings: bool,
    /// Measures of the surface.
    pub analysis: bool,
}

/// All of it.
#[derive(Clone, Debug)]
pub struct ViewState {
    /// Where one looks from; shared by both sides of a comparison.
    pub camera: Camera,
    /// How it is drawn.
    pub style: ViewStyle,
    /// What Enter does.
    pub task: Task,
    /// The bridge that is being made.
    pub bridging: Option<Bridging>,
    /// How faces are selected.
    pub selecting: Selecting,
    /// How the mesh is refined.
    pub refining: Refining,
    /// Limit surface instead of control mesh.
    pub limit_surface: bool,
    /// Whether the opened mesh is shown, or the patches alone.
    pub show_original: bool,
    /// Whether rims are outlined.
    pub show_rims: bool,
    /// Loop under the cursor, in the view or in the list.
    pub hover: Option<LoopId>,
    /// Text of the energy as typed, not always a valid one.
    pub energy_text: String,
    /// Energy of the second side of a comparison; `None` without comparison.
    pub compare_energy: Option<String>,
    /// States of the flow a second.
    pub pace: f64,
    /// What the report measures and shows.
    pub report: ReportView,
    /// The dialog.
    pub modal: Modal,
    /// Side windows.
    pub windows: Windows,
    /// Whether everything is to be fitted into the next frame, whose size is not known yet.
    pub fit: bool,
    /// Size of the viewport at the last frame, physical pixels.
    pub viewport_px: [f64; 2],
}

impl ViewState {
    /// Looks at a box, with the defaults of the window.
    pub fn new(bounds: &crate::render::Bounds, style: ViewStyle) -> Self {
        Self {
            camera: Camera::fit(bounds),
            style,
            task: Task::default(),
            bridging: None,
            selecting: Selecting::default(),
            refining: Refining::default(),
            limit_surface: true,
            show_original: true,
            show_rims: true,
            hover: None,
            energy_text: "H^2".into(),
            compare_energy: None,
            pace: 12.0,
            report: ReportView::default(),
            modal: Modal::None,
            windows: Windows::default(),
            fit: true,
            viewport_px: [1280.0, 800.0],
        }
    }
}
