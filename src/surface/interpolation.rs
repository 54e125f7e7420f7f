//! Interpolation constraints: the interpolating basis (formulation, section 7).
//!
//! `A` is the limit mask, `f` are the constrained and `c` the free vertices. The control points of
//! the constrained vertices follow the free ones, `x_f = A_ff⁻¹ (p_f − A_fc x_c)`, so that the
//! limit surface always interpolates the given points. Free vertices then have the basis
//! `φ̃ = Qᵀφ`, `Q = [−A_ff⁻¹A_fc; I]`. If no two constrained vertices are adjacent, as after a 1→4
//! split, `A_ff` is diagonal. Otherwise it is solved by Gauss-Seidel sweeps. They converge because
//! `A_ff` is diagonally dominant or, by a scaling of its rows, symmetric positive definite.

use crate::mesh::{DVec3, Topology, VertexId};
use crate::subdivision::limit_stencil;

/// Maximum number of sweeps.
const MAX_SWEEPS: usize = 400;

/// Points that the limit surface interpolates.
#[derive(Clone, Debug)]
pub struct Interpolation {
    /// The vertices whose limit positions are given.
    held: Vec<u32>,
    /// Their target points.
    target: Vec<DVec3>,
    /// `A_ff`'s diagonal.
    diagonal: Vec<f64>,
    /// Start of each row in `entries`, and the rows: vertex and weight, without the diagonal.
    start: Vec<u32>,
    entries: Vec<(u32, f64)>,
    /// Place of each vertex among the constrained ones, `NONE` for the free ones.
    place: Vec<u32>,
    /// Whether no two constrained vertices are adjacent.
    is_diagonal: bool,
}

const NONE: u32 = u32::MAX;

impl Interpolation {
    /// Constrains the limit surface over `topology` to interpolate a point at each vertex of
    /// `held`.
    ///
    /// # Panics
    /// If a vertex occurs twice or does not exist.
    pub fn new(topology: &Topology, held: &[(u32, DVec3)]) -> Self {
        let mut place = vec![NONE; topology.vertex_count()];
        for (i, &(v, _)) in held.iter().enumerate() {
            assert_eq!(place[v as usize], NONE, "constrained vertices are distinct");
            place[v as usize] = i as u32;
        }
        let mut out = Self {
            held: held.iter().map(|h| h.0).collect(),
            target: held.iter().map(|h| h.1).collect(),
            diagonal: Vec::with_capacity(held.len()),
            start: vec![0],
            entries: Vec::with_capacity(7 * held.len()),
            place,
            is_diagonal: true,
        };
        let mut stencil = Vec::new();
        for &(v, _) in held {
            stencil.clear();
            limit_stencil(topology, VertexId(v), &mut stencil);
            let own = stencil.iter().filter(|s| s.0 == v).map(|s| s.1).sum();
            out.diagonal.push(own);
            for &(w, weight) in stencil.iter().filter(|s| s.0 != v) {
                let begin = out.start[out.start.len() - 1] as usize;
                match out.entries[begin..].iter_mut().find(|e| e.0 == w) {
                    Some(entry) => entry.1 += weight,
                    None => out.entries.push((w, weight)),
                }
                out.is_diagonal &= out.place[w as usize] == NONE;
            }
            out.start.push(out.entries.len() as u32);
        }
        out
    }

    /// The constrained vertices.
    pub fn constrained(&self) -> &[u32] {
        &self.held
    }

    /// The target points, one for each constrained vertex.
    pub fn targets(&self) -> &[DVec3] {
        &self.target
    }

    /// The same vertices with other points, in the same order.
    ///
    /// # Panics
    /// If the number of points differs from the number of constrained vertices.
    #[must_use]
    pub fn with_targets(&self, targets: Vec<DVec3>) -> Self {
        assert_eq!(targets.len(), self.held.len(), "one point for each");
        Self {
            target: targets,
            ..self.clone()
        }
    }

    /// Weight of the `i`-th constrained vertex in its own limit position, and those of its neighbours.
    pub fn row(&self, i: usize) -> (f64, &[(u32, f64)]) {
        let range = self.start[i] as usize..self.start[i + 1] as usize;
        (self.diagonal[i], &self.entries[range])
    }

    /// Moves the constrained control points so that the limit surface interpolates the targets:
    /// `x_f = A_ff⁻¹ (p_f − A_fc x_c)`.
    pub fn enforce(&self, positions: &mut [DVec3]) {
        self.enforce_at(&self.target, positions);
    }

    /// The same for other targets, one for each constrained vertex.
    pub fn enforce_at(&self, targets: &[DVec3], positions: &mut [DVec3]) {
        let mut largest = 0.0f64;
        for sweep in 0..MAX_SWEEPS {
            let mut change = 0.0f64;
            for (i, &v) in self.held.iter().enumerate() {
                let (own, row) = self.row(i);
                let p = targets[i];
                // differences to the target avoid cancellation far from the origin
                let pull: DVec3 = row
                    .iter()
                    .map(|&(w, weight)| weight * (positions[w as usize] - p))
                    .sum();
                let new = p - pull / own;
                change = change.max(new.distance(positions[v as usize]));
                positions[v as usize] = new;
                largest = largest.max(pull.length());
            }
            if self.is_diagonal || (sweep > 0 && change <= 1e-16 * largest) {
                return;
            }
        }
    }

    /// Largest distance between the limit surface and its targets.
    pub fn error(&self, positions: &[DVec3]) -> f64 {
        let distance = |(i, &v): (usize, &u32)| {
            let (own, row) = self.row(i);
            let p = self.target[i];
            let at = |v: u32, weight: f64| weight * (positions[v as usize] - p);
            let rest: DVec3 = row.iter().map(|&(w, weight)| at(w, weight)).sum();
            (at(v, own) + rest).length()
        };
        self.held
            .iter()
            .enumerate()
            .map(distance)
            .fold(0.0, f64::max)
    }

    /// Converts derivatives by all control points to those by the free ones, which the constrained
    /// ones follow: `g_c ← g_c − A_fcᵀ A_ff⁻ᵀ g_f`, `g_f ← 0`. `gradient` has one entry for each
    /// vertex that `unknown` numbers below its length; it contains no derivatives by other
    /// vertices.
    pub fn pull_back(&self, unknown: &[u32], gradient: &mut [DVec3]) {
        let n = gradient.len();
        let of = |v: u32| unknown[v as usize] as usize;
        // y = A_ff⁻ᵀ g_f by the same sweeps: the remainder of g_f is propagated by columns
        let mut total = vec![DVec3::ZERO; self.held.len()];
        let scale = gradient.iter().fold(0.0f64, |m, g| m.max(g.length()));
        for _ in 0..MAX_SWEEPS {
            let mut change = 0.0f64;
            for (i, &v) in self.held.iter().enumerate() {
                let rest = std::mem::take(&mut gradient[of(v)]);
                if rest == DVec3::ZERO {
                    continue;
                }
                let (own, row) = self.row(i);
                let y = rest / own;
                total[i] += y;
                change = change.max(rest.length());
                for &(w, weight) in row {
                    if self.place[w as usize] != NONE {
                        gradient[of(w)] -= weight * y;
                    }
                }
            }
            if self.is_diagonal || change <= 1e-17 * scale {
                break;
            }
        }
        for (i, &v) in self.held.iter().enumerate() {
            gradient[of(v)] = DVec3::ZERO;
            for &(w, weight) in self.row(i).1 {
                let k = of(w);
                if self.place[w as usize] == NONE && k < n {
                    gradient[k] -= weight * total[i];
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::split_all;
    use crate::random::SplitMix;
    use crate::shapes::{graph, icosphere};
    use crate::subdivision::limit_position;

    /// A mesh split once with its old vertices constrained; with `all`, every vertex of the first
    /// mesh.
    fn cases() -> Vec<(Topology, Vec<DVec3>, Vec<u32>)> {
        let ball = icosphere(2);
        let sheet = graph(2.0, 4, |x, y| x * y, 3);
        let mut out = Vec::new();
        for (positions, triangles) in [ball, sheet] {
            let old = Topology::from_triangles(positions.len(), &triangles).expect("manifold");
            let split = split_all(&old);
            let mut all = positions.clone();
            for &h in &split.edges {
                let (a, b) = (old.origin(h), old.target(h));
                all.push(0.5 * (positions[a.index()] + positions[b.index()]));
            }
            let new = Topology::from_triangles(all.len(), &split.triangles).expect("manifold");
            out.push((new, all, (0..positions.len() as u32).collect()));
            out.push((
                old,
                positions.clone(),
                (0..positions.len() as u32).collect(),
            ));
        }
        out
    }

    #[test]
    fn the_limit_surface_passes_the_targets() {
        for (topology, mut positions, held) in cases() {
            let offset = DVec3::new(3.0, -1.0, 2.0);
            let targets: Vec<(u32, DVec3)> = held
                .iter()
                .map(|&v| (v, positions[v as usize] + offset))
                .collect();
            let map = Interpolation::new(&topology, &targets);
            for p in &mut positions {
                *p += offset;
            }
            map.enforce(&mut positions);
            assert!(map.error(&positions) < 4e-15, "{}", map.error(&positions));
            for (v, p) in targets {
                let q = limit_position(&topology, &positions, VertexId(v));
                assert!(q.distance(p) < 8e-15);
            }
        }
    }

    /// `<Qᵀg, y> = <g, Qy>`.
    #[test]
    fn pulling_back_is_the_transpose() {
        for (topology, mut positions, held) in cases() {
            let n = positions.len();
            let map = Interpolation::new(
                &topology,
                &held
                    .iter()
                    .map(|&v| (v, positions[v as usize]))
                    .collect::<Vec<_>>(),
            );
            map.enforce(&mut positions);
            let mut random = SplitMix::new(5);
            let step: Vec<DVec3> = (0..n as u32)
                .map(|v| {
                    if held.contains(&v) {
                        DVec3::ZERO
                    } else {
                        random.direction()
                    }
                })
                .collect();
            let mut moved: Vec<DVec3> = positions.iter().zip(&step).map(|(p, s)| *p + *s).collect();
            map.enforce(&mut moved);
            let gradient: Vec<DVec3> = (0..n).map(|_| random.direction()).collect();
            let direct: f64 = (0..n)
                .map(|v| gradient[v].dot(moved[v] - positions[v]))
                .sum();
            let identity: Vec<u32> = (0..n as u32).collect();
            let mut pulled = gradient.clone();
            map.pull_back(&identity, &mut pulled);
            let reduced: f64 = pulled.iter().zip(&step).map(|(g, s)| g.dot(*s)).sum();
            assert!(
                (direct - reduced).abs() < 1e-12 * n as f64,
                "{direct} {reduced}"
            );
            assert!(held.iter().all(|&v| pulled[v as usize] == DVec3::ZERO));
        }
    }
}
