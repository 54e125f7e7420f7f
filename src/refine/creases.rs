//! Sharp edges: creases of the limit surface.
//!
//! The limit curve of a crease is a cubic B-spline of the crease's own vertices. The surfaces on
//! the two sides have separate tangent planes (Hoppe et al., "Piecewise Smooth Surface
//! Reconstruction", 1994). Open boundaries have the same properties. The mesh is therefore cut open
//! along its creases and refined as an open mesh. Both sides interpolate the same curves, those of
//! the whole mesh, and the result is welded.

use std::sync::Arc;

use crate::mesh::{
    Attributes, DVec3, FaceId, HalfedgeId, Mesh, Split, Topology, TopologyError, VertexId,
    cut_open, dihedral_angle, edge_between, split_faces,
};
use crate::refine::boundary::BoundaryCurves;
use crate::refine::options::{RefineError, RefineOptions};
use crate::solver::SolverError;
use crate::warning::Warning;

/// Returns for each edge of a mesh whether it is a crease. Creases are the inner edges whose
/// triangles differ by more than the options' angle, and the named edges. A single edge with both
/// ends in the interior is not a crease; one found by its angle is ignored.
///
/// # Errors
/// [`RefineError::NoCrease`] for two vertices that are not neighbours, [`RefineError::LoneCrease`]
/// for a named edge that cannot be a crease.
pub fn crease_edges(mesh: &Mesh, options: &RefineOptions) -> Result<Vec<bool>, RefineError> {
    let topology = &mesh.topology;
    let edges = topology.edges();
    let mut flags: Vec<bool> = match options.controls.crease_angle.map(f64::to_radians) {
        Some(angle) => edges
            .map(|h| dihedral_angle(&mesh.positions, topology, h) > angle)
            .collect(),
        None => edges.map(|_| false).collect(),
    };
    let mut named = vec![false; flags.len()];
    for &ends in &options.creases {
        let [a, b] = ends.map(VertexId);
        let are_there = ends.iter().all(|&v| (v as usize) < mesh.vertex_count());
        let h = are_there.then(|| edge_between(topology, a, b)).flatten();
        let h = h.ok_or(RefineError::NoCrease { ends })?;
        if !topology.is_boundary_edge(h) {
            named[h.edge()] = true;
        }
    }
    for (flag, named) in flags.iter_mut().zip(&named) {
        *flag |= named;
    }
    for e in lone_edges(topology, &flags) {
        if named[e] {
            let h = HalfedgeId::from(2 * e);
            let ends = [topology.origin(h).0, topology.target(h).0];
            return Err(RefineError::LoneCrease { ends });
        }
        flags[e] = false;
    }
    Ok(flags)
}

/// Angle in degrees between the normals of two faces from which an edge between flat parts counts as sharp.
const SHARP_DEGREES: f64 = 30.0;
/// Angle in radians up to which two neighbours count as coplanar. Coordinates of single precision give less.
const COPLANAR: f64 = 1e-3;

/// The warning that sharp edges between flat parts of the mesh, as CAD programs write them, become round. A part is
/// flat if the face at the edge has a coplanar neighbour. `None` without such edges, and if an angle of creases is
/// given. `creases` are the [`crease_edges`].
pub(super) fn rounded_edges(
    mesh: &Mesh,
    options: &RefineOptions,
    creases: &[bool],
) -> Option<Warning> {
    if options.controls.crease_angle.is_some() {
        return None;
    }
    let topology = &mesh.topology;
    let angles: Vec<f64> = topology
        .edges()
        .map(|h| dihedral_angle(&mesh.positions, topology, h))
        .collect();
    let is_inner = |h: HalfedgeId| !topology.is_boundary_edge(h);
    let is_refined = |f: FaceId| options.region.as_ref().is_none_or(|faces| faces[f.index()]);
    let is_flat = |f: FaceId| {
        let mut sides = topology.face_halfedges(f).into_iter();
        sides.any(|h| is_inner(h) && angles[h.edge()] < COPLANAR)
    };
    let is_rounded = |h: &HalfedgeId| {
        let is_sharp = !creases[h.edge()] && angles[h.edge()] > SHARP_DEGREES.to_radians();
        let faces = || [*h, h.twin()].map(|h| topology.face(h));
        is_inner(*h) && is_sharp && faces().into_iter().all(|f| is_refined(f) && is_flat(f))
    };
    let rounded: Vec<HalfedgeId> = topology.edges().filter(is_rounded).collect();
    let &first = rounded.first()?;
    let ends = [topology.origin(first), topology.target(first)].map(|v| mesh.position(v));
    Some(Warning::RoundedEdges {
        edges: rounded.len(),
        at: ends[0].midpoint(ends[1]),
    })
}

/// Creases that meet neither another crease nor a boundary.
fn lone_edges(topology: &Topology, creases: &[bool]) -> Vec<usize> {
    let chosen = creases.iter().enumerate().filter(|&(_, &is)| is);
    let ends_here = |v: VertexId| {
        let meeting = topology.outgoing(v).filter(|h| creases[h.edge()]).count();
        meeting == 1 && !topology.is_boundary_vertex(v)
    };
    chosen
        .map(|(e, _)| e)
        .filter(|&e| {
            let h = HalfedgeId::from(2 * e);
            ends_here(topology.origin(h)) && ends_here(topology.target(h))
        })
        .collect()
}

/// The map from a cut mesh to the whole mesh. Both have the same faces in the same order.
#[derive(Clone, Debug)]
pub struct CreaseWeld {
    /// Connectivity of the whole mesh.
    pub topology: Topology,
    /// The vertex of the whole mesh for each vertex of the cut one.
    pub to_whole: Vec<u32>,
}

impl CreaseWeld {
    /// Converts per-vertex data of the cut mesh to the whole mesh. The first of several copies is
    /// used.
    pub fn welded<T: Copy + Default>(&self, of_cut: &[T]) -> Vec<T> {
        let mut of_whole = vec![T::default(); self.topology.vertex_count()];
        for (&w, &value) in self.to_whole.iter().zip(of_cut).rev() {
            of_whole[w as usize] = value;
        }
        of_whole
    }

    /// The attributes of the whole mesh, from those of the cut one.
    pub fn welded_attributes(&self, of_cut: &Attributes) -> Attributes {
        let own: Vec<u32> = (0..self.to_whole.len() as u32).collect();
        of_cut.with_vertices(&self.welded(&own))
    }

    /// Advances to the meshes after a split of the faces `chosen` and their neighbours.
    fn split(&self, cut: &Topology, whole: &Split) -> Result<(Split, Self), TopologyError> {
        let topology =
            Topology::from_triangles(whole.vertex_count(&self.topology), &whole.triangles)?;
        let mut to_whole = self.to_whole.clone();
        let mut middle_of = vec![u32::MAX; self.topology.halfedge_count() / 2];
        for (i, h) in whole.edges.iter().enumerate() {
            middle_of[h.edge()] = (self.topology.vertex_count() + i) as u32;
        }
        let mut edges = Vec::new();
        // of each edge of the cut mesh, its middle there
        let mut middle = vec![u32::MAX; cut.halfedge_count() / 2];
        let sides = |f: FaceId| {
            cut.face_halfedges(f)
                .into_iter()
                .zip(self.topology.face_halfedges(f))
        };
        for e in 0..middle.len() {
            let h = HalfedgeId::from(2 * e);
            let inner = if cut.is_boundary(h) { h.twin() } else { h };
            let there = sides(cut.face(inner)).find(|&(here, _)| here == inner);
            let m = there.map_or(u32::MAX, |(_, there)| middle_of[there.edge()]);
            if m != u32::MAX {
                middle[e] = to_whole.len() as u32;
                to_whole.push(m);
                edges.push(h);
            }
        }
        let mut triangles = Vec::with_capacity(whole.triangles.len());
        for (triangle, &f) in whole.triangles.iter().zip(&whole.parent) {
            let f = FaceId(f);
            triangles.push(triangle.map(|v| {
                let mut sides = sides(f);
                let vertex = if (v as usize) < self.topology.vertex_count() {
                    sides
                        .find(|&(_, there)| self.topology.origin(there).0 == v)
                        .map(|(here, _)| cut.origin(here).0)
                } else {
                    sides
                        .find(|&(_, there)| middle_of[there.edge()] == v)
                        .map(|(here, _)| middle[here.edge()])
                };
                vertex.expect("a part of a face has its corners or middles")
            }));
        }
        let split = Split {
            triangles,
            parent: whole.parent.clone(),
            edges,
        };
        Ok((split, Self { topology, to_whole }))
    }
}

/// Boundaries and creases of the mesh that is refined.
#[derive(Clone, Debug)]
pub struct Features {
    curves: BoundaryCurves,
    /// If there are creases.
    weld: Option<Arc<CreaseWeld>>,
    /// For each input vertex whether a crease has a corner there.
    corners: Vec<bool>,
}

impl Features {
    /// Those of a mesh with these [`crease_edges`]. Also returns the mesh to refine, as the first value.
    ///
    /// # Errors
    /// The mesh cannot be cut open along the creases.
    pub fn new(
        mesh: &Mesh,
        options: &RefineOptions,
        creases: &[bool],
    ) -> Result<(Topology, Self), RefineError> {
        let topology = &mesh.topology;
        let curves = BoundaryCurves::new(
            topology,
            &mesh.positions,
            creases,
            options.controls.boundary,
            options.controls.corner_angle.to_radians(),
        );
        let (mut cut, mut weld, mut corners) = (topology.clone(), None, Vec::new());
        if creases.contains(&true) {
            let open = cut_open(topology, creases).map_err(SolverError::from)?;
            cut = open.topology;
            weld = Some(Arc::new(CreaseWeld {
                topology: topology.clone(),
                to_whole: open.to_whole,
            }));
            let meets = |v: VertexId| topology.outgoing(v).any(|h| creases[h.edge()]);
            corners = mesh
                .topology
                .vertices()
                .map(|v| meets(v) && curves.is_corner(v))
                .collect();
        }
        let features = Self {
            curves,
            weld,
            corners,
        };
        Ok((cut, features))
    }

    /// How the mesh is welded, if it is cut.
    pub fn weld(&self) -> Option<&Arc<CreaseWeld>> {
        self.weld.as_ref()
    }

    /// The whole mesh of the cut mesh; the two may be the same.
    pub fn whole<'a>(&'a self, cut: &'a Topology) -> &'a Topology {
        self.weld.as_ref().map_or(cut, |weld| &weld.topology)
    }

    /// Converts per-vertex data of the whole mesh to the cut mesh.
    pub fn opened<T: Copy>(&self, of_whole: &[T]) -> Vec<T> {
        match &self.weld {
            Some(weld) if !of_whole.is_empty() => {
                let of = |&w: &u32| of_whole[w as usize];
                weld.to_whole.iter().map(of).collect()
            }
            _ => of_whole.to_vec(),
        }
    }

    /// The attributes of the cut mesh, from those of the whole mesh.
    pub fn opened_attributes(&self, of_whole: &Attributes) -> Attributes {
        match &self.weld {
            Some(weld) => of_whole.with_vertices(&weld.to_whole),
            None => of_whole.clone(),
        }
    }

    /// Splits the faces `chosen` of the mesh and their neighbours, and advances to the finer mesh.
    ///
    /// # Errors
    /// The finer mesh has too many vertices.
    pub fn split(&mut self, cut: &Topology, chosen: &[bool]) -> Result<Split, TopologyError> {
        let Some(weld) = &self.weld else {
            let split = split_faces(cut, chosen);
            self.curves = self.curves.split(cut, &split);
            return Ok(split);
        };
        // split both sides of a crease alike
        let whole = split_faces(&weld.topology, chosen);
        self.curves = self.curves.split(&weld.topology, &whole);
        let (split, finer) = weld.split(cut, &whole)?;
        self.weld = Some(Arc::new(finer));
        Ok(split)
    }

    /// The point of the curve at a vertex; `None` off boundaries and creases.
    pub fn point(&self, v: VertexId) -> Option<DVec3> {
        self.curves.point(match &self.weld {
            Some(weld) => VertexId(weld.to_whole[v.index()]),
            None => v,
        })
    }

    /// For each vertex whether a crease has a corner there; empty if there are no creases.
    pub fn corners(&self) -> Vec<bool> {
        let is_corner = |&w: &u32| self.corners.get(w as usize).copied().unwrap_or(false);
        self.weld.as_ref().map_or_else(Vec::new, |weld| {
            weld.to_whole.iter().map(is_corner).collect()
        })
    }

    /// Makes the points of all copies of a vertex bit-identical. The point is the previous one
    /// (`old`, of the coarser mesh) if one copy keeps it, otherwise that of the first copy.
    pub fn join(&self, points: &mut [DVec3], old: &[DVec3]) {
        let Some(weld) = &self.weld else {
            return;
        };
        let mut common = weld.welded(points);
        for ((&w, &point), &before) in weld.to_whole.iter().zip(&*points).zip(old) {
            if point == before {
                common[w as usize] = before;
            }
        }
        for (point, &w) in points.iter_mut().zip(&weld.to_whole) {
            *point = common[w as usize];
        }
    }
}
