//! The view: camera, style, task, dialogs. Undo does not change it.

use super::report::{ReportFile, ReportView};
use crate::fill::LoopLimits;
use crate::mesh::{DVec3, LoopId};
use crate::refine::{Method, RefineControls};
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

/// What Enter does with the selection.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Task {
    /// A patch for each loop.
    #[default]
    Fill,
    /// One surface that joins all loops.
    Blend,
    /// Selected faces are erased and refilled, or faired.
    Repair,
    /// Every triangle is split into four, on a smooth surface through the given vertices.
    Refine,
}

/// A bridge whose ends the user is clicking.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bridging {
    /// The first end, once it was clicked.
    pub from: Option<DVec3>,
    /// Width in rim edges.
    pub width: usize,
}

/// What the mouse does to the selection of faces.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Tool {
    /// Paints.
    #[default]
    Brush,
    /// Selects the faces within a drawn line.
    Lasso,
    /// A click selects a face; further clicks widen the selection there.
    Grow,
}

/// How the mesh is refined.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Refining {
    /// Options. Only levels, method, vertices to interpolate, boundaries and creases are those of
    /// the refinement; the others follow the controls of the document, the energy if it is not
    /// `None`.
    pub controls: RefineControls,
    /// Whether the edges chosen for the report stay sharp.
    pub chosen_edges: bool,
    /// Whether the rim of the selected faces stays sharp.
    pub selection_rim: bool,
    /// Only the selected faces.
    pub selected_only: bool,
    /// Methods to compare with.
    pub beside: [Option<Method>; 2],
}

/// How faces are selected.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Selecting {
    /// The tool.
    pub tool: Tool,
    /// Radius of the brush, in points of the screen.
    pub brush: f32,
    /// Whether the lasso selects hidden faces too.
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
    /// Recovery files of an earlier session were found.
    Recover(Vec<std::path::PathBuf>),
    /// Settings of a picture.
    Picture(PictureSettings),
}

/// What a path is used for.
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
    /// What it is used for.
    pub purpose: PathUse,
    /// As typed so far.
    pub text: String,
}

/// The action that unsaved changes interrupted.
#[derive(Clone, Debug, PartialEq)]
pub enum AfterUnsaved {
    /// Close the window.
    Close,
    /// Open another file.
    Open(std::path::PathBuf),
    /// Open a sample.
    Sample(String),
    /// Choose a file to open.
    AskOpen,
}

/// What a picture shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PictureKind {
    /// One picture of the viewport.
    Still,
    /// A full turn around the pivot.
    Turntable,
    /// The stored states of the run.
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
    /// What it shows.
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
    /// Pictures per second.
    pub fps: f64,
    /// Path of the file.
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

/// The view.
#[derive(Clone, Debug)]
pub struct ViewState {
    /// The camera; all sides of a comparison share it.
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
    /// Limits of the holes that are selected together.
    pub limits: LoopLimits,
    /// Limit surface instead of control mesh.
    pub limit_surface: bool,
    /// Whether the opened mesh is shown, or the patches alone.
    pub show_original: bool,
    /// Whether rims are outlined.
    pub show_rims: bool,
    /// Loop under the cursor, in the view or in the list.
    pub hover: Option<LoopId>,
    /// Text of the energy as typed; it may be invalid.
    pub energy_text: String,
    /// Energy of the second side of a comparison; `None` without comparison.
    pub compare_energy: Option<String>,
    /// States of the flow per second.
    pub pace: f64,
    /// What the report measures and shows.
    pub report: ReportView,
    /// The dialog.
    pub modal: Modal,
    /// Side windows.
    pub windows: Windows,
    /// Whether to fit everything into the next frame, whose size is not known yet.
    pub fit: bool,
    /// Size of the viewport at the last frame, physical pixels.
    pub viewport_px: [f64; 2],
}

impl ViewState {
    /// The default view of a box.
    pub fn new(bounds: &crate::render::Bounds, style: ViewStyle) -> Self {
        Self {
            camera: Camera::fit(bounds),
            style,
            task: Task::default(),
            bridging: None,
            selecting: Selecting::default(),
            refining: Refining::default(),
            limits: LoopLimits::default(),
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
