//! Warm start of a flow: the graph bi-Laplacian of the patch.

use std::sync::Arc;

use crate::linear::{
    Cholesky, CholeskySymbolic, LinearError, SymmetricPattern, flat, nested_dissection, vector,
};
use crate::mesh::{DVec3, HalfedgeId, Topology, VertexId};

/// Moves the `interior` vertices to the minimum of `Σ |(L x)_i|² / m_i`, all other vertices fixed.
/// L is the Laplacian `(L x)_i = Σ_{j ∈ ring(i)} w_ij (x_i − x_j)`, and the sum runs over all its
/// rows that contain an interior vertex: the interior ones and those of the rim, whose rings reach
/// into the given mesh. The minimum is the solution of L M⁻¹ L x = 0 at the interior vertices
/// (formulation, section 6): it spreads the vertices smoothly *across* the rim, in position and in
/// spacing.
///
/// The weights are the mean of the graph's (1) and the cotangent formula's on the given positions
/// (1 for equilateral triangles, clamped to positive values): the graph's alone crowd and thin the
/// vertices around irregular ones, the cotangents' alone keep every jump of spacing at the rim.
/// Measured over the analytic test surfaces, the mean of both leaves the least error after the
/// flow. Apart from the weights (and the order of elimination) the result does not depend on where
/// the interior vertices were, so no graph Laplacian has to be solved first.
///
/// `m_i` is the area of the triangles at vertex i, so that the sum is an integral of the squared
/// Laplacian wherever the triangles change in size: with m = 1 a patch finer or coarser than its
/// surroundings was not smooth across the rim (twice as fine, 7 of the 21 holes of a scanned model
/// did not converge in 60 steps; with areas all do, in at most 18).
///
/// `positions` has one entry per vertex of `topology`. On open boundaries next to the interior the
/// rows are those of the edges that exist.
///
/// # Errors
/// [`LinearError::NotPositiveDefinite`] if no fixed vertex is near the interior;
/// [`LinearError::TooLarge`] and [`LinearError::OutOfMemory`] for patches too large to factorize.
/// The positions are unchanged then.
///
/// # Panics
/// If `positions` is shorter than the vertex list, or `interior` names a vertex twice.
pub fn warm_start(
    topology: &Topology,
    positions: &mut [DVec3],
    interior: &[VertexId],
) -> Result<(), LinearError> {
    warm_start_with_creases(topology, positions, interior, &[])
}

/// The same where the surface ends in a crease at some fixed vertices: the sum leaves their rows
/// out, so that no direction is preferred there (with creases all around the result is harmonic).
///
/// # Errors
/// As [`warm_start`].
///
/// # Panics
/// As [`warm_start`].
pub fn warm_start_with_creases(
    topology: &Topology,
    positions: &mut [DVec3],
    interior: &[VertexId],
    creases: &[VertexId],
) -> Result<(), LinearError> {
    assert!(
        positions.len() >= topology.vertex_count(),
        "one position per vertex"
    );
    let n = interior.len();
    if n == 0 {
        return Ok(());
    }
    let rows = squared_laplacian(topology, positions, interior, creases);
    if !rows.is_anchored {
        return Err(LinearError::NotPositiveDefinite { index: 0 });
    }
    let points: Vec<DVec3> = interior.iter().map(|v| positions[v.index()]).collect();
    let solution = solve(&rows, &points)?;
    for (v, x) in interior.iter().zip(solution) {
        positions[v.index()] = rows.origin + x;
    }
    Ok(())
}

/// The solution for each unknown. `points` are the places of the unknowns, for the elimination
/// order.
pub(super) fn solve(rows: &Rows, points: &[DVec3]) -> Result<Vec<DVec3>, LinearError> {
    let perm = nested_dissection(points, &rows.offsets, &rows.columns);
    let pattern = SymmetricPattern::of_permuted_graph(&rows.offsets, &rows.columns, &perm);
    let values = permuted_values(rows, &pattern, &perm);
    let mut factor = Cholesky::new(Arc::new(CholeskySymbolic::new(&pattern)?));
    factor.factorize(&values)?;

    let mut solution = flat(perm.iter().map(|&old| rows.rhs[old as usize]));
    factor.solve_in_place(&mut solution, 3);
    let mut out = vec![DVec3::ZERO; points.len()];
    for (new, &old) in perm.iter().enumerate() {
        out[old as usize] = vector(&solution, new);
    }
    Ok(out)
}

/// Rows of L M⁻¹ L for the interior vertices over the interior vertices (the diagonal entry first),
/// and what the fixed vertices contribute to the right-hand side.
pub(super) struct Rows {
    pub offsets: Vec<u32>,
    pub columns: Vec<u32>,
    pub values: Vec<f64>,
    pub rhs: Vec<DVec3>,
    /// Subtracted from all positions, so that a mesh far from the origin loses no digits.
    pub origin: DVec3,
    /// Whether any fixed vertex takes part; otherwise the matrix is singular, which rounding may
    /// hide.
    pub is_anchored: bool,
}

fn squared_laplacian(
    topology: &Topology,
    positions: &[DVec3],
    interior: &[VertexId],
    creases: &[VertexId],
) -> Rows {
    const FIXED: u32 = u32::MAX;
    let n = interior.len();
    let mut unknown = vec![FIXED; topology.vertex_count()];
    for (i, v) in interior.iter().enumerate() {
        assert_eq!(unknown[v.index()], FIXED, "interior vertices are distinct");
        unknown[v.index()] = i as u32;
    }
    let mut rings = Rings::around(topology, positions, interior);
    for v in creases {
        rings.per_mass[v.index()] = 0.0;
    }
    let origin = positions[interior[0].index()];

    let mut rows = Rows {
        offsets: Vec::with_capacity(n + 1),
        columns: Vec::with_capacity(19 * n),
        values: Vec::with_capacity(19 * n),
        rhs: Vec::with_capacity(n),
        origin,
        is_anchored: false,
    };
    // index of unknown k in the current row; valid if not before the row's start
    let mut place = vec![0u32; n];
    rows.offsets.push(0);
    for (i, &v) in interior.iter().enumerate() {
        let start = rows.columns.len() as u32;
        rows.columns.push(i as u32);
        rows.values.push(0.0);
        place[i] = start;
        let mut rhs = DVec3::ZERO;
        let mut add = |weight: f64, k: VertexId| {
            let u = unknown[k.index()];
            if u == FIXED {
                rhs -= weight * (positions[k.index()] - origin);
                rows.is_anchored = true;
                return;
            }
            let at = place[u as usize];
            if (at >= start) && (at as usize) < rows.columns.len() && rows.columns[at as usize] == u
            {
                rows.values[at as usize] += weight;
            } else {
                place[u as usize] = rows.columns.len() as u32;
                rows.columns.push(u);
                rows.values.push(weight);
            }
        };
        // Σ_j L_ij L_jk / m_j, j over i and its ring
        let (ring, diagonal, per_mass) = rings.of(v);
        add(diagonal * diagonal * per_mass, v);
        for &(k, w) in ring {
            add(-diagonal * w * per_mass, k);
        }
        for &(j, w) in ring {
            let (ring_j, diagonal_j, per_mass_j) = rings.of(j);
            let w = w * per_mass_j;
            add(-w * diagonal_j, j);
            for &(k, w_j) in ring_j {
                add(w * w_j, k);
            }
        }
        rows.offsets.push(rows.columns.len() as u32);
        rows.rhs.push(rhs);
    }
    rows
}

/// Neighbours of the interior vertices and of the vertices around them with their weights, in one
/// array.
pub(super) struct Rings {
    /// Start and end per vertex of the mesh, zero where not asked for.
    range: Vec<[u32; 2]>,
    neighbours: Vec<(VertexId, f64)>,
    /// Sum of the weights of each ring.
    diagonal: Vec<f64>,
    /// 1 / m: the patch's mean area around a vertex over that of this ring.
    per_mass: Vec<f64>,
}

impl Rings {
    pub fn around(topology: &Topology, positions: &[DVec3], interior: &[VertexId]) -> Self {
        let mut rings = Self {
            range: vec![[0; 2]; topology.vertex_count()],
            neighbours: Vec::with_capacity(7 * interior.len() + 64),
            diagonal: vec![0.0; topology.vertex_count()],
            per_mass: vec![0.0; topology.vertex_count()],
        };
        for &v in interior {
            rings.append(topology, positions, v);
        }
        let areas = interior.iter().map(|v| rings.per_mass[v.index()]);
        let mean = areas.sum::<f64>() / interior.len() as f64;
        for &v in interior {
            let [begin, end] = rings.range[v.index()];
            for k in begin..end {
                rings.append(topology, positions, rings.neighbours[k as usize].0);
            }
        }
        let [least, most] = AREA_RANGE;
        for area in &mut rings.per_mass {
            // NaN where everything is degenerate: max and min ignore it
            *area = (mean / *area).max(least).min(most);
        }
        rings
    }

    fn append(&mut self, topology: &Topology, positions: &[DVec3], v: VertexId) {
        if self.range[v.index()] != [0; 2] {
            return;
        }
        let begin = self.neighbours.len() as u32;
        for h in topology.outgoing(v) {
            let (weight, area) = edge_weight(topology, positions, h);
            self.neighbours.push((topology.target(h), weight));
            self.diagonal[v.index()] += weight;
            self.per_mass[v.index()] += area;
        }
        self.range[v.index()] = [begin, self.neighbours.len() as u32];
    }

    /// Neighbours with weights, sum of the weights, 1 / m.
    pub fn of(&self, v: VertexId) -> (&[(VertexId, f64)], f64, f64) {
        let [begin, end] = self.range[v.index()];
        (
            &self.neighbours[begin as usize..end as usize],
            self.diagonal[v.index()],
            self.per_mass[v.index()],
        )
    }
}

/// Cotangent weights are clamped to this range (1 for an edge between equilateral triangles), so
/// that neither slivers of the given mesh nor obtuse angles upset the balance.
const COTANGENT_RANGE: [f64; 2] = [0.03, 5.0];

/// Areas around vertices are clamped so that 1 / m stays in this range, for the same reason.
const AREA_RANGE: [f64; 2] = [1.0 / 64.0, 64.0];

/// The weight of an edge and twice the area of its triangles, bit-identical for both half-edges.
/// (The areas of all edges at a vertex sum to four times the area of its triangles.)
fn edge_weight(topology: &Topology, positions: &[DVec3], h: HalfedgeId) -> (f64, f64) {
    let h = HalfedgeId(h.0 & !1);
    let (left, left_area) = opposite_cotangent(topology, positions, h);
    let (right, right_area) = opposite_cotangent(topology, positions, h.twin());
    let cotangents = left + right;
    let [least, most] = COTANGENT_RANGE;
    let relative = 0.5 * 3.0f64.sqrt() * cotangents;
    // NaN next to degenerate faces: max and min ignore it
    let weight = 0.5 + 0.5 * relative.max(least).min(most);
    (weight, left_area + right_area)
}

/// Cotangent of the angle opposite the half-edge and twice the area of its triangle; 0 on a
/// boundary.
fn opposite_cotangent(topology: &Topology, positions: &[DVec3], h: HalfedgeId) -> (f64, f64) {
    if topology.is_boundary(h) {
        return (0.0, 0.0);
    }
    let apex = positions[topology.target(topology.next(h)).index()];
    let u = positions[topology.origin(h).index()] - apex;
    let v = positions[topology.target(h).index()] - apex;
    let area = u.cross(v).length();
    (u.dot(v) / area, area)
}

/// The lower triangle of the permuted matrix in the order of `pattern`.
fn permuted_values(rows: &Rows, pattern: &SymmetricPattern, perm: &[u32]) -> Vec<f64> {
    let n = perm.len();
    let mut new_of_old = vec![0u32; n];
    for (new, &old) in perm.iter().enumerate() {
        new_of_old[old as usize] = new as u32;
    }
    // One column at a time: scattered by new index, gathered in the pattern's order. Entries that
    // the column does not have are never read.
    let mut scattered = vec![0.0; n];
    let mut values = Vec::with_capacity(pattern.nnz());
    for (j, &old) in perm.iter().enumerate() {
        let row = rows.offsets[old as usize] as usize..rows.offsets[old as usize + 1] as usize;
        for p in row {
            scattered[new_of_old[rows.columns[p] as usize] as usize] = rows.values[p];
        }
        let column = pattern.col_ptr[j]..pattern.col_ptr[j + 1];
        values.extend(pattern.row_idx[column].iter().map(|&i| scattered[i]));
    }
    values
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A triangulated parallelogram of the regular lattice, `side` vertices along each side.
    fn lattice(side: usize) -> (Topology, Vec<DVec3>) {
        let at = |i: usize, j: usize| (i * side + j) as u32;
        let mut triangles = Vec::new();
        let mut points = Vec::new();
        for i in 0..side {
            for j in 0..side {
                let (x, y) = (j as f64 + 0.5 * i as f64, 0.75f64.sqrt() * i as f64);
                points.push(DVec3::new(x, y, 0.0));
                if i + 1 < side && j + 1 < side {
                    triangles.push([at(i, j), at(i, j + 1), at(i + 1, j)]);
                    triangles.push([at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)]);
                }
            }
        }
        let topology =
            Topology::from_triangles(points.len(), &triangles).expect("the lattice is a manifold");
        (topology, points)
    }

    /// Lattice vertices at least two rings from the boundary.
    fn inner(side: usize) -> Vec<VertexId> {
        (2..side - 2)
            .flat_map(|i| (2..side - 2).map(move |j| VertexId((i * side + j) as u32)))
            .collect()
    }

    #[test]
    fn reproduces_cubics_on_the_regular_lattice() {
        // L is exactly a multiple of the Laplacian on cubics there, and L of linears is 0. Heights
        // of 1e-6 change the weights by 1e-12.
        let side = 14;
        let (topology, mut points) = lattice(side);
        for p in &mut points {
            let (x, y) = (p.x - 9.0, p.y - 6.0);
            p.z = 1e-6 * (0.02 * x * x * x - 0.05 * x * y * y + 0.1 * x * y + 0.3 * y * y - x);
        }
        let exact = points.clone();
        let interior = inner(side);
        for v in &interior {
            points[v.index()].z = 0.0;
        }
        warm_start(&topology, &mut points, &interior).expect("positive definite");
        for (p, q) in points.iter().zip(&exact) {
            assert!(
                (p.z - q.z).abs() < 1e-15 && p.distance(*q) < 1e-9,
                "{p} {q}"
            );
        }
    }

    /// The lattice with everything moved a little.
    fn rough_lattice(side: usize) -> (Topology, Vec<DVec3>) {
        let (topology, mut points) = lattice(side);
        for (k, p) in points.iter_mut().enumerate() {
            let k = k as f64;
            *p += 0.3 * DVec3::new((1.3 * k).sin(), (2.1 * k).sin(), (1.7 * k).sin());
        }
        (topology, points)
    }

    #[test]
    fn commutes_with_similarities() {
        let side = 11;
        let (topology, mut points) = rough_lattice(side);
        let turn = glam::DQuat::from_axis_angle(DVec3::new(1.0, 2.0, -2.0) / 3.0, 1.1);
        let map = |p: DVec3| turn * (8.0 * p) + DVec3::splat(1e3);
        let interior = inner(side);
        let mut mapped: Vec<_> = points.iter().map(|&p| map(p)).collect();
        warm_start(&topology, &mut points, &interior).expect("positive definite");
        warm_start(&topology, &mut mapped, &interior).expect("positive definite");
        for (p, q) in points.iter().zip(&mapped) {
            assert!(map(*p).distance(*q) < 1e-9);
        }
    }

    #[test]
    fn is_the_minimum() {
        // in every direction the energy grows by exactly its second-order part
        let side = 9;
        let (topology, start) = rough_lattice(side);
        let interior = inner(side);
        let rings = Rings::around(&topology, &start, &interior);
        let energy = |x: &[DVec3]| -> f64 {
            (0..topology.vertex_count())
                .map(|v| {
                    let (ring, diagonal, per_mass) = rings.of(VertexId(v as u32));
                    let sum: DVec3 = ring.iter().map(|&(j, w)| w * x[j.index()]).sum();
                    per_mass * (diagonal * x[v] - sum).length_squared()
                })
                .sum()
        };
        let mut best = start.clone();
        warm_start(&topology, &mut best, &interior).expect("positive definite");
        let least = energy(&best);
        for v in &interior {
            let shifted = |by: f64| {
                let mut x = best.clone();
                x[v.index()] += DVec3::new(by, -by, 0.5 * by);
                energy(&x)
            };
            let (up, down) = (shifted(0.1) - least, shifted(-0.1) - least);
            assert!(up > 0.0 && (up - down).abs() < 1e-11 * least.max(1.0));
        }
    }

    #[test]
    fn rows_count_by_the_area_around_them() {
        // Stretched by e along one side of the centre line, the triangles there have e times the
        // area; a ring on the line has half of its own on either side.
        let (side, e) = (9, 4.0);
        let (topology, mut points) = lattice(side);
        let line = points[4 * side].y;
        for p in &mut points {
            p.y = line + (p.y - line) * if p.y > line { e } else { 1.0 };
        }
        let interior: Vec<_> = [3, 4, 5].map(|i| VertexId(i * side as u32 + 4)).into();
        let rings = Rings::around(&topology, &points, &interior);
        let [below, on, above] = [0, 1, 2].map(|i: usize| 1.0 / rings.of(interior[i]).2);
        assert!((on / below - 0.5 * (1.0 + e)).abs() < 1e-12, "{on} {below}");
        assert!((above / below - e).abs() < 1e-12, "{above} {below}");
        assert!((below + on + above - 3.0).abs() < 1e-12);
    }

    #[test]
    fn loose_vertices_are_an_error() {
        let (topology, mut points) = lattice(4);
        let all: Vec<VertexId> = (0..16).map(VertexId).collect();
        let before = points.clone();
        assert!(matches!(
            warm_start(&topology, &mut points, &all),
            Err(LinearError::NotPositiveDefinite { .. })
        ));
        assert_eq!(points, before);
        warm_start(&topology, &mut points, &[]).expect("nothing to do");
    }
}
