//! Validity of meshes, for tests.

use super::{DVec3, FaceId, HalfedgeId, Mesh, Topology, VertexId};

/// Checks every invariant that [`Topology`] documents, and that no two edges and no two faces have
/// the same vertices.
///
/// # Errors
/// The first fault, in words.
pub fn check_topology(topology: &Topology) -> Result<(), String> {
    check_halfedges(topology)?;
    check_vertices(topology)?;
    let mut edges: Vec<(u32, u32)> = topology
        .edges()
        .map(|h| (topology.origin(h).0, topology.target(h).0))
        .map(|(a, b)| (a.min(b), a.max(b)))
        .collect();
    edges.sort_unstable();
    if let Some(same) = edges.windows(2).find(|w| w[0] == w[1]) {
        let (a, b) = same[0];
        return Err(format!("vertices {a} and {b} are joined by two edges"));
    }
    let mut faces: Vec<([u32; 3], usize)> = topology
        .triangles()
        .enumerate()
        .map(|(f, mut t)| {
            t.sort_unstable();
            (t, f)
        })
        .collect();
    faces.sort_unstable();
    if let Some(same) = faces.windows(2).find(|w| w[0].0 == w[1].0) {
        let (a, b) = (same[0].1, same[1].1);
        return Err(format!("faces {a} and {b} have the same vertices"));
    }
    Ok(())
}

fn check_halfedges(topology: &Topology) -> Result<(), String> {
    let n = topology.halfedge_count();
    let mut arrivals = vec![false; n];
    for h in (0..n).map(HalfedgeId::from) {
        let fault = |what| Err(format!("half-edge {}: {what}", h.0));
        let next = topology.next(h);
        if next.index() >= n {
            return fault("it has no next one");
        }
        if std::mem::replace(&mut arrivals[next.index()], true) {
            return fault("its next one follows another one too");
        }
        if topology.origin(next) != topology.target(h) {
            return fault("its next one does not start where it ends");
        }
        if topology.face(next) != topology.face(h) {
            return fault("its next one belongs to another face");
        }
        if topology.origin(h) == topology.target(h) {
            return fault("it starts where it ends");
        }
        if topology.is_boundary(h) {
            if topology.is_boundary(h.twin()) {
                return fault("it has no face on either side");
            }
        } else if topology.next(topology.next(next)) != h {
            return fault("its face is no triangle");
        }
    }
    for f in topology.faces() {
        let h = topology.halfedge_of_face(f);
        if topology.face(h) != f {
            return Err(format!("half-edge {}: it is not one of its face's", h.0));
        }
    }
    Ok(())
}

fn check_vertices(topology: &Topology) -> Result<(), String> {
    let mut degree = vec![0usize; topology.vertex_count()];
    let mut on_boundary = vec![false; topology.vertex_count()];
    for h in topology.halfedges() {
        degree[topology.origin(h).index()] += 1;
        on_boundary[topology.origin(h).index()] |= topology.is_boundary(h);
    }
    for v in topology.vertices() {
        let fault = |what| Err(format!("vertex {}: {what}", v.0));
        let h = topology.halfedge_of_vertex(v);
        if !h.is_some() {
            if degree[v.index()] > 0 {
                return fault("it has edges but no half-edge");
            }
            continue;
        }
        if topology.origin(h) != v {
            return fault("its half-edge starts elsewhere");
        }
        if topology.is_boundary(h) != on_boundary[v.index()] {
            return fault("its half-edge is not the boundary one");
        }
        if topology.outgoing(v).count() != degree[v.index()] {
            return fault("its faces form more than one fan");
        }
    }
    // loops visit no vertex twice
    let mut last_loop = vec![usize::MAX; topology.vertex_count()];
    for (i, one) in topology.boundary_loops().iter().enumerate() {
        for &h in one {
            let v = topology.origin(h);
            if std::mem::replace(&mut last_loop[v.index()], i) == i {
                return Err(format!(
                    "vertex {}: a boundary loop touches itself there",
                    v.0
                ));
            }
        }
    }
    Ok(())
}

/// [`check_topology`], and finite positions, one for each vertex.
///
/// # Errors
/// The first fault, in words.
pub fn check_mesh(mesh: &Mesh) -> Result<(), String> {
    let (positions, vertices) = (mesh.positions.len(), mesh.topology.vertex_count());
    if positions != vertices {
        return Err(format!("{positions} positions for {vertices} vertices"));
    }
    if let Some(vertex) = mesh.positions.iter().position(|p| !p.is_finite()) {
        let position = mesh.positions[vertex];
        return Err(format!(
            "vertex {vertex} is at {position}, which is not finite"
        ));
    }
    check_topology(&mesh.topology)
}

/// Checks a filled mesh against its input: it is valid, all vertices and faces of the input are
/// unchanged and come first, no new face has zero area, and exactly the loops `left_open` (as in
/// `before`) are open. Does not check self-intersections.
///
/// # Errors
/// The first fault, in words.
pub fn check_filled(before: &Mesh, after: &Mesh, left_open: &[&[VertexId]]) -> Result<(), String> {
    check_mesh(after)?;
    let bits = |p: &DVec3| p.to_array().map(f64::to_bits);
    for (vertex, p) in before.positions.iter().enumerate() {
        if after.positions.get(vertex).map(bits) != Some(bits(p)) {
            return Err(format!("vertex {vertex} of the input was moved"));
        }
    }
    let mut result = after.topology.triangles();
    for (face, t) in before.topology.triangles().enumerate() {
        if result.next() != Some(t) {
            return Err(format!("face {face} of the input was changed"));
        }
    }
    for face in before.face_count()..after.face_count() {
        let [a, b, c] = after.corners(FaceId::from(face));
        if (b - a).cross(c - a).length_squared() <= 0.0 {
            return Err(format!("face {face} has no area"));
        }
    }
    let sorted = |mut ring: Vec<u32>| {
        ring.sort_unstable();
        ring
    };
    let mut wanted: Vec<Vec<u32>> = left_open
        .iter()
        .map(|ring| sorted(ring.iter().map(|v| v.0).collect()))
        .collect();
    for one in after.topology.boundary_loops() {
        let ring = sorted(one.iter().map(|&h| after.topology.origin(h).0).collect());
        let Some(place) = wanted.iter().position(|w| *w == ring) else {
            return Err(format!(
                "the boundary loop through vertex {} is still open",
                ring[0]
            ));
        };
        wanted.swap_remove(place);
    }
    match wanted.first() {
        Some(ring) => Err(format!(
            "the boundary loop through vertex {} is closed",
            ring[0]
        )),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mesh(positions: &[[f64; 3]], triangles: &[[u32; 3]]) -> Mesh {
        let positions = positions.iter().map(|&p| DVec3::from(p)).collect();
        Mesh::from_triangles(positions, triangles).expect("manifold")
    }

    const CORNERS: [[f64; 3]; 4] = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [0., 0., 1.]];
    const TETRA: [[u32; 3]; 4] = [[0, 3, 1], [1, 3, 2], [0, 2, 3], [0, 1, 2]];

    #[test]
    fn a_filled_hole_is_distinguished_from_an_open_one() {
        let open = mesh(&CORNERS, &TETRA[..3]);
        let closed = mesh(&CORNERS, &TETRA);
        let rim = [VertexId(2), VertexId(0), VertexId(1)];
        assert_eq!(check_filled(&open, &closed, &[]), Ok(()));
        assert_eq!(check_filled(&open, &open, &[&rim]), Ok(()));
        let fault = |after: &Mesh, left: &[&[VertexId]]| check_filled(&open, after, left);
        assert!(fault(&open, &[]).is_err_and(|e| e.ends_with("vertex 0 is still open")));
        assert!(fault(&closed, &[&rim]).is_err_and(|e| e.ends_with("vertex 0 is closed")));
    }

    #[test]
    fn changes_to_the_input_are_found() {
        let open = mesh(&CORNERS, &TETRA[..3]);
        let mut moved = mesh(&CORNERS, &TETRA);
        moved.positions[2].x = -0.0;
        let fault = check_filled(&open, &moved, &[]);
        assert!(fault.is_err_and(|e| e.starts_with("vertex 2 of the input")));
        let turned = mesh(&CORNERS, &TETRA.map(|[a, b, c]| [b, c, a]));
        let fault = check_filled(&open, &turned, &[]);
        assert!(fault.is_err_and(|e| e.starts_with("face 0 of the input")));
        let mut wild = mesh(&CORNERS, &TETRA);
        wild.positions[3].y = f64::NAN;
        assert!(check_mesh(&wild).is_err_and(|e| e.starts_with("vertex 3 is at")));
        let mut flat = CORNERS;
        flat[2] = [2., 0., 0.];
        let (open, closed) = (mesh(&flat, &TETRA[..3]), mesh(&flat, &TETRA));
        let fault = check_filled(&open, &closed, &[]);
        assert!(fault.is_err_and(|e| e == "face 3 has no area"));
    }

    #[test]
    fn a_pillow_has_double_faces() {
        let pillow = Topology::from_triangles(3, &[[0, 1, 2], [2, 1, 0]]).expect("closed");
        let fault = check_topology(&pillow);
        assert!(fault.is_err_and(|e| e == "faces 0 and 1 have the same vertices"));
    }
}
