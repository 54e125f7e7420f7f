//! The view: camera, style, task, dialogs. Undo does not change it.

use std::collections::BTreeMap;

use super::action::Action;
use super::report::{ReportFile, ReportView};
use crate::fill::LoopLimits;
use crate::mesh::{BoundaryLoop, DVec3, LoopId};
use crate::refine::{Method, RefineControls, RefineEstimate};
use crate::render::{Camera, SequenceFormat, ViewStyle, bar_length};

/// The mouse controls of the camera.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Navigation {
    /// Left drag rotates, middle or Ctrl+left drag pans, wheel zooms.
    #[default]
    MeshLab,
    /// Middle drag rotates, Shift+middle pans, Ctrl+middle and wheel zoom.
    Blender,
    /// Middle drag rotates, right or Ctrl+middle drag pans, wheel zooms.
    Cad,
    /// Two fingers rotate, with Shift they pan, with Ctrl or a pinch they zoom; left drag rotates.
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

    /// A description of the mouse controls.
    pub fn about(self) -> &'static str {
        match self {
            Self::MeshLab => "left drag rotates, middle (or Ctrl+left) drag pans, wheel zooms",
            Self::Blender => "middle drag rotates, with Shift pans, with Ctrl zooms; wheel zooms",
            Self::Cad => "middle drag rotates, right (or Ctrl+middle) drag pans, wheel zooms",
            Self::Trackpad => {
                "two fingers rotate, with Shift pan, pinch or Ctrl zooms; left drag rotates"
            }
        }
    }
}

/// The task for the selection, started by Enter.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Task {
    /// Fill each loop with a patch.
    #[default]
    Fill,
    /// Join all loops by one patch.
    Blend,
    /// Erase and refill the selected faces, or fair them.
    Repair,
    /// Split every triangle into four on a smooth surface through the input vertices.
    Refine,
}

/// A bridge under construction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bridging {
    /// The first end, once it was clicked.
    pub from: Option<DVec3>,
    /// Width in rim edges.
    pub width: usize,
}

/// The part of a hole to fill: the ends on its rim, as far as they were clicked.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Part {
    /// The rim vertex where it begins.
    pub from: Option<DVec3>,
    /// The rim vertex where it ends.
    pub to: Option<DVec3>,
}

impl Part {
    /// The part after a click on a rim vertex: its end, or where another part begins.
    #[must_use]
    pub fn with(self, vertex: DVec3) -> Self {
        match self {
            Self {
                from: Some(from),
                to: None,
            } if from != vertex => Self {
                from: Some(from),
                to: Some(vertex),
            },
            _ => Self {
                from: Some(vertex),
                to: None,
            },
        }
    }
}

/// The tool that changes the selection of faces.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Tool {
    /// Paints a selection.
    #[default]
    Brush,
    /// Selects the faces inside a drawn line.
    Lasso,
    /// Selects the clicked face. Further clicks grow the selection there.
    Grow,
}

/// How the mesh is refined.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Refining {
    /// Options. Levels, method, vertices to interpolate, boundaries and creases are those of the
    /// refinement. The other options follow the controls of the document; so does the energy unless
    /// it is `None`.
    pub controls: RefineControls,
    /// Whether the edges chosen for the report stay sharp.
    pub chosen_edges: bool,
    /// Whether the rim of the selected faces stays sharp.
    pub selection_rim: bool,
    /// Whether only the selected faces are refined.
    pub selected_only: bool,
    /// Methods to compare with.
    pub beside: [Option<Method>; 2],
}

/// How faces are selected.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Selecting {
    /// The tool.
    pub tool: Tool,
    /// Radius of the brush in screen points.
    pub brush: f32,
    /// Whether the lasso selects hidden faces too.
    pub through: bool,
    /// Faces with a smaller angle are selected, in degrees.
    pub worse_than: f64,
    /// Faces with a longer edge are selected, in units of the file.
    pub longer_than: f64,
}

impl Refining {
    /// What the refinement of a mesh will take, with the methods to compare with.
    pub fn estimate(&self, all: usize, selected: usize) -> RefineEstimate {
        let refined = if self.selected_only { selected } else { all };
        let beside = self.beside.iter().flatten().copied();
        let methods = [self.controls.method].into_iter().chain(beside);
        let each = methods.map(|method| {
            let controls = RefineControls {
                method,
                ..self.controls.clone()
            };
            controls.estimate(refined, all)
        });
        // they run at the same time
        let sum = |a: RefineEstimate, b: RefineEstimate| RefineEstimate {
            bytes: a.bytes + b.bytes,
            seconds: a.seconds + b.seconds,
            is_measured: a.is_measured && b.is_measured,
        };
        each.reduce(sum).unwrap_or_default()
    }

    /// Number of faces after the refinement of a mesh, without those that are split to match.
    pub fn faces_after(&self, all: usize, selected: usize) -> u64 {
        let (refined, others) = if self.selected_only {
            (selected, all - selected.min(all))
        } else {
            (all, 0)
        };
        let each = 1u64 << (2 * self.controls.levels.min(24));
        (refined as u64).saturating_mul(each) + others as u64
    }
}

impl Default for Selecting {
    fn default() -> Self {
        Self {
            tool: Tool::default(),
            brush: 24.0,
            through: false,
            worse_than: 5.0,
            longer_than: 0.0,
        }
    }
}

/// The open dialog. At most one is open.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Modal {
    /// No dialog.
    #[default]
    None,
    /// Asks for a path to open or to write.
    Path(PathPrompt),
    /// Asks whether to replace a file.
    Replace(Box<Replacing>),
    /// Asks about unsaved changes: save, discard or cancel.
    Unsaved(AfterUnsaved),
    /// Offers the recovery files of an earlier session.
    Recover(Vec<std::path::PathBuf>),
    /// Settings of a picture.
    Picture(PictureSettings),
    /// Asks whether to start a refinement to this many faces.
    Large(u64, RefineEstimate),
}

/// The purpose of a path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PathUse {
    /// A mesh or project to open.
    Open,
    /// The file to save the mesh or project to.
    SaveAs,
    /// The file to write only the patches to.
    ExportPatch,
    /// The reference mesh of distances.
    Reference,
    /// The file to write the report to.
    Report(ReportFile),
}

/// A typed path.
#[derive(Clone, Debug, PartialEq)]
pub struct PathPrompt {
    /// The purpose.
    pub purpose: PathUse,
    /// The text typed so far.
    pub text: String,
}

/// The question whether to replace a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Replacing {
    /// The file.
    pub path: std::path::PathBuf,
    /// The action that writes it.
    pub writing: Action,
    /// The dialog in which it was named, which is open again if the file is kept.
    pub named_in: Modal,
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

/// The content of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PictureKind {
    /// One picture of the viewport.
    Still,
    /// A full turn around the pivot.
    Turntable,
    /// The stored states of the run.
    Flow,
}

/// Settings of a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct PictureSettings {
    /// The content.
    pub kind: PictureKind,
    /// The file format.
    pub format: SequenceFormat,
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Whether the background is transparent.
    pub transparent: bool,
    /// Whether rims and selection are drawn.
    pub overlays: bool,
    /// Whether a map has its legend.
    pub legend: bool,
    /// Whether all sides of a comparison are drawn, or only the first.
    pub all_sides: bool,
    /// The text below the views; none if it is empty.
    pub caption: String,
    /// Number of pictures of a turntable.
    pub frames: usize,
    /// Number of states of the run that are drawn, evenly spaced; 0 for all.
    pub states: usize,
    /// Pictures per second.
    pub fps: f64,
    /// Path of the file.
    pub path: String,
}

impl Default for PictureSettings {
    fn default() -> Self {
        Self {
            kind: PictureKind::Still,
            format: SequenceFormat::Png,
            width: 1920,
            height: 1200,
            transparent: false,
            overlays: false,
            legend: true,
            all_sides: true,
            caption: String::new(),
            frames: 72,
            states: 0,
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

impl Windows {
    /// Closes one of the windows over the view, if one is open.
    pub fn close_one(&mut self) -> bool {
        let all = [
            &mut self.help,
            &mut self.settings,
            &mut self.diagnostics,
            &mut self.log,
            &mut self.report,
        ];
        let open = all.into_iter().find(|is_open| **is_open);
        open.map(|is_open| *is_open = false).is_some()
    }
}

/// A column of the list of loops.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LoopColumn {
    /// Number of the loop.
    #[default]
    Number,
    /// Number of edges.
    Edges,
    /// Perimeter.
    Length,
    /// Diameter.
    Width,
    /// Hole or outer boundary.
    Kind,
}

/// The kind of loops that the list shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LoopKind {
    /// All loops.
    #[default]
    All,
    /// Loops that are not classified as outer boundaries.
    Holes,
    /// Outer boundaries.
    Outer,
}

/// Order and content of the list of loops.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LoopList {
    /// The column that the list is sorted by.
    pub sort: LoopColumn,
    /// Whether the largest comes first.
    pub descending: bool,
    /// The kind of the listed loops.
    pub kind: LoopKind,
    /// Minimum number of edges of the listed loops.
    pub least_edges: usize,
}

impl LoopList {
    /// The listed loops in order.
    pub fn listed<'a>(&self, loops: &'a [BoundaryLoop]) -> Vec<&'a BoundaryLoop> {
        let is_listed = |l: &&BoundaryLoop| {
            let kind = match self.kind {
                LoopKind::All => true,
                LoopKind::Holes => !l.is_outer_boundary,
                LoopKind::Outer => l.is_outer_boundary,
            };
            kind && l.edges() >= self.least_edges
        };
        let mut listed: Vec<&BoundaryLoop> = loops.iter().filter(is_listed).collect();
        listed.sort_by(|a, b| {
            let order = match self.sort {
                LoopColumn::Number => a.id.cmp(&b.id),
                LoopColumn::Edges => a.edges().cmp(&b.edges()),
                LoopColumn::Length => a.perimeter.total_cmp(&b.perimeter),
                LoopColumn::Width => a.diameter.total_cmp(&b.diameter),
                LoopColumn::Kind => a.is_outer_boundary.cmp(&b.is_outer_boundary),
            };
            if self.descending {
                order.reverse()
            } else {
                order
            }
        });
        listed
    }
}

/// The energy of the second side of a comparison.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ComparedEnergy {
    /// The text as typed, which may be invalid.
    pub text: String,
    /// Its parameters, which are independent of those of the first side.
    pub param: BTreeMap<String, f64>,
}

/// The view.
#[derive(Clone, Debug)]
pub struct ViewState {
    /// The camera, shared by all sides of a comparison.
    pub camera: Camera,
    /// The drawing style.
    pub style: ViewStyle,
    /// The task that Enter starts.
    pub task: Task,
    /// The bridge under construction.
    pub bridging: Option<Bridging>,
    /// The part of a hole that is being chosen.
    pub part: Option<Part>,
    /// How faces are selected.
    pub selecting: Selecting,
    /// How the mesh is refined.
    pub refining: Refining,
    /// Limits of the holes that are selected together.
    pub limits: LoopLimits,
    /// Whether patches join the rims of islands, the loose components inside holes.
    pub islands: bool,
    /// Order and content of the list of loops.
    pub list: LoopList,
    /// Whether the limit surface is drawn instead of the control mesh.
    pub limit_surface: bool,
    /// Whether the opened mesh is drawn in addition to the patches.
    pub show_original: bool,
    /// Whether rims are outlined.
    pub show_rims: bool,
    /// Loops under the cursor, in the view or in a list.
    pub hover: Vec<LoopId>,
    /// The typed energy, which may be invalid.
    pub energy_text: String,
    /// Energy of the second side of a comparison; `None` without comparison.
    pub compared: Option<ComparedEnergy>,
    /// States of the flow per second.
    pub pace: f64,
    /// The settings of the report.
    pub report: ReportView,
    /// The dialog.
    pub modal: Modal,
    /// Side windows.
    pub windows: Windows,
    /// Whether to fit the whole model into the view at the next frame, when its size is known.
    pub fit: bool,
    /// Size of the viewport at the last frame in physical pixels.
    pub viewport_px: [f64; 2],
    /// Physical pixels per point of the screen.
    pub pixels_per_point: f64,
    /// Size of the window at the last frame in points.
    pub window: [f32; 2],
}

impl ViewState {
    /// Length of the scale bar, and of the cells of the ground grid: a round number of units of the
    /// file; `None` in a view without size.
    pub fn bar_length(&self) -> Option<f64> {
        bar_length(&self.camera, self.viewport_px, self.pixels_per_point)
    }

    /// Units of the file for each point of the screen, at the depth of the pivot.
    pub fn units_per_point(&self) -> f64 {
        2.0 * self.camera.half_height() * self.pixels_per_point / self.viewport_px[1].max(1.0)
    }

    /// The default view of a bounding box.
    pub fn new(bounds: &crate::render::Bounds, style: ViewStyle) -> Self {
        Self {
            camera: Camera::fit(bounds),
            style,
            task: Task::default(),
            bridging: None,
            part: None,
            selecting: Selecting::default(),
            refining: Refining::default(),
            limits: LoopLimits::default(),
            islands: true,
            list: LoopList::default(),
            limit_surface: true,
            show_original: true,
            show_rims: true,
            hover: Vec::new(),
            energy_text: "H^2".into(),
            compared: None,
            pace: 12.0,
            report: ReportView::default(),
            modal: Modal::None,
            windows: Windows::default(),
            fit: true,
            viewport_px: [1280.0, 800.0],
            pixels_per_point: 1.0,
            window: [1360.0, 860.0],
        }
    }
}
