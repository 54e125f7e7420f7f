//! The surface to which an isometry is fitted.

use crate::mesh::{
    DVec3, FaceId, Mesh, TriangleBvh, VertexId, closest_point_on_segment, vertex_normal,
};

/// A point of a surface with its unit normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// The point.
    pub point: DVec3,
    /// The unit normal of the surface there.
    pub normal: DVec3,
}

impl Sample {
    /// A vertex of a mesh with the normal of its faces. `None` if these have no area.
    pub fn of_vertex(mesh: &Mesh, v: VertexId) -> Option<Self> {
        Some(Self {
            point: mesh.position(v),
            normal: vertex_normal(&mesh.topology, v, |v| mesh.position(v))?,
        })
    }
}

/// Least cosine between the normals at a point and at the point nearest to it: the other side of a
/// thin wall is no counterpart.
const LEAST_COSINE: f64 = 0.5;

/// Some vertices of a mesh, among which the nearest one to a point is found fast.
pub struct Target {
    samples: Vec<Sample>,
    bvh: TriangleBvh,
}

impl Target {
    /// At most `most` vertices of a mesh, evenly by number.
    pub fn coarse(mesh: &Mesh, most: usize) -> Self {
        let step = mesh.vertex_count().div_ceil(most).max(1);
        let vertices = mesh.topology.vertices().step_by(step);
        let samples: Vec<Sample> = vertices
            .filter_map(|v| Sample::of_vertex(mesh, v))
            .collect();
        let points: Vec<DVec3> = samples.iter().map(|sample| sample.point).collect();
        let alone: Vec<[u32; 3]> = (0..points.len() as u32).map(|i| [i; 3]).collect();
        Self {
            bvh: TriangleBvh::new(&points, &alone),
            samples,
        }
    }

    /// At most `most` of the samples, evenly by number.
    pub fn some(&self, most: usize) -> Vec<Sample> {
        let step = self.samples.len().div_ceil(most).max(1);
        self.samples.iter().step_by(step).copied().collect()
    }

    /// The nearest sample, if its normal is similar.
    pub fn nearest(&self, to: &Sample) -> Option<Sample> {
        let found = self.bvh.closest_point(to.point)?;
        let found = self.samples[found.face as usize];
        (found.normal.dot(to.normal) >= LEAST_COSINE).then_some(found)
    }
}

/// The point of a mesh nearest to a point, with the normal of its face. `None` if it lies on a boundary,
/// where the surface ends before the true nearest point.
pub fn nearest_inside(mesh: &Mesh, bvh: &TriangleBvh, to: DVec3) -> Option<Sample> {
    nearest_on_face(mesh, bvh, to).map(|found| found.1)
}

/// [`nearest_inside`] with the face.
fn nearest_on_face(mesh: &Mesh, bvh: &TriangleBvh, to: DVec3) -> Option<(FaceId, Sample)> {
    let found = bvh.closest_point(to)?;
    let face = FaceId(found.face);
    let topology = &mesh.topology;
    let [a, b, c] = topology.face_vertices(face).map(|v| mesh.position(v));
    let is_outside = topology.face_halfedges(face).into_iter().any(|h| {
        topology.is_boundary_edge(h) && {
            let [a, b] = [topology.origin(h), topology.target(h)].map(|v| mesh.position(v));
            let nearest = closest_point_on_segment(found.point, a, b);
            found.point.distance(nearest) <= ON_BOUNDARY * a.distance(b)
        }
    });
    let normal = (b - a).cross(c - a).try_normalize()?;
    let point = found.point;
    (!is_outside).then_some((face, Sample { point, normal }))
}

/// [`nearest_inside`] of a sample, if the normals are similar.
pub fn nearest_alike(mesh: &Mesh, bvh: &TriangleBvh, to: &Sample) -> Option<Sample> {
    nearest_inside(mesh, bvh, to.point).filter(|found| found.normal.dot(to.normal) >= LEAST_COSINE)
}

/// [`nearest_alike`], moved from its triangle onto a smooth surface through the vertices.
pub fn nearest_smooth(mesh: &Mesh, bvh: &TriangleBvh, to: &Sample) -> Option<DVec3> {
    let (face, found) = nearest_on_face(mesh, bvh, to.point)?;
    (found.normal.dot(to.normal) >= LEAST_COSINE).then(|| smooth(mesh, face, &found))
}

/// A point of a face moved to the middle between it and the mean of its projections onto the tangent planes at
/// the corners, weighted by its barycentric coordinates (Boubekeur and Alexa, Phong tessellation, 2008, with
/// half of the displacement). A quadratic surface whose normals are exact is restored exactly. At sharp edges,
/// whose vertices have no tangent plane, the point stays.
fn smooth(mesh: &Mesh, face: FaceId, at: &Sample) -> DVec3 {
    let vertices = mesh.topology.face_vertices(face);
    let [a, b, c] = vertices.map(|v| mesh.position(v));
    let part = |from: DVec3, to: DVec3| (from - at.point).cross(to - at.point).dot(at.normal);
    let parts = [part(b, c), part(c, a), part(a, b)];
    let area: f64 = parts.iter().sum();
    let mut shift = DVec3::ZERO;
    for (v, part) in vertices.into_iter().zip(parts) {
        let normal = vertex_normal(&mesh.topology, v, |v| mesh.position(v));
        let Some(normal) = normal.filter(|n| n.dot(at.normal) >= LEAST_TANGENT_COSINE) else {
            return at.point;
        };
        shift += part / area * (mesh.position(v) - at.point).dot(normal) * normal;
    }
    at.point + 0.5 * shift
}

/// Cosine of the largest angle between the normals of a face and of its vertices on a smooth surface (30°).
const LEAST_TANGENT_COSINE: f64 = 0.866_025_403_784_438_6;

/// Distance from a boundary edge, relative to its length, up to which a point lies on it.
const ON_BOUNDARY: f64 = 1e-6;
