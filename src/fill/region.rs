//! The region of a group: its patches and their collars, as a mesh of its own.

use std::collections::BTreeMap;

use crate::fill::shape::{HoleShape, Shape};
use crate::fill::{Continuity, FillOptions, Group, Plan, sheets};
use crate::mesh::{DVec3, FaceId, Mesh, TopologyError, VertexId};
use crate::solver::{FlowProblem, SolverError};

/// The flow of a group's new vertices from `positions`, those of `shape`.
///
/// A patch shares the vertices of its G1 rims with its collar. Of a G0 rim it has its own copies, so
/// that it ends there, and if it has no other rims it has no collar. Where collars of a group overlap
/// with a hole that has a crease, they end at its rim likewise.
pub(super) fn problem(
    mesh: &Mesh,
    plan: &Plan,
    group: &Group,
    shape: &Shape,
    positions: &[DVec3],
    options: &FillOptions,
) -> Result<FlowProblem, SolverError> {
    if !plan.moved.is_empty() {
        return faired(mesh, &plan.moved, group, positions);
    }
    let creased = |h: usize| -> Vec<u32> {
        let hole = &plan.holes[h];
        let rims = hole.loops.iter().zip(&hole.rims);
        let mut creased: Vec<u32> = rims
            .filter(|(id, _)| options.continuity_at(**id) == Continuity::G0)
            .flat_map(|(_, rim)| rim.iter().map(|v| v.0))
            .collect();
        creased.sort_unstable();
        creased
    };
    let has_collar = |h: usize| {
        let mut loops = plan.holes[h].loops.iter();
        loops.any(|&id| options.continuity_at(id) == Continuity::G1)
    };
    let mut region = Region::new(mesh, positions);
    let mut first = 0;
    for (&h, hole) in group.holes.iter().zip(&shape.holes) {
        region.add_patch(hole, first, &creased(h));
        first += hole.new_vertices as u32;
    }
    let collars = group.holes.iter().zip(&group.collars);
    let mut faces: Vec<FaceId> = collars
        .filter(|(h, _)| has_collar(**h))
        .flat_map(|(_, collar)| collar.iter().copied())
        .collect();
    faces.sort_unstable();
    faces.dedup();
    let mut collar: Vec<VertexId> = faces
        .iter()
        .flat_map(|&f| mesh.topology.face_vertices(f))
        .collect();
    collar.sort_unstable();
    collar.dedup();
    // patches without interior vertices close holes in this collar
    for (h, hole) in plan.holes.iter().enumerate() {
        let triangles = &plan.triangles[hole.new_faces.clone()];
        let touches = |v: &u32| collar.binary_search(&VertexId(*v)).is_ok();
        if hole.group.is_none() && has_collar(h) && triangles.iter().flatten().any(touches) {
            region.add(triangles.iter().copied());
        }
    }
    region.add(
        faces
            .iter()
            .map(|&f| mesh.topology.face_vertices(f).map(|v| v.0)),
    );
    region.into_problem(first, group.radius)
}

/// The flow of vertices of the mesh itself from `positions`.
fn faired(
    mesh: &Mesh,
    moved: &[VertexId],
    group: &Group,
    positions: &[DVec3],
) -> Result<FlowProblem, SolverError> {
    let mut region = Region::new(mesh, positions);
    for (i, v) in (0..).zip(moved) {
        region.local[v.index()] = i;
    }
    let faces = group.collars.iter().flatten();
    region.add(faces.map(|&f| mesh.topology.face_vertices(f).map(|v| v.0)));
    region.into_problem(moved.len() as u32, group.radius)
}

/// Vertices and triangles of a region under way: new vertices first.
struct Region<'a> {
    mesh: &'a Mesh,
    /// Number in the region of each vertex of the mesh.
    local: Vec<u32>,
    positions: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    creases: Vec<u32>,
}

impl<'a> Region<'a> {
    fn new(mesh: &'a Mesh, new_positions: &[DVec3]) -> Self {
        Self {
            mesh,
            local: vec![u32::MAX; mesh.positions.len()],
            positions: new_positions.to_vec(),
            triangles: Vec::new(),
            creases: Vec::new(),
        }
    }

    fn number(&mut self, v: u32) -> u32 {
        let slot = &mut self.local[v as usize];
        if *slot == u32::MAX {
            *slot = self.positions.len() as u32;
            self.positions.push(self.mesh.positions[v as usize]);
        }
        *slot
    }

    /// Triangles over vertices of the mesh.
    fn add(&mut self, triangles: impl Iterator<Item = [u32; 3]>) {
        for t in triangles {
            let t = t.map(|v| self.number(v));
            self.triangles.push(t);
        }
    }

    /// A patch that goes on into its collar, but ends at rims that are `creased` (sorted vertices);
    /// `first` is its first new vertex.
    fn add_patch(&mut self, hole: &HoleShape, first: u32, creased: &[u32]) {
        let old = self.mesh.positions.len() as u32;
        let mut copies = BTreeMap::new();
        for t in &hole.triangles {
            let t = t.map(|v| {
                if v >= old {
                    return first + (v - old);
                }
                if creased.binary_search(&v).is_err() {
                    return self.number(v);
                }
                *copies.entry(v).or_insert_with(|| {
                    let copy = self.positions.len() as u32;
                    self.positions.push(self.mesh.positions[v as usize]);
                    self.creases.push(copy);
                    copy
                })
            });
            self.triangles.push(t);
        }
    }

    fn into_problem(mut self, interior: u32, radius: f64) -> Result<FlowProblem, SolverError> {
        let interior: Vec<u32> = (0..interior).collect();
        let problem = match FlowProblem::new(&self.positions, &self.triangles, &interior, radius) {
            Err(SolverError::Topology(TopologyError::NonManifoldVertex { .. })) => {
                sheets::separate(&mut self.positions, &mut self.triangles);
                FlowProblem::new(&self.positions, &self.triangles, &interior, radius)
            }
            problem => problem,
        };
        problem?.with_creases(self.creases)
    }
}
