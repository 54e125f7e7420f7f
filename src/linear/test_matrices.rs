//! Matrices shared by the tests of this module.

use glam::DVec3;

use super::SymmetricPattern;

/// A graph with positions: offsets and adjacency in compressed rows.
pub(crate) struct Graph {
    pub points: Vec<DVec3>,
    pub offsets: Vec<u32>,
    pub adjacency: Vec<u32>,
}

impl Graph {
    /// Graph of the given edges (each once).
    pub(crate) fn new(points: Vec<DVec3>, edges: &[(usize, usize)]) -> Self {
        let mut lists = vec![Vec::new(); points.len()];
        for &(a, b) in edges {
            lists[a].push(b as u32);
            lists[b].push(a as u32);
        }
        let mut offsets = vec![0];
        for list in &mut lists {
            list.sort_unstable();
            offsets.push(offsets[offsets.len() - 1] + list.len() as u32);
        }
        Self {
            points,
            offsets,
            adjacency: lists.concat(),
        }
    }

    /// nx x ny vertices of a square grid, neighbours at most `reach` edges away.
    pub(crate) fn grid(nx: usize, ny: usize, reach: usize) -> Self {
        let points = (0..nx * ny)
            .map(|v| DVec3::new((v % nx) as f64, (v / nx) as f64, 0.0))
            .collect();
        let mut edges = Vec::new();
        for a in 0..nx * ny {
            for b in a + 1..nx * ny {
                let distance = (a % nx).abs_diff(b % nx) + (a / nx).abs_diff(b / nx);
                if distance <= reach {
                    edges.push((a, b));
                }
            }
        }
        Self::new(points, &edges)
    }

    pub(crate) fn n(&self) -> usize {
        self.points.len()
    }

    pub(crate) fn neighbours(&self, v: usize) -> &[u32] {
        &self.adjacency[self.offsets[v] as usize..self.offsets[v + 1] as usize]
    }

    /// Laplacian with Dirichlet boundary in the style of finite differences, permuted: diagonal
    /// `diagonal`, -1 for each edge.
    pub(crate) fn laplacian(&self, diagonal: f64, perm: &[u32]) -> (SymmetricPattern, Vec<f64>) {
        let pattern = SymmetricPattern::of_permuted_graph(&self.offsets, &self.adjacency, perm);
        let mut values = vec![-1.0; pattern.nnz()];
        for &start in &pattern.col_ptr[..pattern.n] {
            values[start] = diagonal;
        }
        (pattern, values)
    }
}

/// Reproducible numbers in [-1, 1): the same on every machine.
pub(crate) fn noise(seed: u64, n: usize) -> Vec<f64> {
    let mut state = seed.wrapping_add(0x9e37_79b9_7f4a_7c15);
    (0..n)
        .map(|_| {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
        })
        .collect()
}

pub(crate) fn identity_order(n: usize) -> Vec<u32> {
    (0..n as u32).collect()
}
