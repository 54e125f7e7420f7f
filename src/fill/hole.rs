//! Holes with their rims and first patches.

use std::sync::Arc;
use std::time::Instant;

use crate::fill::options::FillOptions;
use crate::fill::patch_topology::HoleTopology;
use crate::fill::result::milliseconds;
use crate::fill::rim::rim_geometry;
use crate::mesh::DVec3;
use crate::mesh::{BoundaryLoop, LoopId, Mesh, VertexId};
use crate::patch::{self, Patch, PatchError, RimGeometry};
use crate::warning::Warnings;

/// Distance from the rim, in radii of the hole, above which a surface is [far](HoleRims::far_reach).
const FAR: f64 = 1.6;
/// Maximum number of distances that are computed to see it.
const MAX_DISTANCES: usize = 10_000_000;

/// The rims that one patch joins.
#[derive(Clone, Debug)]
pub(crate) struct HoleRims {
    /// At least one loop. The first represents the hole.
    pub loops: Vec<BoundaryLoop>,
    /// All loops that the patch closes. Those on both sides of a released bridge have one rim.
    pub closed: Vec<LoopId>,
    /// Vertices of the mesh along all rims: the first vertices of the patch, in its order.
    pub vertices: Vec<VertexId>,
    pub geometry: RimGeometry,
    /// The vertices of the patch along which it ends in a crease though its rim is smooth: those of
    /// the curves along which a hole is split. Mostly none.
    pub crease: Vec<usize>,
}

impl HoleRims {
    pub fn new(mesh: &Mesh, loops: &[&BoundaryLoop]) -> Self {
        let geometry = rim_geometry(mesh, loops);
        Self::with_geometry(loops.iter().map(|&one| one.clone()).collect(), geometry)
    }

    pub fn with_geometry(loops: Vec<BoundaryLoop>, geometry: RimGeometry) -> Self {
        Self {
            vertices: loops.iter().flat_map(|l| l.vertices.clone()).collect(),
            closed: loops.iter().map(|l| l.id).collect(),
            loops,
            geometry,
            crease: Vec::new(),
        }
    }

    pub fn id(&self) -> LoopId {
        self.loops[0].id
    }

    /// Whether there are several rims.
    pub fn is_blend(&self) -> bool {
        self.loops.len() > 1
    }

    /// Whether the patch ends at a curve through the hole, across which nothing continues.
    pub fn is_part(&self) -> bool {
        let has_curve = |l: &BoundaryLoop| l.edges() < l.vertices.len();
        self.loops.iter().any(has_curve)
    }

    /// The largest radius of the rims.
    pub fn radius(&self) -> f64 {
        self.loops.iter().map(|l| l.radius).fold(0.0, f64::max)
    }

    /// The largest distance of points from the nearest vertex of the rims, in radii of the hole.
    pub fn reach(&self, points: &[DVec3]) -> f64 {
        let rim: Vec<DVec3> = self.geometry.points().collect();
        // of many points some: a surface has no lone one far away
        let step = points.len() * rim.len() / MAX_DISTANCES + 1;
        let nearest = |p: &DVec3| {
            let distances = rim.iter().map(|q| p.distance_squared(*q));
            distances.fold(f64::INFINITY, f64::min)
        };
        let farthest = points.iter().step_by(step).map(nearest).fold(0.0, f64::max);
        farthest.sqrt() / self.radius()
    }

    /// The [reach](Self::reach) of the new vertices of a patch that is far: farther than a hemisphere over a round rim,
    /// which reaches √2 radii.
    pub fn far_reach(&self, points: &[DVec3]) -> Option<f64> {
        Some(self.reach(points)).filter(|reach| *reach > FAR)
    }

    /// The patch of a triangulation whose new vertices are at `positions`.
    pub fn patch(&self, topology: &HoleTopology, positions: &[DVec3]) -> Patch {
        Patch {
            rim: self.vertices.len(),
            points: self
                .geometry
                .points()
                .chain(positions.iter().copied())
                .collect(),
            triangles: topology.triangles.clone(),
        }
    }
}

/// A hole and its first patch, or the error.
#[derive(Clone, Debug)]
pub(super) struct DraftHole {
    pub rims: Arc<HoleRims>,
    pub patch: Result<Patch, PatchError>,
    /// See [`PlannedHole::has_initial_shape`].
    pub has_initial_shape: bool,
    /// See [`PlannedHole::patch_ms`].
    pub patch_ms: f64,
    /// About islands that the patch does not join, and defects of a patch that no flow changes.
    pub warnings: Warnings,
    /// Whether the patch is known to be sound, or to stay unsound, if no flow changes it.
    pub is_checked: bool,
}

impl DraftHole {
    /// A hole with the first patch between its rims.
    pub fn new(rims: HoleRims, options: &FillOptions) -> Self {
        let start = Instant::now();
        let patch = patch::blend(&rims.geometry, options.patch);
        Self::with_patch(rims, patch, start)
    }

    /// A hole with a first patch whose construction began at `start`.
    pub fn with_patch(rims: HoleRims, patch: Result<Patch, PatchError>, start: Instant) -> Self {
        Self {
            patch,
            rims: Arc::new(rims),
            has_initial_shape: false,
            patch_ms: milliseconds(start),
            warnings: Warnings::default(),
            is_checked: false,
        }
    }
}

/// A hole with its first patch.
#[derive(Clone, Debug)]
pub(crate) struct PlannedHole {
    pub rims: Arc<HoleRims>,
    pub patch: Patch,
    /// Whether the patch is already the start surface of its flow and needs no warm start.
    pub has_initial_shape: bool,
    /// Milliseconds the first patch took.
    pub patch_ms: f64,
    /// Islands that the patch does not join, and defects of a patch that no flow changes.
    pub warnings: Warnings,
}

impl PlannedHole {
    /// The triangles of a patch without new vertices, of vertices of the mesh; none of other patches.
    pub fn loose_triangles(&self) -> impl Iterator<Item = [u32; 3]> + '_ {
        let is_loose = self.patch.new_points().is_empty();
        let triangles = self.patch.triangles.iter().filter(move |_| is_loose);
        triangles.map(|t| t.map(|v| self.rims.vertices[v as usize].0))
    }
}
