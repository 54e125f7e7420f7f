//! The first position of new vertices.

use std::sync::Arc;

use crate::linear::{Cholesky, CholeskySymbolic, LinearError, SymmetricPattern, nested_dissection};
use crate::mesh::{DVec3, Split, Topology, VertexId};
use crate::solver::Interpolation;

/// Old positions, and new vertices on their edges, nearer to the end with the shorter edges.
///
/// Old vertices are to lie on the limit surface, so their control points step aside from the
/// middle of their new neighbours. Midpoints of edges of unequal lengths have that middle far off
/// along the surface, and the control point, going the other way, folds it. With edges divided in
/// the ratio of the shortest edges at their ends the new neighbours of a vertex are at like
/// distances.
pub fn graded_points(topology: &Topology, positions: &[DVec3], split: &Split) -> Vec<DVec3> {
    let shortest: Vec<f64> = (0..positions.len())
        .map(|v| {
            topology
                .neighbours(VertexId::from(v))
                .map(|w| positions[w.index()].distance(positions[v]))
                .fold(f64::INFINITY, f64::min)
        })
        .collect();
    let mut points = positions.to_vec();
    for &h in &split.edges {
        let (a, b) = (topology.origin(h).index(), topology.target(h).index());
        let sum = shortest[a] + shortest[b];
        let part = if sum > 0.0 { shortest[a] / sum } else { 0.5 };
        points.push(positions[a].lerp(positions[b], part));
    }
    points
}

/// New vertices where the graph bi-Laplacian is least: the minimum of `Σ |(L x)_i|²` over all control
/// points, `(L x)_i` the difference of a vertex to the mean of its neighbours, among those whose limit
/// surface passes the points `held` (formulation, section 7). The condition is kept by a penalty,
/// to a few digits; [`Interpolation::settle`] does the rest.
///
/// # Errors
/// Those of a factorization; nothing is held, or the mesh is beyond its reach.
pub fn fair_points(
    topology: &Topology,
    positions: &[DVec3],
    interpolation: &Interpolation,
) -> Result<Vec<DVec3>, LinearError> {
    let n = positions.len();
    let origin = positions.first().copied().unwrap_or_default();
    let mut normal = NormalEquations::new(n);
    for v in (0..n).map(VertexId::from) {
        let share = 1.0 / topology.valence(v).max(1) as f64;
        let ring = topology.neighbours(v).map(|w| (w.0, -share));
        let row: Vec<(u32, f64)> = std::iter::once((v.0, 1.0)).chain(ring).collect();
        // a boundary vertex has half a ring, and an isolated one stays
        if !topology.is_boundary_vertex(v) && row.len() > 1 {
            normal.add(&row, 1.0, DVec3::ZERO);
        } else {
            normal.add(&row[..1], 1e-6, positions[v.index()] - origin);
        }
    }
    for (i, &v) in interpolation.held().iter().enumerate() {
        let (own, others) = interpolation.row(i);
        let mut row = vec![(v, own)];
        row.extend_from_slice(others);
        normal.add(&row, HOLD, interpolation.targets()[i] - origin);
    }
    let mut solution = normal.solve(positions)?;
    for p in &mut solution {
        *p += origin;
    }
    Ok(solution)
}

/// Weight of the held points in the bi-Laplacian's minimum.
const HOLD: f64 = 1e6;

/// `Σ weight |row · x − value|²`, to be minimised over one vector per unknown.
struct NormalEquations {
    /// Lower and upper entries, the same pair many times.
    entries: Vec<(u32, u32, f64)>,
    rhs: Vec<DVec3>,
}

impl NormalEquations {
    fn new(n: usize) -> Self {
        Self {
            entries: Vec::with_capacity(60 * n),
            rhs: vec![DVec3::ZERO; n],
        }
    }

    fn add(&mut self, row: &[(u32, f64)], weight: f64, value: DVec3) {
        for &(i, a) in row {
            self.rhs[i as usize] += weight * a * value;
            for &(j, b) in row {
                self.entries.push((i, j, weight * a * b));
            }
        }
    }

    fn solve(mut self, positions: &[DVec3]) -> Result<Vec<DVec3>, LinearError> {
        let n = self.rhs.len();
        // stable, so that equal pairs are summed in the order in which they came
        self.entries.sort_by_key(|&(i, j, _)| (i, j));
        let mut offsets = vec![0u32];
        let (mut columns, mut values) = (Vec::new(), Vec::new());
        let mut rest = self.entries.as_slice();
        for i in 0..n as u32 {
            while let Some(&(_, j, _)) = rest.first().filter(|e| e.0 == i) {
                let same = rest.partition_point(|e| (e.0, e.1) <= (i, j));
                columns.push(j);
                values.push(rest[..same].iter().map(|e| e.2).sum::<f64>());
                rest = &rest[same..];
            }
            offsets.push(columns.len() as u32);
        }
        let perm = nested_dissection(positions, &offsets, &columns);
        let pattern = SymmetricPattern::of_permuted_graph(&offsets, &columns, &perm);
        let mut lower = Vec::with_capacity(pattern.nnz());
        for j in 0..n {
            let row = offsets[perm[j] as usize] as usize..offsets[perm[j] as usize + 1] as usize;
            for &i in &pattern.row_idx[pattern.col_ptr[j]..pattern.col_ptr[j + 1]] {
                let at = columns[row.clone()].binary_search(&perm[i]);
                lower.push(at.map_or(0.0, |k| values[row.start + k]));
            }
        }
        let mut factor = Cholesky::new(Arc::new(CholeskySymbolic::new(&pattern)?));
        factor.factorize(&lower)?;
        let mut x = vec![0.0; 3 * n];
        for (new, &old) in perm.iter().enumerate() {
            let b = self.rhs[old as usize];
            (x[new], x[n + new], x[2 * n + new]) = (b.x, b.y, b.z);
        }
        factor.solve_in_place(&mut x, 3);
        for (new, &old) in perm.iter().enumerate() {
            self.rhs[old as usize] = DVec3::new(x[new], x[n + new], x[2 * n + new]);
        }
        Ok(self.rhs)
    }
}
