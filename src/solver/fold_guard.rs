//! A guard against steps that would fold the surface.
//!
//! An energy sampled at quadrature points does not detect a fold between them, and a minimiser
//! finds such places. Two conditions are therefore checked in addition to the energy. First, on
//! each face the normals of the limit surface stay on the side of the flat triangle through the
//! limit positions of the corners. Second, no two neighbouring flat triangles fold onto each other.
//! A face that is already folded may not get much worse. It may stay folded, because the energy
//! falls when it leaves the fold.

use std::sync::Arc;

use rayon::prelude::*;

use crate::mesh::{DVec3, FaceId, Topology};
use crate::solver::discretization::Discretization;
use crate::subdivision::{Elements, Rule, limit_normals, limit_positions};

/// The finest rule at whose points normals are checked.
const MAX_RULE: Rule = Rule::FortyEight;
/// A face is not folded if its normals have at least this cosine to that of the flat triangle.
const MIN_NORMAL_COSINE: f64 = -0.3;
/// Two neighbouring flat triangles are not folded if their normals have at least this cosine.
const MIN_EDGE_COSINE: f64 = -0.77;
/// Maximum decrease, in one step, of a cosine that is below its limit.
const MAX_DEGRADATION: f64 = 0.3;
/// Cosine of the maximum rotation of the flat triangle of an unfolded face in one step.
const MIN_TURN_COSINE: f64 = 0.5;

/// Cosine between a vector and a unit vector; -1 for a vector without direction.
fn cosine(vector: DVec3, unit: DVec3) -> f64 {
    let length = vector.length();
    if length > 0.0 && length.is_finite() {
        vector.dot(unit) / length
    } else {
        -1.0
    }
}

/// The folds of a surface, the reference with which steps are compared.
#[derive(Clone, Debug, Default)]
struct FoldState {
    /// Minimum cosine between a normal and that of the flat triangle, by element.
    min_normal_cosine: Vec<f64>,
    /// Normal of the flat triangle, by face.
    facet_normals: Vec<DVec3>,
}

impl FoldState {
    /// Computes the state of the surface over `elements`, which cover the faces that may change.
    fn new(topology: &Topology, elements: &Elements, positions: &[DVec3]) -> Self {
        let points = limit_positions(topology, positions);
        let normals = limit_normals(topology, positions);
        let facet_normals: Vec<DVec3> = (0..topology.face_count())
            .map(|f| {
                let corners = topology.face_vertices(FaceId::from(f));
                let [a, b, c] = corners.map(|v| points[v.index()]);
                (b - a).cross(c - a).normalize_or_zero()
            })
            .collect();
        let min_cosine = |local: &mut Vec<DVec3>, e: usize| {
            let (table, vertices) = (elements.table(e), elements.vertices_of(e));
            let facet = facet_normals[elements.faces()[e] as usize];
            local.clear();
            local.extend(vertices.iter().map(|&v| positions[v as usize]));
            let inside = (0..table.points).map(|point| {
                let (du, dv) = (table.row(point, 1), table.row(point, 2));
                let (mut u, mut v) = (DVec3::ZERO, DVec3::ZERO);
                for ((&a, &b), &p) in du.iter().zip(dv).zip(&*local) {
                    u += a * p;
                    v += b * p;
                }
                cosine(u.cross(v), facet)
            });
            let least = inside.fold(1.0, f64::min);
            let corners = vertices[..3]
                .iter()
                .map(|&v| normals[v as usize].dot(facet));
            corners.fold(least, f64::min)
        };
        Self {
            min_normal_cosine: (0..elements.len())
                .into_par_iter()
                .with_min_len(64)
                .map_init(Vec::new, min_cosine)
                .collect(),
            facet_normals,
        }
    }
}

/// Compares steps with the current surface of a flow.
pub struct FoldGuard {
    topology: Arc<Topology>,
    elements: Elements,
    current: FoldState,
    trial: FoldState,
    marked: Vec<bool>,
}

impl FoldGuard {
    /// Starts at the surface over `positions`, sampled by `rule` or by [`MAX_RULE`] if that is
    /// coarser.
    pub fn new(discretization: &Discretization, rule: Rule, positions: &[DVec3]) -> Self {
        let topology = Arc::clone(discretization.topology());
        let elements = discretization.elements(rule.min(MAX_RULE)).clone();
        Self {
            current: FoldState::new(&topology, &elements, positions),
            trial: FoldState::default(),
            marked: vec![false; positions.len()],
            topology,
            elements,
        }
    }

    /// Whether the step to `positions` would fold the surface, or make a fold much worse. Marks the
    /// control vertices of such places.
    pub fn would_fold(&mut self, positions: &[DVec3]) -> bool {
        self.trial = FoldState::new(&self.topology, &self.elements, positions);
        self.marked.fill(false);
        // run both, so that all places are marked
        self.mark_faces() | self.mark_edges()
    }

    /// For each vertex whether the last trial step folds the surface near it.
    pub fn marked(&self) -> &[bool] {
        &self.marked
    }

    /// Makes the last trial surface the current one.
    pub fn accept(&mut self) {
        std::mem::swap(&mut self.current, &mut self.trial);
    }

    /// Makes another surface the current one.
    pub fn reset(&mut self, positions: &[DVec3]) {
        self.current = FoldState::new(&self.topology, &self.elements, positions);
    }

    /// Marks the faces whose normals leave the side of their flat triangle, or whose flat triangle
    /// turns too far.
    fn mark_faces(&mut self) -> bool {
        let (old, new) = (&self.current, &self.trial);
        let mut any = false;
        for (e, &f) in self.elements.faces().iter().enumerate() {
            let turn = new.facet_normals[f as usize].dot(old.facet_normals[f as usize]);
            let [before, after] = [old, new].map(|state| state.min_normal_cosine[e]);
            let has_turned = before >= MIN_NORMAL_COSINE && turn < MIN_TURN_COSINE;
            if has_turned || degrades(before, after, MIN_NORMAL_COSINE) {
                any = true;
                for &v in self.elements.vertices_of(e) {
                    self.marked[v as usize] = true;
                }
            }
        }
        any
    }

    /// Marks the edges whose two flat triangles fold onto each other.
    fn mark_edges(&mut self) -> bool {
        let topology = &self.topology;
        let mut any = false;
        for h in topology.edges() {
            if topology.is_boundary_edge(h) {
                continue;
            }
            let [f, g] = [h, h.twin()].map(|h| topology.face(h).index());
            let [before, after] = [&self.current, &self.trial]
                .map(|state| state.facet_normals[f].dot(state.facet_normals[g]));
            if degrades(before, after, MIN_EDGE_COSINE) {
                any = true;
                for v in [topology.origin(h), topology.target(h)] {
                    self.marked[v.index()] = true;
                    for w in topology.neighbours(v) {
                        self.marked[w.index()] = true;
                    }
                }
            }
        }
        any
    }
}

/// Whether a cosine falls below its limit, or, if it is already below, falls by more than the
/// tolerance.
fn degrades(old: f64, new: f64, limit: f64) -> bool {
    new.is_nan() || (new < limit && (old >= limit || new < old - MAX_DEGRADATION))
}

#[cfg(test)]
#[path = "fold_guard_tests.rs"]
mod tests;
