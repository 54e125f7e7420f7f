//! Where the vector flow `g2` takes some vertices of a mesh from their own positions, in their
//! metric: one linear system, without a region, elements or a symbolic factorization. For
//! predictions, which solve many small systems on the same part of a mesh.

use crate::linear::Envelope;
use crate::mesh::DVec3;
use crate::solver::diffusion::{MIN_AREA, edge_weight, half_cotangent};

/// Number of rings around the moving vertices that the system depends on.
pub const G2_RINGS: usize = 3;

/// The discrete Laplacian at the inner vertices of a part of a mesh, in the numbers of that part.
#[derive(Debug, Default)]
pub struct Laplacian {
    /// Area at each vertex.
    mass: Vec<f64>,
    /// Start of each vertex in `edges`; one more at the end.
    start: Vec<usize>,
    /// The neighbours of each vertex with the weights of the edges.
    edges: Vec<(u32, f64)>,
}

impl Laplacian {
    /// In the metric of `points`. `neighbours` gives the vertices around a vertex in cyclic order; none
    /// for a vertex on a boundary, and for others at which the Laplacian is not needed.
    pub fn new<'a>(points: &[DVec3], neighbours: impl Fn(usize) -> &'a [u32]) -> Self {
        let mut out = Self::default();
        for (i, point) in points.iter().enumerate() {
            let begin = out.edges.len();
            out.start.push(begin);
            out.edges.extend(neighbours(i).iter().map(|&j| (j, 0.0)));
            let fan = &mut out.edges[begin..];
            let mut mass = 0.0;
            for k in 0..fan.len() {
                let next = if k + 1 < fan.len() { k + 1 } else { 0 };
                let [a, b] = [k, next].map(|k| points[fan[k].0 as usize] - point);
                let double = a.cross(b).length();
                mass += double / 6.0;
                fan[k].1 += half_cotangent(-b, a - b, double);
                fan[next].1 += half_cotangent(-a, b - a, double);
            }
            for edge in fan {
                edge.1 = edge_weight(edge.1);
            }
            out.mass.push(mass);
        }
        out.start.push(out.edges.len());
        let count = out.mass.iter().filter(|mass| **mass > 0.0).count();
        let least = MIN_AREA * out.mass.iter().sum::<f64>() / count as f64;
        out.mass.iter_mut().for_each(|mass| *mass = mass.max(least));
        out
    }

    /// The integral of the curvature vector `2H n` over the cell of a vertex, and the area of the cell.
    pub fn curvature(&self, points: &[DVec3], i: usize) -> (DVec3, f64) {
        let edges = self.edges(i).iter();
        let sum = edges.map(|&(j, w)| w * (points[j as usize] - points[i]));
        (sum.sum(), self.mass[i])
    }

    /// The neighbours of a vertex with the weights of the edges.
    fn edges(&self, i: usize) -> &[(u32, f64)] {
        &self.edges[self.start[i]..self.start[i + 1]]
    }

    /// The Laplacian at the first `rows` of some vertices, in their order. These contain the neighbours of
    /// the rows.
    fn restricted(&self, vertices: &[u32], rows: usize) -> Self {
        let mut number = vec![u32::MAX; self.mass.len()];
        for (&v, i) in vertices.iter().zip(0..) {
            number[v as usize] = i;
        }
        let mut out = Self::default();
        for &v in &vertices[..rows] {
            out.mass.push(self.mass[v as usize]);
            out.start.push(out.edges.len());
            let edges = self.edges(v as usize).iter();
            out.edges
                .extend(edges.map(|&(j, w)| (number[j as usize], w)));
        }
        out.start.push(out.edges.len());
        out
    }
}

/// Derivatives of the curvature vectors at the first vertices by the moving ones: pairs of a moving vertex
/// and a factor.
struct Derivatives {
    /// Start of each vertex in `pairs`; one more at the end.
    start: Vec<usize>,
    pairs: Vec<(usize, f64)>,
    /// The first moving vertex on which each curvature vector depends.
    least: Vec<usize>,
}

impl Derivatives {
    /// At the first `near` vertices, of which the first `moving` move.
    fn new(laplacian: &Laplacian, moving: usize, near: usize) -> Self {
        let mut out = Self {
            start: vec![0],
            pairs: Vec::with_capacity(8 * near),
            least: Vec::with_capacity(near),
        };
        for i in 0..near {
            let edges = laplacian.edges(i).iter();
            let sum: f64 = edges.clone().map(|e| e.1).sum();
            let own = edges.map(|&(j, w)| (j as usize, w)).chain([(i, -sum)]);
            let own = own.filter(|e| e.0 < moving);
            let begin = out.pairs.len();
            let mass = laplacian.mass[i];
            out.pairs.extend(own.map(|(j, w)| (j, w / mass)));
            let least = out.pairs[begin..].iter().map(|e| e.0).min();
            out.least.push(least.unwrap_or(usize::MAX));
            out.start.push(out.pairs.len());
        }
        out
    }

    fn len(&self) -> usize {
        self.least.len()
    }

    /// Those at a vertex; none beyond the first.
    fn of(&self, i: usize) -> &[(usize, f64)] {
        match self.start.get(i + 1) {
            Some(&end) => &self.pairs[self.start[i]..end],
            None => &[],
        }
    }

    /// The first moving vertex on which the curvature vector at a vertex depends.
    fn least(&self, i: usize) -> usize {
        self.least.get(i).copied().unwrap_or(usize::MAX)
    }
}

/// The energy of `g2` in a given metric as a function of some vertices, the moving ones, with `N`
/// tensions.
pub struct LocalG2<const N: usize> {
    /// On the rings before the last, in the order of the rings.
    laplacian: Laplacian,
    /// Derivatives of the curvature vectors at rings 0 and 1 by the moving vertices.
    derivatives: Derivatives,
    tensions: [f64; N],
    envelope: Envelope,
    /// The Cholesky factors of the matrices.
    factors: Vec<[f64; N]>,
}

impl<const N: usize> LocalG2<N> {
    /// For the first of some vertices, which form [`G2_RINGS`] + 1 rings with the given `ends`; the
    /// Laplacian is known on all rings but the last. Vertices that lie near each other should follow each
    /// other, so that the envelope is small. The tensions are those over the squared radius.
    pub fn new(
        laplacian: &Laplacian,
        vertices: &[u32],
        ends: &[usize; G2_RINGS + 1],
        tensions: [f64; N],
    ) -> Self {
        let [moving, near, inner, _] = *ends;
        let laplacian = laplacian.restricted(vertices, inner);
        let derivatives = Derivatives::new(&laplacian, moving, near);
        let of = |i: usize| derivatives.of(i);
        // two vertices have an entry if the curvatures at the ends of an edge depend on them
        let mut first: Vec<usize> = (0..moving).collect();
        for i in 0..near {
            let around = laplacian.edges(i).iter().map(|e| e.0 as usize).chain([i]);
            let least = around.map(|j| derivatives.least(j)).min();
            for &(v, _) in of(i) {
                first[v] = first[v].min(least.unwrap_or(v));
            }
        }
        let envelope = Envelope::new(first);
        let [mut stiffness, mut bending] = [(); 2].map(|()| envelope.zeros());
        // Σ_e w_e (h_i − h_j), derived by the moving vertices, of which it depends on `used`
        let mut differences = vec![0.0; moving];
        let mut used = Vec::new();
        let mut used_by = vec![usize::MAX; moving];
        for i in 0..near {
            let own = of(i);
            let mut add = |entries: &[(usize, f64)], factor: f64| {
                for &(v, d) in entries {
                    if used_by[v] != i {
                        used_by[v] = i;
                        differences[v] = 0.0;
                        used.push(v);
                    }
                    differences[v] += factor * d;
                }
            };
            for &(j, w) in laplacian.edges(i) {
                add(of(j as usize), -w);
            }
            add(own, laplacian.edges(i).iter().map(|e| e.1).sum());
            for &(v, d) in own {
                let entries = used.iter().map(|&u| (u, differences[u]));
                envelope.add_to_row(&mut stiffness, v, d, entries);
                let mass = laplacian.mass[i];
                envelope.add_to_row(&mut bending, v, mass * d, own.iter().copied());
            }
            used.clear();
        }
        let mut factors = vec![[0.0; N]; stiffness.len()];
        for ((sums, a), b) in factors.iter_mut().zip(&stiffness).zip(&bending) {
            for (sum, tension) in sums.iter_mut().zip(tensions) {
                *sum = a + tension * b;
            }
        }
        envelope.factorize(&mut factors);
        Self {
            laplacian,
            derivatives,
            tensions,
            envelope,
            factors,
        }
    }

    /// Displacements of the moving vertices from a shape of all rings to the minimum of the energy: x, y
    /// and z, each by tension. Where the position of a vertex is unknown, the curvature vectors around it
    /// contribute nothing. NaN where the energy has no minimum.
    pub fn steps(&self, shape: &[Option<DVec3>]) -> Vec<[[f64; N]; 3]> {
        let laplacian = &self.laplacian;
        let curvature = |i: usize| {
            let own = shape[i]?;
            let edges = laplacian.edges(i).iter();
            let sum = edges
                .map(|&(j, w)| Some(w * (shape[j as usize]? - own)))
                .sum::<Option<DVec3>>()?;
            Some(sum / laplacian.mass[i])
        };
        let curvatures: Vec<Option<DVec3>> = (0..laplacian.mass.len()).map(curvature).collect();
        let mut steps = vec![[[0.0; N]; 3]; self.envelope.unknowns()];
        for i in 0..self.derivatives.len() {
            let Some(own) = curvatures[i] else { continue };
            // derivatives of ½∫|∇h|² and ½∫|h|² by the curvature vector
            let edges = laplacian.edges(i).iter();
            let stiff = edges.filter_map(|&(j, w)| Some(w * (own - curvatures[j as usize]?)));
            let stiff: [f64; 3] = stiff.sum::<DVec3>().into();
            let bending: [f64; 3] = (laplacian.mass[i] * own).into();
            for axis in 0..3 {
                let force = self
                    .tensions
                    .map(|tension| stiff[axis] + tension * bending[axis]);
                for &(v, d) in self.derivatives.of(i) {
                    for (step, force) in steps[v][axis].iter_mut().zip(force) {
                        *step -= d * force;
                    }
                }
            }
        }
        self.envelope.solve_in_place(&self.factors, &mut steps);
        steps
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Mesh, Neighbourhood, VertexId};
    use crate::shapes;
    use crate::solver::diffusion::DiffusionFlow;
    use crate::solver::{FlowProblem, SUPPORT_RINGS, StepRequest, Stepper, SurfaceModel};

    const TENSIONS: [f64; 3] = [0.0, 3.0, 100.0];

    /// The steps are those of the flow.
    #[test]
    fn steps_agree_with_the_flow() {
        let (mut positions, triangles) = shapes::sphere(600, 2);
        for (i, p) in positions.iter_mut().enumerate() {
            *p *= 1.0 + 0.02 * (1e3 * i as f64).sin();
        }
        let mesh = Mesh::from_triangles(positions, &triangles).expect("a sphere");
        let vertices = mesh.topology.vertices();
        let moving: Vec<VertexId> = vertices.filter(|&v| mesh.position(v).z > 0.9).collect();
        assert!(moving.len() > 20);
        let region = Neighbourhood::without_faces(&mesh.topology, moving.iter().copied(), G2_RINGS);
        let around = |v: VertexId| mesh.topology.neighbours(v).map(|w| w.0).collect();
        let around: Vec<Vec<u32>> = mesh.topology.vertices().map(around).collect();
        let laplacian = Laplacian::new(&mesh.positions, |i| &around[i]);
        let vertices = region.vertices().iter();
        let shape: Vec<Option<DVec3>> = vertices.clone().map(|&v| Some(mesh.position(v))).collect();
        let vertices: Vec<u32> = vertices.map(|v| v.0).collect();
        let counts: Vec<usize> = region.rings().map(<[_]>::len).collect();
        let ends = std::array::from_fn(|k| counts[..=k].iter().sum());
        let interior: Vec<u32> = moving.iter().map(|v| v.0).collect();
        let (radius, tau) = (0.4, 1e9);
        let problem = FlowProblem::new(&mesh.positions, &triangles, &interior, radius);
        let problem = problem.expect("a problem");
        assert!(G2_RINGS < usize::from(SUPPORT_RINGS));
        let local = LocalG2::new(
            &laplacian,
            &vertices,
            &ends,
            TENSIONS.map(|t| t / (radius * radius)),
        );
        let steps = local.steps(&shape);
        for (k, tension) in TENSIONS.into_iter().enumerate() {
            let flow = DiffusionFlow::new(&problem, SurfaceModel::G2, tension);
            let mut flow = flow.expect("a flow");
            let attempt = flow.attempt(&StepRequest {
                tau,
                next_tau: tau,
                may_freeze: false,
            });
            assert!(attempt.is_accepted());
            let mut longest = 0.0f64;
            for (&v, step) in interior.iter().zip(&steps) {
                let v = v as usize;
                let step = DVec3::from_array(step.map(|by_tension| by_tension[k]));
                let expected = flow.state().positions[v] - problem.positions()[v];
                assert!(step.distance(expected) < 1e-9, "{step} {expected}");
                longest = longest.max(step.length());
            }
            assert!(longest > 1e-3);
        }
    }
}
