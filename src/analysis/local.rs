//! A few faces of a mesh with all that their limit surface depends on, as a mesh of its own.

use crate::mesh::union_find::{find, unite};
use crate::mesh::{DVec3, FaceId, HalfedgeId, Topology};
use crate::subdivision::elements_at;
use crate::surface::{PointGeometry, surface_point};

/// Faces with the rings of their corners.
pub(super) struct Local {
    /// The local faces in the order of `faces`, corners as in the mesh.
    pub(super) topology: Topology,
    /// For each local vertex the vertex of the mesh it is, or is a copy of.
    source: Vec<u32>,
    /// For each local face its face in the mesh, ascending.
    faces: Vec<u32>,
}

impl Local {
    /// The faces and every face at one of their corners, cut apart along the edges of `cuts`: at each
    /// vertex every sector between cut or boundary edges gets a copy of its own. A cut edge both of
    /// whose ends lie inside the surface and on no other cut stays closed. `None` if what is cut out is
    /// no manifold, which takes a mesh that was none.
    pub(super) fn new(topology: &Topology, faces: &[FaceId], cuts: &[HalfedgeId]) -> Option<Self> {
        let mut around: Vec<u32> = faces
            .iter()
            .flat_map(|&f| topology.face_vertices(f))
            .flat_map(|v| topology.outgoing(v))
            .map(|h| topology.face(h))
            .filter(|f| f.is_some())
            .map(|f| f.0)
            .collect();
        around.sort_unstable();
        around.dedup();
        let mut cut: Vec<usize> = cuts.iter().map(|h| h.edge()).collect();
        cut.sort_unstable();
        let corners = corner_classes(topology, &around, &cut);

        let mut number = vec![u32::MAX; corners.len()];
        let mut source = Vec::new();
        let mut triangles = Vec::with_capacity(around.len());
        for (l, &f) in around.iter().enumerate() {
            let vertices = topology.face_vertices(FaceId(f));
            triangles.push([0, 1, 2].map(|k| {
                let class = corners[3 * l + k] as usize;
                if number[class] == u32::MAX {
                    number[class] = source.len() as u32;
                    source.push(vertices[k].0);
                }
                number[class]
            }));
        }
        Some(Self {
            topology: Topology::from_triangles(source.len(), &triangles).ok()?,
            source,
            faces: around,
        })
    }

    /// The local number of a face of the mesh that is among the local ones.
    pub(super) fn face(&self, f: FaceId) -> FaceId {
        FaceId::from(self.faces.partition_point(|&g| g < f.0))
    }

    /// The face of the mesh that a local one is.
    pub(super) fn source_face(&self, local: FaceId) -> FaceId {
        FaceId(self.faces[local.index()])
    }

    /// What the mesh's vertices have, for the local ones.
    pub(super) fn gather(&self, of_mesh: &[DVec3]) -> Vec<DVec3> {
        self.source.iter().map(|&v| of_mesh[v as usize]).collect()
    }
}

/// For each corner `3 l + k` of the faces the lowest corner that is the same vertex.
fn corner_classes(topology: &Topology, faces: &[u32], cut: &[usize]) -> Vec<u32> {
    let mut link: Vec<u32> = (0..3 * faces.len() as u32).collect();
    for (l, &f) in faces.iter().enumerate() {
        let mut h = topology.halfedge_of_face(FaceId(f));
        for side in 0..3 {
            let beyond = topology.face(h.twin());
            if beyond.is_some()
                && cut.binary_search(&h.edge()).is_err()
                && let Ok(m) = faces.binary_search(&beyond.0)
            {
                let other = topology.face_vertices(beyond);
                let corner = |v| other.iter().position(|&w| w == v).unwrap_or(0);
                let (a, b) = (topology.origin(h), topology.target(h));
                unite(&mut link, (3 * l + side) as u32, (3 * m + corner(a)) as u32);
                let next = 3 * l + (side + 1) % 3;
                unite(&mut link, next as u32, (3 * m + corner(b)) as u32);
            }
            h = topology.next(h);
        }
    }
    (0..link.len() as u32).map(|c| find(&mut link, c)).collect()
}

/// The limit surface over one face, at any of its points.
pub(super) struct FaceSurface {
    local: Local,
    face: FaceId,
    control: Vec<DVec3>,
}

impl FaceSurface {
    /// Of face `f`; positions of points will be relative to `origin`.
    pub(super) fn new(
        topology: &Topology,
        control: &[DVec3],
        origin: DVec3,
        f: FaceId,
    ) -> Option<Self> {
        let local = Local::new(topology, &[f], &[])?;
        let mut control = local.gather(control);
        for p in &mut control {
            *p -= origin;
        }
        Some(Self {
            face: local.face(f),
            local,
            control,
        })
    }

    /// Points and geometry at the given `(v, w)`; the geometry is not finite at irregular corners.
    pub(super) fn at(&self, points: &[[f64; 2]]) -> Vec<(DVec3, PointGeometry)> {
        let elements = elements_at(&self.local.topology, &[self.face], points);
        (0..points.len())
            .map(|i| surface_point(&elements, 0, i, &self.control))
            .collect()
    }
}
