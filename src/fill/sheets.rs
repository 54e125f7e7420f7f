//! Separates parts of a region that touch in single vertices.

use crate::mesh::DVec3;
use crate::mesh::union_find::{find, unite};

/// Gives each fan of triangles around a vertex, but the first, its own copy of the vertex, at the
/// end of `positions`.
///
/// A region consists of the faces within some rings around holes. Where two parts of the outermost
/// ring meet in one vertex the region is no manifold, though the mesh is. All such vertices lie in
/// that outermost ring. Their positions are fixed, and nothing uses their own rings.
pub(super) fn separate(positions: &mut Vec<DVec3>, triangles: &mut [[u32; 3]]) {
    let corner = |c: usize| triangles[c / 3][c % 3];
    let following = |c: usize| if c % 3 == 2 { c - 2 } else { c + 1 };
    let mut edges: Vec<([u32; 2], usize)> = (0..3 * triangles.len())
        .map(|c| {
            let (a, b) = (corner(c), corner(following(c)));
            ([a.min(b), a.max(b)], c)
        })
        .collect();
    edges.sort_unstable();
    let mut link: Vec<u32> = (0..edges.len() as u32).collect();
    for pair in edges.windows(2) {
        let ((e, c), (f, d)) = (pair[0], pair[1]);
        if e == f {
            // the two sides run through the edge in opposite directions
            unite(&mut link, c as u32, following(d) as u32);
            unite(&mut link, following(c) as u32, d as u32);
        }
    }
    let mut first = vec![usize::MAX; positions.len()];
    let mut name = vec![0; link.len()];
    for c in 0..link.len() {
        let root = find(&mut link, c as u32) as usize;
        if root == c {
            let v = corner(c);
            let seen = &mut first[v as usize];
            name[c] = if *seen == usize::MAX {
                *seen = c;
                v
            } else {
                positions.push(positions[v as usize]);
                positions.len() as u32 - 1
            };
        } else {
            // roots are the lowest of their class
            name[c] = name[root];
        }
    }
    for (t, names) in triangles.iter_mut().zip(name.chunks_exact(3)) {
        t.copy_from_slice(names);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Topology;
    use crate::shapes;

    #[test]
    fn sheets_joined_at_a_vertex_come_apart() {
        // two pairs of triangles that meet in vertex 0
        let mut triangles = [[0, 1, 2], [0, 2, 3], [4, 0, 5], [5, 0, 6]];
        let mut positions: Vec<DVec3> = (0..7).map(|i| DVec3::splat(f64::from(i))).collect();
        positions[0] = DVec3::new(0.5, 0.25, -3.0);
        assert!(Topology::from_triangles(7, &triangles).is_err());
        separate(&mut positions, &mut triangles);
        assert_eq!(triangles, [[0, 1, 2], [0, 2, 3], [4, 7, 5], [5, 7, 6]]);
        assert_eq!(positions.len(), 8);
        assert_eq!(positions[7], positions[0]);
        assert!(Topology::from_triangles(8, &triangles).is_ok());
    }

    #[test]
    fn manifolds_stay_as_they_are() {
        let (mut positions, mut triangles) = shapes::icosphere(3);
        let before = (positions.clone(), triangles.clone());
        separate(&mut positions, &mut triangles);
        assert_eq!((positions, triangles), before);
    }
}
