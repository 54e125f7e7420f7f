//! Where the vector flow `g2` takes some vertices of a mesh from their own positions, in their
//! metric: one linear system, without a region, elements or a symbolic factorization. For
//! predictions, which solve many small systems.

use rustc_hash::FxHashMap;

use crate::linear::{Envelope, LinearError};
use crate::mesh::{DVec3, Mesh, Neighbourhood, VertexId};
use crate::solver::diffusion::{LEAST_AREA, edge_weight, half_cotangent};

/// Number of rings around the moving vertices that the system depends on.
pub const G2_RINGS: usize = 3;

/// The energy of `g2` in the metric of given positions: its matrix for the moving vertices, and its
/// gradients at some shapes.
pub struct LocalG2 {
    envelope: Envelope,
    /// Matrices of `½∫|∇h|²` and `½∫|h|²`.
    matrices: [Vec<f64>; 2],
    /// Gradients of both at each shape.
    gradients: Vec<[Vec<DVec3>; 2]>,
}

/// The discrete Laplacian at some vertices, numbered within a region.
#[derive(Default)]
struct Laplacian {
    /// Area at each vertex.
    mass: Vec<f64>,
    /// Start of each vertex in `edges`; one more at the end.
    start: Vec<usize>,
    /// The neighbours of each vertex with the weights of the edges.
    edges: Vec<(usize, f64)>,
}

impl Laplacian {
    /// At the first `count` vertices of a region, which are inner vertices of the mesh.
    fn new(mesh: &Mesh, region: &[VertexId], count: usize) -> Self {
        let number: FxHashMap<VertexId, usize> = region.iter().copied().zip(0..).collect();
        let points: Vec<DVec3> = region.iter().map(|&v| mesh.position(v)).collect();
        let mut out = Self::default();
        for (i, &v) in region[..count].iter().enumerate() {
            let begin = out.edges.len();
            out.start.push(begin);
            let neighbours = mesh.topology.neighbours(v);
            out.edges.extend(neighbours.map(|w| (number[&w], 0.0)));
            let fan = &mut out.edges[begin..];
            let mut mass = 0.0;
            for k in 0..fan.len() {
                let next = if k + 1 < fan.len() { k + 1 } else { 0 };
                let [a, b] = [k, next].map(|k| points[fan[k].0] - points[i]);
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
        let least = LEAST_AREA * out.mass.iter().sum::<f64>() / count as f64;
        out.mass.iter_mut().for_each(|mass| *mass = mass.max(least));
        out
    }

    /// The neighbours of a vertex with the weights of the edges.
    fn edges(&self, i: usize) -> &[(usize, f64)] {
        &self.edges[self.start[i]..self.start[i + 1]]
    }
}

impl LocalG2 {
    /// For the vertices of ring 0 of a neighbourhood with [`G2_RINGS`] rings; no vertex of the rings
    /// before the last may lie on a boundary. Vertices that lie near each other should follow each
    /// other, so that the envelope is small. `shapes` are positions of the vertices of the neighbourhood;
    /// where one is unknown, its shape contributes nothing to the gradients.
    pub fn new(mesh: &Mesh, region: &Neighbourhood, shapes: &[&[Option<DVec3>]]) -> Self {
        let vertices = region.vertices();
        let count = |rings: usize| region.rings().take(rings).map(<[_]>::len).sum();
        let (moving, near, inner) = (count(1), count(2), count(3));
        let laplacian = Laplacian::new(mesh, vertices, inner);
        // curvature vectors, and for rings 0 and 1 their derivatives by the moving vertices
        let curvature = |x: &[Option<DVec3>], i: usize| {
            let own = x[i]?;
            let edges = laplacian.edges(i).iter();
            let sum = edges
                .map(|&(j, w)| Some(w * (x[j]? - own)))
                .sum::<Option<DVec3>>()?;
            Some(sum / laplacian.mass[i])
        };
        let curvatures = shapes
            .iter()
            .map(|x| (0..inner).map(|i| curvature(x, i)).collect());
        let curvatures: Vec<Vec<Option<DVec3>>> = curvatures.collect();
        let (mut start, mut derivatives) = (vec![0], Vec::new());
        for i in 0..near {
            let edges = laplacian.edges(i);
            let sum: f64 = edges.iter().map(|e| e.1).sum();
            let own = edges.iter().copied().chain([(i, -sum)]);
            let own = own.filter(|e| e.0 < moving);
            derivatives.extend(own.map(|(j, w)| (j, w / laplacian.mass[i])));
            start.push(derivatives.len());
        }
        let derivatives = |i: usize| match start.get(i + 1) {
            Some(&end) => &derivatives[start[i]..end],
            None => &[],
        };
        // two vertices have an entry if the curvatures at the ends of an edge depend on them
        let mut first: Vec<usize> = (0..moving).collect();
        for i in 0..near {
            let around = laplacian.edges(i).iter().map(|e| e.0).chain([i]);
            let least = around.flat_map(derivatives).map(|e| e.0).min();
            for &(v, _) in derivatives(i) {
                first[v] = first[v].min(least.unwrap_or(v));
            }
        }
        let envelope = Envelope::new(first);
        let mut matrices = [(); 2].map(|()| envelope.zeros());
        let zero = || vec![DVec3::ZERO; moving];
        let mut gradients: Vec<[Vec<DVec3>; 2]> = shapes.iter().map(|_| [zero(), zero()]).collect();
        // Σ_e w_e (h_i − h_j), derived by the moving vertices, of which it depends on `used`
        let mut stiffness = vec![0.0; moving];
        let mut used = Vec::new();
        let mut used_by = vec![usize::MAX; moving];
        for i in 0..near {
            let mut add = |entries: &[(usize, f64)], factor: f64| {
                for &(v, d) in entries {
                    if used_by[v] != i {
                        used_by[v] = i;
                        stiffness[v] = 0.0;
                        used.push(v);
                    }
                    stiffness[v] += factor * d;
                }
            };
            for &(j, w) in laplacian.edges(i) {
                add(derivatives(j), -w);
            }
            let own = derivatives(i);
            add(own, laplacian.edges(i).iter().map(|e| e.1).sum());
            let mass = laplacian.mass[i];
            for &(v, d) in own {
                let entries = used.iter().map(|&u| (u, stiffness[u]));
                envelope.add_to_row(&mut matrices[0], v, d, entries);
                envelope.add_to_row(&mut matrices[1], v, mass * d, own.iter().copied());
            }
            for (h, [stiff, bending]) in curvatures.iter().zip(&mut gradients) {
                let Some(hi) = h[i] else { continue };
                let edges = laplacian.edges(i).iter();
                let force: DVec3 = edges.filter_map(|&(j, w)| Some(w * (hi - h[j]?))).sum();
                for &(v, d) in own {
                    stiff[v] += d * force;
                    bending[v] += mass * d * hi;
                }
            }
            used.clear();
        }
        Self {
            envelope,
            matrices,
            gradients,
        }
    }

    /// Displacements of the moving vertices from each shape to the minimum of the energy, with the
    /// tension over the squared radius.
    ///
    /// # Errors
    /// [`LinearError::NotPositiveDefinite`].
    pub fn steps(&self, tension: f64) -> Result<Vec<Vec<DVec3>>, LinearError> {
        let [stiffness, bending] = &self.matrices;
        let pairs = stiffness.iter().zip(bending);
        let mut matrix: Vec<f64> = pairs.map(|(a, b)| a + tension * b).collect();
        self.envelope.factorize(&mut matrix)?;
        let step = |[a, b]: &[Vec<DVec3>; 2]| {
            let pairs = a.iter().zip(b);
            let mut shift: Vec<DVec3> = pairs.map(|(a, b)| -(*a + tension * *b)).collect();
            self.envelope.solve_in_place(&matrix, &mut shift);
            shift
        };
        Ok(self.gradients.iter().map(step).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes;
    use crate::solver::diffusion::DiffusionFlow;
    use crate::solver::{FlowProblem, SUPPORT_RINGS, StepRequest, Stepper, SurfaceModel};

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
        let shape = region.vertices().iter().map(|&v| Some(mesh.position(v)));
        let shape: Vec<Option<DVec3>> = shape.collect();
        let local = LocalG2::new(&mesh, &region, &[&shape]);
        let interior: Vec<u32> = moving.iter().map(|v| v.0).collect();
        let (radius, tau) = (0.4, 1e9);
        let problem = FlowProblem::new(&mesh.positions, &triangles, &interior, radius);
        let problem = problem.expect("a problem");
        assert!(G2_RINGS < usize::from(SUPPORT_RINGS));
        for tension in [0.0, 3.0, 100.0] {
            let flow = DiffusionFlow::new(&problem, SurfaceModel::G2, tension);
            let mut flow = flow.expect("a flow");
            let attempt = flow.attempt(&StepRequest {
                tau,
                next_tau: tau,
                may_freeze: false,
            });
            assert!(attempt.is_accepted());
            let steps = local.steps(tension / (radius * radius)).expect("a step");
            let mut longest = 0.0f64;
            for (&v, step) in interior.iter().zip(&steps[0]) {
                let v = v as usize;
                let expected = flow.state().positions[v] - problem.positions()[v];
                assert!(step.distance(expected) < 1e-9, "{step} {expected}");
                longest = longest.max(step.length());
            }
            assert!(longest > 1e-3);
        }
    }
}
