//! Vector flows on the control triangles: quasi surface diffusion and its curvature continuous
//! relative.
//!
//! The curvature vector `h = Δx` is piecewise linear, `M h = −L x`, with the lumped mass matrix M
//! and the cotangent Laplacian L of the current triangles. Each flow lowers a quadratic energy:
//!
//! - order 4: `½∫|h|² + t/(2R²) ∫|∇x|²`, the flow `x_t = −Δ²x` (quasi surface diffusion, Xu, Pan &
//!   Bajaj 2006);
//! - order 6: `½∫|∇h|² + t/(2R²) ∫|h|²`, the flow `x_t = Δ³x`. Here h is given on the second ring
//!   around the moving vertices, so that curvatures continue across the rim, apart from parts of it with
//!   free curvature: edges from there to the second ring are left out.
//!
//! t is the tension, R the hole radius. Where the problem has a [`Reference`] of share s with the
//! curvature vector `h'` (in the metric of the triangles), the flow of order 6 contains `h − s h'`
//! instead of h: it copies the shape and bends it smoothly to fit the rim (a Poisson equation for the
//! displacement). Both energies are sums of weighted squares
//! `½ Σ s |Σ c_v x_v|²`. All three components move, so the vertices also spread along the surface.
//!
//! The metric (M and L) is that of the starting triangles until the surface has settled, then that of
//! the settled ones, unless the problem [keeps its metric](FlowProblem::keeping_metric). In each metric the
//! energy is quadratic, and no step raises it.

use std::sync::Arc;

use crate::linear::{Cholesky, CholeskySymbolic, flat, vector};
use crate::mesh::{DVec3, HalfedgeId, Topology, VertexId};
use crate::solver::assembly::EnergySum;
use crate::solver::control::Attempt;
use crate::solver::evaluator::State;
use crate::solver::options::SurfaceModel;
use crate::solver::record::{RejectReason, StepKind};
use crate::solver::sparsity::{IndexLists, ListGraph, SymmetricScatter};
use crate::solver::stepper::{StepRequest, Stepper};
use crate::solver::unknowns::Unknowns;
use crate::solver::{FlowProblem, Reference, SolverError};

/// Displacement, scaled to the natural time and relative to the hole radius, below which the surface
/// has settled in a metric.
const SETTLED: f64 = 1e-3;
/// Number of metric updates. Each update lets the vertices slide a little in the same direction. On
/// scans (`real/`) one update left 0.6 % of the triangles with an angle below 10°, 20 left 7 %.
const UPDATES: usize = 1;
/// Weight of an edge between two equilateral triangles.
const EQUILATERAL: f64 = 0.577_350_269_189_625_8;
/// Lower limit of edge weights, relative to [`EQUILATERAL`], so that obtuse angles keep the
/// Laplacian elliptic.
const MIN_WEIGHT: f64 = 0.03;
/// Limit of the cotangent of an angle (3°).
const MAX_COTANGENT: f64 = 20.0;
/// Lower limit of the area at a vertex, relative to the mean.
pub(super) const MIN_AREA: f64 = 1.0 / 64.0;

/// Weight of equations for which a reference of share 1 should give a value but has no positions, relative
/// to those for which it gives one: there the surface is known much better. On scans (`real/`) 0.03 was
/// better than 0.001 and 0.3.
const WITHOUT_REFERENCE: f64 = 0.03;

/// The contribution of a reference to a curvature vector.
#[derive(Clone, Copy, Debug)]
struct Referred {
    /// The number of the reference.
    number: usize,
    /// The curvature vector of the reference times its share, if it is known.
    curvature: Option<DVec3>,
    /// Weight of squares without it: the expected square of what the reference leaves, relative to that
    /// without a reference.
    weight: f64,
}

/// State of a vector flow.
pub struct DiffusionFlow {
    problem: FlowProblem,
    unknowns: Unknowns,
    squares: Squares,
    scatter: SymmetricScatter,
    factor: Cholesky,
    updates_left: usize,
    state: State,
    /// Area at each moving vertex.
    mass: Vec<f64>,
    /// Matrix of the energy, in the order of the pattern.
    matrix: Vec<f64>,
}

/// What a square of the energy contains.
#[derive(Clone, Copy, Debug)]
enum Term {
    /// The curvature vector of a vertex, by its number.
    Curvature(u32),
    /// The difference of the curvature vectors at the ends of an edge. One without a number is 0.
    Gradient(HalfedgeId, [Option<u32>; 2]),
    /// An edge itself.
    Edge(HalfedgeId),
}

/// The squares of an energy.
struct Squares {
    model: SurfaceModel,
    /// t/R².
    tension: f64,
    /// The vertices with a curvature vector.
    centres: Vec<u32>,
    /// The moving vertices on which each curvature vector depends: its own, then its neighbours.
    rings: IndexLists,
    terms: Vec<Term>,
    /// The moving vertices of each term.
    vertices: IndexLists,
    /// Of each term, for each item of its rings, the place in its vertices.
    places: IndexLists,
}

/// Lengths and areas of the current triangles.
struct Metric {
    /// Half the cotangent of the angle opposite each half-edge.
    half_cotangents: Vec<f64>,
    /// A third of the area of the triangles at each vertex.
    mass: Vec<f64>,
}

impl Metric {
    fn new(topology: &Topology, x: &[DVec3]) -> Self {
        let mut half_cotangents = vec![0.0; topology.halfedge_count()];
        let mut mass = vec![0.0; topology.vertex_count()];
        for f in topology.faces() {
            let [i, j, k] = topology.face_vertices(f);
            let double = (x[j.index()] - x[i.index()])
                .cross(x[k.index()] - x[i.index()])
                .length();
            for v in [i, j, k] {
                mass[v.index()] += double / 6.0;
            }
            for h in topology.face_halfedges(f) {
                let apex = x[topology.target(topology.next(h)).index()];
                let u = x[topology.origin(h).index()] - apex;
                let v = x[topology.target(h).index()] - apex;
                half_cotangents[h.index()] = half_cotangent(u, v, double);
            }
        }
        let (sum, count) = mass
            .iter()
            .filter(|&&m| m > 0.0)
            .fold((0.0, 0.0), |(sum, count), m| (sum + m, count + 1.0));
        for m in &mut mass {
            *m = m.max(MIN_AREA * sum / count);
        }
        Self {
            half_cotangents,
            mass,
        }
    }

    fn weight(&self, h: HalfedgeId) -> f64 {
        let [own, other] = [h, h.twin()].map(|h| self.half_cotangents[h.index()]);
        edge_weight(own + other)
    }
}

/// Half the cotangent of the angle between two edges, given twice the area of their triangle.
pub(super) fn half_cotangent(u: DVec3, v: DVec3, double: f64) -> f64 {
    // a triangle without extent has no angles
    let cotangent = if double > 0.0 { u.dot(v) / double } else { 0.0 };
    0.5 * cotangent.clamp(-MAX_COTANGENT, MAX_COTANGENT)
}

/// Weight of an edge, given the sum of the half cotangents of the angles opposite it.
pub(super) fn edge_weight(sum: f64) -> f64 {
    sum.max(MIN_WEIGHT * EQUILATERAL)
}

impl Squares {
    fn new(problem: &FlowProblem, model: SurfaceModel, tension: f64) -> Self {
        let topology = problem.topology();
        let ring = problem.ring();
        let is_crease = problem.crease_marks();
        let reach = match model {
            SurfaceModel::G2 => 2,
            _ => 1,
        };
        let mut number: Vec<Option<u32>> = vec![None; ring.len()];
        let mut centres = Vec::new();
        let mut rings = IndexLists {
            start: vec![0],
            items: Vec::new(),
        };
        for v in topology.vertices() {
            let is_inside = topology.has_faces(v) && !topology.is_boundary_vertex(v);
            if ring[v.index()] <= reach && is_inside && !is_crease[v.index()] {
                number[v.index()] = Some(rings.len() as u32);
                centres.push(v.0);
                let all = std::iter::once(v).chain(topology.neighbours(v));
                let moving = all.filter(|v| ring[v.index()] == 0);
                rings.items.extend(moving.map(|v| v.0));
                rings.start.push(rings.items.len() as u32);
            }
        }
        let mut out = Self {
            model,
            tension: tension / (problem.radius() * problem.radius()),
            centres,
            rings,
            terms: Vec::new(),
            vertices: IndexLists {
                start: vec![0],
                items: Vec::new(),
            },
            places: IndexLists {
                start: vec![0],
                items: Vec::new(),
            },
        };
        let is_near = |v: VertexId| ring[v.index()] <= 1;
        if model == SurfaceModel::G2 {
            let is_free = problem.free_curvature_marks();
            for h in topology.edges() {
                let ends = [topology.origin(h), topology.target(h)];
                let is_outside = |v: &VertexId| ring[v.index()] > 1;
                if ends.iter().any(|v| is_free[v.index()]) && ends.iter().any(is_outside) {
                    continue;
                }
                let known = ends.map(|v| number[v.index()].is_some() || is_crease[v.index()]);
                if known == [true; 2] && ends.iter().any(|&v| is_near(v)) {
                    out.push(Term::Gradient(h, ends.map(|v| number[v.index()])), problem);
                }
            }
        } else if tension != 0.0 {
            for h in topology.edges() {
                let ends = [topology.origin(h), topology.target(h)];
                if ends.iter().any(|&v| ring[v.index()] == 0) {
                    out.push(Term::Edge(h), problem);
                }
            }
        }
        if model != SurfaceModel::G2 || tension != 0.0 {
            for v in topology.vertices().filter(|&v| is_near(v)) {
                if let Some(i) = number[v.index()] {
                    out.push(Term::Curvature(i), problem);
                }
            }
        }
        out
    }

    fn push(&mut self, term: Term, problem: &FlowProblem) {
        let topology = problem.topology();
        let begin = self.vertices.items.len();
        let used = match term {
            Term::Curvature(i) => [Some(i), None],
            Term::Gradient(_, ends) => ends,
            Term::Edge(h) => {
                let ends = [topology.origin(h), topology.target(h)].into_iter();
                let moving = ends.filter(|v| problem.ring()[v.index()] == 0);
                self.vertices.items.extend(moving.map(|v| v.0));
                [None; 2]
            }
        };
        for i in used.into_iter().flatten() {
            for at in self.rings.start[i as usize]..self.rings.start[i as usize + 1] {
                let v = self.rings.items[at as usize];
                let own = &self.vertices.items[begin..];
                let place = own.iter().position(|&w| w == v).unwrap_or(own.len());
                if place == own.len() {
                    self.vertices.items.push(v);
                }
                self.places.items.push(place as u32);
            }
        }
        self.terms.push(term);
        self.vertices.start.push(self.vertices.items.len() as u32);
        self.places.start.push(self.places.items.len() as u32);
    }

    /// Curvature vectors `−(L x)_v / m_v`: the coefficients of the moving vertices of each ring, and
    /// the sum over the fixed ones.
    fn laplacians(&self, problem: &FlowProblem, metric: &Metric) -> (Vec<f64>, Vec<DVec3>) {
        let (topology, fixed) = (problem.topology(), problem.positions());
        let is_moving = |v: VertexId| problem.ring()[v.index()] == 0;
        let mut out = Vec::with_capacity(self.rings.items.len());
        let mut constants = Vec::with_capacity(self.centres.len());
        for &centre in &self.centres {
            let v = VertexId(centre);
            let per_mass = 1.0 / metric.mass[v.index()];
            let own = out.len();
            if is_moving(v) {
                out.push(0.0);
            }
            let (mut sum, mut constant) = (0.0, DVec3::ZERO);
            for h in topology.outgoing(v) {
                let w = metric.weight(h) * per_mass;
                sum += w;
                let to = topology.target(h);
                if is_moving(to) {
                    out.push(w);
                } else {
                    constant += w * fixed[to.index()];
                }
            }
            if is_moving(v) {
                out[own] = -sum;
            } else {
                constant -= sum * fixed[v.index()];
            }
            constants.push(constant);
        }
        (out, constants)
    }

    /// What the references say about each curvature vector.
    fn references(&self, problem: &FlowProblem, metric: &Metric) -> Vec<Option<Referred>> {
        if problem.references().is_empty() {
            return vec![None; self.centres.len()];
        }
        let topology = problem.topology();
        let curvature = |v: VertexId, shape: &Reference| {
            let at = |v: VertexId| shape.positions.get(&v.0).copied().flatten();
            let own = at(v)?;
            let edges = topology.outgoing(v);
            let edges = edges.map(|h| Some(metric.weight(h) * (at(topology.target(h))? - own)));
            Some(shape.share * edges.sum::<Option<DVec3>>()? / metric.mass[v.index()])
        };
        let first = |&v: &u32| {
            let mut shapes = problem.references().iter().enumerate();
            let (number, shape) = shapes.find(|(_, shape)| shape.positions.contains_key(&v))?;
            let own = 1.0 - shape.share;
            Some(Referred {
                number,
                curvature: curvature(VertexId(v), shape),
                weight: own * own + shape.share * shape.share * WITHOUT_REFERENCE,
            })
        };
        self.centres.iter().map(first).collect()
    }

    /// Calls `visit` with number, weight, coefficients and constant of each square.
    fn for_each(
        &self,
        problem: &FlowProblem,
        metric: &Metric,
        mut visit: impl FnMut(usize, f64, &[f64], DVec3),
    ) {
        let (topology, fixed) = (problem.topology(), problem.positions());
        let (laplacians, constants) = self.laplacians(problem, metric);
        let references = self.references(problem, metric);
        let lower = match self.model {
            SurfaceModel::G2 => self.tension,
            _ => 1.0,
        };
        let mut coefficients = Vec::new();
        for (e, term) in self.terms.iter().enumerate() {
            coefficients.clear();
            coefficients.resize(self.vertices.of(e).len(), 0.0);
            let mut constant = DVec3::ZERO;
            let (weight, used) = match *term {
                Term::Curvature(i) => {
                    let mut weight = lower;
                    if let Some(own) = references[i as usize] {
                        match own.curvature {
                            Some(curvature) => constant -= curvature,
                            None => weight *= own.weight,
                        }
                    }
                    let v = self.centres[i as usize] as usize;
                    (weight * metric.mass[v], [Some(i), None])
                }
                Term::Gradient(h, ends) => {
                    let mut weight = metric.weight(h);
                    if let [Some(from), Some(to)] = ends.map(|i| references[i? as usize])
                        && from.number == to.number
                    {
                        match (from.curvature, to.curvature) {
                            (Some(a), Some(b)) => constant -= a - b,
                            _ => weight *= from.weight,
                        }
                    }
                    (weight, ends)
                }
                Term::Edge(h) => {
                    let ends = [topology.origin(h), topology.target(h)];
                    let mut moving = coefficients.iter_mut();
                    for (v, sign) in ends.map(VertexId::index).into_iter().zip([1.0, -1.0]) {
                        if problem.ring()[v] != 0 {
                            constant += sign * fixed[v];
                        } else if let Some(coefficient) = moving.next() {
                            *coefficient = sign;
                        }
                    }
                    (self.tension * metric.weight(h), [None; 2])
                }
            };
            let mut places = self.places.of(e).iter();
            for (i, sign) in used.into_iter().zip([1.0, -1.0]) {
                let Some(i) = i else { continue };
                constant += sign * constants[i as usize];
                let range = self.rings.start[i as usize]..self.rings.start[i as usize + 1];
                for (at, &place) in range.zip(&mut places) {
                    coefficients[place as usize] += sign * laplacians[at as usize];
                }
            }
            visit(e, weight, &coefficients, constant);
        }
    }
}

impl DiffusionFlow {
    /// The flow of a surface model other than `Energy` from the problem's positions. `tension` is
    /// t, without a unit.
    ///
    /// # Errors
    /// A failed symbolic factorization.
    pub fn new(
        problem: &FlowProblem,
        model: SurfaceModel,
        tension: f64,
    ) -> Result<Self, SolverError> {
        let squares = Squares::new(problem, model, tension);
        let unordered = Unknowns::new(problem.positions().len(), problem.interior().to_vec());
        let vertices = squares.vertices.items.iter();
        let lists = IndexLists {
            start: squares.vertices.start.clone(),
            items: vertices.map(|&v| unordered.of_vertex[v as usize]).collect(),
        };
        let graph = ListGraph::new(&lists, unordered.len());
        let order = graph.dissect(&unordered.points(problem.positions()));
        let scatter = graph.scatter(&order);
        let symbolic = Arc::new(CholeskySymbolic::new(&scatter.pattern)?);
        let mut flow = Self {
            problem: problem.clone(),
            unknowns: unordered.reordered(&order),
            squares,
            scatter,
            factor: Cholesky::new(symbolic),
            updates_left: UPDATES,
            state: State {
                positions: problem.positions().to_vec(),
                ..State::default()
            },
            mass: Vec::new(),
            matrix: Vec::new(),
        };
        flow.update_metric();
        Ok(flow)
    }

    fn radius(&self) -> f64 {
        self.problem.radius()
    }

    /// Computes matrix, energy and gradient in the metric of the current positions, or of the starting ones
    /// if the problem keeps it.
    fn update_metric(&mut self) {
        let of = if self.problem.keeps_metric() {
            self.problem.positions()
        } else {
            &self.state.positions
        };
        let metric = Metric::new(self.problem.topology(), of);
        let x = &self.state.positions;
        self.matrix.clear();
        self.matrix.resize(self.scatter.pattern.nnz(), 0.0);
        let mut gradient = vec![DVec3::ZERO; self.unknowns.len()];
        let mut energy = 0.0;
        self.squares
            .for_each(&self.problem, &metric, |e, weight, c, constant| {
                let vertices = self.squares.vertices.of(e);
                let moving = c.iter().zip(vertices).map(|(c, &v)| *c * x[v as usize]);
                let value = constant + moving.sum::<DVec3>();
                energy += 0.5 * weight * value.length_squared();
                for (c, &v) in c.iter().zip(vertices) {
                    gradient[self.unknowns.of_vertex[v as usize] as usize] += weight * c * value;
                }
                let mut slots = self.scatter.slots(e).iter();
                for (i, ci) in c.iter().enumerate() {
                    for (cj, &slot) in c[..=i].iter().zip(&mut slots) {
                        self.matrix[slot as usize] += weight * ci * cj;
                    }
                }
            });
        self.state.gradient = gradient;
        self.state.energy = EnergySum {
            value: energy,
            scale: energy,
        };
        let moving = self.unknowns.vertex.iter();
        self.mass = moving.map(|&v| metric.mass[v as usize]).collect();
    }

    /// Updates energy and gradient after the displacement `shift`, in the same metric.
    fn follow(&mut self, shift: &[DVec3]) {
        let pattern = &self.scatter.pattern;
        let mut change = vec![DVec3::ZERO; shift.len()];
        for j in 0..pattern.n {
            for at in pattern.col_ptr[j]..pattern.col_ptr[j + 1] {
                let i = pattern.row_idx[at];
                change[i] += self.matrix[at] * shift[j];
                if i != j {
                    change[j] += self.matrix[at] * shift[i];
                }
            }
        }
        for ((g, c), d) in self.state.gradient.iter_mut().zip(&change).zip(shift) {
            self.state.energy.value += g.dot(*d) + 0.5 * c.dot(*d);
            *g += *c;
        }
    }
}

impl Stepper for DiffusionFlow {
    fn state(&self) -> &State {
        &self.state
    }

    /// One implicit step `(M/τ + A) d = −∇E`. Its energy in the metric of the step never rises.
    fn attempt(&mut self, request: &StepRequest) -> Attempt {
        let mut values = self.matrix.clone();
        for (m, &diagonal) in self.mass.iter().zip(&self.scatter.pattern.col_ptr) {
            values[diagonal] += m / request.tau;
        }
        if let Err(error) = self.factor.factorize(&values) {
            return Attempt::rejected(error.into());
        }
        let mut solution = flat(self.state.gradient.iter().map(|&g| -g));
        self.factor.solve_in_place(&mut solution, 3);
        let shift: Vec<DVec3> = (0..self.unknowns.len())
            .map(|i| vector(&solution, i))
            .collect();
        let mut longest = shift.iter().map(|d| d.length()).fold(0.0, f64::max);
        if !shift.iter().all(|d| d.is_finite()) {
            return Attempt::rejected(RejectReason::NoDescent);
        }
        for (&v, d) in self.unknowns.vertex.iter().zip(&shift) {
            self.state.positions[v as usize] += *d;
        }
        let natural_time = self.squares.model.natural_time(self.radius());
        let scaled = longest / self.radius() * (natural_time / request.tau).max(1.0);
        if self.updates_left > 0 && scaled < SETTLED {
            self.updates_left -= 1;
            self.update_metric();
            // the surface is not stationary in the new metric
            longest = longest.max(SETTLED * self.radius());
        } else {
            self.follow(&shift);
        }
        Attempt::accepted(longest, StepKind::Factorized)
    }

    fn set_references(&mut self, problem: &FlowProblem) {
        self.problem = problem.clone();
        self.update_metric();
    }

    /// The flow already spreads the vertices along the surface.
    fn normals(&self) -> Option<(&[u32], &[DVec3])> {
        None
    }

    fn slide(&mut self, _: &[DVec3], _: EnergySum) -> bool {
        false
    }

    /// The time in which detail of the size of an edge relaxes.
    fn first_tau(&self, tau_ref: f64) -> f64 {
        let mean = self.mass.iter().sum::<f64>() / self.mass.len().max(1) as f64;
        let natural_time = |length| self.squares.model.natural_time(length);
        tau_ref / natural_time(self.radius()) * natural_time(mean.sqrt())
    }
}

#[cfg(test)]
#[path = "diffusion_tests.rs"]
mod tests;
