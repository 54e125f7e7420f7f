//! Sharp edges that end at a hole on both sides continue through it.
//!
//! ```text
//!        o---------o              the sharp lines that end at a and b are joined by a curve, the
//!       /           \             chord, and the hole is filled in two parts. Each part continues
//!   ===a - - - - - - b===         the faces on its own side of the lines. The patch has a crease
//!       \           /             along the chord.
//!        o---------o
//! ```

use crate::fill::hermite::{hermite_between, length, pieces};
use crate::fill::hole::HoleRims;
use crate::fill::partial::{part_of_loop, part_of_rim};
use crate::mesh::{BoundaryLoop, DVec3, HalfedgeId, Mesh, VertexId, dihedral_angle};
use crate::patch::RimGeometry;

/// Edges with a larger angle between their faces are sharp, in degrees.
const SHARP: f64 = 40.0;
/// Sharp edges that a line consists of at least; an end of noise is shorter.
const LEAST_EDGES: usize = 3;
/// Largest turn of a line at a vertex, in degrees.
const LARGEST_TURN: f64 = 30.0;
/// Largest difference of the angles between faces along a line and from one line to the other, in
/// degrees.
const LARGEST_CHANGE: f64 = 25.0;
/// Largest angle between a line and the straight way to the other line, in degrees: half a turn of 120°.
const LARGEST_DEVIATION: f64 = 60.0;

/// A hole in two parts, with a crease between them.
pub(super) struct SplitHole {
    pub parts: [HoleRims; 2],
    /// New vertices along the crease, without its ends.
    pub chord: Vec<DVec3>,
    /// The rim vertices that it joins.
    pub ends: [VertexId; 2],
}

impl SplitHole {
    /// Numbers the vertices of the chord from `first` on. Until then they have no numbers of the mesh.
    pub fn number(&mut self, first: usize) {
        let count = self.chord.len();
        for (k, part) in self.parts.iter_mut().enumerate() {
            for (i, at) in part.crease.clone().enumerate() {
                let i = if k == 0 { i } else { count - 1 - i };
                let v = VertexId::from(first + i);
                part.vertices[at] = v;
                part.loops[0].vertices[at] = v;
            }
        }
    }
}

/// Whether the faces beside an edge meet at a sharp angle.
pub(super) fn is_sharp(mesh: &Mesh, h: HalfedgeId) -> bool {
    dihedral_angle(&mesh.positions, &mesh.topology, h) > SHARP.to_radians()
}

/// Splits a hole between the ends of two sharp lines. `None` if there are no such lines, if other
/// sharp edges end at the hole, or if the lines do not lead to each other.
pub(super) fn split(mesh: &Mesh, hole: &BoundaryLoop, density: f64) -> Option<SplitHole> {
    let [a, b] = line_ends(mesh, hole)?;
    let n = hole.vertices.len();
    if b.index - a.index < 2 || n + a.index - b.index < 2 {
        return None;
    }
    let straight = b.point - a.point;
    let leads =
        |end: &LineEnd, to: DVec3| end.ahead.angle_between(to) <= LARGEST_DEVIATION.to_radians();
    let turns = (a.angle - b.angle).abs() > LARGEST_CHANGE.to_radians();
    if turns || !leads(&a, straight) || !leads(&b, -straight) {
        return None;
    }
    // from b back to a, as the rim of the first part runs
    let curve = hermite_between(b.point, b.ahead, a.point, -a.ahead);
    let size = hole.perimeter / hole.edges() as f64 / density;
    let count = pieces(length(&curve), size, 2);
    let chord: Vec<DVec3> = (1..count).map(|i| curve(i as f64 / count as f64)).collect();
    if !is_apart(mesh, hole, &chord, 0.5 * size) {
        return None;
    }
    let back: Vec<DVec3> = chord.iter().rev().copied().collect();
    let part = |from: usize, to: usize, chord: &[DVec3]| {
        let edges = (to + n - from) % n;
        let along: Vec<usize> = (0..edges).map(|k| (from + k) % n).collect();
        let rim = part_of_rim(mesh, hole, &along, to, chord);
        let unnumbered = vec![VertexId::NONE; chord.len()];
        let one = part_of_loop(hole, &along, to, &rim, &unnumbered);
        let crease = edges + 1..one.vertices.len();
        HoleRims {
            crease,
            ..HoleRims::with_geometry(vec![one], RimGeometry::single(rim))
        }
    };
    Some(SplitHole {
        parts: [
            part(a.index, b.index, &chord),
            part(b.index, a.index, &back),
        ],
        ends: [b.index, a.index].map(|i| hole.vertices[i]),
        chord,
    })
}

/// The points, from rim to rim, of the crease that [`Features::Auto`](crate::fill::Features::Auto)
/// makes in the patch over a hole without islands, at a [density](crate::patch::PatchOptions::density).
/// `None` if no sharp edge continues through the hole.
pub fn crease_through(mesh: &Mesh, hole: &BoundaryLoop, density: f64) -> Option<Vec<DVec3>> {
    let SplitHole { chord, ends, .. } = split(mesh, hole, density)?;
    let [first, last] = ends.map(|v| mesh.position(v));
    Some([vec![first], chord, vec![last]].concat())
}

/// Whether the middle half of a chord stays away from the rim. It does not where the rim itself runs
/// along the sharp line, because only the faces on one side of it are missing.
fn is_apart(mesh: &Mesh, hole: &BoundaryLoop, chord: &[DVec3], distance: f64) -> bool {
    let middle = &chord[chord.len() / 4..chord.len() - chord.len() / 4];
    let mut rim = hole.vertices.iter().map(|&v| mesh.position(v));
    rim.all(|p| middle.iter().all(|q| p.distance(*q) >= distance))
}

/// The end of a sharp line at a rim.
struct LineEnd {
    /// Index along the loop.
    index: usize,
    point: DVec3,
    /// Unit tangent of the line, into the hole.
    ahead: DVec3,
    /// Angle between the faces of its last edge, in radians; negative where the edge is a valley.
    angle: f64,
}

/// The only two sharp edges at the rim, if each is the end of a line.
fn line_ends(mesh: &Mesh, hole: &BoundaryLoop) -> Option<[LineEnd; 2]> {
    let mut sharp = Vec::new();
    for (index, &v) in hole.vertices.iter().enumerate() {
        let outgoing = mesh.topology.outgoing(v);
        sharp.extend(outgoing.filter(|&h| is_sharp(mesh, h)).map(|h| (index, h)));
        if sharp.len() > 2 {
            return None;
        }
    }
    let [a, b] = sharp[..] else {
        return None;
    };
    let end = |(index, h)| line_end(mesh, index, h);
    Some([end(a)?, end(b)?]).filter(|_| a.0 != b.0)
}

/// The end of the line that begins with a sharp edge from a rim vertex away from the hole.
fn line_end(mesh: &Mesh, index: usize, first: HalfedgeId) -> Option<LineEnd> {
    let topology = &mesh.topology;
    let angle = signed_angle(mesh, first);
    let mut along = vec![direction(mesh, first)];
    let mut h = first;
    while along.len() < LEAST_EDGES {
        let at = topology.target(h);
        let mut on = topology
            .outgoing(at)
            .filter(|&o| o != h.twin() && is_sharp(mesh, o));
        let next = on.next().filter(|_| on.next().is_none())?;
        let turn = direction(mesh, h).angle_between(direction(mesh, next));
        let change = (signed_angle(mesh, next) - angle).abs();
        if turn > LARGEST_TURN.to_radians() || change > LARGEST_CHANGE.to_radians() {
            return None;
        }
        along.push(direction(mesh, next));
        h = next;
    }
    // an edge of a curve has the direction of its middle, half an edge before the end
    let ahead = -(along[0] + 0.5 * (along[0] - along[1])).normalize_or_zero();
    Some(LineEnd {
        index,
        point: mesh.position(topology.origin(first)),
        ahead,
        angle,
    })
}

fn direction(mesh: &Mesh, h: HalfedgeId) -> DVec3 {
    let [from, to] = [mesh.topology.origin(h), mesh.topology.target(h)];
    (mesh.position(to) - mesh.position(from)).normalize_or_zero()
}

/// The angle between the faces of an edge, negative where the edge is a valley.
fn signed_angle(mesh: &Mesh, h: HalfedgeId) -> f64 {
    let [m, n] = [h, h.twin()].map(|h| {
        let [a, b, c] = mesh.corners(mesh.topology.face(h));
        (b - a).cross(c - a)
    });
    let angle = dihedral_angle(&mesh.positions, &mesh.topology, h);
    angle.copysign(m.cross(n).dot(direction(mesh, h)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fill::{Features, FillOptions, fill_rim_sets};
    use crate::mesh::{boundary_loops, check_mesh};
    use crate::random::SplitMix;
    use crate::shapes;

    /// A grid of points `at(i, j)` with the faces that `keep`, merged where points coincide.
    struct Sheets {
        points: Vec<DVec3>,
        faces: Vec<[u32; 3]>,
    }

    impl Sheets {
        fn number(&mut self, p: DVec3) -> u32 {
            let same = |q: &DVec3| q.distance(p) < 1e-9;
            let found = self.points.iter().position(same);
            found.unwrap_or_else(|| {
                self.points.push(p);
                self.points.len() - 1
            }) as u32
        }

        fn add(&mut self, n: usize, m: usize, at: impl Fn(usize, usize) -> DVec3) {
            for (i, j) in (0..n).flat_map(|i| (0..m).map(move |j| (i, j))) {
                let quad = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)];
                let [a, b, c, d] = quad.map(|(i, j)| self.number(at(i, j)));
                self.faces.extend([[a, b, c], [a, c, d]]);
            }
        }

        fn without(self, centre: DVec3, radius: f64) -> Mesh {
            let inside = |p: DVec3| p.distance(centre) < radius;
            let (points, faces) = shapes::cut_where(&(self.points, self.faces), inside);
            Mesh::from_triangles(points, &faces).expect("manifold")
        }
    }

    /// Two square sides of a cube that meet along the line x = 1, z = 1.
    fn corner_of_cube() -> Sheets {
        let n = 20;
        let step = |i: usize| i as f64 / n as f64;
        let mut sheets = Sheets {
            points: Vec::new(),
            faces: Vec::new(),
        };
        sheets.add(n, n, |i, j| DVec3::new(step(i), step(j), 1.0));
        sheets.add(n, n, |i, j| DVec3::new(1.0, step(j), 1.0 - step(i)));
        sheets
    }

    /// The wall and the flat top of a cylinder of radius 1 that meet along the circle z = 0.
    fn drum() -> Sheets {
        let around = |j: usize, r: f64, z: f64| {
            let (sin, cos) = (std::f64::consts::TAU * (j % 60) as f64 / 60.0).sin_cos();
            DVec3::new(r * cos, r * sin, z)
        };
        let mut sheets = Sheets {
            points: Vec::new(),
            faces: Vec::new(),
        };
        sheets.add(8, 60, |i, j| around(j, 0.2 + 0.1 * i as f64, 0.0));
        sheets.add(10, 60, |i, j| around(j, 1.0, -0.1 * i as f64));
        sheets
    }

    fn filled(mesh: &Mesh, at: DVec3, features: Features) -> Mesh {
        let loops = boundary_loops(mesh);
        let far = |l: &&BoundaryLoop| l.centroid.distance(at);
        let hole = loops.iter().min_by(|a, b| far(a).total_cmp(&far(b)));
        let options = FillOptions {
            features,
            ..FillOptions::default()
        };
        let hole = hole.expect("a hole");
        let filled = fill_rim_sets(mesh, &[vec![hole]], &options, &|_, _| true).expect("filled");
        assert!(filled.failed.is_empty() && filled.groups.iter().all(Result::is_ok));
        assert_eq!(
            filled.holes.len(),
            1 + usize::from(features == Features::Auto)
        );
        check_mesh(&filled.mesh).expect("sound");
        assert_eq!(boundary_loops(&filled.mesh).len(), loops.len() - 1);
        assert_eq!(filled.mesh.positions[..mesh.vertex_count()], mesh.positions);
        filled.mesh
    }

    /// Total length of the sharp edges whose ends satisfy a condition.
    fn sharp_length(mesh: &Mesh, is_on: impl Fn(DVec3) -> bool) -> f64 {
        let ends = |h| [mesh.topology.origin(h), mesh.topology.target(h)].map(|v| mesh.position(v));
        let edges = mesh.topology.edges().filter(|&h| is_sharp(mesh, h));
        let edges = edges.map(ends).filter(|e| e.iter().all(|&p| is_on(p)));
        edges.map(|[a, b]| a.distance(b)).sum()
    }

    #[test]
    fn the_edge_of_a_cube_comes_back() {
        let at = DVec3::new(1.0, 0.5, 1.0);
        let mesh = corner_of_cube().without(at, 0.25);
        let on_edge = |p: DVec3| (p.x - 1.0).abs() < 1e-9 && (p.z - 1.0).abs() < 1e-9;
        let sharp = filled(&mesh, at, Features::Auto);
        let loops = boundary_loops(&mesh);
        let hole = loops.iter().min_by(|a, b| a.edges().cmp(&b.edges()));
        let crease = crease_through(&mesh, hole.expect("a hole"), 1.0).expect("a crease");
        assert!(crease.iter().all(|&p| on_edge(p)), "{crease:?}");
        let new = |p: &&DVec3| !mesh.positions.contains(p);
        let inner = &crease[1..crease.len() - 1];
        assert!(inner.iter().all(|p| new(&p) && sharp.positions.contains(p)));
        assert!(
            mesh.positions.contains(&crease[0])
                && mesh.positions.contains(&crease[crease.len() - 1])
        );
        for p in &sharp.positions {
            assert!((p.x - 1.0).abs().min((p.z - 1.0).abs()) < 1e-9, "{p}");
        }
        assert!((sharp_length(&sharp, on_edge) - 1.0).abs() < 1e-9);
        let smooth = filled(&mesh, at, Features::Off);
        assert!(sharp_length(&smooth, on_edge) < 0.7);
    }

    /// Both parts of a patch with a crease get one chart: its vertices are in the texture once.
    #[cfg(feature = "textures")]
    #[test]
    fn parts_of_a_patch_share_a_chart() {
        use crate::images::Pixels;
        use crate::mesh::{Column, FaceTag, NO_VALUE, OwnMaterial};
        use std::collections::BTreeSet;
        use std::sync::Arc;
        let at = DVec3::new(1.0, 0.5, 1.0);
        let mut mesh = corner_of_cube().without(at, 0.25);
        let column = |name: &str, number: &dyn Fn(&DVec3) -> f64| {
            Column::decimals(name, mesh.positions.iter().map(number).collect())
        };
        let unfolded = column("u", &|p| 0.45 * (p.x + 1.0 - p.z));
        let texture = vec![unfolded, column("v", &|p| 0.9 * p.y)];
        let normals = ["nx", "ny", "nz"].map(|name| column(name, &|_| 0.5));
        let corners: Vec<u32> = mesh.topology.triangles().flatten().collect();
        let pixels = Pixels {
            width: 64,
            height: 64,
            rgba: (0..64 * 64).flat_map(|k| [k as u8, 9, 99, 255]).collect(),
        };
        let all = &mut mesh.attributes;
        all.texture = Arc::new(texture);
        all.normals = Arc::new(normals.to_vec());
        all.faces.texture.clone_from(&corners);
        all.faces.normals = corners;
        all.tags = vec![FaceTag {
            material: "skin".into(),
            ..FaceTag::default()
        }];
        all.faces.tags = vec![0; mesh.topology.face_count()];
        all.own_materials = vec![OwnMaterial {
            name: "skin".into(),
            like: String::new(),
            png: Arc::new(pixels.to_png().expect("written")),
        }];
        let given = [mesh.vertex_count(), mesh.face_count()];
        let filled = filled(&mesh, at, Features::Auto);
        let all = &filled.attributes;
        assert_eq!(all.own_materials.len(), 2);
        let rows = &all.faces.texture[3 * given[1]..];
        let vertices: BTreeSet<u32> = filled
            .topology
            .triangles()
            .skip(given[1])
            .flatten()
            .collect();
        assert_eq!(rows.iter().collect::<BTreeSet<_>>().len(), vertices.len());
        assert!(
            rows.iter()
                .all(|&row| row as usize >= given[0] && row != NO_VALUE)
        );
    }

    #[test]
    fn the_edge_of_a_drum_comes_back() {
        let at = DVec3::new(1.0, 0.0, 0.0);
        let mesh = drum().without(at, 0.45);
        let sharp = filled(&mesh, at, Features::Auto);
        let off = |p: &DVec3| (p.truncate().length() - 1.0).abs().min(p.z.abs());
        let off = sharp.positions.iter().map(off).fold(0.0, f64::max);
        // measured: 0.009, on the wall; 0.106 without the crease
        assert!(off < 0.012, "{off}");
        let on_edge = |p: DVec3| (p.truncate().length() - 1.0).abs() < 2e-3 && p.z.abs() < 1e-3;
        let length = sharp_length(&sharp, on_edge);
        assert!((length - std::f64::consts::TAU).abs() < 0.02, "{length}");
    }

    #[test]
    fn other_holes_are_not_split() {
        let split_first = |mesh: &Mesh| {
            let loops = boundary_loops(mesh);
            let hole = loops
                .iter()
                .min_by(|a, b| a.perimeter.total_cmp(&b.perimeter));
            split(mesh, hole.expect("a hole"), 1.0).is_some()
        };
        let edge = DVec3::new(1.0, 0.5, 1.0);
        assert!(split_first(&corner_of_cube().without(edge, 0.25)));
        // on one side only, away from the edge and with a rim along it
        let away = DVec3::new(0.5, 0.5, 1.0);
        assert!(!split_first(&corner_of_cube().without(away, 0.25)));
        let mut half = corner_of_cube();
        let centre =
            |t: &[u32; 3], p: &[DVec3]| t.iter().map(|&v| p[v as usize]).sum::<DVec3>() / 3.0;
        let points = half.points.clone();
        half.faces.retain(|t| {
            let c = centre(t, &points);
            c.z < 1.0 - 1e-9 || c.distance(edge) > 0.25
        });
        let half = Mesh::from_triangles(half.points, &half.faces).expect("manifold");
        assert!(
            boundary_loops(&half)
                .iter()
                .all(|l| split(&half, l, 1.0).is_none())
        );
        // noise with sharp edges everywhere
        let (mut points, faces) = shapes::cut_where(&shapes::sphere(2000, 7), |p: DVec3| p.z > 0.7);
        let mut random = SplitMix::new(3);
        for p in &mut points {
            *p *= 1.0 + 0.05 * random.unit();
        }
        let noisy = Mesh::from_triangles(points, &faces).expect("manifold");
        assert!(!split_first(&noisy));
    }
}
