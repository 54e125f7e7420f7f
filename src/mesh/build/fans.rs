//! Vertices of the repaired mesh: one for each fan of connected faces around a position.
//!
//! ```text
//!       f0   f1            corners c0 and c1 at the position p belong to faces that are joined
//!      ____ ____           across an edge: one fan, one vertex. The corners c2 and c3 of the
//!      \   |   /           other two faces form a second fan at the same position: a second
//!       \c0|c1/            vertex, although the file has a single one.
//!        \ | /
//!         \p/
//!         / \
//!       /c2|c3\
//!      /___|___\
//!       f2   f3
//! ```
//!
//! Corner `3 f + k` is corner `k` of face `f`; edge `3 f + k` runs from it to the next corner. A
//! *mate* is the edge of another face to which an edge is joined.

use super::edges::{EdgeTable, ends, following, opposite};
use super::join::{NONE, Sheets};
use crate::mesh::union_find::{find, unite};
use crate::mesh::{Topology, TopologyError};

/// Corners grouped by the vertex they become.
pub(super) struct Fans {
    /// The fan of each corner (3 f + k), numbered by their lowest corner.
    pub of_corner: Vec<u32>,
    /// Number of fans.
    pub count: usize,
}

/// Joins the corners at both ends of every joined edge; `own` are the file's corners, `triangles`
/// names one vertex per position.
pub(super) fn fans(own: &[[u32; 3]], triangles: &[[u32; 3]], mate: &[u32]) -> Fans {
    let mut link: Vec<u32> = (0..mate.len() as u32).collect();
    for (c, &d) in mate.iter().enumerate() {
        let c = c as u32;
        if d == NONE || d < c {
            continue;
        }
        let (mut d0, mut d1) = (d, following(d));
        let same_way = match (ends(own, c), ends(own, d)) {
            ((a, b), (p, q)) if (a, b) == (p, q) || (a, b) == (q, p) => a == p,
            _ => ends(triangles, c).0 == ends(triangles, d).0,
        };
        if !same_way {
            std::mem::swap(&mut d0, &mut d1);
        }
        unite(&mut link, c, d0);
        unite(&mut link, following(c), d1);
    }
    number(&mut link)
}

/// Numbers the classes in the order of their lowest member.
fn number(link: &mut [u32]) -> Fans {
    let mut of_corner = vec![0; link.len()];
    let mut count = 0;
    for c in 0..link.len() as u32 {
        let root = find(link, c);
        of_corner[c as usize] = if root == c {
            count += 1;
            count - 1
        } else {
            of_corner[root as usize]
        };
    }
    Fans {
        of_corner,
        count: count as usize,
    }
}

/// Rounds in which edges that came to have the same vertices may still be joined instead of cut.
const JOIN_ROUNDS: usize = 8;

/// Undoes joins after which two different edges have the same two vertices, or two faces the same
/// three: index triples cannot tell those apart. Checks only the corner-edges `suspects`, all if
/// `None`. Returns one corner-edge of each edge that was cut.
pub(super) fn cut_parallel_edges(
    own: &[[u32; 3]],
    triangles: &[[u32; 3]],
    sheets: &mut Sheets,
    suspects: Option<&[u32]>,
) -> (Fans, Vec<u32>) {
    let all: Vec<u32> = match suspects {
        Some(some) => some.to_vec(),
        None => (0..sheets.mate.len() as u32)
            .filter(|&c| !sheets.dropped[c as usize / 3])
            .collect(),
    };
    let mut cuts = Vec::new();
    for round in 0.. {
        let current = fans(own, triangles, &sheets.mate);
        let named = corners_as_triangles(&current.of_corner);
        let table = EdgeTable::new(&named, current.count, all.iter().copied());
        let before = cuts.len();
        let mut changed = false;
        // a group: all corner-edges between the same two vertices
        for group in table.groups(&named) {
            if let [c, d] = *group
                && sheets.mate[c as usize] != d
                && round < JOIN_ROUNDS
            {
                sheets.try_join(&named, c, d);
                changed = true;
            }
            // sound: one boundary edge, or two faces joined to each other with different third
            // corners
            let sound = match *group {
                [c, d] => {
                    sheets.mate[c as usize] == d && opposite(&named, c) != opposite(&named, d)
                }
                _ => group.len() < 2,
            };
            if sound {
                continue;
            }
            cuts.push(group[0]);
            if !unmate(&mut sheets.mate, group.iter().copied()) {
                // nothing is joined at the edge itself: cut all edges of the later faces
                for &c in &group[1..] {
                    let f = c - c % 3;
                    unmate(&mut sheets.mate, f..f + 3);
                }
            }
        }
        if cuts.len() == before && !changed {
            return (current, cuts);
        }
    }
    unreachable!("every round cuts faces apart, of which there are finitely many")
}

fn unmate(mate: &mut [u32], edges: impl Iterator<Item = u32>) -> bool {
    let mut any = false;
    for c in edges {
        let d = std::mem::replace(&mut mate[c as usize], NONE);
        if d != NONE {
            mate[d as usize] = NONE;
            any = true;
        }
    }
    any
}

/// The fan indices of all corners as index triples.
pub(super) fn corners_as_triangles(of_corner: &[u32]) -> Vec<[u32; 3]> {
    of_corner
        .chunks_exact(3)
        .map(|t| [t[0], t[1], t[2]])
        .collect()
}

/// Merges fans that a single boundary loop passes at the same position. There a hole touches
/// itself, and its lobes are filled one by one. `open` are the fans on the boundary. Returns the
/// number of such positions.
///
/// # Errors
/// The faces are not a manifold even if all fans are separate.
pub(super) fn join_pinches(
    fans: &mut Fans,
    oriented: &[[u32; 3]],
    position_of_fan: &[u32],
    open: &[u32],
) -> Result<usize, TopologyError> {
    let mut rim: Vec<(u32, u32)> = open
        .iter()
        .map(|&fan| (position_of_fan[fan as usize], fan))
        .collect();
    rim.sort_unstable();
    rim.dedup();
    if rim.windows(2).all(|pair| pair[0].0 != pair[1].0) {
        return Ok(0);
    }
    let topology = Topology::from_triangles(fans.count, oriented)?;
    let mut link: Vec<u32> = (0..fans.count as u32).collect();
    let mut pinches = 0;
    for one in topology.boundary_loops() {
        let mut visits: Vec<(u32, u32)> = one
            .iter()
            .map(|&h| topology.origin(h).0)
            .map(|fan| (position_of_fan[fan as usize], fan))
            .collect();
        visits.sort_unstable();
        for pair in visits.windows(2) {
            if pair[0].0 == pair[1].0 {
                unite(&mut link, pair[0].1, pair[1].1);
                pinches += 1;
            }
        }
    }
    if pinches == 0 {
        return Ok(0);
    }
    let merged = number(&mut link);
    let joined: Vec<[u32; 3]> = oriented
        .iter()
        .map(|t| t.map(|fan| merged.of_corner[fan as usize]))
        .collect();
    if Topology::from_triangles(merged.count, &joined).map_or(true, |t| has_pillow(&t)) {
        return Ok(0);
    }
    for fan in &mut fans.of_corner {
        *fan = merged.of_corner[*fan as usize];
    }
    fans.count = merged.count;
    Ok(pinches)
}

/// The numbering of the vertices of the repaired mesh.
pub(super) struct Naming {
    /// The mesh vertex of each fan.
    pub of_fan: Vec<u32>,
    /// The file vertex of each mesh vertex, which may be a copy.
    pub source: Vec<u32>,
    /// For each file vertex its mesh vertex.
    pub file_to_mesh: Vec<u32>,
    /// Copied file vertices, with the number of copies.
    pub copied: Vec<(u32, u32)>,
    /// File vertices merged with an earlier one.
    pub welded: usize,
}

/// Assigns to each fan, in order of decreasing size, the first unused file vertex at its corners.
/// Fans without an unused vertex get copies at the end.
pub(super) fn name_vertices(fans: &Fans, own: &[u32], vertices: usize, used: &[bool]) -> Naming {
    // most fans have one file vertex that no other fan has; only the others are sorted
    let mut size = vec![0u32; fans.count];
    let mut file_vertex = vec![NONE; fans.count];
    let mut owner = vec![NONE; vertices];
    let mut contested = (vec![false; fans.count], vec![false; vertices]);
    let corners = || {
        let pairs = own.iter().zip(&fans.of_corner).enumerate();
        pairs
            .filter(|(c, _)| used[c / 3])
            .map(|(_, (&v, &fan))| (v, fan))
    };
    for (v, fan) in corners() {
        let (v, f) = (v as usize, fan as usize);
        size[f] += 1;
        if file_vertex[f] == NONE {
            file_vertex[f] = v as u32;
        }
        if owner[v] == NONE {
            owner[v] = fan;
        }
        contested.0[f] |= file_vertex[f] != v as u32;
        contested.1[v] |= owner[v] != fan;
    }
    let open = |&(v, fan): &(u32, u32)| contested.0[fan as usize] || contested.1[v as usize];
    let mut wishes: Vec<(u32, u32)> = corners().filter(open).collect();
    wishes.sort_unstable();
    wishes.dedup();
    for &(v, fan) in &wishes {
        owner[v as usize] = NONE;
        file_vertex[fan as usize] = NONE;
    }
    for same in wishes.chunk_by(|x, y| x.0 == y.0) {
        let best = same
            .iter()
            .map(|w| w.1)
            .filter(|&fan| file_vertex[fan as usize] == NONE)
            .max_by_key(|&fan| (size[fan as usize], std::cmp::Reverse(fan)));
        if let Some(fan) = best {
            file_vertex[fan as usize] = same[0].0;
            owner[same[0].0 as usize] = fan;
        }
    }
    // the vertex list: file vertices that are kept, then copies
    let mut welded_into = vec![NONE; vertices];
    for &(v, fan) in &wishes {
        if owner[v as usize] == NONE && file_vertex[fan as usize] != NONE {
            welded_into[v as usize] = fan;
        }
    }
    let mut naming = Naming {
        of_fan: vec![NONE; fans.count],
        source: Vec::with_capacity(vertices),
        file_to_mesh: vec![NONE; vertices],
        copied: Vec::new(),
        welded: 0,
    };
    for v in 0..vertices {
        if welded_into[v] != NONE {
            naming.welded += 1;
            continue;
        }
        naming.file_to_mesh[v] = naming.source.len() as u32;
        if owner[v] != NONE {
            naming.of_fan[owner[v] as usize] = naming.source.len() as u32;
        }
        naming.source.push(v as u32);
    }
    for v in 0..vertices {
        if welded_into[v] != NONE {
            naming.file_to_mesh[v] = naming.of_fan[welded_into[v] as usize];
        }
    }
    for &(v, fan) in &wishes {
        if naming.of_fan[fan as usize] != NONE {
            continue;
        }
        naming.of_fan[fan as usize] = naming.source.len() as u32;
        naming.source.push(v);
        match naming.copied.last_mut() {
            Some((last, copies)) if *last == v => *copies += 1,
            _ => naming.copied.push((v, 1)),
        }
    }
    naming
}

/// Whether two faces share all their edges: a face and its flipped copy.
pub(super) fn has_pillow(topology: &Topology) -> bool {
    topology.faces().any(|f| {
        let [a, b, c] = topology.face_halfedges(f).map(|h| topology.face(h.twin()));
        a.is_some() && a == b && b == c
    })
}
