//! Options of a refinement, and the errors that prevent it from starting.

use std::collections::BTreeMap;

use crate::energy::{Energy, ExprError, Preset};
use crate::memory::TooLittleMemory;
use crate::mesh::{Mesh, dihedral_angle};
use crate::options::{choices, options};
use crate::refine::BoundaryRule;
use crate::refine::measures::radius;
use crate::solver::{FlowOptions, Mode, SolverError, Tau};

/// How new vertices are placed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Method {
    /// By a geometric flow; the limit surface interpolates the input vertices.
    #[default]
    Pde,
    /// By the modified Butterfly scheme; the input vertices stay.
    Butterfly,
    /// By Loop's scheme, which does not interpolate: the input vertices move.
    Loop,
}

choices!(Method: Pde "pde", Butterfly "butterfly", Loop "loop");

/// The vertices that the limit surface interpolates from the second level on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Hold {
    /// All vertices of the previous level, as in the paper.
    #[default]
    Previous,
    /// The input vertices only: lower energies, but larger deviation from the first level.
    Given,
}

choices!(Hold: Previous "previous", Given "given");

options! {
    /// The options of a refinement.
    pub struct RefineControls {
        /// Number of levels: on each, every triangle is cut into four.
        levels("N"): usize = 3,
        /// How new vertices are placed: `pde` by a flow, `butterfly` and `loop` by the subdivision
        /// schemes of these names.
        method: Method = Method::default(),
        /// Energy f(H,K): a preset or an expression [default: auto, which is sqrt(k1^2+k2^2+c^2)
        /// with the c and the tension that suit the mesh's edge length].
        energy("F"): Option<String> = None,
        /// Value of a parameter of the energy (repeatable).
        param("NAME=VALUE"): BTreeMap<String, f64> = BTreeMap::new(),
        /// Weight of the area beside the energy, in units of 1/r^2, r the RMS distance of the
        /// vertices from their mean [default: auto, which is 0 for a given energy].
        tension("W"): Option<f64> = None,
        /// Which vertices the surface interpolates from the second level on: all vertices of the
        /// previous level, or those of IN only.
        hold: Hold = Hold::default(),
        /// Shape of boundaries and creases between their vertices.
        boundary: BoundaryRule = BoundaryRule::default(),
        /// A vertex of a boundary or crease is a corner if the curve turns there by more than this
        /// angle, in degrees.
        corner_angle("DEG"): f64 = 45.0,
        /// Keep edges sharp at which the triangles' normals differ by more than this angle, in
        /// degrees.
        crease_angle("DEG"): Option<f64> = None,
        /// `fast` computes the stationary shape in few steps, `flow` follows the flow in true time.
        mode: Mode = Mode::default(),
        /// Time step: auto, or a fixed one (length^2 / unit of f).
        tau("T"): Tau = Tau::default(),
        /// Factor of an adaptive time step after an accepted step [default: 10 in fast mode, 1.3 in
        /// flow mode].
        growth("F"): Option<f64> = None,
        /// Spontaneous curvature in units of 1/r, with r as for --tension.
        bulge("C"): f64 = 0.0,
        /// Maximum number of steps on a level.
        steps("N"): usize = 400,
    }
}

impl RefineControls {
    /// The energy, if one is given.
    ///
    /// # Errors
    /// An invalid energy.
    pub fn given_energy(&self) -> Result<Option<Energy>, ExprError> {
        let text = self.energy.as_deref();
        text.map(|text| Energy::parse(text, &self.param))
            .transpose()
    }

    /// The options of the flow on a mesh. Defaults for energy and tension are adapted to the mesh.
    ///
    /// # Errors
    /// [`RefineError::Energy`], or an option of the flow out of range.
    pub fn flow(&self, mesh: &Mesh) -> Result<FlowOptions, RefineError> {
        let (energy, tension) = match self.given_energy()? {
            Some(energy) => (energy, 0.0),
            None => mesh_adapted_flow(mesh),
        };
        self.flow_of(energy, tension)
    }

    /// Checks the values that do not depend on a mesh.
    ///
    /// # Errors
    /// The first invalid option.
    pub fn check(&self) -> Result<(), RefineError> {
        if self.levels > MAX_LEVELS {
            return Err(RefineError::TooManyLevels {
                levels: self.levels,
            });
        }
        let energy = self.given_energy()?;
        let energy = energy.unwrap_or_else(|| Energy::preset(Preset::H2));
        self.flow_of(energy, 0.0).map(|_| ())
    }

    fn flow_of(&self, energy: Energy, tension: f64) -> Result<FlowOptions, RefineError> {
        if energy.gradient() != 0.0 {
            return Err(RefineError::Solver(SolverError::BadOption {
                option: "energy",
                value: energy.text().to_owned(),
                expected: "a refinement needs an energy without gradH2",
            }));
        }
        let mut flow = FlowOptions::new(energy);
        flow.tension = self.tension.unwrap_or(tension);
        flow.mode = self.mode;
        (flow.tau, flow.growth, flow.bulge) = (self.tau, self.growth, self.bulge);
        flow.max_steps = self.steps;
        flow.validate()?;
        Ok(flow)
    }
}

/// All settings of the refinement of one mesh.
#[derive(Clone, Debug, Default)]
pub struct RefineOptions {
    /// What may change during the refinement.
    pub controls: RefineControls,
    /// Further creases, by the ends of their edges.
    pub creases: Vec<[u32; 2]>,
    /// Refine only these faces (one flag per face). Neighbouring faces are split to match.
    pub region: Option<Vec<bool>>,
}

impl From<RefineControls> for RefineOptions {
    fn from(controls: RefineControls) -> Self {
        Self {
            controls,
            ..Self::default()
        }
    }
}

/// Maximum number of levels; 4^12 triangles from each input triangle.
pub const MAX_LEVELS: usize = 12;
/// Curvature above which bends cost their angle in [`mesh_adapted_flow`], in median bends over an edge.
const BENDS: f64 = 3.0;
/// Weight of the area against that of the bending there, over the inverse squared edge length.
const AREA: f64 = 3.0;

impl RefineOptions {
    /// The memory in bytes that the last level takes.
    pub(super) fn memory(&self, mesh: &Mesh) -> f64 {
        let all = mesh.face_count();
        let refined = (self.region.as_ref()).map_or(all, |r| r.iter().filter(|&&f| f).count());
        self.controls.estimate(refined, all).bytes
    }

    /// # Errors
    /// [`RefineError`] naming the option that is out of range.
    pub fn validate(&self, mesh: &Mesh) -> Result<(), RefineError> {
        let controls = &self.controls;
        controls.check()?;
        let (levels, faces) = (controls.levels, mesh.face_count() as u64);
        if self.region.is_none() && faces << (2 * levels) > u64::from(u32::MAX) / 3 {
            return Err(RefineError::TooManyLevels { levels });
        }
        if let Some(region) = &self.region
            && region.len() != mesh.face_count()
        {
            return Err(RefineError::BadRegion {
                flags: region.len(),
                faces: mesh.face_count(),
            });
        }
        let angles = [
            ("corner", Some(controls.corner_angle)),
            ("crease", controls.crease_angle),
        ];
        for (which, angle) in angles {
            if let Some(angle) = angle.filter(|angle| angle.is_nan() || *angle <= 0.0) {
                return Err(RefineError::BadAngle { which, angle });
            }
        }
        Ok(())
    }
}

/// The energy and the tension ([`FlowOptions::tension`]) adapted to a mesh: `√(κ1² + κ2² + c²) + t`
/// with `c = max(1, 3 θ) / h` and `c + t = 3 / (c h²)`. Here `h` is the mean edge length and `θ`
/// the median angle between triangles, in radians.
///
/// Bends much sharper than most edges of the mesh cost their angle. Weaker bends cost their square,
/// as under `H²`. Over one edge, the area counts as much as the bending. `H²` alone costs the
/// square of every bend, so it rounds edges off and bulges beside them. It also has no length
/// scale, so the surface inflates between sparse vertices.
pub fn mesh_adapted_flow(mesh: &Mesh) -> (Energy, f64) {
    let (length, angle) = (mean_edge(mesh), median_bend(mesh));
    let c = (BENDS * angle).max(1.0) / length;
    let total = Energy::preset(Preset::CurvatureNorm);
    match total.with_param("c", c) {
        Ok(energy) if c > 0.0 => {
            let tension = AREA / (c * length * length) - c;
            (energy, tension * radius(mesh).powi(2))
        }
        _ => (total, 0.0), // all vertices in one place
    }
}

fn mean_edge(mesh: &Mesh) -> f64 {
    let topology = &mesh.topology;
    let lengths = topology.edges().map(|h| mesh.edge_length(h));
    lengths.sum::<f64>() / topology.edges().len().max(1) as f64
}

/// Median over the inner edges of the angle their triangles' normals make, radians.
fn median_bend(mesh: &Mesh) -> f64 {
    let topology = &mesh.topology;
    let mut bends: Vec<f64> = topology
        .edges()
        .filter(|&h| !topology.is_boundary_edge(h))
        .map(|h| dihedral_angle(&mesh.positions, topology, h))
        .collect();
    let middle = bends.len() / 2;
    if bends.is_empty() {
        return 0.0;
    }
    *bends.select_nth_unstable_by(middle, f64::total_cmp).1
}

/// Why a mesh cannot be refined.
#[derive(Clone, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RefineError {
    /// The result would be too large.
    #[error(
        "{levels} levels give more triangles than a mesh can hold; use fewer (each level replaces \
         a triangle by four)"
    )]
    TooManyLevels {
        /// Requested number of levels.
        levels: usize,
    },
    /// The region does not belong to the mesh.
    #[error("the region has {flags} flags for {faces} faces; give one for each")]
    BadRegion {
        /// Number of flags.
        flags: usize,
        /// Number of faces of the mesh.
        faces: usize,
    },
    /// An angle is not positive.
    #[error("the {which} angle is {angle} degrees; give a positive number")]
    BadAngle {
        /// `corner` or `crease`.
        which: &'static str,
        /// In degrees.
        angle: f64,
    },
    /// A crease is not an edge of the mesh.
    #[error(
        "the crease from vertex {} to vertex {} (counted from 1) is not an edge of the mesh; name \
         adjacent vertices",
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
         other crease and no boundary; add an adjacent edge or omit it",
        ends[0] + 1,
        ends[1] + 1
    )]
    LoneCrease {
        /// The vertices.
        ends: [u32; 2],
    },
    /// The levels need more memory than is free.
    #[error("{0}; use fewer levels or refine fewer faces")]
    Memory(#[from] TooLittleMemory),
    /// There is nothing to refine.
    #[error("the mesh has no triangle that can be refined")]
    NoFaces,
    /// The energy, with the place in its text.
    #[error(transparent)]
    Energy(#[from] ExprError),
    /// The flow cannot run.
    #[error(transparent)]
    Solver(#[from] SolverError),
}
