//! Second fundamental forms as tensors of space.

use std::collections::BTreeMap;

use glam::DMat3;

use crate::mesh::{DVec3, FaceId, Topology};
use crate::subdivision::{Rule, elements};
use crate::surface::{PointGeometry, each_point};

/// The symmetric tensor `b^ab x_a x_bᵀ`: `t · (form t)` is the normal curvature along a unit tangent
/// `t`, half the trace the mean curvature.
pub(super) fn bending_form(p: &PointGeometry) -> DMat3 {
    // h^ab = [[b22, -b12], [-b12, b11]] / g
    let det = p.sqrt_g * p.sqrt_g;
    let [b22, minus_b12, b11] = p.h_inv.map(|h| h * det);
    let b12 = -minus_b12;
    let [g11, g12, g22] = p.g_inv;
    // dual tangents x^a = g^ab x_b
    let (u, v) = (p.x_u * g11 + p.x_v * g12, p.x_u * g12 + p.x_v * g22);
    outer(u, u * b11 + v * b12) + outer(v, u * b12 + v * b22)
}

fn outer(a: DVec3, b: DVec3) -> DMat3 {
    DMat3::from_cols(a * b.x, a * b.y, a * b.z)
}

/// Averages of [`bending_form`] around the corners of `faces` (the L2 projection to piecewise linear
/// functions with lumped mass), by vertex.
pub(super) fn vertex_forms(
    topology: &Topology,
    control: &[DVec3],
    faces: &[FaceId],
) -> BTreeMap<u32, DMat3> {
    let corners = faces.iter().flat_map(|&f| topology.face_vertices(f));
    let mut sums: BTreeMap<u32, (f64, DMat3)> =
        corners.clone().map(|v| (v.0, (0.0, DMat3::ZERO))).collect();
    let mut around: Vec<FaceId> = corners
        .flat_map(|v| topology.outgoing(v))
        .map(|h| topology.face(h))
        .filter(|f| f.is_some())
        .collect();
    around.sort_unstable();
    around.dedup();
    let elements = elements(topology, &around, Rule::Twelve);
    for e in 0..elements.len() {
        let corners = &elements.vertices_of(e)[..3];
        let mut point = 0;
        each_point(&elements, e, control, |_, p| {
            let [v, w] = Rule::Twelve.points()[point];
            point += 1;
            let form = bending_form(p);
            if !(p.sqrt_g > 0.0 && form.is_finite()) {
                return;
            }
            for (corner, hat) in corners.iter().zip([1.0 - v - w, v, w]) {
                if let Some((weight, sum)) = sums.get_mut(corner) {
                    *weight += hat * p.sqrt_g;
                    *sum += form * (hat * p.sqrt_g);
                }
            }
        });
    }
    sums.into_iter()
        .map(|(v, (weight, sum))| (v, sum * (1.0 / weight)))
        .collect()
}
