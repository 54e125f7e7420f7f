//! A refinement as a process: its steps begin a level, attempt a step of the level's flow, or
//! finish the level.
//!
//! [`LiveRefine`] runs it in the background, [`refine`] on the calling thread. The results are
//! bit-identical.

mod state;

use std::sync::Arc;

use crate::mesh::Mesh;
use crate::refine::levels::{Refinement, SavedState};
use crate::refine::{
    LevelReport, RefineControls, RefineError, RefineEvent, RefineOptions, Refined, crease_edges,
};
use crate::runner::{
    Process, Recording, Refused, RunControls, RunSettings, Runner, Snapshot, StartError, Wake,
    replay,
};
use crate::solver::{FASTEST, StepRecord};
pub use state::{LevelFrame, RefineState};

/// A refinement running in the background.
pub type LiveRefine = Runner<RefineProcess>;
/// A stored state of a refinement: 48 bytes a vertex, and the connectivity of each level.
pub type RefineSnapshot = Snapshot<RefineState>;

/// The status of a refinement.
#[derive(Clone, Debug, Default)]
pub struct RefineStatus {
    /// The level in progress or the last finished one; 0 before the first.
    pub level: usize,
    /// Total number of levels.
    pub levels: usize,
    /// Vertices of the mesh.
    pub vertices: usize,
    /// Attempted steps of all levels.
    pub attempts: usize,
    /// Rejected ones.
    pub rejected: usize,
    /// The next time step over the natural time of the mesh; `None` between levels.
    pub relative_tau: Option<f64>,
    /// Residual of the last accepted step of the level.
    pub residual: Option<f64>,
    /// Reports of the finished levels.
    pub reports: Vec<LevelReport>,
}

impl RunControls for RefineControls {
    const FIXED: &'static [&'static str] =
        &["method", "hold", "boundary", "corner-angle", "crease-angle"];
    const FASTEST: &'static [(&'static str, &'static str)] = FASTEST;
    type Error = RefineError;

    fn validate(&self) -> Result<(), RefineError> {
        self.check()
    }
}

impl Runner<RefineProcess> {
    /// Starts the refinement of a mesh, with creases given by the ends of their edges. Refines all
    /// faces or a region (one flag per face). `wake` is called from the background thread whenever
    /// there are events to [poll](Self::poll).
    ///
    /// # Errors
    /// Invalid options, a mesh without triangles, or no thread could be started.
    pub fn spawn(
        mesh: Arc<Mesh>,
        controls: RefineControls,
        creases: Vec<[u32; 2]>,
        region: Option<Vec<bool>>,
        settings: RunSettings,
        wake: Wake,
    ) -> Result<Self, StartError<RefineError>> {
        let options = RefineOptions {
            controls: controls.clone(),
            creases,
            region,
        };
        let checked = options.validate(&mesh);
        let checked = checked.and_then(|()| crease_edges(&mesh, &options).map(drop));
        checked.map_err(StartError::Options)?;
        let set_up = move || RefineProcess::new(mesh, options);
        Self::start("refine", controls, settings, wake, set_up).map_err(StartError::Thread)
    }
}

/// Refines a mesh with the changes of a recording. `observe` is called with every event and returns
/// whether to continue. Returns the result and the refused changes.
///
/// # Errors
/// An option out of range, a named crease that is not a crease, a mesh without triangles, or an
/// error of a flow that a smaller step cannot avoid.
pub fn refine(
    mesh: Arc<Mesh>,
    options: RefineOptions,
    recording: &Recording<RefineControls>,
    observe: &mut dyn FnMut(RefineEvent) -> bool,
) -> Result<(Refined, Vec<Refused>), RefineError> {
    let mut process = RefineProcess::new(mesh, options)?;
    let refused = replay(&mut process, recording, observe)?;
    Ok((process.result(), refused))
}

/// The refinement of a mesh.
pub struct RefineProcess {
    refinement: Refinement,
    mesh: Arc<Mesh>,
    /// Shared by the states of the current level, once there is one.
    frame: Option<Arc<LevelFrame>>,
    /// The last accepted step of the level.
    last: Option<StepRecord>,
    attempts: usize,
    rejected: usize,
    has_new_state: bool,
    /// The state that was restored last, until the next change.
    rewound: Option<Arc<RefineState>>,
}

impl RefineProcess {
    fn new(mesh: Arc<Mesh>, options: RefineOptions) -> Result<Self, RefineError> {
        Ok(Self {
            refinement: Refinement::new(Arc::clone(&mesh), options)?,
            mesh,
            frame: None,
            last: None,
            attempts: 0,
            rejected: 0,
            has_new_state: true,
            rewound: None,
        })
    }

    fn result(&self) -> Refined {
        match &self.rewound {
            Some(state) => Refined {
                mesh: state.mesh(),
                control: state.control_mesh(),
                levels: self.refinement.levels().to_vec(),
            },
            None => self.refinement.result(),
        }
    }

    fn changed(&mut self, last: Option<StepRecord>) {
        (self.last, self.rewound, self.has_new_state) = (last, None, true);
    }
}

fn refused(error: &RefineError) -> Vec<Refused> {
    let text = format!("a change was refused and the refinement continues as before: {error}");
    vec![Refused { part: None, text }]
}

impl Process for RefineProcess {
    type Controls = RefineControls;
    type State = RefineState;
    type Event = RefineEvent;
    type Status = RefineStatus;
    type Error = RefineError;

    fn advance(&mut self, _: usize, emit: &mut dyn FnMut(RefineEvent)) -> Result<(), RefineError> {
        let Some(event) = self.refinement.step()? else {
            return Ok(());
        };
        let mut done = None;
        match &event {
            RefineEvent::Level { .. } => {
                self.frame = None;
                self.changed(None);
                // a level without a flow is finished at once
                if self.refinement.flow().is_none() {
                    done = self.refinement.levels().last().cloned();
                }
            }
            RefineEvent::Step { record, .. } => {
                self.attempts += 1;
                self.rejected += usize::from(record.is_rejected());
                if !record.is_rejected() {
                    self.changed(Some(record.clone()));
                }
            }
            RefineEvent::LevelDone(_) => {}
        }
        emit(event);
        done.map(RefineEvent::LevelDone).into_iter().for_each(emit);
        Ok(())
    }

    fn set_controls(&mut self, controls: &RefineControls) -> Vec<Refused> {
        let result = self.refinement.set_controls(controls);
        result
            .err()
            .map(|error| refused(&error))
            .unwrap_or_default()
    }

    fn rewind(&mut self, to: &Arc<RefineState>, controls: &RefineControls) -> Vec<Refused> {
        let state = SavedState {
            level: &to.frame.saved,
            points: &to.points,
            control: &to.control,
            steps: to.step,
        };
        if let Err(error) = self.refinement.restore(&state, controls) {
            return refused(&error);
        }
        self.frame = Some(Arc::clone(&to.frame));
        (self.last, self.has_new_state) = (None, false);
        self.rewound = Some(Arc::clone(to));
        Vec::new()
    }

    fn stop(&mut self, emit: &mut dyn FnMut(RefineEvent)) {
        if let Some(report) = self.refinement.stop() {
            emit(RefineEvent::LevelDone(report));
        }
    }

    fn ended(&self) -> bool {
        self.refinement.is_finished()
    }

    fn has_new_state(&self) -> bool {
        self.has_new_state
    }

    fn state(&mut self) -> Result<Arc<RefineState>, RefineError> {
        self.has_new_state = false;
        if let Some(state) = &self.rewound {
            return Ok(Arc::clone(state));
        }
        let refinement = &self.refinement;
        let frame = || Arc::new(LevelFrame::of(refinement, &self.mesh));
        let frame = Arc::clone(self.frame.get_or_insert_with(frame));
        let last = self.last.as_ref();
        Ok(Arc::new(RefineState::of(
            refinement,
            frame,
            last,
            self.attempts,
        )))
    }

    fn status(&mut self, _: f64, _: &mut dyn FnMut(RefineEvent)) -> RefineStatus {
        let refinement = &self.refinement;
        RefineStatus {
            level: refinement.level(),
            levels: refinement.planned_levels(),
            vertices: refinement.vertex_count(),
            attempts: self.attempts,
            rejected: self.rejected,
            relative_tau: refinement.flow().map(|f| f.tau() / f.tau_ref()),
            residual: self.last.as_ref().map(|record| record.residual),
            reports: refinement.levels().to_vec(),
        }
    }
}
