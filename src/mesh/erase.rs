//! Erasing faces.

use super::selection::touched_vertices;
use super::{FaceId, Mesh, Topology, VertexId};

/// A mesh without some of its faces.
#[derive(Clone, Debug)]
pub struct Erased {
    /// The remaining vertices and faces in their order. Vertices that only erased faces used are
    /// removed.
    pub mesh: Mesh,
    /// The old index of each vertex of `mesh`.
    pub old_vertex: Vec<u32>,
    /// The old index of each face of `mesh`.
    pub old_face: Vec<u32>,
}

/// Erases the selected faces, and those that would touch the remaining faces only at a vertex.
///
/// # Panics
/// If there is not one flag per face.
pub fn erase(mesh: &Mesh, selected: &[bool]) -> Erased {
    assert_eq!(selected.len(), mesh.face_count(), "one flag per face");
    let topology = &mesh.topology;
    let mut gone = selected.to_vec();
    erase_loose_fans(topology, &mut gone);
    let touched = touched_vertices(topology, &gone);
    let is_kept = |v: VertexId| {
        let mut faces = topology.outgoing(v).map(|h| topology.face(h));
        faces.any(|f| f.is_some() && !gone[f.index()])
    };
    let old_vertex: Vec<u32> = (0..mesh.vertex_count() as u32)
        .filter(|&v| !touched[v as usize] || is_kept(VertexId(v)))
        .collect();
    let mut index = vec![u32::MAX; mesh.vertex_count()];
    for (new, &old) in old_vertex.iter().enumerate() {
        index[old as usize] = new as u32;
    }
    let old_face: Vec<u32> = (0..mesh.face_count() as u32)
        .filter(|&f| !gone[f as usize])
        .collect();
    let renumbered = |t: [u32; 3]| t.map(|v| index[v as usize]);
    let faces: Vec<[u32; 3]> = old_face
        .iter()
        .map(|&f| renumbered(topology.face_vertices(FaceId(f)).map(|v| v.0)))
        .collect();
    Erased {
        mesh: Mesh {
            positions: picked(&mesh.positions, &old_vertex),
            topology: Topology::from_triangles(old_vertex.len(), &faces)
                .expect("loose fans are gone, and what is left of a manifold is one"),
            colors: picked(&mesh.colors, &old_vertex),
            face_tags: picked(&mesh.face_tags, &old_face),
            tags: mesh.tags.clone(),
            non_orientable: mesh
                .non_orientable
                .iter()
                .copied()
                .map(renumbered)
                .collect(),
            non_orientable_tags: mesh.non_orientable_tags.clone(),
        },
        old_vertex,
        old_face,
    }
}

/// Entries at `indices`; none of a list that is empty because the mesh has no such attribute.
fn picked<T: Copy>(all: &[T], indices: &[u32]) -> Vec<T> {
    if all.is_empty() {
        return Vec::new();
    }
    indices.iter().map(|&i| all[i as usize]).collect()
}

/// Where the remaining faces around a vertex form several fans, erases all but the largest.
fn erase_loose_fans(topology: &Topology, gone: &mut [bool]) {
    let mut waiting: Vec<u32> = (0..topology.vertex_count() as u32)
        .filter(|&v| {
            let mut faces = topology.outgoing(VertexId(v)).map(|h| topology.face(h));
            faces.any(|f| f.is_some() && gone[f.index()])
        })
        .rev()
        .collect();
    while let Some(v) = waiting.pop() {
        let ring: Vec<Option<FaceId>> = topology
            .outgoing(VertexId(v))
            .map(|h| topology.face(h))
            .map(|f| (f.is_some() && !gone[f.index()]).then_some(f))
            .collect();
        for f in loose_faces(&ring) {
            gone[f.index()] = true;
            waiting.extend(topology.face_vertices(f).map(|w| w.0));
        }
    }
}

/// The faces of all runs in the cyclic list but the longest one (of equals: the first).
fn loose_faces(ring: &[Option<FaceId>]) -> Vec<FaceId> {
    let Some(gap) = ring.iter().position(Option::is_none) else {
        return Vec::new();
    };
    let mut runs: Vec<Vec<FaceId>> = vec![Vec::new()];
    for k in 0..ring.len() {
        match ring[(gap + k) % ring.len()] {
            Some(f) => runs.last_mut().expect("never empty").push(f),
            None => runs.push(Vec::new()),
        }
    }
    let mut longest = 0;
    for (k, run) in runs.iter().enumerate() {
        if run.len() > runs[longest].len() {
            longest = k;
        }
    }
    runs.swap_remove(longest);
    runs.into_iter().flatten().collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{DVec3, check_mesh, faces_in_ball};
    use crate::random::SplitMix;
    use crate::shapes;

    #[test]
    fn what_is_left_is_a_manifold_in_order() {
        let (positions, triangles) = shapes::sphere(800, 3);
        let mut mesh = Mesh::from_triangles(positions, &triangles).expect("closed");
        mesh.colors = (0..mesh.vertex_count()).map(|v| [v as f32; 4]).collect();
        mesh.face_tags = (0..mesh.face_count() as u32).collect();
        let mut random = SplitMix::new(1);
        for share in [3, 10, 60] {
            let mut selected = faces_in_ball(&mesh, DVec3::X, 0.8);
            for flag in &mut selected {
                *flag |= random.below(share) == 0;
            }
            let left = erase(&mesh, &selected);
            check_mesh(&left.mesh).expect("sound");
            assert!(left.old_vertex.is_sorted() && left.old_face.is_sorted());
            for (v, &old) in left.old_vertex.iter().enumerate() {
                assert_eq!(left.mesh.positions[v], mesh.positions[old as usize]);
                assert_eq!(left.mesh.colors[v][0], old as f32);
            }
            for (f, &old) in left.old_face.iter().enumerate() {
                assert!(!selected[old as usize]);
                assert_eq!(left.mesh.face_tags[f], old);
            }
            let lonely = |v| !left.mesh.topology.has_faces(VertexId::from(v));
            assert!(!(0..left.mesh.vertex_count()).any(lonely));
        }
    }

    #[test]
    fn nothing_selected_changes_nothing() {
        let (positions, triangles) = shapes::demo();
        let mesh = Mesh::from_triangles(positions, &triangles).expect("manifold");
        let left = erase(&mesh, &vec![false; mesh.face_count()]);
        assert_eq!(left.mesh, mesh);
    }
}
