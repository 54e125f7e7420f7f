//! Faces selected by their quality.

use super::{DVec3, FOLD_DEGREES, Mesh, face_flags, folded_edges, self_intersections};

/// A flaw of faces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Flaw {
    /// The smallest angle is below this limit, in degrees. Triangles without area have the angle 0.
    WorseThan(f64),
    /// An edge is longer than this, in units of the mesh.
    LongerThan(f64),
    /// The face intersects another one.
    Crossing,
    /// The normals of the face and of a neighbour differ by [`FOLD_DEGREES`] degrees or more.
    Folded,
}

/// The faces with a flaw, one flag each.
pub fn flawed_faces(mesh: &Mesh, flaw: Flaw) -> Vec<bool> {
    let faces = mesh.topology.faces();
    let corners = faces.map(|f| mesh.corners(f));
    match flaw {
        Flaw::WorseThan(limit) => {
            let limit = limit.to_radians();
            corners.map(|c| smallest_angle(c) < limit).collect()
        }
        Flaw::LongerThan(limit) => corners
            .map(|[a, b, c]| {
                let lengths = [a.distance(b), b.distance(c), c.distance(a)];
                lengths.into_iter().any(|length| length > limit)
            })
            .collect(),
        Flaw::Crossing => {
            let triangles: Vec<[u32; 3]> = mesh.topology.triangles().collect();
            let pairs = self_intersections(&mesh.positions, &triangles, None, usize::MAX);
            face_flags(pairs.as_flattened(), triangles.len())
        }
        Flaw::Folded => {
            let pairs = folded_edges(&mesh.positions, &mesh.topology, FOLD_DEGREES.to_radians());
            face_flags(pairs.as_flattened(), mesh.face_count())
        }
    }
}

/// The smallest angle of a triangle in radians; 0 without area.
fn smallest_angle(corners: [DVec3; 3]) -> f64 {
    let [a, b, c] = corners;
    let angle = |p: DVec3, q: DVec3, r: DVec3| {
        let (u, v) = (q - p, r - p);
        u.cross(v).length().atan2(u.dot(v))
    };
    if (b - a).cross(c - a) == DVec3::ZERO {
        return 0.0;
    }
    angle(a, b, c).min(angle(b, c, a)).min(angle(c, a, b))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::face_list;

    /// Three separate triangles: with angles 90, 60 and 30 degrees, without area, and across the
    /// first one.
    fn mesh() -> Mesh {
        let positions = [
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [0.0, 3f64.sqrt(), 0.0],
            [9.0, 0.0, 0.0],
            [9.5, 0.0, 0.0],
            [10.0, 0.0, 0.0],
            [0.2, 0.2, -0.5],
            [0.2, 0.2, 0.5],
            [0.9, 0.9, 0.0],
        ];
        let positions = positions.map(DVec3::from).to_vec();
        Mesh::from_triangles(positions, &[[0, 1, 2], [3, 4, 5], [6, 7, 8]]).expect("three parts")
    }

    #[test]
    fn faces_are_found_by_their_flaws() {
        let mesh = mesh();
        for (flaw, wanted) in [
            (Flaw::WorseThan(0.0), &[][..]),
            (Flaw::WorseThan(29.9), &[1]),
            (Flaw::WorseThan(30.1), &[0, 1]),
            (Flaw::WorseThan(60.0), &[0, 1, 2]),
            (Flaw::LongerThan(1.99), &[0]),
            (Flaw::LongerThan(2.01), &[]),
            (Flaw::LongerThan(0.99), &[0, 1, 2]),
            (Flaw::Crossing, &[0, 2]),
        ] {
            let found = face_list(&flawed_faces(&mesh, flaw));
            assert_eq!(found, wanted, "{flaw:?}");
        }
    }

    #[test]
    fn faces_beside_a_fold_are_found() {
        // a strip of three triangles, the last one turned about its edge by an angle
        let folded = |degrees: f64| {
            let (sin, cos) = degrees.to_radians().sin_cos();
            let tip = DVec3::new(1.0 + cos, 0.5, sin);
            let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
            let corners = corners.map(|[x, y]| DVec3::new(x, y, 0.0));
            let positions = [&corners[..], &[tip]].concat();
            let strip = [[0, 2, 3], [0, 1, 2], [1, 4, 2]];
            let mesh = Mesh::from_triangles(positions, &strip).expect("a strip");
            face_list(&flawed_faces(&mesh, Flaw::Folded))
        };
        assert!(folded(FOLD_DEGREES - 1.0).is_empty());
        assert_eq!(folded(FOLD_DEGREES + 1.0), [1, 2]);
        assert_eq!(folded(180.0), [1, 2]);
    }
}
