//! Harmonic continuation of numbers from a rim into a patch.

use std::ops::Range;
use std::sync::Arc;

use crate::linear::{Cholesky, CholeskySymbolic, LinearError, SymmetricPattern, nested_dissection};
use crate::mesh::{DVec3, VertexId, sides};

/// The Laplace equation on the edges of a patch: the number at a new vertex is the mean of those at
/// its neighbours, and the numbers at the rim are given. Every solution stays between the least and
/// the greatest given number.
pub struct Harmonic {
    /// The vertices with given numbers, ascending.
    pub rim: Vec<VertexId>,
    /// For each new vertex the rim vertex with the fewest edges to it.
    pub nearest: Vec<VertexId>,
    /// Edges from a new vertex to a rim vertex, by their indices.
    links: Vec<[u32; 2]>,
    /// The new vertex that each row of the factor stands for.
    order: Vec<u32>,
    /// `None` if the equation has no unique solution.
    factor: Option<Cholesky>,
}

const UNREACHED: u32 = u32::MAX;

impl Harmonic {
    /// Prepares the equation for a patch with these triangles and `new` vertices.
    ///
    /// # Panics
    /// If there is not one position per vertex.
    pub fn new(
        triangles: impl Iterator<Item = [u32; 3]>,
        new: Range<usize>,
        positions: &[DVec3],
    ) -> Self {
        let count = new.len();
        let mut edges: Vec<[u32; 2]> = triangles.flat_map(sides).collect();
        let is_new = |v: u32| new.contains(&(v as usize));
        let mut rim: Vec<u32> = edges.iter().map(|e| e[0]).filter(|&v| !is_new(v)).collect();
        rim.sort_unstable();
        rim.dedup();
        edges.retain(|e| is_new(e[0]));
        edges.sort_unstable();
        edges.dedup();
        let unknown = |v: u32| v - new.start as u32;
        let mut offsets = vec![0_u32; count + 1];
        let mut degree = vec![0_u32; count];
        let (mut adjacency, mut links) = (Vec::with_capacity(edges.len()), Vec::new());
        for &[from, to] in &edges {
            let from = unknown(from);
            degree[from as usize] += 1;
            if is_new(to) {
                adjacency.push(unknown(to));
                offsets[from as usize + 1] += 1;
            } else {
                let place = rim.partition_point(|&v| v < to) as u32;
                links.push([from, place]);
            }
        }
        for i in 0..count {
            offsets[i + 1] += offsets[i];
        }
        let nearest = nearest(&offsets, &adjacency, &links);
        let order = nested_dissection(&positions[new], &offsets, &adjacency);
        let of_rim = |&place: &u32| VertexId(rim.get(place as usize).copied().unwrap_or(rim[0]));
        Self {
            nearest: nearest.iter().map(of_rim).collect(),
            factor: factorized(&offsets, &adjacency, &degree, &order).ok(),
            rim: rim.into_iter().map(VertexId).collect(),
            links,
            order,
        }
    }

    /// The numbers at the new vertices for these numbers at the rim; those of the nearest rim vertices if
    /// the equation has no unique solution.
    pub fn solve(&mut self, at_rim: &[f64]) -> Vec<f64> {
        let count = self.nearest.len();
        let Some(factor) = &mut self.factor else {
            let place = |v: &VertexId| self.rim.partition_point(|r| r < v);
            return self.nearest.iter().map(|v| at_rim[place(v)]).collect();
        };
        let mut sums = vec![0.0; count];
        for &[new, place] in &self.links {
            sums[new as usize] += at_rim[place as usize];
        }
        let mut solution: Vec<f64> = self.order.iter().map(|&i| sums[i as usize]).collect();
        factor.solve_in_place(&mut solution, 1);
        let mut out = vec![0.0; count];
        for (&new, x) in self.order.iter().zip(solution) {
            out[new as usize] = x;
        }
        out
    }
}

/// The place on the rim that is nearest to each new vertex, counted in edges.
fn nearest(offsets: &[u32], adjacency: &[u32], links: &[[u32; 2]]) -> Vec<u32> {
    let mut nearest = vec![UNREACHED; offsets.len() - 1];
    let mut waiting = std::collections::VecDeque::new();
    for &[new, place] in links {
        if nearest[new as usize] == UNREACHED {
            nearest[new as usize] = place;
            waiting.push_back(new);
        }
    }
    while let Some(v) = waiting.pop_front() {
        let around = offsets[v as usize] as usize..offsets[v as usize + 1] as usize;
        for &w in &adjacency[around] {
            if nearest[w as usize] == UNREACHED {
                nearest[w as usize] = nearest[v as usize];
                waiting.push_back(w);
            }
        }
    }
    nearest
}

/// The factor of the graph Laplacian in this order.
fn factorized(
    offsets: &[u32],
    adjacency: &[u32],
    degree: &[u32],
    order: &[u32],
) -> Result<Cholesky, LinearError> {
    let pattern = SymmetricPattern::of_permuted_graph(offsets, adjacency, order);
    let mut values = vec![-1.0; pattern.nnz()];
    for (column, &new) in order.iter().enumerate() {
        values[pattern.col_ptr[column]] = f64::from(degree[new as usize]);
    }
    let mut factor = Cholesky::new(Arc::new(CholeskySymbolic::new(&pattern)?));
    factor.factorize(&values)?;
    Ok(factor)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes;

    /// A linear function on a regular grid is harmonic.
    #[test]
    fn linear_functions_are_continued_exactly() {
        let n = 9_u32;
        let at = |i: u32, j: u32| i * n + j;
        let inner = |i: u32, j: u32| i > 0 && j > 0 && i < n - 1 && j < n - 1;
        // rim vertices first
        let cells: Vec<(u32, u32)> = (0..n).flat_map(|i| (0..n).map(move |j| (i, j))).collect();
        let (inside, rim): (Vec<_>, Vec<_>) = cells.iter().partition(|&&(i, j)| inner(i, j));
        let places = [&rim[..], &inside[..]].concat();
        let mut number = vec![0; places.len()];
        for (k, &&(i, j)) in places.iter().enumerate() {
            number[at(i, j) as usize] = k as u32;
        }
        let position = |&&(i, j): &&(u32, u32)| DVec3::new(f64::from(i), f64::from(j), 0.0);
        let positions: Vec<DVec3> = places.iter().map(position).collect();
        let cell = |i: u32, j: u32| {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            [[a, b, c], [a, c, d]].map(|t| t.map(|v| number[v as usize]))
        };
        let triangles = (0..n - 1).flat_map(|i| (0..n - 1).flat_map(move |j| [(i, j)]));
        let triangles = triangles.flat_map(|(i, j)| cell(i, j));
        let mut equation = Harmonic::new(triangles, rim.len()..places.len(), &positions);
        let function = |p: &DVec3| 2.0 * p.x - 0.5 * p.y + 1.0;
        let at_rim: Vec<f64> = equation
            .rim
            .iter()
            .map(|v| function(&positions[v.index()]))
            .collect();
        let solution = equation.solve(&at_rim);
        for (value, p) in solution.iter().zip(&positions[rim.len()..]) {
            assert!((value - function(p)).abs() < 1e-12);
        }
        for (v, p) in equation.nearest.iter().zip(&positions[rim.len()..]) {
            let to_side = [p.x, p.y, 8.0 - p.x, 8.0 - p.y]
                .into_iter()
                .reduce(f64::min);
            let far = (positions[v.index()] - *p).abs().max_element();
            assert_eq!(Some(far), to_side);
        }
    }

    /// Without a rim every number solves the equation.
    #[test]
    fn closed_surfaces_have_no_solution() {
        let (positions, triangles) = shapes::icosphere(1);
        let triangles = triangles.into_iter().filter(|t| !t.contains(&0));
        let equation = Harmonic::new(triangles, 0..0, &positions);
        assert!(equation.nearest.is_empty());
    }
}
