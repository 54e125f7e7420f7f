//! Shape of the triangles.

use serde::Serialize;

use crate::mesh::{
    DVec3, FOLD_DEGREES, HalfedgeId, Mesh, dihedral_angle, folded_edges, self_intersections,
};

/// Maximum number of intersecting pairs that are counted.
const MAX_INTERSECTIONS: usize = 10_000;
/// Maximum number of reported places.
const PLACES: usize = 100;

/// Quality of the triangles of a mesh.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct QualityReport {
    /// Smallest angle, degrees.
    pub min_angle: f64,
    /// Centre of the triangle that has it.
    pub min_angle_at: [f64; 3],
    /// Mean over the triangles of their smallest angles, degrees.
    pub mean_min_angle: f64,
    /// Largest angle, degrees.
    pub max_angle: f64,
    /// Triangles with an angle below 10°.
    pub slivers: usize,
    /// Triangles without area.
    pub degenerate: usize,
    /// Minimum, mean and maximum over the triangles of twice the inscribed over the circumscribed
    /// radius, 1 for an equilateral one.
    pub radius_ratio: [f64; 3],
    /// Minimum, mean and maximum edge length.
    pub edge_length: [f64; 3],
    /// Maximum angle between the normals of neighbouring triangles in degrees.
    pub max_dihedral: f64,
    /// Number of edges with an angle above 150°.
    pub folded_edges: usize,
    /// Pairs of triangles that meet outside a shared edge or vertex, at most 10,000.
    pub self_intersections: usize,
    /// Centres of the first of these pairs, at most 100.
    pub self_intersections_at: Vec<[f64; 3]>,
    /// Vertices by valence, from 0.
    pub valences: Vec<usize>,
}

/// Measures the triangles of a mesh.
pub fn quality(mesh: &Mesh) -> QualityReport {
    let topology = &mesh.topology;
    let faces: Vec<[DVec3; 3]> = topology.faces().map(|f| mesh.corners(f)).collect();
    let centre = |f: usize| faces[f].iter().sum::<DVec3>() / 3.0;
    let (with_area, angles): (Vec<usize>, Vec<[f64; 3]>) = faces
        .iter()
        .enumerate()
        .filter_map(|(f, corners)| Some((f, angles(corners)?)))
        .unzip();
    let smallest: Vec<f64> = angles
        .iter()
        .map(|a| a.iter().copied().fold(f64::INFINITY, f64::min))
        .collect();
    let worst = (0..smallest.len()).min_by(|&a, &b| smallest[a].total_cmp(&smallest[b]));
    let ratios: Vec<f64> = faces.iter().map(radius_ratio).collect();
    let edges = topology.edges().map(|h| mesh.edge_length(h));
    let mut valences = Vec::new();
    for v in topology.vertices() {
        let valence = topology.valence(v);
        if valences.len() <= valence {
            valences.resize(valence + 1, 0);
        }
        valences[valence] += 1;
    }
    let triangles: Vec<[u32; 3]> = topology.triangles().collect();
    let pairs = self_intersections(&mesh.positions, &triangles, None, MAX_INTERSECTIONS);
    let middle = |p: &[u32; 2]| (0.5 * (centre(p[0] as usize) + centre(p[1] as usize))).to_array();
    let degrees = |x: f64| x.to_degrees();
    QualityReport {
        min_angle: degrees(spread(smallest.iter().copied())[0]),
        min_angle_at: worst.map_or([0.0; 3], |i| centre(with_area[i]).to_array()),
        mean_min_angle: degrees(spread(smallest.iter().copied())[1]),
        max_angle: degrees(spread(angles.iter().flatten().copied())[2]),
        slivers: smallest.iter().filter(|&&a| degrees(a) < 10.0).count(),
        degenerate: faces.len() - angles.len(),
        radius_ratio: spread(ratios.into_iter()),
        edge_length: spread(edges),
        max_dihedral: degrees(max_dihedral(mesh)),
        folded_edges: folded_edges(&mesh.positions, topology, FOLD_DEGREES.to_radians()).len(),
        self_intersections: pairs.len(),
        self_intersections_at: pairs.iter().take(PLACES).map(middle).collect(),
        valences,
    }
}

/// Minimum, mean and maximum; zeros for an empty list.
fn spread(values: impl Iterator<Item = f64>) -> [f64; 3] {
    let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
    let (mut sum, mut count) = (0.0, 0usize);
    for x in values {
        least = least.min(x);
        most = most.max(x);
        sum += x;
        count += 1;
    }
    if count == 0 {
        return [0.0; 3];
    }
    [least, sum / count as f64, most]
}

/// Angles in radians; `None` for a triangle without area.
fn angles(corners: &[DVec3; 3]) -> Option<[f64; 3]> {
    let at = |k: usize| {
        let (u, v) = (
            corners[(k + 1) % 3] - corners[k],
            corners[(k + 2) % 3] - corners[k],
        );
        u.cross(v).length().atan2(u.dot(v))
    };
    let [a, b, c] = *corners;
    ((b - a).cross(c - a).length_squared() > 0.0).then(|| [at(0), at(1), at(2)])
}

fn radius_ratio([a, b, c]: &[DVec3; 3]) -> f64 {
    let (x, y, z) = (a.distance(*b), b.distance(*c), c.distance(*a));
    let doubled = (*b - *a).cross(*c - *a).length();
    // 2 r / R = 16 area² / ((x + y + z) x y z)
    let ratio = 4.0 * doubled * doubled / ((x + y + z) * x * y * z);
    if ratio.is_finite() { ratio } else { 0.0 }
}

fn max_dihedral(mesh: &Mesh) -> f64 {
    let topology = &mesh.topology;
    topology
        .edges()
        .filter(|&h| !topology.is_boundary_edge(h))
        .map(|h| dihedral(mesh, h))
        .fold(0.0, f64::max)
}

/// Angle between the normals of the triangles at an inner edge, radians; 0 where one has no area.
pub(super) fn dihedral(mesh: &Mesh, h: HalfedgeId) -> f64 {
    dihedral_angle(&mesh.positions, &mesh.topology, h)
}
