//! All actions of the window, as values.

use std::path::PathBuf;

use super::faces::FaceEdit;
use super::report::ReportAction;
use super::view_state::{
    Bridging, LoopList, Modal, Navigation, Part, PathUse, PictureSettings, Refining, Selecting,
    Task,
};
use crate::fill::{Controls, LoopLimits};
use crate::mesh::{DVec3, LoopId};
use crate::render::{Camera, StandardView, ViewMode, ViewStyle};

/// An action.
#[derive(Clone, Debug, PartialEq)]
pub enum Action {
    /// Opening, saving, closing.
    File(FileAction),
    /// Undo, and changes of the mesh without a flow.
    Edit(EditAction),
    /// The selection.
    Select(SelectAction),
    /// The task and its settings.
    Task(TaskAction),
    /// Energy and controls.
    Controls(ControlsAction),
    /// The run.
    Run(RunAction),
    /// Camera, style, appearance.
    View(ViewAction),
    /// Measures of the surface.
    Report(ReportAction),
    /// Pictures.
    Picture(PictureAction),
    /// Close the topmost dialog or tool, else cancel what is made in the background, else stop the run, else
    /// clear the selection.
    Escape,
    /// Open, change or close the dialog.
    Modal(Modal),
    /// Close a toast.
    DismissToast(usize),
}

macro_rules! from_kinds {
    ($($variant:ident($kind:ident)),+) => {
        $(impl From<$kind> for Action {
            fn from(action: $kind) -> Self {
                Self::$variant(action)
            }
        })+
    };
}

from_kinds!(
    File(FileAction),
    Edit(EditAction),
    Select(SelectAction),
    Task(TaskAction),
    Controls(ControlsAction),
    Run(RunAction),
    View(ViewAction),
    Report(ReportAction),
    Picture(PictureAction),
    Modal(Modal)
);

/// Opening, saving, closing.
#[derive(Clone, Debug, PartialEq)]
pub enum FileAction {
    /// Choose a file to open.
    AskOpen,
    /// Open a mesh or project.
    Open(PathBuf),
    /// Open a sample.
    Sample(String),
    /// Save to the last path, or ask for one.
    Save,
    /// Choose where to save.
    AskSaveAs,
    /// Save the mesh, or the project if the path has its extension.
    SaveAs(PathBuf),
    /// Use a path that was typed for this purpose; before a file is replaced, ask.
    UsePath(PathUse, PathBuf),
    /// Choose where to write the patches.
    AskExportPatch,
    /// Write only the patches.
    ExportPatch(PathBuf),
    /// Close the window, after asking about unsaved changes.
    Close,
    /// Continue the action that unsaved changes interrupted, without saving.
    DiscardAndContinue,
    /// Save, then continue the interrupted action.
    SaveAndContinue,
    /// Open a recovery file.
    Recover(PathBuf),
    /// Delete the offered recovery files.
    DropRecovery,
    /// Copy the command that repeats the work.
    CopyCommand,
}

/// Undo, and changes of the mesh without a flow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum EditAction {
    /// Undo; during a run, first accept the shown state.
    Undo,
    /// Redo.
    Redo,
    /// Erase the selected faces.
    Erase,
    /// Flip the component of a loop.
    Flip(LoopId),
    /// Build a bridge between two rim vertices, this many edges wide.
    Bridge([DVec3; 2], usize),
    /// Remove loose parts.
    Clean,
    /// Join boundary edges that coincide.
    Stitch,
    /// Remove loose parts, replace damaged faces and fill all holes, in the background.
    Repair,
    /// Cancel the repair.
    CancelRepair,
}

/// How a click changes the selection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SelectHow {
    /// Select only this loop.
    Replace,
    /// Add this loop.
    Add,
    /// Toggle this loop.
    Toggle,
}

/// The selection of loops and faces.
#[derive(Clone, Debug, PartialEq)]
pub enum SelectAction {
    /// Click on a loop.
    Loop(LoopId, SelectHow),
    /// Add these loops.
    Several(Vec<LoopId>),
    /// Add all loops of the same kind and about the same size.
    Similar(LoopId),
    /// All loops that are not classified as outer boundaries.
    All,
    /// All loops but the largest.
    AllButLargest,
    /// Nothing: no loop, or no face in the tasks that work on faces.
    None,
    /// Change the selection of faces.
    Faces(FaceEdit),
}

/// The task and its settings.
#[derive(Clone, Debug, PartialEq)]
pub enum TaskAction {
    /// Fill, blend, repair or refine.
    Choose(Task),
    /// How faces are selected.
    Selecting(Selecting),
    /// How the mesh is refined.
    Refining(Box<Refining>),
    /// Limits of the holes that are selected together.
    Limits(LoopLimits),
    /// Whether patches join the rims of islands.
    Islands(bool),
    /// Order and content of the list of loops.
    List(LoopList),
    /// Start, change or cancel a bridge.
    Bridging(Option<Bridging>),
    /// Start, change or cancel the choice of a part of a hole.
    Part(Option<Part>),
}

/// Energy and controls.
#[derive(Clone, Debug, PartialEq)]
pub enum ControlsAction {
    /// Set the controls, also of the current run.
    Set(Box<Controls>),
    /// A slider was released, so the next change is a new undo entry.
    EndDrag,
    /// Energy text as typed.
    EnergyText(String),
    /// Use the typed energy.
    ApplyEnergy,
    /// Set a parameter of the typed energy.
    AddParameter(String),
    /// Compare with another energy, or stop comparing.
    CompareEnergy(Option<String>),
    /// Set a parameter of that energy, also in the current run.
    CompareParameter(String, f64),
}

/// The run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RunAction {
    /// Start the task; accept a finished run.
    Proceed,
    /// Start the task: fill the selected holes, blend the rims, refill the selected faces, refine.
    Start,
    /// Start a refinement of any size.
    StartLarge,
    /// Fair the selected faces: keep their triangles, move their inner vertices.
    Fair,
    /// Play or pause.
    PlayPause,
    /// Take one step.
    Step,
    /// Go back by one stored state.
    StepBack,
    /// Jump to the converged shape.
    Finish,
    /// End the flow here.
    Stop,
    /// Show a stored state; `None` for the newest.
    Scrub(Option<usize>),
    /// Continue the flow from the state that is shown.
    ContinueFromShown,
    /// Set the number of states per second.
    Pace(f64),
    /// Accept the shown state of a variant.
    Accept(usize),
    /// Discard the run.
    Reject,
}

/// A switch of the view.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Switch {
    /// Limit surface or control mesh.
    LimitSurface,
    /// The opened mesh on or off.
    Original,
    /// Rims on or off.
    Rims,
    /// Wireframe on or off.
    Wireframe,
    /// Patch tint on or off.
    Tint,
    /// Perspective or parallel projection.
    Projection,
    /// Whether z points up instead of y.
    ZUp,
    /// The grid on the ground.
    Grid,
    /// The load report.
    Report,
    /// The log.
    Log,
    /// The shortcut sheet.
    Help,
    /// Frame times.
    Diagnostics,
    /// Settings.
    Settings,
    /// Measures of the surface.
    Analysis,
    /// The left panel: task and loops.
    LeftPanel,
    /// The right panel: controls or report.
    RightPanel,
    /// Numbers and plots of the run.
    Details,
}

/// Camera, style, appearance.
#[derive(Clone, Debug, PartialEq)]
pub enum ViewAction {
    /// The cursor is over these loops, in the view or in a list.
    Hover(Vec<LoopId>),
    /// Another camera.
    Camera(Camera),
    /// A standard view.
    Standard(StandardView),
    /// Fit the whole model.
    FitAll,
    /// Move the camera to a loop.
    FlyToLoop(LoopId),
    /// Another style.
    Style(ViewStyle),
    /// A view mode.
    Mode(ViewMode),
    /// The next view mode.
    NextMode,
    /// The view mode before.
    PreviousMode,
    /// More stripes.
    MoreStripes,
    /// Fewer stripes.
    FewerStripes,
    /// Flip a switch.
    Toggle(Switch),
    /// Navigation preset.
    Navigation(Navigation),
    /// Dark or light.
    Dark(bool),
    /// Scale of the interface.
    UiScale(f32),
}

/// Pictures.
#[derive(Clone, Debug, PartialEq)]
pub enum PictureAction {
    /// Open the picture dialog.
    Ask,
    /// Choose the file in the dialog of the system.
    Browse,
    /// Write a picture or a sequence; before a file is replaced, ask.
    Make(Box<PictureSettings>),
    /// Picture of the views to the clipboard, as they are shown.
    Copy,
    /// One picture to the clipboard.
    CopyAs(Box<PictureSettings>),
    /// Picture of the whole window.
    Window,
    /// Stop writing pictures.
    Cancel,
}
