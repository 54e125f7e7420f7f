//! Running operations.

use std::sync::Arc;

use super::{
    BlendSpec, BridgeSpec, Faces, FacesSpec, FillPartSpec, FillSpec, FlipSpec, FlowSpec, Operation,
    RefineSpec,
};
use crate::fill::{
    self, BridgeError, ControlsError, FillError, Filled, LiveFill, LoopChoice, NoSuchLoop,
    Observer, PartialError, PreparedFill, RefillError, Refilled, RimSet, ScheduledOptions, choose,
    nearest_loop, rim_sets, segment_at,
};
use crate::mesh::{
    BoundaryLoop, BuildError, DVec3, Erased, LoopId, Mesh, boundary_loops, erase, face_flags,
};
use crate::refine::{RefineError, RefineEvent, RefineOptions, Refined, refine};
use crate::runner::{RunControls, RunSettings, ScheduleError, StartError, Wake};

/// The result of an operation.
#[derive(Debug)]
#[non_exhaustive]
pub enum Outcome {
    /// Patches were added, or vertices were moved.
    Filled(Box<Filled>),
    /// Faces were erased and patches added.
    Refilled(Box<Refilled>),
    /// The mesh was refined.
    Refined(Box<Refined>),
    /// Faces were erased.
    Erased(Erased),
    /// The mesh was changed without a flow and without erasing faces.
    Changed(Mesh),
}

impl Outcome {
    /// The new mesh.
    pub fn mesh(&self) -> &Mesh {
        match self {
            Self::Filled(filled) => &filled.mesh,
            Self::Refilled(refilled) => &refilled.filled.mesh,
            Self::Refined(refined) => &refined.mesh,
            Self::Erased(erased) => &erased.mesh,
            Self::Changed(mesh) => mesh,
        }
    }

    /// The holes with their patches, of an operation that fills holes.
    pub fn filled(&self) -> Option<&Filled> {
        match self {
            Self::Filled(filled) => Some(filled),
            Self::Refilled(refilled) => Some(&refilled.filled),
            Self::Refined(_) | Self::Erased(_) | Self::Changed(_) => None,
        }
    }

    /// The new mesh by value.
    pub fn into_mesh(self) -> Mesh {
        match self {
            Self::Filled(filled) => filled.mesh,
            Self::Refilled(refilled) => refilled.filled.mesh,
            Self::Refined(refined) => refined.mesh,
            Self::Erased(erased) => erased.mesh,
            Self::Changed(mesh) => mesh,
        }
    }
}

/// Why an operation failed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum OperationError {
    /// A loop does not exist.
    #[error(transparent)]
    NoSuchLoop(#[from] NoSuchLoop),
    /// The mesh has no boundary loop at all.
    #[error("the mesh has no boundary loop")]
    NoLoops,
    /// A blend of fewer than two loops.
    #[error("a blend joins at least two loops, not {0}")]
    TooFewLoops(usize),
    /// A face does not exist.
    #[error("there is no face {}: the mesh has {faces}", face + 1)]
    NoSuchFace {
        /// The largest index given.
        face: u32,
        /// Number of faces of the mesh.
        faces: usize,
    },
    /// No face is selected.
    #[error("no face is selected; choose other places, numbers or limits")]
    NoFaces,
    /// An operation without first patches.
    #[error("the {0} is not a fill")]
    NotAFill(String),
    /// The tolerance of a stitching is not a length.
    #[error("the tolerance is {0}; write a length of 0 or more, in units of the file")]
    Tolerance(f64),
    /// A mesh that cannot be stitched.
    #[error(transparent)]
    Stitch(#[from] BuildError),
    /// Invalid options.
    #[error(transparent)]
    Controls(#[from] ControlsError),
    /// An invalid schedule.
    #[error(transparent)]
    Schedule(#[from] ScheduleError),
    /// A fill or blend.
    #[error(transparent)]
    Fill(#[from] FillError),
    /// A fill of part of a hole.
    #[error(transparent)]
    FillPart(#[from] PartialError),
    /// A refill or fairing.
    #[error(transparent)]
    Refill(#[from] RefillError),
    /// A bridge.
    #[error(transparent)]
    Bridge(#[from] BridgeError),
    /// A refinement.
    #[error(transparent)]
    Refine(#[from] RefineError),
}

impl Operation {
    /// Applies the operation to a mesh and returns the new mesh.
    ///
    /// # Errors
    /// The operation does not fit the mesh, its options are invalid, or it produced nothing.
    /// Failures of single holes are in the outcome.
    pub fn run(&self, mesh: &Mesh, observe: Observer<'_>) -> Result<Outcome, OperationError> {
        Ok(match self {
            Self::Fill(_) | Self::Blend(_) | Self::Fair(_) | Self::FillPart(_) => {
                Outcome::Filled(Box::new(self.prepare(mesh)?.run(observe)?))
            }
            Self::Refill(spec) => {
                let flags = flags(mesh, &spec.faces)?;
                let new = fill::refill(mesh, &flags, spec.flow.options()?, observe)?;
                Outcome::Refilled(Box::new(new))
            }
            Self::Refine(spec) => Outcome::Refined(Box::new(spec.run(mesh, observe)?)),
            Self::Erase(spec) => {
                if spec.faces.is_empty() {
                    return Err(OperationError::NoFaces);
                }
                Outcome::Erased(erase(mesh, &flags(mesh, &spec.faces)?))
            }
            Self::Flip(spec) => Outcome::Changed(spec.run(mesh)?),
            Self::Bridge(spec) => Outcome::Changed(spec.run(mesh)?),
            Self::Clean(spec) => Outcome::Erased(erase(mesh, &spec.parts(mesh).faces)),
            Self::Stitch(spec) => Outcome::Changed(spec.run(mesh)?),
        })
    }
}

impl Operation {
    /// Makes the first patches of a fill, a blend, a fairing or a fill of part of a hole.
    ///
    /// # Errors
    /// As [`Self::run`], and [`OperationError::NotAFill`] for other operations.
    pub fn prepare<'m>(&self, mesh: &'m Mesh) -> Result<PreparedFill<'m>, OperationError> {
        match self {
            Self::Fill(spec) => spec.prepare(mesh),
            Self::Blend(spec) => spec.prepare(mesh),
            Self::Fair(spec) => {
                let flags = flags(mesh, &spec.faces)?;
                Ok(PreparedFill::fairing(mesh, &flags, spec.flow.options()?)?)
            }
            Self::FillPart(spec) => spec.prepare(mesh),
            _ => Err(OperationError::NotAFill(self.label())),
        }
    }

    /// Starts an operation that can be [prepared](Self::prepare) in the background, with its options at the
    /// start and without their changes. An error of the preparation comes back as
    /// [`Event::Failed`](crate::runner::Event::Failed).
    ///
    /// # Errors
    /// Invalid controls, or no thread is left.
    pub fn start(
        self,
        mesh: Arc<Mesh>,
        settings: RunSettings,
        wake: Wake,
    ) -> Result<LiveFill, StartError<ControlsError>> {
        let controls = self.flow().map(|flow| flow.controls.clone());
        let controls = controls.unwrap_or_default();
        LiveFill::spawn(mesh, controls, settings, wake, move |mesh| {
            self.prepare(mesh)
        })
    }
}

impl FlowSpec {
    /// The options of the fill with their changes.
    ///
    /// # Errors
    /// Invalid controls or an invalid schedule.
    pub fn options(&self) -> Result<ScheduledOptions, OperationError> {
        self.controls.validate()?;
        Ok(ScheduledOptions::new(&self.controls, &self.schedule)?)
    }
}

impl FillSpec {
    /// Makes the first patches.
    ///
    /// # Errors
    /// As [`Operation::prepare`].
    pub fn prepare<'m>(&self, mesh: &'m Mesh) -> Result<PreparedFill<'m>, OperationError> {
        let loops = boundary_loops(mesh);
        self.prepare_rims(mesh, &self.rim_sets(mesh, &loops)?)
    }

    /// As [`Self::prepare`], with the rims of the loops from [`Self::rim_sets`].
    ///
    /// # Errors
    /// As [`Operation::prepare`].
    pub fn prepare_rims<'m>(
        &self,
        mesh: &'m Mesh,
        rim_sets: &[RimSet<'_>],
    ) -> Result<PreparedFill<'m>, OperationError> {
        check_faces(mesh, &self.bridges)?;
        let options = self.flow.options()?.leaving_islands();
        Ok(PreparedFill::new(mesh, rim_sets, &self.bridges, options))
    }

    /// The rims that each patch joins: a loop and the rims of the islands in it.
    ///
    /// # Errors
    /// A loop does not exist.
    pub fn rim_sets<'a>(
        &self,
        mesh: &Mesh,
        loops: &'a [BoundaryLoop],
    ) -> Result<Vec<RimSet<'a>>, NoSuchLoop> {
        let chosen = chosen(loops, &self.loops)?;
        Ok(rim_sets(mesh, loops, &chosen, self.islands))
    }
}

impl BlendSpec {
    /// Makes the first patch.
    ///
    /// # Errors
    /// As [`Operation::prepare`].
    pub fn prepare<'m>(&self, mesh: &'m Mesh) -> Result<PreparedFill<'m>, OperationError> {
        let loops = boundary_loops(mesh);
        let chosen = chosen(&loops, &self.loops)?;
        if chosen.len() < 2 {
            return Err(OperationError::TooFewLoops(chosen.len()));
        }
        let rims = chosen.iter().map(|id| &loops[id.index()]).collect();
        let options = self.flow.options()?;
        Ok(PreparedFill::new(mesh, &[rims], &[], options))
    }
}

impl FacesSpec {
    /// The fill of a refill, islands included: of the loops that erasing the faces has opened or enlarged.
    pub fn fill_of(&self, opened: &[LoopId]) -> FillSpec {
        FillSpec {
            loops: opened.to_vec(),
            islands: true,
            bridges: Faces::default(),
            flow: self.flow.clone(),
        }
    }
}

impl FillPartSpec {
    /// The hole, and the indices along it between which it is filled, in its direction.
    pub fn segment<'a>(
        &self,
        mesh: &Mesh,
        loops: &'a [BoundaryLoop],
    ) -> Option<(&'a BoundaryLoop, [usize; 2])> {
        let [from, to] = self.ends;
        let hole = &loops[nearest_loop(mesh, loops, from)?.index()];
        let [from, to] = [from, to].map(|point| nearest_index(mesh, hole, point));
        let n = hole.edges();
        // the shorter segment
        let is_shorter = (to + n - from) % n <= n / 2;
        Some((hole, if is_shorter { [from, to] } else { [to, from] }))
    }

    /// Makes the first patch.
    ///
    /// # Errors
    /// As [`Operation::prepare`].
    pub fn prepare<'m>(&self, mesh: &Mesh) -> Result<PreparedFill<'m>, OperationError> {
        let loops = boundary_loops(mesh);
        let (hole, ends) = (self.segment(mesh, &loops)).ok_or(OperationError::NoLoops)?;
        let options = self.flow.options()?;
        Ok(PreparedFill::part(mesh, hole, ends, options)?)
    }
}

impl RefineSpec {
    /// The options of the refinement of a mesh.
    ///
    /// # Errors
    /// A face that does not exist.
    pub fn options(&self, mesh: &Mesh) -> Result<RefineOptions, OperationError> {
        let edges = self.creases.iter().flat_map(|c| c.windows(2));
        let some = !self.faces.is_empty();
        Ok(RefineOptions {
            controls: self.controls.clone(),
            creases: edges.map(|e| [e[0], e[1]]).collect(),
            region: some.then(|| flags(mesh, &self.faces)).transpose()?,
        })
    }

    fn run(&self, mesh: &Mesh, observe: Observer<'_>) -> Result<Refined, OperationError> {
        let recording = self.schedule.recording(&self.controls)?;
        let observe = &mut |event| match event {
            RefineEvent::Step { level, record } => observe(level, &record),
            _ => true,
        };
        let (options, mesh) = (self.options(mesh)?, Arc::new(mesh.clone()));
        Ok(refine(mesh, options, &recording, observe)?.0)
    }
}

impl FlipSpec {
    /// The mesh with flipped components.
    ///
    /// # Errors
    /// A loop does not exist.
    pub fn run(&self, mesh: &Mesh) -> Result<Mesh, NoSuchLoop> {
        let loops = boundary_loops(mesh);
        let chosen = chosen(&loops, &self.loops)?;
        let components: Vec<u32> = (chosen.iter())
            .map(|id| loops[id.index()].component)
            .collect();
        Ok(mesh.with_flipped(&components))
    }
}

impl BridgeSpec {
    fn run(&self, mesh: &Mesh) -> Result<Mesh, OperationError> {
        let loops = boundary_loops(mesh);
        let end = |point| segment_at(mesh, &loops, point, self.width);
        match self.ends.map(end) {
            [Some(from), Some(to)] => Ok(fill::bridge(mesh, &loops, from, to)?),
            _ => Err(OperationError::NoLoops),
        }
    }
}

/// The listed loops in ascending order, if all exist.
fn chosen(loops: &[BoundaryLoop], listed: &[LoopId]) -> Result<Vec<LoopId>, NoSuchLoop> {
    choose(loops, &LoopChoice::Listed(listed.to_vec()))
}

/// One flag for each face of the mesh.
fn flags(mesh: &Mesh, faces: &[u32]) -> Result<Vec<bool>, OperationError> {
    check_faces(mesh, faces)?;
    Ok(face_flags(faces, mesh.face_count()))
}

/// Checks that the faces (ascending) exist.
fn check_faces(mesh: &Mesh, faces: &[u32]) -> Result<(), OperationError> {
    let count = mesh.face_count();
    match faces.last() {
        Some(&face) if face as usize >= count => {
            Err(OperationError::NoSuchFace { face, faces: count })
        }
        _ => Ok(()),
    }
}

/// Index along the loop of the vertex nearest to a point.
fn nearest_index(mesh: &Mesh, hole: &BoundaryLoop, point: DVec3) -> usize {
    let distance = |i: &usize| mesh.position(hole.vertices[*i]).distance_squared(point);
    (0..hole.edges())
        .min_by(|i, j| distance(i).total_cmp(&distance(j)))
        .unwrap_or(0)
}
