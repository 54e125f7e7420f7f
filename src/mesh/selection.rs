//! Selections of faces: one flag per face.

use super::{DVec3, FaceId, Mesh, Topology, VertexId};

/// Faces all of whose corners lie in the ball, its surface included.
pub fn faces_in_ball(mesh: &Mesh, centre: DVec3, radius: f64) -> Vec<bool> {
    let inside = |p: DVec3| p.distance(centre) <= radius;
    mesh.topology
        .faces()
        .map(|f| mesh.corners(f).into_iter().all(inside))
        .collect()
}

/// The connected faces of `limit` that contain `seed`, connected across edges.
pub fn connected_faces(topology: &Topology, seed: FaceId, limit: &[bool]) -> Vec<bool> {
    let mut reached = vec![false; topology.face_count()];
    let mut stack = vec![seed];
    while let Some(f) = stack.pop() {
        if !limit[f.index()] || std::mem::replace(&mut reached[f.index()], true) {
            continue;
        }
        for h in topology.face_halfedges(f) {
            let g = topology.face(h.twin());
            if g.is_some() && !reached[g.index()] {
                stack.push(g);
            }
        }
    }
    reached
}

/// Adds all faces that share a vertex with a selected one.
pub fn grow(topology: &Topology, selected: &mut [bool]) {
    let touched = touched_vertices(topology, selected);
    for (f, flag) in selected.iter_mut().enumerate() {
        let corners = topology.face_vertices(FaceId::from(f));
        *flag |= corners.iter().any(|v| touched[v.index()]);
    }
}

/// Removes all faces that share a vertex with one that is not selected.
pub fn shrink(topology: &Topology, selected: &mut [bool]) {
    invert(selected);
    grow(topology, selected);
    invert(selected);
}

/// Inverts the selection.
pub fn invert(selected: &mut [bool]) {
    for flag in selected {
        *flag = !*flag;
    }
}

/// Smooths the border by majority: a face with two or more neighbours on the other side changes
/// sides, until none is left or `passes` are over. This removes ears and notches one face wide, and
/// single faces.
pub fn smooth_border(topology: &Topology, selected: &mut [bool], passes: usize) {
    for _ in 0..passes {
        let before = selected.to_vec();
        let mut any = false;
        for (f, flag) in selected.iter_mut().enumerate() {
            let (mut same, mut other) = (0, 0);
            for h in topology.face_halfedges(FaceId::from(f)) {
                let g = topology.face(h.twin());
                if g.is_some() {
                    if before[g.index()] == before[f] {
                        same += 1;
                    } else {
                        other += 1;
                    }
                }
            }
            if other > same && other >= 2 {
                *flag = !before[f];
                any = true;
            }
        }
        if !any {
            return;
        }
    }
}

/// Interior vertices whose faces are all selected, in ascending order. These vertices may move
/// while all others are fixed.
pub fn inner_vertices(topology: &Topology, selected: &[bool]) -> Vec<VertexId> {
    topology
        .vertices()
        .filter(|&v| {
            topology.has_faces(v)
                && topology.outgoing(v).all(|h| {
                    let f = topology.face(h);
                    f.is_some() && selected[f.index()]
                })
        })
        .collect()
}

/// Ascending indices as text: numbers from 1 on and ranges of them, `1-12,40`.
pub fn ranges_text(indices: &[u32]) -> String {
    let mut words = Vec::new();
    let mut at = 0;
    while at < indices.len() {
        let first = indices[at];
        let run = (0..).zip(&indices[at..]);
        let length = run.take_while(|&(k, &i)| i == first + k).count();
        let last = u64::from(first) + length as u64;
        words.push(if length == 1 {
            last.to_string()
        } else {
            format!("{}-{last}", u64::from(first) + 1)
        });
        at += length;
    }
    words.join(",")
}

/// Parses the text of [`ranges_text`] for a list of `count` items. Line breaks and spaces separate
/// words too. Returns ascending indices, each once.
///
/// # Errors
/// The invalid word and the reason.
pub fn parse_ranges(text: &str, count: usize) -> Result<Vec<u32>, String> {
    let mut indices = Vec::new();
    for word in text.split([',', ' ', '\t', '\n', '\r']) {
        if word.is_empty() {
            continue;
        }
        let (first, last) = word.split_once('-').unwrap_or((word, word));
        let number = |w: &str| match w.parse::<u32>() {
            Ok(n) if n >= 1 && n as usize <= count => Ok(n - 1),
            Ok(n) => Err(format!("`{word}`: {n} is not in 1 to {count}")),
            Err(_) => Err(format!(
                "`{word}` is neither a number nor a range; write a list as in 1-12,40"
            )),
        };
        let (first, last) = (number(first)?, number(last)?);
        if first > last {
            return Err(format!(
                "`{word}`: the end of the range is before its start"
            ));
        }
        indices.extend(first..=last);
    }
    indices.sort_unstable();
    indices.dedup();
    Ok(indices)
}

/// One flag for each of `count` faces, set for the listed ones.
pub fn face_flags(faces: &[u32], count: usize) -> Vec<bool> {
    let mut flags = vec![false; count];
    for &f in faces {
        flags[f as usize] = true;
    }
    flags
}

/// The set flags as ascending indices.
pub fn face_list(flags: &[bool]) -> Vec<u32> {
    (0..)
        .zip(flags)
        .filter(|(_, set)| **set)
        .map(|(f, _)| f)
        .collect()
}

/// The faces with a corner within `radius` of `centre` that are connected to `seed` across edges of
/// such faces, and always `seed`, in ascending order. The cost depends on the result, not on the
/// size of the mesh.
pub fn faces_near(mesh: &Mesh, seed: FaceId, centre: DVec3, radius: f64) -> Vec<u32> {
    let topology = &mesh.topology;
    let near = |f: FaceId| {
        let corners = mesh.corners(f);
        corners.iter().any(|p| p.distance(centre) <= radius)
    };
    let mut found = std::collections::BTreeSet::from([seed.0]);
    let mut stack = vec![seed];
    while let Some(f) = stack.pop() {
        for h in topology.face_halfedges(f) {
            let g = topology.face(h.twin());
            if g.is_some() && near(g) && found.insert(g.0) {
                stack.push(g);
            }
        }
    }
    found.into_iter().collect()
}

pub(super) fn touched_vertices(topology: &Topology, selected: &[bool]) -> Vec<bool> {
    let mut touched = vec![false; topology.vertex_count()];
    for (f, _) in selected.iter().enumerate().filter(|(_, flag)| **flag) {
        for v in topology.face_vertices(FaceId::from(f)) {
            touched[v.index()] = true;
        }
    }
    touched
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes;

    fn ball() -> Mesh {
        let (positions, triangles) = shapes::icosphere(8);
        Mesh::from_triangles(positions, &triangles).expect("closed")
    }

    fn count(selected: &[bool]) -> usize {
        selected.iter().filter(|&&flag| flag).count()
    }

    #[test]
    fn growing_and_shrinking_go_ring_by_ring() {
        let mesh = ball();
        let t = &mesh.topology;
        // around a regular vertex of the lattice: 6, then 24, then 54 triangles
        let v = t
            .vertices()
            .find(|&v| t.valence(v) == 6 && t.neighbours(v).all(|w| t.valence(w) == 6))
            .expect("inside a face of the icosahedron");
        let mut selected = vec![false; t.face_count()];
        for h in t.outgoing(v) {
            selected[t.face(h).index()] = true;
        }
        let first = selected.clone();
        grow(t, &mut selected);
        assert_eq!(count(&selected), 24);
        let border = inner_vertices(t, &selected);
        assert_eq!(border.len(), 7);
        assert!(border.contains(&v));
        shrink(t, &mut selected);
        assert_eq!(selected, first);
        invert(&mut selected);
        assert_eq!(count(&selected), t.face_count() - 6);
    }

    #[test]
    fn smoothing_takes_off_ears_and_fills_notches() {
        let mesh = ball();
        let t = &mesh.topology;
        let smooth = faces_in_ball(&mesh, DVec3::Z, 0.7);
        let mut rough = smooth.clone();
        smooth_border(t, &mut rough, 20);
        let smooth = rough.clone();
        // a lone face well inside and one outside
        let mut deep = smooth.clone();
        shrink(t, &mut deep);
        shrink(t, &mut deep);
        let inside = deep.iter().position(|&flag| flag).expect("an inner face");
        let low = |f: &usize| mesh.corners(FaceId::from(*f))[0].z;
        let far = (0..t.face_count())
            .min_by(|f, g| low(f).total_cmp(&low(g)))
            .expect("a face at the bottom");
        rough[inside] = false;
        rough[far] = true;
        smooth_border(t, &mut rough, 20);
        assert_eq!(rough, smooth);
    }

    #[test]
    fn lists_of_faces_as_text_and_back() {
        for list in [vec![], vec![0], vec![0, 1, 2, 7, 9, 10], vec![3, 5, 6]] {
            let text = ranges_text(&list);
            assert_eq!(parse_ranges(&text, 11), Ok(list.clone()), "{text}");
            assert_eq!(face_list(&face_flags(&list, 11)), list);
        }
        assert_eq!(ranges_text(&[0, 1, 2, 7]), "1-3,8");
        assert_eq!(parse_ranges("4\n2-3, 3", 4), Ok(vec![1, 2, 3]));
        for wrong in ["0", "12", "3-2", "a", "1-", "-1", "5000000000"] {
            let fault = parse_ranges(wrong, 11).expect_err(wrong);
            assert!(fault.contains(&format!("`{wrong}`")), "{fault}");
        }
    }

    #[test]
    fn near_faces_are_those_of_the_ball_that_hang_together() {
        let mesh = ball();
        let seed = FaceId(17);
        let centre = mesh.corners(seed)[0];
        let near = faces_near(&mesh, seed, centre, 0.4);
        let touches = |f: u32| {
            let corners = mesh.corners(FaceId(f));
            corners.iter().any(|p| p.distance(centre) <= 0.4)
        };
        let all: Vec<u32> = (0..mesh.face_count() as u32)
            .filter(|&f| touches(f))
            .collect();
        assert_eq!(near, all);
        assert_eq!(faces_near(&mesh, seed, centre * 9.0, 0.4), [17]);
    }

    #[test]
    fn connected_faces_stop_at_the_limit() {
        let mesh = ball();
        let t = &mesh.topology;
        let all = vec![true; t.face_count()];
        assert_eq!(connected_faces(t, FaceId(3), &all), all);
        let mut halves = vec![false; t.face_count()];
        for (f, flag) in halves.iter_mut().enumerate() {
            let z: f64 = mesh.corners(FaceId::from(f)).iter().map(|p| p.z).sum();
            *flag = z.abs() > 0.6;
        }
        let top = (0..t.face_count())
            .find(|&f| halves[f] && mesh.corners(FaceId::from(f))[0].z > 0.0)
            .expect("a face");
        let reached = connected_faces(t, FaceId::from(top), &halves);
        assert!(reached.iter().zip(&halves).all(|(r, h)| !r || *h));
        assert_eq!(2 * count(&reached), count(&halves));
    }
}
