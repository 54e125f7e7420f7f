//! Continuity across chains of edges: positions, normals, curvatures from both sides.

use serde::Serialize;

use crate::analysis::chains::EdgeChain;
use crate::analysis::local::with_rings;
use crate::mesh::{DVec3, FaceId, HalfedgeId, Mesh, Topology, dihedral_angle};
use crate::subdivision::{Rule, elements, elements_at};
use crate::surface::{PointGeometry, each_point, mean_curvature};

/// Measured points of each edge, as fractions of its length. The ends are left out: a limit
/// surface may have no curvature there.
const PLACES: [f64; 3] = [1.0 / 6.0, 0.5, 5.0 / 6.0];

/// Minimum, mean and maximum of a quantity along a chain.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Statistic {
    /// Minimum.
    pub min: f64,
    /// Average over the measured places, weighted by edge length.
    pub mean: f64,
    /// Maximum.
    pub max: f64,
    /// The point of the maximum.
    pub max_at: [f64; 3],
}

/// Continuity of the surface across a chain of edges.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ChainReport {
    /// Name of the chain.
    pub name: String,
    /// Its edges with a triangle on both sides.
    pub edges: usize,
    /// Sum of their lengths.
    pub length: f64,
    /// Whether the two sides were measured as separate surfaces.
    pub is_crease: bool,
    /// Whether the limit surface is continuous in position and normal by construction: always,
    /// unless it is a crease.
    pub smooth_by_construction: bool,
    /// Distance between the two sides' points (G0).
    pub gap: Statistic,
    /// Angle between the two sides' normals, degrees (G1).
    pub normal_angle: Statistic,
    /// Angle between the normals of the two triangles, degrees.
    pub dihedral: Statistic,
    /// Difference of the two sides' mean curvatures at the edge (G2), relative to nothing, in units
    /// of 1 / length. A Loop surface has none away from irregular vertices.
    pub curvature_jump: Statistic,
    /// Difference of the mean curvatures averaged over the two faces: the visible change of
    /// curvature across one row of triangles.
    pub curvature_step: Statistic,
}

/// The measures of one edge.
struct Edge {
    length: f64,
    middle: DVec3,
    gap: f64,
    angle: f64,
    dihedral: f64,
    jump: f64,
    step: f64,
}

/// Measures the surface of `control` points across a chain of edges of the mesh.
pub fn measure_chain(mesh: &Mesh, control: &[DVec3], chain: &EdgeChain) -> ChainReport {
    let topology = &mesh.topology;
    let inner = |h: &HalfedgeId| !topology.is_boundary_edge(*h);
    let edges: Vec<HalfedgeId> = chain.edges.iter().copied().filter(inner).collect();
    let measured = measure(topology, &mesh.positions, control, &edges, chain.is_crease);
    let of = |value: fn(&Edge) -> f64| statistic(&measured, value);
    ChainReport {
        name: chain.name.clone(),
        edges: edges.len(),
        length: measured.iter().map(|e| e.length).sum(),
        is_crease: chain.is_crease,
        smooth_by_construction: !chain.is_crease,
        gap: of(|e| e.gap),
        normal_angle: of(|e| e.angle.to_degrees()),
        dihedral: of(|e| e.dihedral.to_degrees()),
        curvature_jump: of(|e| e.jump),
        curvature_step: of(|e| e.step),
    }
}

/// The worst of a rim, by the definitions of [`ChainReport`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WorstJumps {
    /// Maximum [`ChainReport::normal_angle`] in degrees.
    pub normal_angle: f64,
    /// Maximum [`ChainReport::curvature_step`].
    pub curvature_step: f64,
}

/// The worst places along inner edges of the surface of `control` points; `is_crease` as in
/// [`EdgeChain`]. `None` without edges at which the measures are finite.
pub fn worst_jumps(
    topology: &Topology,
    control: &[DVec3],
    edges: &[HalfedgeId],
    is_crease: bool,
) -> Option<WorstJumps> {
    if edges.is_empty() {
        return None;
    }
    let measured = measure(topology, control, control, edges, is_crease);
    let worst = |of: fn(&Edge) -> f64| statistic(&measured, of).max;
    let normal_angle = worst(|e| e.angle.to_degrees());
    let curvature_step = worst(|e| e.step);
    let is_finite = normal_angle.is_finite() && curvature_step.is_finite();
    (!measured.is_empty() && is_finite).then_some(WorstJumps {
        normal_angle,
        curvature_step,
    })
}

fn statistic(edges: &[Edge], value: fn(&Edge) -> f64) -> Statistic {
    let mut out = Statistic {
        min: f64::INFINITY,
        mean: 0.0,
        max: f64::NEG_INFINITY,
        max_at: [0.0; 3],
    };
    let mut length = 0.0;
    for edge in edges {
        let x = value(edge);
        out.min = out.min.min(x);
        if x > out.max {
            (out.max, out.max_at) = (x, edge.middle.to_array());
        }
        out.mean += edge.length * x;
        length += edge.length;
    }
    if length > 0.0 {
        out.mean /= length;
    } else {
        (out.min, out.max) = (0.0, 0.0);
    }
    out
}

/// The edges, on the surface cut open along them if they are creases.
fn measure(
    topology: &Topology,
    positions: &[DVec3],
    control: &[DVec3],
    edges: &[HalfedgeId],
    is_crease: bool,
) -> Vec<Edge> {
    let cuts: &[HalfedgeId] = if is_crease { edges } else { &[] };
    let Some(sides) = Sides::new(topology, control, edges, cuts) else {
        return Vec::new();
    };
    edges
        .iter()
        .map(|&h| {
            let [a, b] = [topology.origin(h), topology.target(h)].map(|v| positions[v.index()]);
            let (own, other) = (sides.at(topology, h), sides.at(topology, h.twin()));
            let (mut gap, mut angle, mut jump) = (0.0f64, 0.0f64, 0.0f64);
            for (k, p) in own.points.iter().enumerate() {
                // the other side runs through the edge backwards
                let q = &other.points[PLACES.len() - 1 - k];
                gap = gap.max(p.at.distance(q.at));
                let (m, n) = (p.normal, q.normal);
                angle = angle.max(m.cross(n).length().atan2(m.dot(n)));
                jump = jump.max((p.mean - q.mean).abs());
            }
            Edge {
                length: a.distance(b),
                middle: own.points[1].at,
                gap,
                angle,
                dihedral: dihedral_angle(positions, topology, h),
                jump,
                step: (own.average - other.average).abs(),
            }
        })
        .collect()
}

#[derive(Clone, Copy)]
struct Point {
    at: DVec3,
    normal: DVec3,
    mean: f64,
}

/// A side of an edge: its points in the direction of the half-edge.
struct Side {
    points: Vec<Point>,
    average: f64,
}

/// The surface at the edges of the faces next to a chain.
struct Sides {
    /// Faces in ascending order.
    faces: Vec<FaceId>,
    /// For each of `faces` its points on the three sides, and its mean curvature.
    points: Vec<Vec<Point>>,
    average: Vec<f64>,
}

impl Sides {
    fn new(
        topology: &Topology,
        control: &[DVec3],
        edges: &[HalfedgeId],
        cuts: &[HalfedgeId],
    ) -> Option<Self> {
        let both = edges.iter().flat_map(|h| [*h, h.twin()]);
        let mut faces: Vec<FaceId> = both.map(|h| topology.face(h)).collect();
        faces.sort_unstable();
        faces.dedup();
        let local = with_rings(topology, &faces, cuts)?;
        let control = local.gather(control);
        let ids: Vec<FaceId> = faces.iter().filter_map(|&f| local.face(f)).collect();
        // (v, w) along the sides from corner 0 to 1, 1 to 2, 2 to 0
        let on_sides = [0, 1, 2].map(|side| {
            PLACES.map(|t| {
                let mut bary = [0.0; 3];
                bary[side] = 1.0 - t;
                bary[(side + 1) % 3] = t;
                [bary[1], bary[2]]
            })
        });
        let topology = &local.topology;
        let sampled = elements_at(topology, &ids, on_sides.as_flattened());
        let inside = elements(topology, &ids, Rule::Twelve);
        let mut out = Self {
            points: vec![Vec::new(); faces.len()],
            average: vec![0.0; faces.len()],
            faces,
        };
        for e in 0..sampled.len() {
            let place = out.place(local.faces[sampled.faces()[e] as usize]);
            let mut points = Vec::with_capacity(9);
            each_point(&sampled, e, &control, |at, p: &PointGeometry| {
                points.push(Point {
                    at,
                    normal: p.normal,
                    mean: p.mean,
                });
            });
            out.points[place] = points;
        }
        for e in 0..inside.len() {
            let place = out.place(local.faces[inside.faces()[e] as usize]);
            out.average[place] = mean_curvature(&inside, e, &control);
        }
        Some(out)
    }

    fn place(&self, f: FaceId) -> usize {
        self.faces.partition_point(|&g| g < f)
    }

    fn at(&self, topology: &Topology, h: HalfedgeId) -> Side {
        let f = topology.face(h);
        let corners = topology.face_vertices(f);
        let origin = topology.origin(h);
        let side = corners.iter().position(|&v| v == origin).unwrap_or(0);
        let place = self.place(f);
        let first = side * PLACES.len();
        Side {
            points: self.points[place][first..first + PLACES.len()].to_vec(),
            average: self.average[place],
        }
    }
}
