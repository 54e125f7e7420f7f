//! What may be chosen about a refinement, and what can keep it from starting.

use crate::mesh::{HalfedgeId, Mesh};
use crate::refine::BoundaryRule;
use crate::refine::creases::crease_edges;
use crate::refine::measures::radius;
use crate::solver::energy::Energy;
use crate::solver::{FlowOptions, SolverError};

/// How new vertices are placed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Method {
    /// By a geometric flow; the given vertices lie on the limit surface.
    #[default]
    Pde,
    /// By the modified Butterfly scheme; the given vertices stay.
    Butterfly,
    /// By Loop's scheme, which does not interpolate: the given vertices move.
    Loop,
}

/// Which vertices the limit surface keeps passing from the second level on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Hold {
    /// All vertices of the previous level, as in the paper.
    #[default]
    Previous,
    /// The given vertices only: lower energies, farther from the first level.
    Given,
}

/// Everything about a refinement that may be chosen.
#[derive(Clone, Debug)]
pub struct RefineOptions {
    /// 1→4 splits.
    pub levels: usize,
    /// The method.
    pub method: Method,
    /// What later levels hold.
    pub hold: Hold,
    /// Energy, mode, τ and steps (of each level) of the flow. Scheme and quadrature are chosen by
    /// the refinement.
    pub flow: FlowOptions,
    /// Boundaries and creases between their vertices.
    pub boundary: BoundaryRule,
    /// A vertex of a boundary or crease is a corner where that turns by more than this, radians.
    pub corner_angle: f64,
    /// Edges at which the triangles differ by more than this are creases, radians.
    pub crease_angle: Option<f64>,
    /// More creases, by the ends of the edges.
    pub creases: Vec<[u32; 2]>,
    /// Refine only these faces (one flag each); those beside them are cut to fit.
    pub region: Option<Vec<bool>>,
}

/// Most levels: 4^12 triangles of each.
pub const MAX_LEVELS: usize = 12;
/// Weight of the area in [`natural_tension`], in units of the inverse squared edge length.
pub const TENSION: f64 = 4.0;

impl RefineOptions {
    /// Three levels by the flow of the given energy, everything else at its default.
    pub fn new(energy: Energy) -> Self {
        Self {
            levels: 3,
            method: Method::default(),
            hold: Hold::default(),
            flow: FlowOptions::new(energy),
            boundary: BoundaryRule::default(),
            corner_angle: std::f64::consts::FRAC_PI_4,
            crease_angle: None,
            creases: Vec::new(),
            region: None,
        }
    }

    /// # Errors
    /// [`RefineError`] naming the option that is out of range.
    pub fn validate(&self, mesh: &Mesh) -> Result<(), RefineError> {
        if self.levels > MAX_LEVELS {
            return Err(RefineError::TooManyLevels {
                levels: self.levels,
            });
        }
        let faces = mesh.face_count() as u64;
        if self.region.is_none() && faces << (2 * self.levels) > u64::from(u32::MAX) / 3 {
            return Err(RefineError::TooManyLevels {
                levels: self.levels,
            });
        }
        if let Some(region) = &self.region
            && region.len() != mesh.face_count()
        {
            return Err(RefineError::BadRegion {
                flags: region.len(),
                faces: mesh.face_count(),
            });
        }
        if self.corner_angle.is_nan() || self.corner_angle <= 0.0 {
            return Err(RefineError::BadAngle {
                which: "corner",
                angle: self.corner_angle.to_degrees(),
            });
        }
        if let Some(angle) = self.crease_angle
            && (angle.is_nan() || angle <= 0.0)
        {
            return Err(RefineError::BadAngle {
                which: "crease",
                angle: angle.to_degrees(),
            });
        }
        crease_edges(mesh, self)?;
        Ok(self.flow.validate()?)
    }
}

/// The tension ([`FlowOptions::tension`]) that makes bending and area balance over the mesh's own edge
/// length, `4 r²/h²` with `h` the mean edge length and `r` the [`radius`]: the surface does not bulge
/// between sparse vertices. `H²` alone knows no scale and inflates what the mesh leaves open.
pub fn natural_tension(mesh: &Mesh) -> f64 {
    let topology = &mesh.topology;
    let lengths = (0..topology.halfedge_count()).step_by(2).map(|h| {
        let h = HalfedgeId::from(h);
        mesh.position(topology.origin(h))
            .distance(mesh.position(topology.target(h)))
    });
    let edges = (topology.halfedge_count() / 2).max(1);
    let mean = lengths.sum::<f64>() / edges as f64;
    let tension = TENSION * (radius(mesh) / mean).powi(2);
    if tension.is_finite() { tension } else { 0.0 }
}

/// Why a mesh cannot be refined.
#[derive(Clone, Debug, thiserror::Error)]
pub enum RefineError {
    /// The result would be too large.
    #[error(
        "{levels} levels make more triangles than a mesh can hold; take fewer (each level makes \
         four of one)"
    )]
    TooManyLevels {
        /// Levels asked for.
        levels: usize,
    },
    /// The region does not belong to the mesh.
    #[error("the region has {flags} flags for {faces} faces; give one for each")]
    BadRegion {
        /// Flags given.
        flags: usize,
        /// Faces of the mesh.
        faces: usize,
    },
    /// An angle is not positive.
    #[error("the {which} angle is {angle} degrees; give a positive number")]
    BadAngle {
        /// Of corners or of creases.
        which: &'static str,
        /// In degrees.
        angle: f64,
    },
    /// A crease is no edge of the mesh.
    #[error(
        "the crease from vertex {} to vertex {} (counted from 1) is no edge of the mesh; name \
         neighbouring vertices",
        ends[0] + 1,
        ends[1] + 1
    )]
    NoCrease {
        /// The vertices.
        ends: [u32; 2],
    },
    /// A crease is too short to be one.
    #[error(
        "the crease from vertex {} to vertex {} (counted from 1) is a single edge that meets no \
         other crease and no boundary; add a neighbouring edge or leave it out",
        ends[0] + 1,
        ends[1] + 1
    )]
    LoneCrease {
        /// The vertices.
        ends: [u32; 2],
    },
    /// There is nothing to refine.
    #[error("the mesh has no triangle that can be refined")]
    NoFaces,
    /// The system gives no thread.
    #[error("the system gives no thread for the refinement: {0}")]
    Thread(String),
    /// The flow cannot run.
    #[error(transparent)]
    Solver(#[from] SolverError),
}
