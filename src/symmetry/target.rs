//! The surface to which an isometry is fitted.

use crate::mesh::{
    ClosestPoint, DVec3, FaceId, Mesh, TriangleBvh, VertexId, closest_point_on_segment,
    vertex_normal,
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

/// Smallest cosine between the normals at a point and at the point nearest to it: the other side of a
/// thin wall is no counterpart.
const MIN_COSINE: f64 = 0.5;

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
        (found.normal.dot(to.normal) >= MIN_COSINE).then_some(found)
    }
}

/// The point found to be nearest to some point, with the normal of its face. `None` if it lies on a boundary,
/// where the surface ends before the true nearest point.
pub fn inside(mesh: &Mesh, found: &ClosestPoint) -> Option<Sample> {
    let topology = &mesh.topology;
    let face = FaceId(found.face);
    let [a, b, c] = mesh.corners(face);
    let is_outside = topology.face_halfedges(face).into_iter().any(|h| {
        topology.is_boundary_edge(h) && {
            let [a, b] = [topology.origin(h), topology.target(h)].map(|v| mesh.position(v));
            let nearest = closest_point_on_segment(found.point, a, b);
            found.point.distance(nearest) <= ON_BOUNDARY * a.distance(b)
        }
    });
    let normal = (b - a).cross(c - a).try_normalize()?;
    let point = found.point;
    (!is_outside).then_some(Sample { point, normal })
}

/// [`inside`] for the point nearest to a sample, if the normals are similar.
pub fn alike(mesh: &Mesh, found: &ClosestPoint, to: &Sample) -> Option<Sample> {
    inside(mesh, found).filter(|found| found.normal.dot(to.normal) >= MIN_COSINE)
}

/// [`alike`], moved from its triangle onto a smooth surface through the vertices, whose unit normals are given; 0
/// for none.
pub fn smooth(mesh: &Mesh, normals: &[DVec3], found: &ClosestPoint, to: &Sample) -> Option<DVec3> {
    let sample = alike(mesh, found, to)?;
    Some(on_tangent_planes(
        mesh,
        normals,
        FaceId(found.face),
        &sample,
    ))
}

/// A point of a face moved to the middle between it and the mean of its projections onto the tangent planes at
/// the corners, weighted by its barycentric coordinates (Boubekeur and Alexa, Phong tessellation, 2008, with
/// half of the displacement). A quadratic surface whose normals are exact is restored exactly. At sharp edges,
/// whose vertices have no tangent plane, the point stays.
fn on_tangent_planes(mesh: &Mesh, normals: &[DVec3], face: FaceId, at: &Sample) -> DVec3 {
    let vertices = mesh.topology.face_vertices(face);
    let [a, b, c] = mesh.corners(face);
    let part = |from: DVec3, to: DVec3| (from - at.point).cross(to - at.point).dot(at.normal);
    let parts = [part(b, c), part(c, a), part(a, b)];
    let area: f64 = parts.iter().sum();
    let mut shift = DVec3::ZERO;
    for (v, part) in vertices.into_iter().zip(parts) {
        let normal = normals[v.index()];
        if normal.dot(at.normal) < MIN_TANGENT_COSINE {
            return at.point;
        }
        shift += part / area * (mesh.position(v) - at.point).dot(normal) * normal;
    }
    at.point + 0.5 * shift
}

/// Cosine of the largest angle between the normals of a face and of its vertices on a smooth surface (30°).
const MIN_TANGENT_COSINE: f64 = 0.866_025_403_784_438_6;

/// Distance from a boundary edge, relative to its length, up to which a point lies on it.
const ON_BOUNDARY: f64 = 1e-6;
