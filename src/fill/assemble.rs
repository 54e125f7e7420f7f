//! The filled mesh: patches inserted into the input mesh.
//!
//! A patch has its own vertex numbers (see [`Patch`](crate::patch::Patch)). This module assigns
//! numbers to new vertices that continue those of the mesh.

use std::ops::Range;
use std::sync::Arc;

use crate::fill::attributes::{Look, filled_attributes};
use crate::fill::hole::HoleRims;
use crate::fill::patch_topology::PatchTopology;
use crate::fill::plan::Plan;
use crate::fill::result::FilledHole;
use crate::mesh::{DVec3, FaceId, FaceTag, LoopId, Mesh, Topology, TopologyError, VertexId};
use crate::warning::Warning;

/// The triangulation of one patch: its rim vertices in the mesh, its triangles in patch numbers,
/// and its number of new vertices.
pub(super) type Part<'a> = (&'a [VertexId], &'a [[u32; 3]], usize);

/// Triangles of patches over the vertices of the mesh, the first `given`, and the new vertices of
/// all patches, which follow patch by patch.
pub(super) fn appended_triangles<'a>(
    given: usize,
    patches: impl IntoIterator<Item = Part<'a>>,
) -> Vec<[u32; 3]> {
    let mut first = given;
    let mut all = Vec::new();
    for (rim, triangles, new_vertices) in patches {
        let number = |v: u32| match rim.get(v as usize) {
            Some(given) => given.0,
            None => (first + v as usize - rim.len()) as u32,
        };
        all.extend(triangles.iter().map(|t| t.map(number)));
        first += new_vertices;
    }
    all
}

/// Connectivity and layout of a filled mesh: the input vertices and faces, then those of the
/// patches, hole by hole. It does not depend on positions.
///
/// Its methods take the positions of each group's vertices: those of a fairing, or new ones in the
/// order of the group's [`PatchTopology`].
#[derive(Clone, Debug)]
pub(crate) struct Assembly {
    pub topology: Arc<Topology>,
    pub holes: Vec<FilledHole>,
    /// Fairing: the input vertices that flow, in ascending order.
    pub moved: Vec<VertexId>,
    /// The tags of the filled mesh: those of the mesh, then those of the patches if they get groups.
    tags: Vec<FaceTag>,
    given_faces: usize,
    /// The triangulation of each group.
    groups: Vec<Arc<PatchTopology>>,
    look: Look,
}

impl Assembly {
    /// The filled mesh whose groups have these triangulations. If patches have labels, the faces of each
    /// get a group with the next number that the tags of the mesh leave.
    ///
    /// # Errors
    /// The filled mesh is not a manifold: an internal error.
    pub fn new(
        mesh: &Mesh,
        plan: &Plan,
        groups: Vec<Arc<PatchTopology>>,
        look: &Look,
    ) -> Result<Self, TopologyError> {
        // patches without new vertices are in no group
        let loose = plan.holes().iter().map(|hole| {
            let rim = &hole.rims.vertices[..];
            (None, (rim, &hole.patch.triangles[..], 0))
        });
        let mut parts: Vec<(Option<usize>, Part<'_>)> = loose.collect();
        for (g, (group, topology)) in plan.groups.iter().zip(&groups).enumerate() {
            for (&h, hole) in group.holes.iter().zip(&topology.holes) {
                let (_, (rim, ..)) = parts[h];
                parts[h] = (Some(g), (rim, &hole.triangles, hole.new_vertices));
            }
        }
        let (mut vertices, mut faces) = (mesh.vertex_count(), mesh.face_count());
        let mut holes = Vec::with_capacity(parts.len());
        let mut tags = mesh.attributes.tags.clone();
        if look.labels && tags.is_empty() {
            tags.push(FaceTag::default());
        }
        let mut patch = tags.iter().filter_map(FaceTag::patch).max().unwrap_or(0);
        for (hole, &(group, (rim, triangles, new_vertices))) in plan.holes().iter().zip(&parts) {
            let (first_vertex, first_face) = (vertices, faces);
            vertices += new_vertices;
            faces += triangles.len();
            let like = face_beside(mesh, &hole.rims);
            let of_faces = &mesh.attributes.faces.tags;
            let mut tag = of_faces.get(like.index()).copied().unwrap_or(0);
            if look.labels {
                patch += 1;
                tags.push(tags[tag as usize].in_patch(patch));
                tag = tags.len() as u32 - 1;
            }
            holes.push(FilledHole {
                loops: hole.rims.loops.iter().map(|l| l.id).collect(),
                edges: rim.len(),
                radius: hole.rims.radius(),
                group,
                vertices: first_vertex..vertices,
                faces: first_face..faces,
                patch_ms: hole.patch_ms,
                warnings: hole.warnings.clone(),
                tag,
                like,
            });
        }
        let mut triangles = Vec::with_capacity(faces);
        triangles.extend(mesh.topology.triangles());
        let patches = parts.iter().map(|&(_, part)| part);
        triangles.extend(appended_triangles(mesh.vertex_count(), patches));
        Ok(Self {
            topology: Arc::new(Topology::from_triangles(vertices, &triangles)?),
            holes,
            moved: plan.moved().to_vec(),
            tags,
            given_faces: mesh.face_count(),
            groups,
            look: look.clone(),
        })
    }

    /// Reads in advance what [`Self::mesh`] may need of the files to which the mesh refers.
    pub fn prepare_look(&self, mesh: &Mesh) {
        self.look.prepare(mesh, &self.holes, &self.topology);
    }

    /// Whether [`Self::mesh`] may make texture images.
    pub fn makes_images(&self, mesh: &Mesh) -> bool {
        self.look.makes_images(mesh)
    }

    /// Whether the groups have these triangulations.
    pub fn fits<'a>(&self, groups: impl IntoIterator<Item = &'a Arc<PatchTopology>>) -> bool {
        let mut pairs = self.groups.iter().zip(groups);
        pairs.all(|(own, other)| Arc::ptr_eq(own, other))
    }

    /// The faces of the patches in the filled mesh.
    pub fn patch_faces(&self) -> Range<usize> {
        self.given_faces..self.topology.face_count()
    }

    /// Positions of the vertices that flow: all new ones in the order of the filled mesh, or those
    /// of a fairing.
    pub fn flowing_positions<'a>(
        &self,
        groups: impl IntoIterator<Item = &'a [DVec3]>,
    ) -> Vec<DVec3> {
        let mut rest: Vec<&[DVec3]> = groups.into_iter().collect();
        if !self.moved.is_empty() {
            return rest.concat();
        }
        let mut out = Vec::with_capacity(self.new_vertices());
        for hole in &self.holes {
            if let Some(g) = hole.group {
                // a group's holes follow each other in the order of all holes
                let (own, after) = rest[g].split_at(hole.vertices.len());
                out.extend_from_slice(own);
                rest[g] = after;
            }
        }
        out
    }

    /// Positions of all vertices of the filled mesh.
    pub fn positions<'a>(
        &self,
        mesh: &Mesh,
        groups: impl IntoIterator<Item = &'a [DVec3]>,
    ) -> Vec<DVec3> {
        let flowing = self.flowing_positions(groups);
        let mut positions = Vec::with_capacity(self.topology.vertex_count());
        positions.extend_from_slice(&mesh.positions);
        if self.moved.is_empty() {
            positions.extend(flowing);
        } else {
            for (v, p) in self.moved.iter().zip(flowing) {
                positions[v.index()] = p;
            }
        }
        positions
    }

    /// The filled mesh with the attributes of [`filled_attributes`], and warnings about holes.
    pub fn mesh<'a>(
        &self,
        mesh: &Mesh,
        groups: impl IntoIterator<Item = &'a [DVec3]>,
    ) -> (Mesh, Vec<(LoopId, Warning)>) {
        let positions = self.positions(mesh, groups);
        let (holes, tags) = (&self.holes, &self.tags);
        let (attributes, failed) =
            filled_attributes(mesh, holes, tags, &self.topology, &positions, &self.look);
        let filled = Mesh {
            attributes,
            positions,
            topology: (*self.topology).clone(),
            non_orientable: mesh.non_orientable.clone(),
        };
        let warning =
            |(hole, reason): (usize, String)| (holes[hole].id(), Warning::NoTexture { reason });
        (filled, failed.into_iter().map(warning).collect())
    }

    fn new_vertices(&self) -> usize {
        self.holes.iter().map(|hole| hole.vertices.len()).sum()
    }

    /// Size in bytes, for the memory limit of a timeline.
    pub fn bytes(&self) -> usize {
        let flowing = self.new_vertices() + self.moved.len();
        let faces: usize = self.holes.iter().map(|hole| hole.faces.len()).sum();
        flowing * size_of::<DVec3>() + faces * size_of::<[u32; 3]>() + self.topology.bytes()
    }
}

/// The face across the first edge of the first rim; one at its first vertex if the patch continues no faces.
fn face_beside(mesh: &Mesh, rims: &HoleRims) -> FaceId {
    let (rim, topology) = (&rims.loops[0], &mesh.topology);
    let across = rim.halfedges.iter().map(|h| h.twin());
    let mut inside = across.chain(topology.outgoing(rim.vertices[0]));
    let inside = inside.find(|&h| !topology.is_boundary(h));
    inside.map_or(FaceId(0), |h| topology.face(h))
}
