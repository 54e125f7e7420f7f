//! The reference mesh of distances.

use std::path::{Path, PathBuf};

use crate::io;
use crate::mesh::{DVec3, FaceId, Mesh, TriangleBvh, VertexId};

/// A closest point with a barycentric coordinate below this lies on an edge of its triangle.
const ON_SIDE: f64 = 1e-9;

/// A mesh prepared for distances to it.
pub struct Reference {
    /// The file.
    pub path: PathBuf,
    /// The mesh of the file.
    pub mesh: Mesh,
    bvh: TriangleBvh,
    /// Normals of the triangles, and of the vertices weighted by angles.
    face_normals: Vec<DVec3>,
    vertex_normals: Vec<DVec3>,
}

impl Reference {
    /// Reads a mesh file.
    ///
    /// # Errors
    /// A message for the user: the file is invalid, or the mesh has no triangle.
    pub fn open(path: &Path) -> Result<Self, String> {
        let opened = io::open(path).map_err(|e| e.to_string())?;
        let reference = Self::new(path.to_owned(), opened.mesh);
        if reference.bvh.closest_point(DVec3::ZERO).is_none() {
            return Err(format!(
                "{} contains no triangles; choose another mesh",
                path.display()
            ));
        }
        Ok(reference)
    }

    /// Prepares a mesh.
    pub fn new(path: PathBuf, mesh: Mesh) -> Self {
        let triangles: Vec<[u32; 3]> = mesh.all_triangles().collect();
        let mut vertex_normals = vec![DVec3::ZERO; mesh.vertex_count()];
        let face_normals: Vec<DVec3> = mesh
            .topology
            .faces()
            .map(|f| {
                let corners = mesh.corners(f);
                let [a, b, c] = corners;
                let normal = (b - a).cross(c - a).normalize_or_zero();
                for (k, v) in mesh.topology.face_vertices(f).into_iter().enumerate() {
                    let (p, q) = (
                        corners[(k + 1) % 3] - corners[k],
                        corners[(k + 2) % 3] - corners[k],
                    );
                    let angle = p.cross(q).length().atan2(p.dot(q));
                    vertex_normals[v.index()] += angle * normal;
                }
                normal
            })
            .collect();
        Self {
            path,
            bvh: TriangleBvh::new(&mesh.positions, &triangles),
            mesh,
            face_normals,
            vertex_normals,
        }
    }

    /// Signed distance of a point, positive on the side of the normals. The sign comes from the
    /// angle-weighted pseudonormal of the nearest face, edge or vertex (Baerentzen and Aanaes
    /// 2005). It is positive for non-orientable meshes.
    pub fn signed_distance(&self, p: DVec3) -> f64 {
        let Some(closest) = self.bvh.closest_point(p) else {
            return f64::NAN;
        };
        let face = closest.face as usize;
        if face >= self.face_normals.len() {
            return closest.distance;
        }
        let normal = self.pseudonormal(FaceId::from(face), closest.point);
        if (p - closest.point).dot(normal) < 0.0 {
            -closest.distance
        } else {
            closest.distance
        }
    }

    fn pseudonormal(&self, f: FaceId, at: DVec3) -> DVec3 {
        let topology = &self.mesh.topology;
        let [a, b, c] = self.mesh.corners(f);
        let area = (b - a).cross(c - a);
        let part = |p: DVec3, q: DVec3| (p - at).cross(q - at).dot(area) / area.length_squared();
        let weight = [part(b, c), part(c, a), part(a, b)];
        let own = self.face_normals[f.index()];
        let on_side: Vec<usize> = (0..3).filter(|&k| weight[k] < ON_SIDE).collect();
        match on_side[..] {
            [opposite] => {
                let mut h = topology.halfedge_of_face(f);
                for _ in 0..(opposite + 1) % 3 {
                    h = topology.next(h);
                }
                let beyond = topology.face(h.twin());
                if beyond.is_some() {
                    own + self.face_normals[beyond.index()]
                } else {
                    own
                }
            }
            [j, k] => {
                let v: VertexId = topology.face_vertices(f)[3 - j - k];
                self.vertex_normals[v.index()]
            }
            _ => own,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Outside a thin wedge the nearest point is on its sharp edge, where one of the two face
    /// normals points away from the query point.
    #[test]
    fn signs_hold_beside_sharp_edges() {
        let corners = [
            DVec3::new(0.0, 0.0, 0.0),
            DVec3::new(0.0, 1.0, 0.0),
            DVec3::new(4.0, 0.5, 0.3),
            DVec3::new(4.0, 0.5, -0.3),
        ];
        let triangles = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
        let mesh = Mesh::from_triangles(corners.to_vec(), &triangles).expect("a tetrahedron");
        let flip = if mesh_volume(&mesh) > 0.0 { 1.0 } else { -1.0 };
        let reference = Reference::new("wedge".into(), mesh);
        for (p, sign) in [
            (DVec3::new(-0.5, 0.5, 0.2), 1.0),
            (DVec3::new(-0.1, 0.5, -0.3), 1.0),
            (DVec3::new(-0.2, -0.3, 0.1), 1.0),
            (DVec3::new(2.0, 0.5, 0.0), -1.0),
            (DVec3::new(2.0, 0.5, 1.0), 1.0),
        ] {
            let d = flip * reference.signed_distance(p);
            assert!(d * sign > 0.0, "{p}: {d}");
        }
        let d = reference.signed_distance(DVec3::new(-0.5, 0.5, 0.0)).abs();
        assert!((d - 0.5).abs() < 1e-15);
    }

    fn mesh_volume(mesh: &Mesh) -> f64 {
        let tetrahedron = |f: usize| {
            let [a, b, c] = mesh.corners(FaceId::from(f));
            a.dot(b.cross(c))
        };
        (0..mesh.face_count()).map(tetrahedron).sum()
    }
}
