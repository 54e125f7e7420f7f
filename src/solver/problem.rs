//! The validated description of a flow on a region of a mesh.

use std::sync::Arc;

use rustc_hash::FxHashMap;

use crate::mesh::{DVec3, FaceId, Neighbourhood, Topology, VertexId};
use crate::solver::SolverError;
use crate::solver::discretization::Discretization;
use crate::subdivision::{EXACT_VALENCE, Rule, elements};
use crate::surface::Interpolation;

/// Number of rings around the interior vertices whose positions matter. Active elements have
/// corners up to ring 2 whose one-rings reach ring 3; the fixed curvatures of scheme A reach ring
/// 4.
pub const SUPPORT_RINGS: u8 = 4;

/// A shape that a part of the surface resembles. The flow of `g2` lowers the variation of the difference
/// `h − s h'` of the curvature vectors of both instead of that of its own.
#[derive(Clone, Debug, Default)]
pub struct Reference {
    /// Positions of the shape for the vertices of that part, relative to the centre of the problem,
    /// where they are known.
    pub positions: FxHashMap<u32, Option<DVec3>>,
    /// Its share s, from 0 to 1.
    pub share: f64,
}

/// A local mesh whose interior vertices move while all others stay.
///
/// Positions are stored relative to `centre`, to avoid cancellation on a mesh far from the origin.
#[derive(Clone, Debug)]
pub struct FlowProblem {
    discretization: Arc<Discretization>,
    positions: Vec<DVec3>,
    centre: DVec3,
    ring: Vec<u8>,
    interior: Vec<u32>,
    radius: f64,
    creases: Vec<u32>,
    free_curvatures: Vec<u32>,
    interpolation: Option<Arc<Interpolation>>,
    references: Arc<[Reference]>,
    keeps_metric: bool,
}

impl FlowProblem {
    /// A flow of the vertices `interior` of the mesh `positions`, `triangles`.
    ///
    /// The mesh must contain all faces within [`SUPPORT_RINGS`] rings of the interior. A nearer
    /// boundary counts as a boundary of the surface. `radius` is the hole radius (RMS distance of
    /// the rim from its mean), the unit of length of all tolerances.
    ///
    /// # Errors
    /// [`SolverError`] if the triangles are not an oriented manifold, a coordinate is not finite,
    /// an interior vertex does not exist or lies on a boundary, or the radius is not positive.
    pub fn new(
        positions: &[DVec3],
        triangles: &[[u32; 3]],
        interior: &[u32],
        radius: f64,
    ) -> Result<Self, SolverError> {
        let topology = Topology::from_triangles(positions.len(), triangles)?;
        if let Some(vertex) = positions.iter().position(|p| !p.is_finite()) {
            return Err(SolverError::NotFinite { vertex });
        }
        if !(radius.is_finite() && radius > 0.0) {
            return Err(SolverError::BadRadius { radius });
        }
        for &v in interior {
            let vertex = v as usize;
            if vertex >= positions.len() {
                return Err(SolverError::NoSuchVertex { vertex });
            }
            let id = VertexId(v);
            if !topology.has_faces(id) || topology.is_boundary_vertex(id) {
                return Err(SolverError::InteriorOnBoundary { vertex });
            }
        }
        let ring = rings(&topology, interior);
        let active = active_faces(&topology, &ring);
        let centre = interior
            .iter()
            .map(|&v| positions[v as usize])
            .sum::<DVec3>()
            / interior.len().max(1) as f64;
        Ok(Self {
            discretization: Arc::new(Discretization::new(Arc::new(topology), active)),
            positions: positions.iter().map(|&p| p - centre).collect(),
            centre,
            ring,
            interior: interior.to_vec(),
            radius,
            creases: Vec::new(),
            free_curvatures: Vec::new(),
            interpolation: None,
            references: Arc::default(),
            keeps_metric: false,
        })
    }

    /// The same problem in which only some of the interior vertices move.
    ///
    /// # Errors
    /// As [`Self::new`], which cannot occur for interior vertices.
    pub fn moving_only(&self, vertices: &[u32]) -> Result<Self, SolverError> {
        let world: Vec<DVec3> = self.positions.iter().map(|&p| p + self.centre).collect();
        let triangles: Vec<[u32; 3]> = self.topology().triangles().collect();
        let mut part = Self::new(&world, &triangles, vertices, self.radius)?;
        // the same origin, so that positions of both can be exchanged
        (part.centre, part.positions) = (self.centre, self.positions.clone());
        part.free_curvatures.clone_from(&self.free_curvatures);
        part.with_creases(self.creases.clone())
    }

    /// The same problem with fixed vertices at which the surface ends in a crease (G0). The normal
    /// is free there.
    ///
    /// # Errors
    /// [`SolverError::NoSuchVertex`].
    pub fn with_creases(mut self, creases: Vec<u32>) -> Result<Self, SolverError> {
        let count = self.positions.len();
        if let Some(&vertex) = creases.iter().find(|&&v| v as usize >= count) {
            let vertex = vertex as usize;
            return Err(SolverError::NoSuchVertex { vertex });
        }
        self.creases = creases;
        Ok(self)
    }

    /// The same problem with vertices of ring 1 across which flows of sixth order continue normals only
    /// (G1): the curvature there is free.
    #[must_use]
    pub fn with_free_curvatures(mut self, vertices: Vec<u32>) -> Self {
        self.free_curvatures = vertices;
        self
    }

    /// For each vertex whether the surface has a free curvature there.
    pub fn free_curvature_marks(&self) -> Vec<bool> {
        self.marks(&self.free_curvatures)
    }

    /// Whether a face lies outside a part of the rim with free curvature: it has a vertex there and one
    /// of ring 2 or more.
    pub(super) fn is_beyond_free_curvature(&self, free: &[bool], face: FaceId) -> bool {
        let corners = self.topology().face_vertices(face).map(VertexId::index);
        corners.iter().any(|&v| free[v]) && corners.iter().any(|&v| self.ring[v] > 1)
    }

    /// Vertices at which the surface ends in a crease.
    pub fn creases(&self) -> &[u32] {
        &self.creases
    }

    /// For each vertex whether it is one of [`Self::creases`].
    pub fn crease_marks(&self) -> Vec<bool> {
        self.marks(&self.creases)
    }

    fn marks(&self, vertices: &[u32]) -> Vec<bool> {
        let mut marks = vec![false; self.positions.len()];
        for &v in vertices {
            marks[v as usize] = true;
        }
        marks
    }

    /// The same problem with interpolation constraints: the limit surface passes given points (in
    /// the input mesh's coordinates). The control points of these vertices follow those of the
    /// other interior vertices. The vertices may lie on a boundary; other vertices of a boundary do
    /// not move. The starting positions of the constrained vertices are set accordingly.
    ///
    /// # Errors
    /// [`SolverError`] if a vertex does not exist or is named twice, or a coordinate is not finite.
    pub fn with_constraints(mut self, held: &[(u32, DVec3)]) -> Result<Self, SolverError> {
        let mut seen = vec![false; self.positions.len()];
        for &(v, target) in held {
            let vertex = v as usize;
            match seen.get_mut(vertex) {
                None => return Err(SolverError::NoSuchVertex { vertex }),
                Some(seen) if *seen => return Err(SolverError::ConstrainedTwice { vertex }),
                Some(seen) => *seen = true,
            }
            if !target.is_finite() {
                return Err(SolverError::NotFinite { vertex });
            }
        }
        let relative: Vec<_> = held.iter().map(|&(v, p)| (v, p - self.centre)).collect();
        let interpolation = Interpolation::new(self.topology(), &relative);
        interpolation.enforce(&mut self.positions);
        self.interpolation = Some(Arc::new(interpolation));
        self.take_in(held.iter().map(|&(v, _)| VertexId(v)));
        Ok(self)
    }

    /// Activates the faces around given vertices that have no active face. Constrained vertices are
    /// unknowns, and each needs an element to have a row of the matrix.
    fn take_in(&mut self, vertices: impl Iterator<Item = VertexId>) {
        let topology = self.topology();
        let faces = |v| {
            topology
                .outgoing(v)
                .map(|h| topology.face(h))
                .filter(|f| f.is_some())
        };
        let is_active = |f: FaceId| self.active_faces().binary_search(&f).is_ok();
        let more: Vec<FaceId> = vertices
            .filter(|&v| !faces(v).any(is_active))
            .flat_map(faces)
            .collect();
        if !more.is_empty() {
            let mut active = [self.active_faces(), &more].concat();
            active.sort_unstable();
            active.dedup();
            let topology = Arc::clone(self.topology());
            self.discretization = Arc::new(Discretization::new(topology, active));
        }
    }

    /// The same problem with reference shapes. A vertex belongs to the first that contains it.
    #[must_use]
    pub fn with_references(mut self, references: Vec<Reference>) -> Self {
        self.references = references.into();
        self
    }

    /// The reference shapes.
    pub fn references(&self) -> &Arc<[Reference]> {
        &self.references
    }

    /// The same problem from a surface that has settled: vector flows keep the metric of its triangles.
    #[must_use]
    pub fn keeping_metric(mut self) -> Self {
        self.keeps_metric = true;
        self
    }

    /// Whether vector flows keep the metric of the starting triangles.
    pub fn keeps_metric(&self) -> bool {
        self.keeps_metric
    }

    /// Connectivity of the region.
    pub fn topology(&self) -> &Arc<Topology> {
        self.discretization.topology()
    }

    /// Connectivity and elements.
    pub fn discretization(&self) -> &Arc<Discretization> {
        &self.discretization
    }

    /// Starting positions relative to [`Self::centre`].
    pub fn positions(&self) -> &[DVec3] {
        &self.positions
    }

    /// The point subtracted from the input positions.
    pub fn centre(&self) -> DVec3 {
        self.centre
    }

    /// Graph distance from the interior vertices: 0 at these, at most [`SUPPORT_RINGS`] + 1.
    pub fn ring(&self) -> &[u8] {
        &self.ring
    }

    /// The vertices that move.
    pub fn interior(&self) -> &[u32] {
        &self.interior
    }

    /// The faces over which the energy is integrated: those with a vertex at graph distance at most
    /// 1 from an interior vertex, and those around constrained vertices farther away. Of large fans
    /// only the triangles that depend on an interior vertex.
    pub fn active_faces(&self) -> &[FaceId] {
        self.discretization.active_faces()
    }

    /// The interpolation constraints, if there are any.
    pub fn interpolation(&self) -> Option<&Arc<Interpolation>> {
        self.interpolation.as_ref()
    }

    /// The vertices whose control points change: the interior ones, then the other constrained
    /// ones.
    pub fn moving(&self) -> Vec<u32> {
        let mut moving = self.interior.clone();
        if let Some(interpolation) = &self.interpolation {
            let others = interpolation.constrained().iter().copied();
            moving.extend(others.filter(|&v| self.ring[v as usize] > 0));
        }
        moving
    }

    /// Hole radius.
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// The same problem with other starting positions (of all vertices, relative to
    /// [`Self::centre`]). Only those of the [`Self::moving`] vertices are used.
    #[must_use]
    pub fn with_positions(mut self, positions: &[DVec3]) -> Self {
        for v in self.moving() {
            self.positions[v as usize] = positions[v as usize];
        }
        self
    }

    /// Positions of the interior vertices in the input mesh's coordinates.
    pub fn to_world(&self, positions: &[DVec3]) -> Vec<DVec3> {
        self.interior
            .iter()
            .map(|&v| positions[v as usize] + self.centre)
            .collect()
    }
}

/// The faces whose energy depends on the interior: those with a corner in ring 0 or 1, apart from
/// the triangles of large fans (more than [`EXACT_VALENCE`] of them) that are far from it.
fn active_faces(topology: &Topology, ring: &[u8]) -> Vec<FaceId> {
    let is_near = |f: &FaceId| {
        let corners = topology.face_vertices(*f);
        corners.iter().any(|v| ring[v.index()] <= 1)
    };
    let mut active: Vec<FaceId> = topology.faces().filter(is_near).collect();
    let is_large = |v: &VertexId| topology.outgoing(*v).nth(EXACT_VALENCE).is_some();
    let in_fan = |f: &FaceId| topology.face_vertices(*f).iter().any(is_large);
    let fans: Vec<FaceId> = active.iter().copied().filter(in_fan).collect();
    if fans.is_empty() {
        return active;
    }
    let elements = elements(topology, &fans, Rule::Three);
    let is_idle = |e: &usize| {
        let mut vertices = elements.vertices_of(*e).iter();
        vertices.all(|&v| ring[v as usize] > 0)
    };
    let idle = (0..elements.len()).filter(is_idle);
    let mut idle: Vec<u32> = idle.map(|e| elements.faces()[e]).collect();
    idle.sort_unstable();
    active.retain(|f| idle.binary_search(&f.0).is_err());
    active
}

fn rings(topology: &Topology, interior: &[u32]) -> Vec<u8> {
    let mut ring = vec![SUPPORT_RINGS + 1; topology.vertex_count()];
    let seeds = interior.iter().map(|&v| VertexId(v));
    let around = Neighbourhood::new(topology, seeds, usize::from(SUPPORT_RINGS));
    for (distance, vertices) in (0..).zip(around.rings()) {
        for v in vertices {
            ring[v.index()] = distance;
        }
    }
    ring
}
