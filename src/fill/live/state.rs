//! Shapes of a whole fill on its way, and the kept ones.

use std::ops::Range;
use std::sync::Arc;

use crate::mesh::{DVec3, Topology};

/// One group's shape after an accepted step.
#[derive(Clone, Debug)]
pub struct GroupState {
    /// Accepted steps.
    pub step: usize,
    /// Attempted steps.
    pub attempt: usize,
    /// Positions of the group's new vertices.
    pub positions: Arc<[DVec3]>,
    /// Energy, by the rule of the steps.
    pub energy: f64,
    /// Residual of the step; `None` before the first.
    pub residual: Option<f64>,
    /// Time step of the step; 0 before the first.
    pub tau: f64,
    /// Smallest angle of a triangle of the patches, in degrees.
    pub worst_angle: f64,
}

/// A hole's part of a filled mesh.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct HoleLayout {
    /// Number of the loop.
    pub number: usize,
    /// The group it is solved with; `None` if it has no interior vertex.
    pub group: Option<usize>,
    /// Its new vertices, counted from the mesh's.
    pub vertices: Range<usize>,
    /// Its faces in the filled mesh.
    pub faces: Range<usize>,
    /// Its vertices' places in its group's positions.
    pub places: Range<usize>,
}

/// What belongs to which hole in a filled mesh.
#[derive(Clone, Debug)]
pub struct Layout {
    /// Vertices of the given mesh.
    pub old_vertices: usize,
    /// Faces of the given mesh.
    pub old_faces: usize,
    /// Every hole with a patch.
    pub holes: Vec<HoleLayout>,
}

/// The whole fill at one moment.
#[derive(Clone, Debug)]
pub struct State {
    /// Serial number, never used twice in one fill.
    pub index: usize,
    /// Attempts before it.
    pub attempt: usize,
    /// Every group's shape.
    pub groups: Vec<Arc<GroupState>>,
    /// Connectivity of the whole filled mesh, the given vertices and faces first. The same `Arc` as
    /// long as no density changes.
    pub topology: Arc<Topology>,
    /// What in it belongs to which hole; the same `Arc` as long as the topology's is.
    pub layout: Arc<Layout>,
}

impl State {
    /// Sum of the groups' energies.
    pub fn energy(&self) -> f64 {
        self.groups.iter().map(|g| g.energy).sum()
    }

    /// Positions of all new vertices in the order of the filled mesh.
    pub fn new_positions(&self) -> Vec<DVec3> {
        let holes = &self.layout.holes;
        let mut out = Vec::with_capacity(holes.last().map_or(0, |h| h.vertices.end));
        for hole in holes {
            if let Some(group) = hole.group {
                out.extend_from_slice(&self.groups[group].positions[hole.places.clone()]);
            }
        }
        out
    }

    /// The patch faces, as a range of faces of the filled mesh.
    pub fn patch_faces(&self) -> Range<usize> {
        self.layout.old_faces..self.topology.face_count()
    }
}

/// Kept states of a fill, oldest first.
#[derive(Clone, Debug, Default)]
pub struct Timeline {
    /// The states.
    pub states: Vec<Arc<State>>,
    /// Bytes their positions and connectivities take.
    pub bytes: usize,
}
