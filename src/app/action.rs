//! Everything a person can ask of the window, as values.

use std::path::PathBuf;

use super::faces::FaceEdit;
use super::report::ReportAction;
use super::view_state::{Bridging, Modal, Navigation, PictureSettings, Refining, Selecting, Task};
use crate::fill::Controls;
use crate::mesh::{DVec3, LoopId};
use crate::render::{Camera, ViewStyle};

/// How a click changes the selection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SelectHow {
    /// Only this loop.
    Replace,
    /// This loop too.
    Add,
    /// This loop in or out.
    Toggle,
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
}

/// A request.
#[derive(Clone, Debug)]
pub enum Action {
    /// Choose a file to open.
    AskOpen,
    /// Open a mesh or project.
    Open(PathBuf),
    /// Open a sample.
    Sample(String),
    /// Save to where it was saved last, or ask.
    Save,
    /// Choose where to save.
    AskSaveAs,
    /// Save the mesh, or the project if the path says so.
    SaveAs(PathBuf),
    /// Choose where to write the patches.
    AskExportPatch,
    /// Write the patches alone.
    ExportPatch(PathBuf),
    /// Close the window, after asking about unsaved changes.
    Close,
    /// Go on with what unsaved changes held up, without saving.
    Discard,
    /// Save, then go on.
    SaveThenGoOn,
    /// Open a recovery file.
    Recover(PathBuf),
    /// Delete the recovery files offered.
    DropRecovery,

    /// Click on a loop.
    Select(LoopId, SelectHow),
    /// All loops that are no outer rims.
    SelectAll,
    /// All loops but the largest.
    SelectAllButLargest,
    /// None.
    SelectNone,
    /// Fill, blend or repair.
    Task(Task),
    /// How faces are selected.
    Selecting(Selecting),
    /// How the mesh is refined.
    Refining(Box<Refining>),
    /// Change the selection of faces.
    Faces(FaceEdit),
    /// Let the selected faces flow as they are.
    Fair,
    /// Erase the selected faces.
    Erase,
    /// Turn over the component of a loop.
    Flip(LoopId),
    /// Begin a bridge, change it, or leave it.
    Bridging(Option<Bridging>),
    /// Build a bridge between two rim vertices, so many edges wide.
    Bridge([DVec3; 2], usize),
    /// The cursor is over a loop.
    Hover(Option<LoopId>),

    /// Set the controls; acts on the run, if there is one.
    Controls(Box<Controls>),
    /// A slider was let go: the next change is an undo entry of its own.
    Settle,
    /// Energy text as typed.
    EnergyText(String),
    /// Take the typed energy.
    ApplyEnergy,
    /// Give a name of the typed energy a value.
    AddParameter(String),
    /// Compare with another energy (or stop comparing).
    CompareEnergy(Option<String>),

    /// Do the task: fill the selected holes, blend the rims, refill the selected faces.
    Fill,
    /// Play or pause.
    PlayPause,
    /// One step.
    Step,
    /// Jump to the converged shape.
    Finish,
    /// End the flow here.
    Stop,
    /// Show a kept state; `None` for the newest.
    Scrub(Option<usize>),
    /// Go on from the state that is shown.
    GoOnFromHere,
    /// States a second.
    Pace(f64),
    /// Take the patch in; the side of a comparison.
    Accept(usize),
    /// Drop the run.
    Reject,
    /// Esc: close, cancel or clear, whichever is first.
    Escape,

    /// Undo.
    Undo,
    /// Redo.
    Redo,

    /// Look from elsewhere.
    Camera(Camera),
    /// Look at everything.
    FitAll,
    /// Look at a loop.
    FlyToLoop(LoopId),
    /// Look at a place.
    FlyTo(DVec3),
    /// Draw differently.
    Style(ViewStyle),
    /// Flip a switch.
    Toggle(Switch),
    /// Navigation preset.
    Navigation(Navigation),
    /// Dark or light.
    Dark(bool),
    /// Scale of the interface.
    UiScale(f32),

    /// Something of the report.
    Report(ReportAction),

    /// Close a toast.
    DismissToast(usize),
    /// Open or change the dialog.
    Modal(Modal),
    /// Make a picture, or a sequence.
    Picture(Box<PictureSettings>),
    /// Picture of the viewport to the clipboard.
    CopyPicture,
    /// Picture of the whole window.
    WindowPicture,
    /// The command that repeats the work, to the clipboard.
    CopyCommand,
    /// Stop the sequence that is being written.
    CancelPicture,
}
