//! Events and reports of a refinement.

use serde::{Serialize, Serializer};

use crate::solver::{End, StepRecord};
use crate::warning::Warnings;

/// Report of a finished level.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct LevelReport {
    /// From 1.
    pub level: usize,
    /// Vertices of the mesh.
    pub vertices: usize,
    /// Triangles.
    pub faces: usize,
    /// Accepted steps of the flow.
    pub steps: usize,
    /// Rejected ones.
    pub rejected: usize,
    /// Whether the stopping rule was met (always for the schemes without a flow).
    pub converged: bool,
    /// Why its flow ended; the schemes without a flow converge. Written as [`Self::end_name`].
    #[serde(serialize_with = "write_end")]
    pub end: End,
    /// Energy of the limit surface at the start of the level, by the 12 points of each triangle of
    /// the last level. At most 192 points per triangle are used; 12 for Loop's scheme and
    /// Butterfly.
    pub energy_start: f64,
    /// At its end.
    pub energy_end: f64,
    /// Largest distance between the limit surface and a vertex it interpolates, over the radius of
    /// the mesh; null for Loop's scheme and Butterfly.
    pub held_error: Option<f64>,
    /// Wall-clock time of the computation in seconds, without pauses.
    pub seconds: f64,
    /// Largest resident set of the process up to the end of the level, bytes; 0 where the system
    /// does not report it.
    pub peak_memory: u64,
    /// Warnings about the level's flow.
    #[serde(flatten)]
    pub warnings: Warnings,
}

impl LevelReport {
    /// `converged`, `steps` (as many as allowed), `stuck` (no further step is possible) or `cancelled`.
    pub fn end_name(&self) -> &'static str {
        end_name(self.end)
    }
}

fn end_name(end: End) -> &'static str {
    match end {
        End::Converged => "converged",
        End::MaxSteps => "steps",
        End::StepSizeCollapsed | End::Pinched | End::SelfIntersected => "stuck",
        End::Cancelled => "cancelled",
    }
}

#[expect(
    clippy::trivially_copy_pass_by_ref,
    reason = "the signature that serde calls"
)]
fn write_end<S: Serializer>(end: &End, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(end_name(*end))
}

/// Something that happened in a refinement.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub enum RefineEvent {
    /// A level was begun.
    Level {
        /// From 1.
        level: usize,
        /// Vertices of its mesh.
        vertices: usize,
        /// Triangles.
        faces: usize,
    },
    /// A step of a level's flow was attempted.
    Step {
        /// The level.
        level: usize,
        /// Its result.
        record: StepRecord,
    },
    /// A level is finished. Its report contains the warnings.
    LevelDone(LevelReport),
}
