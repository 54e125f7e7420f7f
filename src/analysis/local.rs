//! A few faces of a mesh, with all vertices that their limit surface depends on, as a separate
//! mesh.

use crate::mesh::{DVec3, FaceId, HalfedgeId, Submesh, Topology, faces_around};
use crate::subdivision::elements_at;
use crate::surface::{PointGeometry, surface_point};

/// The faces and every face at one of their corners, cut apart along the edges of `cuts`. `None` if
/// the result is not a manifold, which happens only if the mesh is not one.
pub(super) fn with_rings(
    topology: &Topology,
    faces: &[FaceId],
    cuts: &[HalfedgeId],
) -> Option<Submesh> {
    let mut cut: Vec<usize> = cuts.iter().map(|h| h.edge()).collect();
    cut.sort_unstable();
    let is_cut = |h: HalfedgeId| cut.binary_search(&h.edge()).is_ok();
    Submesh::new(topology, faces_around(topology, faces), is_cut).ok()
}

/// The limit surface over one face, at any of its points.
pub(super) struct FaceSurface {
    local: Submesh,
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
        let local = with_rings(topology, &[f], &[])?;
        let mut control = local.gather(control);
        for p in &mut control {
            *p -= origin;
        }
        Some(Self {
            face: local.face(f)?,
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
