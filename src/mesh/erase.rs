//! Erasing faces.

use super::selection::touched_vertices;
use super::{FaceId, Mesh, Topology, TopologyError, VertexId};

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
    let mut gone = selected.to_vec();
    let beside = touched_vertices(&mesh.topology, &gone);
    let beside = (0..).zip(beside).filter_map(|(v, is)| is.then_some(v));
    erase_loose_fans(&mesh.topology, &mut gone, beside.collect());
    loop {
        let (old_vertex, old_face) = remaining(&mesh.topology, &gone);
        let mut index = vec![u32::MAX; mesh.vertex_count()];
        for (new, &old) in old_vertex.iter().enumerate() {
            index[old as usize] = new as u32;
        }
        let renumbered = |t: [u32; 3]| t.map(|v| index[v as usize]);
        let corners = |&f: &u32| mesh.topology.face_vertices(FaceId(f)).map(|v| v.0);
        let faces: Vec<_> = old_face.iter().map(|f| renumbered(corners(f))).collect();
        let topology = match Topology::from_triangles(old_vertex.len(), &faces) {
            Ok(topology) => topology,
            // the fans of a pinched vertex belong together only while a boundary loop joins them
            Err(TopologyError::NonManifoldVertex { vertex }) => {
                let old = old_vertex[vertex as usize];
                erase_loose_fans(&mesh.topology, &mut gone, vec![old]);
                continue;
            }
            Err(defect) => unreachable!("a part of a manifold: {defect}"),
        };
        let one_sided = mesh.non_orientable.iter().copied();
        let at = |v: u32| mesh.positions[v as usize];
        return Erased {
            mesh: Mesh {
                positions: old_vertex.iter().map(|&v| at(v)).collect(),
                topology,
                attributes: mesh.attributes.picked(&old_vertex, &old_face),
                non_orientable: one_sided.map(renumbered).collect(),
            },
            old_vertex,
            old_face,
        };
    }
}

/// The vertices and the faces that are left without the faces `gone`: vertices with a face that is
/// left, and those that had none.
fn remaining(topology: &Topology, gone: &[bool]) -> (Vec<u32>, Vec<u32>) {
    let touched = touched_vertices(topology, gone);
    let is_kept = |v: VertexId| {
        let mut faces = topology.outgoing(v).map(|h| topology.face(h));
        faces.any(|f| f.is_some() && !gone[f.index()])
    };
    let vertices = topology.vertices();
    let vertices = vertices.filter(|&v| !touched[v.index()] || is_kept(v));
    let faces = topology.faces().filter(|f| !gone[f.index()]);
    (
        vertices.map(|v| v.0).collect(),
        faces.map(|f| f.0).collect(),
    )
}

/// Where the remaining faces around one of the `waiting` vertices form several fans, erases all but
/// the largest, and so on at the vertices of the faces erased.
fn erase_loose_fans(topology: &Topology, gone: &mut [bool], mut waiting: Vec<u32>) {
    waiting.reverse();
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
    use crate::mesh::{Column, DVec3, Soup, build, check_mesh, faces_in_ball};
    use crate::random::SplitMix;
    use crate::shapes;

    #[test]
    fn what_is_left_is_a_manifold_in_order() {
        let (positions, triangles) = shapes::sphere(800, 3);
        let mut mesh = Mesh::from_triangles(positions, &triangles).expect("closed");
        let labels = (0..mesh.vertex_count()).map(|v| v as f64).collect();
        mesh.attributes.vertices = vec![Column::decimals("label", labels)];
        mesh.attributes.faces.tags = (0..mesh.face_count() as u32).collect();
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
                let label = left.mesh.attributes.vertices[0].numbers.get(v);
                assert_eq!(label, f64::from(old));
            }
            for (f, &old) in left.old_face.iter().enumerate() {
                assert!(!selected[old as usize]);
                assert_eq!(left.mesh.attributes.faces.tags[f], old);
            }
            let lonely = |v| !left.mesh.topology.has_faces(VertexId::from(v));
            assert!(!(0..left.mesh.vertex_count()).any(lonely));
        }
    }

    /// Random faces are missing, so that many vertices have several fans; some of these are joined
    /// by one boundary loop only, which erasing takes apart.
    #[test]
    fn pinched_vertices_stay_manifold() {
        let (positions, triangles) = shapes::icosphere(6);
        let mut random = SplitMix::new(3);
        let mut pinched = 0;
        for _ in 0..40 {
            let left = triangles.iter().filter(|_| random.below(3) > 0);
            let corners: Vec<u32> = left.copied().flatten().collect();
            let soup = Soup {
                positions: positions.clone(),
                offsets: (0..=corners.len() as u32).step_by(3).collect(),
                corners,
                ..Soup::default()
            };
            let (mesh, _) = build(&soup).expect("a mesh");
            for centre in [DVec3::X, DVec3::Y, DVec3::new(-0.6, 0.0, -0.8)] {
                let left = erase(&mesh, &faces_in_ball(&mesh, centre, 0.9));
                check_mesh(&left.mesh).expect("sound");
                pinched += left
                    .mesh
                    .topology
                    .vertices()
                    .filter(|&v| {
                        let t = &left.mesh.topology;
                        t.outgoing(v).filter(|&h| t.is_boundary(h)).count() > 1
                    })
                    .count();
            }
        }
        assert!(pinched > 0);
    }

    #[test]
    fn nothing_selected_changes_nothing() {
        let (positions, triangles) = shapes::demo();
        let mesh = Mesh::from_triangles(positions, &triangles).expect("manifold");
        let left = erase(&mesh, &vec![false; mesh.face_count()]);
        assert_eq!(left.mesh, mesh);
    }
}
