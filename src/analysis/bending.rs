//! Second fundamental forms as tensors of space.

use std::collections::BTreeMap;

use glam::DMat3;

use crate::mesh::{DVec3, FaceId, Topology, faces_around};
use crate::subdivision::{Rule, elements};
use crate::surface::{PointGeometry, project_to_vertices, surface_point};

/// The symmetric tensor `b^ab x_a x_bᵀ`: `t · (form t)` is the normal curvature along a unit
/// tangent `t`, half the trace the mean curvature.
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

/// Averages of [`bending_form`] around the corners of `faces` (the L2 projection to piecewise
/// linear functions with lumped mass), by vertex.
pub(super) fn vertex_forms(
    topology: &Topology,
    control: &[DVec3],
    faces: &[FaceId],
) -> BTreeMap<u32, DMat3> {
    let corners = faces.iter().flat_map(|&f| topology.face_vertices(f));
    let mut sums: BTreeMap<u32, (f64, DMat3)> =
        corners.map(|v| (v.0, (0.0, DMat3::ZERO))).collect();
    let around = faces_around(topology, faces);
    let elements = elements(topology, &around, Rule::Twelve);
    let sample = |e, q| {
        let (_, p) = surface_point(&elements, e, q, control);
        let form = bending_form(&p);
        (p.sqrt_g > 0.0 && form.is_finite()).then_some((p.sqrt_g, form))
    };
    project_to_vertices(&elements, Rule::Twelve, sample, |v, weight, form| {
        if let Some((area, sum)) = sums.get_mut(&v) {
            *area += weight;
            *sum += *form * weight;
        }
    });
    sums.into_iter()
        .map(|(v, (weight, sum))| (v, sum * (1.0 / weight)))
        .collect()
}
