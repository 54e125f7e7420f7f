//! Loose parts: small components, and flaps that stick into holes.

use super::selection::face_flags;
use super::{FaceId, HalfedgeId, Mesh, Topology, boundary_loops, components};

/// The loose parts of a mesh.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LooseParts {
    /// For each face whether it belongs to a loose part.
    pub faces: Vec<bool>,
    /// Number of small components.
    pub components: usize,
    /// Number of flaps.
    pub flaps: usize,
}

/// Number of faces below which a component counts as loose, unless told otherwise.
pub const LOOSE_FACES: usize = 10;

/// The components with fewer than `min_faces` faces, except the largest one, and the flaps of at most
/// `flap_faces` faces. A flap is joined to the rest by one edge, and all its boundary edges are on
/// holes: the corners of an open sheet are no flaps.
pub fn loose_parts(mesh: &Mesh, min_faces: usize, flap_faces: usize) -> LooseParts {
    let topology = &mesh.topology;
    let parts = components(topology);
    let mut sizes = vec![0; parts.count];
    for &part in &parts.of_face {
        sizes[part as usize] += 1;
    }
    let most = sizes.iter().copied().max().unwrap_or(0);
    let largest = sizes.iter().position(|&size| size == most);
    let is_small = |part: usize| sizes[part] < min_faces && Some(part) != largest;
    let of_face = parts.of_face.iter();
    let mut faces: Vec<bool> = of_face.map(|&part| is_small(part as usize)).collect();
    let flaps = flaps(mesh, flap_faces);
    let flaps = flaps.iter().filter(|flap| !faces[flap.stem as usize]);
    let flaps: Vec<&Flap> = flaps.collect();
    let in_flap = flaps.iter().flat_map(|flap| flap.faces.iter().copied());
    let in_flap = face_flags(&in_flap.collect::<Vec<u32>>(), faces.len());
    // a flap on another one is part of it
    let whole = flaps.iter().filter(|flap| !in_flap[flap.stem as usize]);
    let whole = whole.count();
    for (flag, flap) in faces.iter_mut().zip(in_flap) {
        *flag |= flap;
    }
    LooseParts {
        faces,
        components: (0..parts.count).filter(|&part| is_small(part)).count(),
        flaps: whole,
    }
}

/// Faces that one edge joins to the rest of their component.
struct Flap {
    faces: Vec<u32>,
    /// The face of the rest at that edge.
    stem: u32,
}

fn flaps(mesh: &Mesh, most: usize) -> Vec<Flap> {
    if most == 0 {
        return Vec::new();
    }
    let topology = &mesh.topology;
    let mut is_outer = vec![false; topology.face_count()];
    for one in boundary_loops(mesh).iter().filter(|l| l.is_outer_boundary) {
        for h in &one.halfedges {
            is_outer[topology.face(h.twin()).index()] = true;
        }
    }
    let mut found = Vec::new();
    for tree in spanning_trees(topology) {
        let count = tree.order.len();
        for &Bridge { stem, start, end } in &tree.bridges {
            // the smaller side of the bridge; of equals that of the root stays
            let below = end - start;
            let (faces, stem) = if below <= most && 2 * below <= count {
                (tree.order[start..end].to_vec(), stem)
            } else if count - below <= most && 2 * below > count {
                let above = [&tree.order[..start], &tree.order[end..]];
                (above.concat(), tree.order[start])
            } else {
                continue;
            };
            if !faces.iter().any(|&f| is_outer[f as usize]) {
                found.push(Flap { faces, stem });
            }
        }
    }
    found
}

/// The faces of a component in the order of a depth-first search.
struct Tree {
    order: Vec<u32>,
    bridges: Vec<Bridge>,
}

/// An edge without which the component would be two: the faces beyond it are `order[start..end]`.
struct Bridge {
    /// The face before the edge.
    stem: u32,
    start: usize,
    end: usize,
}

/// A depth-first search of each component finds its bridges (R. Tarjan, *A note on finding the bridges
/// of a graph*, 1974).
fn spanning_trees(topology: &Topology) -> Vec<Tree> {
    const NEW: usize = usize::MAX;
    let count = topology.face_count();
    // the place of each face in its order, and the lowest place that its subtree reaches
    let (mut place, mut low) = (vec![NEW; count], vec![NEW; count]);
    let mut trees = Vec::new();
    let mut stack: Vec<(FaceId, Option<HalfedgeId>, usize)> = Vec::new();
    for root in topology.faces() {
        if place[root.index()] != NEW {
            continue;
        }
        let mut tree = Tree {
            order: vec![root.0],
            bridges: Vec::new(),
        };
        (place[root.index()], low[root.index()]) = (0, 0);
        stack.push((root, None, 0));
        while let Some((f, entry, next)) = stack.last_mut() {
            let (f, entry, k) = (*f, *entry, *next);
            *next += 1;
            if let Some(&h) = topology.face_halfedges(f).get(k) {
                let g = topology.face(h.twin());
                if !g.is_some() || Some(h) == entry {
                    continue;
                }
                if place[g.index()] == NEW {
                    (place[g.index()], low[g.index()]) = (tree.order.len(), tree.order.len());
                    tree.order.push(g.0);
                    stack.push((g, Some(h.twin()), 0));
                } else {
                    low[f.index()] = low[f.index()].min(place[g.index()]);
                }
                continue;
            }
            stack.pop();
            if let Some(&(stem, ..)) = stack.last() {
                low[stem.index()] = low[stem.index()].min(low[f.index()]);
                if low[f.index()] == place[f.index()] {
                    tree.bridges.push(Bridge {
                        stem: stem.0,
                        start: place[f.index()],
                        end: tree.order.len(),
                    });
                }
            }
        }
        trees.push(tree);
    }
    trees
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{DVec3, check_mesh, erase, face_list};
    use crate::shapes;

    /// A sphere with a hole around +z, and what is given beside it.
    fn with(more: impl FnOnce(&mut Vec<DVec3>, &mut Vec<[u32; 3]>)) -> (Mesh, usize) {
        let (mut positions, mut triangles) =
            shapes::cut_where(&shapes::icosphere(8), |p| p.z > 0.8);
        let count = triangles.len();
        more(&mut positions, &mut triangles);
        let mesh = Mesh::from_triangles(positions, &triangles).expect("a manifold");
        (mesh, count)
    }

    /// Adds faces on a rim edge: each one on the last edge of the one before.
    fn strip(positions: &mut Vec<DVec3>, triangles: &mut Vec<[u32; 3]>, faces: usize) {
        let mesh = Mesh::from_triangles(positions.clone(), triangles).expect("a manifold");
        let rim = boundary_loops(&mesh).remove(0);
        let [mut a, b] = [rim.vertices[0].0, rim.vertices[1].0];
        for _ in 0..faces {
            let c = positions.len() as u32;
            positions.push(0.5 * (positions[a as usize] + positions[b as usize]) + 0.1 * DVec3::Z);
            triangles.push([a, b, c]);
            a = c;
        }
    }

    #[test]
    fn small_components_are_loose_and_the_largest_is_not() {
        let (mesh, count) = with(|positions, triangles| {
            for _ in 0..2 {
                let n = positions.len() as u32;
                positions.extend([DVec3::X, DVec3::Y, DVec3::Z, DVec3::ONE].map(|p| p * 4.0));
                triangles.extend([[n, n + 1, n + 2], [n, n + 2, n + 3]]);
            }
        });
        let loose = loose_parts(&mesh, 3, 0);
        assert_eq!((loose.components, loose.flaps), (2, 0));
        assert!(
            face_list(&loose.faces)
                .into_iter()
                .eq((0..4).map(|f| count as u32 + f))
        );
        assert_eq!(loose_parts(&mesh, 2, 0).components, 0);
        // the largest component stays, whatever its size
        assert_eq!(loose_parts(&mesh, 10_000, 0), loose);
    }

    #[test]
    fn flaps_hang_at_one_edge_in_a_hole() {
        for faces in 1..5 {
            let (mesh, count) = with(|p, t| strip(p, t, faces));
            let loose = loose_parts(&mesh, 0, faces);
            assert_eq!((loose.components, loose.flaps), (0, 1));
            let wanted = count..count + faces;
            assert!(
                face_list(&loose.faces)
                    .iter()
                    .map(|&f| f as usize)
                    .eq(wanted)
            );
            let left = erase(&mesh, &loose.faces).mesh;
            check_mesh(&left).expect("sound");
            assert_eq!(left, with(|_, _| ()).0);
            // of a longer flap only its end is short enough
            let end = loose_parts(&mesh, 0, faces - 1);
            assert_eq!(face_list(&end.faces).len(), faces - 1);
        }
    }

    #[test]
    fn corners_of_sheets_are_no_flaps() {
        // a square of two triangles a cell; two of its corners are triangles at one edge
        let at = |i: u32, j: u32| 5 * j + i;
        let positions = (0..25).map(|k| DVec3::new(f64::from(k % 5), f64::from(k / 5), 0.0));
        let cells = (0..4).flat_map(|j| (0..4).map(move |i| (i, j)));
        let triangles: Vec<[u32; 3]> = cells
            .flat_map(|(i, j)| {
                let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                [[a, b, c], [a, c, d]]
            })
            .collect();
        let sheet = Mesh::from_triangles(positions.collect(), &triangles).expect("a sheet");
        assert_eq!(loose_parts(&sheet, 10, 4).faces, vec![false; 32]);
    }
}
