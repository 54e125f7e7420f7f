//! Shapes of a whole fill on its way.

use std::ops::Range;
use std::sync::Arc;

use crate::fill::Plan;
use crate::fill::schedule::Row;
use crate::fill::shape::Shape;
use crate::mesh::{DVec3, LoopId, Mesh, Topology};

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
    pub(super) shape: Arc<Shape>,
}

/// A hole's part of a filled mesh.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct HoleLayout {
    /// The loop.
    pub id: LoopId,
    /// The group it is solved with; `None` if it has no interior vertex.
    pub group: Option<usize>,
    /// Its vertices in the filled mesh.
    pub vertices: Range<usize>,
    /// Its faces in the filled mesh.
    pub faces: Range<usize>,
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
    pub(super) plan: Plan,
    /// The shapes it is made of.
    pub(super) shapes: Vec<Arc<Shape>>,
}

impl Layout {
    /// The layout of a plan whose groups have these shapes.
    pub(super) fn new(mesh: &Mesh, plan: Plan, shapes: Vec<Arc<Shape>>) -> Self {
        let (old_vertices, old_faces) = (mesh.vertex_count(), mesh.face_count());
        let from = |range: &Range<usize>, old: usize| old + range.start..old + range.end;
        let holes = plan.holes.iter().map(|hole| HoleLayout {
            id: hole.id,
            group: hole.group,
            vertices: from(&hole.new_vertices, old_vertices),
            faces: from(&hole.new_faces, old_faces),
        });
        Self {
            old_vertices,
            old_faces,
            holes: holes.collect(),
            plan,
            shapes,
        }
    }

    /// Whether it is made of these shapes.
    pub(super) fn fits(&self, groups: &[Arc<GroupState>]) -> bool {
        let mut pairs = self.shapes.iter().zip(groups);
        pairs.all(|(shape, group)| Arc::ptr_eq(shape, &group.shape))
    }
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

    /// Positions of all vertices of the filled mesh; `given` is the mesh it was started on.
    pub fn positions(&self, given: &Mesh) -> Vec<DVec3> {
        self.layout.plan.positions(given, &self.new_positions())
    }

    /// Positions of the vertices that flow: all new ones in the order of the filled mesh, or those
    /// of a fairing, ascending.
    pub fn new_positions(&self) -> Vec<DVec3> {
        let plan = &self.layout.plan;
        let mut out = vec![DVec3::ZERO; plan.new_positions.len()];
        for (group, state) in plan.groups.iter().zip(&self.groups) {
            for (&v, &p) in group.new_vertices.iter().zip(state.positions.iter()) {
                out[v as usize] = p;
            }
        }
        out
    }

    /// The patch faces, as a range of faces of the filled mesh.
    pub fn patch_faces(&self) -> Range<usize> {
        self.layout.old_faces..self.topology.face_count()
    }

    /// The whole filled mesh with the attributes of the given one, the old part first.
    pub(super) fn mesh(&self, given: &Mesh) -> Mesh {
        let mut plan = self.layout.plan.clone();
        for (g, state) in self.groups.iter().enumerate() {
            plan.place(g, &state.positions);
        }
        plan.assemble(given, (*self.topology).clone())
    }
}
