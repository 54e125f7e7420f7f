//! The plan of a fill: first patches, and the groups to be solved together.

use std::sync::{Arc, OnceLock};

use crate::fill::group::{Group, groups};
use crate::fill::hole::PlannedHole;
use crate::fill::result::FillError;
use crate::fill::self_intersection::Obstacles;
use crate::mesh::{DVec3, LoopId, Mesh, VertexId};
use crate::symmetry::Isometry;

/// The vertices that flow.
#[derive(Clone, Debug)]
pub(crate) enum Domain {
    /// New vertices, in the patches of these holes.
    Holes(Vec<PlannedHole>),
    /// Fairing: these vertices of the mesh, ascending. They form one group.
    Vertices(Vec<VertexId>),
}

/// First patches of all holes, and the groups of the flows to run on them.
#[derive(Clone, Debug)]
pub(crate) struct Plan {
    pub domain: Domain,
    /// Holes for which no patch could be built.
    pub failed: Vec<FillError>,
    pub groups: Vec<Group>,
    /// Indices of the holes whose patches have no interior vertices; they are in no group.
    pub loose: Vec<usize>,
    /// The triangles of the mesh that patches must not intersect.
    pub obstacles: Obstacles,
    /// The approximate symmetries of the mesh, found when they are first needed.
    pub symmetries: OnceLock<Arc<Vec<Isometry>>>,
    /// Unit normals at the vertices of the mesh, found when they are first needed; 0 for none.
    pub normals: OnceLock<Arc<Vec<DVec3>>>,
}

impl Plan {
    /// The plan of these holes. `obstacles` are the triangles of the mesh that their patches must not intersect.
    pub fn new(
        mesh: &Mesh,
        holes: Vec<PlannedHole>,
        failed: Vec<FillError>,
        obstacles: Obstacles,
    ) -> Self {
        let is_loose = |&h: &usize| holes[h].patch.new_points().is_empty();
        Self {
            loose: (0..holes.len()).filter(is_loose).collect(),
            groups: groups(mesh, &holes),
            obstacles,
            symmetries: OnceLock::new(),
            normals: OnceLock::new(),
            domain: Domain::Holes(holes),
            failed,
        }
    }

    /// All holes; none in a fairing.
    pub fn holes(&self) -> &[PlannedHole] {
        match &self.domain {
            Domain::Holes(holes) => holes,
            Domain::Vertices(_) => &[],
        }
    }

    /// Fairing: the vertices that flow; none otherwise.
    pub fn moved(&self) -> &[VertexId] {
        match &self.domain {
            Domain::Holes(_) => &[],
            Domain::Vertices(moved) => moved,
        }
    }

    /// The holes of a group.
    pub fn holes_of(&self, group: usize) -> impl Iterator<Item = &PlannedHole> {
        self.groups[group].holes.iter().map(|&h| &self.holes()[h])
    }

    /// The loops that stand for the holes of a group.
    pub fn hole_ids(&self, group: usize) -> Vec<LoopId> {
        self.holes_of(group).map(|hole| hole.rims.id()).collect()
    }

    /// The loops that the patch of each hole of a group closes.
    pub fn closed_loops(&self, group: usize) -> Vec<Vec<LoopId>> {
        self.holes_of(group)
            .map(|hole| hole.rims.closed.clone())
            .collect()
    }

    /// The patches without new vertices, as triangles of vertices of the mesh.
    pub fn loose_triangles(&self) -> impl Iterator<Item = [u32; 3]> + '_ {
        let loose = self.loose.iter().map(|&h| &self.holes()[h]);
        loose.flat_map(PlannedHole::loose_triangles)
    }

    /// Positions of a group's vertices in the first patches.
    pub fn start_positions(&self, mesh: &Mesh, group: usize) -> Vec<DVec3> {
        match &self.domain {
            Domain::Vertices(moved) => moved.iter().map(|&v| mesh.position(v)).collect(),
            Domain::Holes(_) => {
                let new = self
                    .holes_of(group)
                    .flat_map(|hole| hole.patch.new_points());
                new.copied().collect()
            }
        }
    }
}
