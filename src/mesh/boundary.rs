//! Boundary loops, their measures, and their classification as outer boundaries or holes.

use super::outer_boundary::classify_loops;
use super::{
    Components, DVec3, HalfedgeId, LoopId, Mesh, VertexId, Weld, components, perimeter,
    rms_distance,
};

/// A closed chain of boundary edges.
#[derive(Clone, Debug, PartialEq)]
pub struct BoundaryLoop {
    /// The identity of the loop.
    pub id: LoopId,
    /// The boundary half-edges, in the direction in which a patch traverses the rim.
    pub halfedges: Vec<HalfedgeId>,
    /// The start vertex of each half-edge. The lowest vertex comes first.
    pub vertices: Vec<VertexId>,
    /// Sum of the edge lengths.
    pub perimeter: f64,
    /// Diameter: maximum distance between two vertices of the loop.
    pub diameter: f64,
    /// Mean of the vertices.
    pub centroid: DVec3,
    /// Root of the mean squared distance of the vertices from `centroid`.
    pub radius: f64,
    /// The component (see [`components`]) the loop belongs to.
    pub component: u32,
    /// Whether the loop is classified as an outer boundary of an open surface or as a single point,
    /// not as a hole.
    pub is_outer_boundary: bool,
    /// The reason of the classification, in words.
    pub reason: String,
}

impl BoundaryLoop {
    /// Number of edges, which is the number of vertices.
    pub fn edges(&self) -> usize {
        self.halfedges.len()
    }

    /// Why it is an outer boundary, in words.
    pub fn why_outer(&self) -> String {
        format!("classified as an outer boundary: {}", self.reason)
    }

    /// The two ends of each edge, in the loop's direction.
    pub fn edge_ends(&self) -> impl Iterator<Item = [VertexId; 2]> + '_ {
        let following = self.vertices.iter().cycle().skip(1);
        self.vertices.iter().zip(following).map(|(&a, &b)| [a, b])
    }
}

/// All boundary loops of a mesh, in the order of their lowest vertices.
pub fn boundary_loops(mesh: &Mesh) -> Vec<BoundaryLoop> {
    let parts = components(&mesh.topology);
    let mut loops: Vec<BoundaryLoop> = mesh
        .topology
        .boundary_loops()
        .into_iter()
        .enumerate()
        .map(|(i, halfedges)| measure(mesh, &parts, i.into(), halfedges))
        .collect();
    classify_loops(mesh, &parts, &mut loops);
    classify_points(mesh, &mut loops);
    loops
}

/// Loops whose vertices lie at one place, but for the rounding of the file's numbers, are no holes.
fn classify_points(mesh: &Mesh, loops: &mut [BoundaryLoop]) {
    let Some(least) = loops.iter().map(|l| l.diameter).reduce(f64::min) else {
        return;
    };
    let tolerance = Weld::Auto.tolerance(&mesh.positions, false);
    if least > tolerance {
        return;
    }
    for one in loops.iter_mut().filter(|l| l.diameter <= tolerance) {
        one.is_outer_boundary = true;
        one.reason = "no hole: its vertices lie at one place".into();
    }
}

fn measure(
    mesh: &Mesh,
    parts: &Components,
    id: LoopId,
    halfedges: Vec<HalfedgeId>,
) -> BoundaryLoop {
    let topology = &mesh.topology;
    let vertices: Vec<_> = halfedges.iter().map(|&h| topology.origin(h)).collect();
    let points: Vec<_> = vertices.iter().map(|&v| mesh.position(v)).collect();
    let origin = points[0];
    let centroid = origin + points.iter().map(|&p| p - origin).sum::<DVec3>() / points.len() as f64;
    BoundaryLoop {
        id,
        perimeter: perimeter(&points),
        diameter: diameter(&points, centroid),
        centroid,
        radius: rms_distance(points.iter().copied(), centroid),
        component: parts.of_face[topology.face(halfedges[0].twin()).index()],
        is_outer_boundary: false,
        reason: String::new(),
        halfedges,
        vertices,
    }
}

/// Maximum distance between two of the points.
///
/// Points are sorted by decreasing distance from the centre, so that these distances exclude most
/// pairs. For more than 20 000 points the search stops at the best pair of two sweeps.
fn diameter(points: &[DVec3], centre: DVec3) -> f64 {
    let farthest = |from: DVec3| {
        points.iter().fold((0.0, from), |best, &p| {
            let d = p.distance(from);
            if d > best.0 { (d, p) } else { best }
        })
    };
    let (_, a) = farthest(centre);
    let (_, b) = farthest(a);
    let (mut best, _) = farthest(b);
    if points.len() > 20_000 {
        return best;
    }
    let mut order: Vec<(f64, DVec3)> = points.iter().map(|&p| (p.distance(centre), p)).collect();
    order.sort_by(|x, y| y.0.total_cmp(&x.0));
    for (i, &(d, p)) in order.iter().enumerate() {
        if 2.0 * d <= best {
            break;
        }
        for &(e, q) in &order[i + 1..] {
            if d + e <= best {
                break;
            }
            best = best.max(p.distance(q));
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    use crate::random::SplitMix;

    #[test]
    fn measures_of_a_square_hole() {
        // a frame of eight triangles around the unit square
        let outside = [[-1., -1.], [2., -1.], [2., 2.], [-1., 2.]];
        let inside = [[0., 0.], [1., 0.], [1., 1.], [0., 1.]];
        let positions = outside
            .iter()
            .chain(&inside)
            .map(|&[x, y]| DVec3::new(x, y, 7.0))
            .collect();
        let triangles: Vec<[u32; 3]> = (0..4)
            .flat_map(|i| {
                let j = (i + 1) % 4;
                [[i, j, j + 4], [i, j + 4, i + 4]]
            })
            .collect();
        let loops = boundary_loops(&Mesh::from_triangles(positions, &triangles).expect("a ring"));
        assert_eq!(
            loops.iter().map(|l| l.id.index()).collect::<Vec<_>>(),
            [0, 1]
        );
        let hole = &loops[1];
        assert_eq!(
            hole.vertices.iter().map(|v| v.0).collect::<Vec<_>>(),
            [4, 5, 6, 7]
        );
        assert_eq!((hole.perimeter, hole.component), (4.0, 0));
        assert_eq!(hole.centroid, DVec3::new(0.5, 0.5, 7.0));
        assert!((hole.diameter - 2f64.sqrt()).abs() < 1e-15);
        assert!((hole.radius - 0.5f64.sqrt()).abs() < 1e-15);
        assert_eq!(
            (loops[0].is_outer_boundary, hole.is_outer_boundary),
            (true, false)
        );
    }

    #[test]
    fn diameter_agrees_with_all_pairs() {
        let mut random = SplitMix::new(11);
        for n in [3, 10, 200] {
            let points: Vec<DVec3> = (0..n)
                .map(|_| random.direction() * random.range(0.9, 1.0) + DVec3::splat(1e3))
                .collect();
            let centre = points.iter().sum::<DVec3>() / f64::from(n);
            let mut best = 0.0f64;
            for p in &points {
                best = points.iter().fold(best, |best, q| best.max(p.distance(*q)));
            }
            assert_eq!(diameter(&points, centre), best);
        }
    }
}
