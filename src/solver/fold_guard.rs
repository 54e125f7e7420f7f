//! A watch over steps that would fold the surface.
//!
//! An energy sampled at quadrature points does not see a fold between them, and a minimiser finds
//! such places. So beside the energy a step has to keep, face by face, the limit surface's normals on
//! the side of the flat triangle through the limit positions of its corners, and no two neighbouring
//! flat triangles may close like a book. Faces that are folded already are only kept from getting
//! worse: leaving the fold lowers the energy.

use rayon::prelude::*;

use crate::mesh::{DVec3, FaceId, HalfedgeId, Topology};
use crate::subdivision::{Elements, limit_normals, limit_positions};

/// A face is in order if its normals keep at least this cosine to the flat triangle.
const UPRIGHT: f64 = -0.3;
/// Two flat triangles are in order if their normals keep at least this cosine.
const OPEN: f64 = -0.77;
/// How much worse a face or edge that is not in order may get in one step.
const WORSE: f64 = 0.3;
/// Cosine of the most that the flat triangle of a face in order may turn in one step.
const TURN: f64 = 0.5;

/// Cosine between a vector and a unit vector; -1 for one that has no direction.
fn cosine(vector: DVec3, unit: DVec3) -> f64 {
    let length = vector.length();
    if length > 0.0 && length.is_finite() {
        vector.dot(unit) / length
    } else {
        -1.0
    }
}

/// How a surface is folded: the state steps are compared with.
#[derive(Clone, Debug, Default)]
pub struct FoldState {
    /// Least cosine between a normal and the flat triangle's, by element.
    upright: Vec<f64>,
    /// Normal of the flat triangle, by face.
    flat: Vec<DVec3>,
}

impl FoldState {
    /// Looks at the surface over `elements`, which cover the faces that may change.
    pub fn new(topology: &Topology, elements: &Elements, positions: &[DVec3]) -> Self {
        let points = limit_positions(topology, positions);
        let normals = limit_normals(topology, positions);
        let flat: Vec<DVec3> = (0..topology.face_count())
            .map(|f| {
                let corners = topology.face_vertices(FaceId::from(f));
                let [a, b, c] = corners.map(|v| points[v.index()]);
                (b - a).cross(c - a).normalize_or_zero()
            })
            .collect();
        let upright = |local: &mut Vec<DVec3>, e: usize| {
            let (table, vertices) = (elements.table(e), elements.vertices_of(e));
            let face = flat[elements.faces()[e] as usize];
            local.clear();
            local.extend(vertices.iter().map(|&v| positions[v as usize]));
            let inside = (0..table.points).map(|point| {
                let (du, dv) = (table.row(point, 1), table.row(point, 2));
                let (mut u, mut v) = (DVec3::ZERO, DVec3::ZERO);
                for ((&a, &b), &p) in du.iter().zip(dv).zip(&*local) {
                    u += a * p;
                    v += b * p;
                }
                cosine(u.cross(v), face)
            });
            let least = inside.fold(1.0, f64::min);
            let corners = vertices[..3].iter().map(|&v| normals[v as usize].dot(face));
            corners.fold(least, f64::min)
        };
        Self {
            upright: (0..elements.len())
                .into_par_iter()
                .with_min_len(64)
                .map_init(Vec::new, upright)
                .collect(),
            flat,
        }
    }

    /// Marks the control vertices of the places where a step to `next` would fold the surface;
    /// returns whether there are any.
    pub fn mark_folds(
        &self,
        next: &Self,
        topology: &Topology,
        elements: &Elements,
        marked: &mut [bool],
    ) -> bool {
        let gets_bad = |old: f64, new: f64, limit: f64| {
            new.is_nan() || (new < limit && (old >= limit || new < old - WORSE))
        };
        let mut any = false;
        for e in 0..elements.len() {
            let f = elements.faces()[e] as usize;
            let (old, new) = (self.upright[e], next.upright[e]);
            let turned = old >= UPRIGHT && next.flat[f].dot(self.flat[f]) < TURN;
            if turned || gets_bad(old, new, UPRIGHT) {
                any = true;
                for &v in elements.vertices_of(e) {
                    marked[v as usize] = true;
                }
            }
        }
        for h in (0..topology.halfedge_count())
            .step_by(2)
            .map(HalfedgeId::from)
        {
            if topology.is_boundary(h) || topology.is_boundary(h.twin()) {
                continue;
            }
            let [f, g] = [h, h.twin()].map(|h| topology.face(h).index());
            let cosine = |flat: &[DVec3]| flat[f].dot(flat[g]);
            if gets_bad(cosine(&self.flat), cosine(&next.flat), OPEN) {
                any = true;
                for v in [topology.origin(h), topology.target(h)] {
                    marked[v.index()] = true;
                    for w in topology.neighbours(v) {
                        marked[w.index()] = true;
                    }
                }
            }
        }
        any
    }

    /// Elements whose normals turn away from their flat triangle.
    pub fn folded(&self) -> usize {
        self.upright.iter().filter(|&&u| u < UPRIGHT).count()
    }
}
