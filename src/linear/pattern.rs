//! Sparsity of a symmetric matrix.

/// Sparsity of a symmetric matrix: lower triangle with the diagonal, compressed columns.
///
/// The values of a matrix of this pattern are one `f64` for each entry of `row_idx`, in its order.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SymmetricPattern {
    /// Number of rows, and of columns.
    pub n: usize,
    /// Start of each column in `row_idx`; length `n + 1`, first entry 0, last `row_idx.len()`.
    pub col_ptr: Vec<usize>,
    /// Rows of each column, strictly ascending; the first row of column `j` is `j`.
    pub row_idx: Vec<usize>,
}

impl SymmetricPattern {
    /// Wraps the arrays of a pattern.
    ///
    /// # Panics
    /// With debug assertions on, if the invariants stated at the fields are violated.
    pub fn new(n: usize, col_ptr: Vec<usize>, row_idx: Vec<usize>) -> Self {
        debug_assert_eq!(col_ptr.len(), n + 1, "one column pointer more than columns");
        debug_assert_eq!(col_ptr[0], 0);
        debug_assert_eq!(col_ptr[n], row_idx.len());
        debug_assert!(
            (0..n).all(|j| {
                let rows = &row_idx[col_ptr[j]..col_ptr[j + 1]];
                rows.first() == Some(&j)
                    && rows.is_sorted_by(|a, b| a < b)
                    && rows.last().is_some_and(|&i| i < n)
            }),
            "columns must start with the diagonal and ascend strictly"
        );
        Self {
            n,
            col_ptr,
            row_idx,
        }
    }

    /// Pattern of the matrix of an undirected graph, diagonal added, in the order `perm` (`perm[new]
    /// = old`).
    ///
    /// `offsets` (length n + 1) and `adjacency` list the neighbours of each old vertex, each edge
    /// from both ends; loops (a vertex as its own neighbour) are allowed, repeated neighbours are
    /// not. Linear time, no sorting.
    ///
    /// # Panics
    /// If `offsets` is not of length n + 1, or an index is out of range.
    pub fn of_permuted_graph(offsets: &[u32], adjacency: &[u32], perm: &[u32]) -> Self {
        let n = perm.len();
        assert_eq!(offsets.len(), n + 1, "one offset more than vertices");
        let neighbours = |old: u32| {
            &adjacency[offsets[old as usize] as usize..offsets[old as usize + 1] as usize]
        };
        let mut new_of_old = vec![0_u32; n];
        for (new, &old) in perm.iter().enumerate() {
            new_of_old[old as usize] = new as u32;
        }
        let mut col_ptr = vec![0_usize; n + 1];
        for (j, &old) in perm.iter().enumerate() {
            let below = neighbours(old)
                .iter()
                .filter(|&&o| new_of_old[o as usize] as usize > j)
                .count();
            col_ptr[j + 1] = col_ptr[j] + 1 + below;
        }
        // Rows are visited in ascending order, so every column fills in ascending order.
        let mut next = col_ptr[..n].to_vec();
        let mut row_idx = vec![0_usize; col_ptr[n]];
        for (i, &old) in perm.iter().enumerate() {
            row_idx[next[i]] = i;
            next[i] += 1;
            for &o in neighbours(old) {
                let j = new_of_old[o as usize] as usize;
                if j < i {
                    row_idx[next[j]] = i;
                    next[j] += 1;
                }
            }
        }
        Self::new(n, col_ptr, row_idx)
    }

    /// Number of stored entries: the length of a value array of this pattern.
    pub fn nnz(&self) -> usize {
        self.row_idx.len()
    }

    /// `y = A x` for the symmetric matrix with these lower-triangle values.
    ///
    /// # Panics
    /// If the lengths do not match the pattern.
    pub fn multiply(&self, values: &[f64], x: &[f64], y: &mut [f64]) {
        assert_eq!(values.len(), self.nnz(), "one value per stored entry");
        assert!(
            x.len() == self.n && y.len() == self.n,
            "vectors of length n"
        );
        y.fill(0.0);
        for j in 0..self.n {
            let range = self.col_ptr[j]..self.col_ptr[j + 1];
            let xj = x[j];
            let mut sum = values[range.start] * xj;
            for p in range.start + 1..range.end {
                let i = self.row_idx[p];
                y[i] += values[p] * xj;
                sum += values[p] * x[i];
            }
            y[j] += sum;
        }
    }
}
