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
    (!is_outside).then_some(Sample { point, normal })
}

/// [`nearest_inside`] of a sample, if the normals are similar.
pub fn nearest_alike(mesh: &Mesh, bvh: &TriangleBvh, to: &Sample) -> Option<Sample> {
    nearest_inside(mesh, bvh, to.point).filter(|found| found.normal.dot(to.normal) >= LEAST_COSINE)
}

/// Distance from a boundary edge, relative to its length, up to which a point lies on it.
const ON_BOUNDARY: f64 = 1e-6;
