//! Connectivity of a group's patches, apart from the positions of their vertices.

use crate::fill::{Group, Plan};
use crate::mesh::DVec3;

/// The triangulation of one hole.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct HoleShape {
    /// Corners: vertices of the mesh, and from its vertex count on this hole's new vertices.
    pub triangles: Vec<[u32; 3]>,
    /// How many new vertices there are.
    pub new_vertices: usize,
}

/// The triangulations of a group's holes, in the order of [`Group::holes`](crate::fill::Group).
/// Positions that belong to it hold the new vertices of the first hole, then of the second, ...
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Shape {
    pub holes: Vec<HoleShape>,
}

impl Shape {
    /// Bytes the triangles take.
    pub fn bytes(&self) -> usize {
        let triangles: usize = self.holes.iter().map(|h| h.triangles.len()).sum();
        triangles * size_of::<[u32; 3]>()
    }
}

impl Plan {
    /// A group's shape and positions as they are in the plan.
    pub(super) fn shape_of(&self, group: &Group) -> (Shape, Vec<DVec3>) {
        let mut positions = Vec::new();
        if !self.moved.is_empty() {
            positions.clone_from(&self.new_positions);
        }
        let holes = group.holes.iter().map(|&h| {
            let hole = &self.holes[h];
            positions.extend_from_slice(&self.new_positions[hole.new_vertices.clone()]);
            let (old, first) = (self.old_vertices as u32, hole.new_vertices.start as u32);
            let own = |v: u32| if v < old { v } else { v - first };
            let triangles = &self.triangles[hole.new_faces.clone()];
            HoleShape {
                triangles: triangles.iter().map(|t| t.map(own)).collect(),
                new_vertices: hole.new_vertices.len(),
            }
        });
        let holes = holes.collect();
        (Shape { holes }, positions)
    }

    /// The same plan with other triangulations, one shape a group; the positions of new vertices
    /// are still to be [placed](Plan::place).
    pub(super) fn reshaped(&self, shapes: &[&Shape]) -> Self {
        let old = self.old_vertices as u32;
        let mut out = Self {
            old_vertices: self.old_vertices,
            holes: self.holes.clone(),
            failed: self.failed.clone(),
            new_positions: Vec::new(),
            triangles: Vec::new(),
            groups: self.groups.clone(),
            moved: self.moved.clone(),
        };
        for group in &mut out.groups {
            group.new_vertices.clear();
        }
        for (h, hole) in out.holes.iter_mut().enumerate() {
            let (vertices, faces) = (out.new_positions.len(), out.triangles.len());
            let Some(g) = hole.group else {
                let faces = &self.triangles[self.holes[h].new_faces.clone()];
                out.triangles.extend_from_slice(faces);
                hole.new_vertices = vertices..vertices;
                hole.new_faces = out.triangles.len() - faces.len()..out.triangles.len();
                continue;
            };
            let at = self.groups[g].holes.iter().position(|&other| other == h);
            let shape = &shapes[g].holes[at.expect("a hole is in its group")];
            let global = |v: u32| if v < old { v } else { v + vertices as u32 };
            let triangles = shape.triangles.iter();
            out.triangles.extend(triangles.map(|t| t.map(global)));
            let end = vertices + shape.new_vertices;
            out.new_positions.resize(end, DVec3::ZERO);
            hole.new_vertices = vertices..end;
            hole.new_faces = faces..out.triangles.len();
        }
        for group in &mut out.groups {
            for &h in &group.holes {
                let vertices = out.holes[h].new_vertices.clone();
                group.new_vertices.extend(vertices.map(|v| v as u32));
            }
        }
        out
    }
}
