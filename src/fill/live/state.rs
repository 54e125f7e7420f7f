//! Shapes of a whole fill on its way.

use std::ops::Range;
use std::sync::Arc;

use crate::fill::assemble::Assembly;
use crate::fill::patch_topology::PatchTopology;
use crate::fill::schedule::Row;
use crate::mesh::{DVec3, Mesh, Topology};

/// One group's shape after an accepted step.
#[derive(Clone, Debug)]
pub struct GroupState {
    /// Accepted steps.
    pub step: usize,
    /// Attempts before it.
    pub attempt: usize,
    /// Positions of the group's new vertices.
    pub positions: Arc<[DVec3]>,
    /// Energy, by the rule of the steps; NaN where there is no flow.
    pub energy: f64,
    /// Residual of the step; `None` before the first.
    pub residual: Option<f64>,
    /// Time step of the step; 0 before the first.
    pub tau: f64,
    /// Smallest angle of a triangle of the patches, in degrees.
    pub worst_angle: f64,
    pub(super) patches: Arc<PatchTopology>,
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
    /// The whole filled mesh but for positions; the same `Arc` as long as no density changes.
    pub(super) assembly: Arc<Assembly>,
    /// Whether every group had ended.
    pub ended: bool,
    /// What was changed before it.
    pub(super) rows: Arc<Vec<Row>>,
}

impl State {
    /// Sum of the groups' energies.
    pub fn energy(&self) -> f64 {
        self.groups.iter().map(|g| g.energy).sum()
    }

    /// Smallest angle of a triangle of the groups' patches, in degrees; `None` without groups.
    pub fn worst_angle(&self) -> Option<f64> {
        self.groups.iter().map(|g| g.worst_angle).reduce(f64::min)
    }

    /// Connectivity of the whole filled mesh, the given vertices and faces first. The same `Arc` as
    /// long as no density changes.
    pub fn topology(&self) -> &Arc<Topology> {
        &self.assembly.topology
    }

    /// Positions of all vertices of the filled mesh; `given` is the mesh it was started on.
    pub fn positions(&self, given: &Mesh) -> Vec<DVec3> {
        self.assembly.positions(given, self.group_positions())
    }

    /// Positions of the vertices that flow: all new ones in the order of the filled mesh, or those
    /// of a fairing, ascending.
    pub fn new_positions(&self) -> Vec<DVec3> {
        self.assembly.flowing_positions(self.group_positions())
    }

    /// The patch faces, as a range of faces of the filled mesh.
    pub fn patch_faces(&self) -> Range<usize> {
        self.assembly.patch_faces()
    }

    /// The whole filled mesh with the attributes of the given one, the old part first.
    pub(super) fn mesh(&self, given: &Mesh) -> Mesh {
        self.assembly.mesh(given, self.group_positions())
    }

    fn group_positions(&self) -> impl Iterator<Item = &[DVec3]> {
        self.groups.iter().map(|group| &group.positions[..])
    }
}
