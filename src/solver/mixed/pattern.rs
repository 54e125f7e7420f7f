//! Sparsity patterns of matrices that are sums of small dense ones.

/// Lists of indices, one after another.
#[derive(Clone, Debug, Default)]
pub struct IndexLists {
    /// Start of each list in `items`; one more entry at the end.
    pub start: Vec<u32>,
    /// The items.
    pub items: Vec<u32>,
}

impl IndexLists {
    /// Number of lists.
    pub fn len(&self) -> usize {
        self.start.len() - 1
    }

    /// One list.
    #[inline]
    pub fn of(&self, list: usize) -> &[u32] {
        &self.items[self.start[list] as usize..self.start[list + 1] as usize]
    }

    /// For each value below `n` the lists that contain it and its place there; other values are
    /// left out.
    fn inverse(&self, n: usize) -> (Vec<usize>, Vec<[u32; 2]>) {
        let mut start = vec![0; n + 1];
        for &i in &self.items {
            if (i as usize) < n {
                start[i as usize + 1] += 1;
            }
        }
        for i in 0..n {
            start[i + 1] += start[i];
        }
        let mut fill = start.clone();
        let mut entries = vec![[0; 2]; start[n]];
        for list in 0..self.len() {
            for (place, &i) in self.of(list).iter().enumerate() {
                if (i as usize) < n {
                    entries[fill[i as usize]] = [list as u32, place as u32];
                    fill[i as usize] += 1;
                }
            }
        }
        (start, entries)
    }
}

/// Rows of a sparse matrix `Σ_e P_eᵀ a_e Q_e` and where each entry of each small matrix `a_e` goes.
#[derive(Clone, Debug, Default)]
pub struct ScatterMap {
    /// Start of each row in `columns`.
    pub offsets: Vec<usize>,
    /// Columns of each row, ascending.
    pub columns: Vec<usize>,
    /// Start of each small matrix in `slot`.
    start: Vec<usize>,
    /// Place of the entries of each small matrix, row by row; the number of stored entries for
    /// those that belong nowhere (fixed values, or below the diagonal if only the upper triangle
    /// is kept).
    slot: Vec<u32>,
}

impl ScatterMap {
    /// Couples each member of `rows` list e with each member of `columns` list e. Indices from `n`
    /// (of rows) or `m` (of columns) on are fixed values and have no place. With `upper`, only
    /// entries on and above the diagonal are kept.
    pub fn new(rows: &IndexLists, columns: &IndexLists, n: usize, m: usize, upper: bool) -> Self {
        let mut start = Vec::with_capacity(rows.len() + 1);
        let mut total = 0;
        start.push(0);
        for e in 0..rows.len() {
            total += rows.of(e).len() * columns.of(e).len();
            start.push(total);
        }
        let (first, incident) = rows.inverse(n);
        let mut slot = vec![u32::MAX; total];
        let mut stamp = vec![usize::MAX; m];
        let mut place = vec![0u32; m];
        let mut offsets = Vec::with_capacity(n + 1);
        let mut indices: Vec<usize> = Vec::new();
        offsets.push(0);
        for i in 0..n {
            let kept = |j: u32| (j as usize) < m && !(upper && (j as usize) < i);
            let own = &incident[first[i]..first[i + 1]];
            let begin = indices.len();
            for &[e, _] in own {
                for &j in columns.of(e as usize) {
                    if kept(j) && stamp[j as usize] != i {
                        stamp[j as usize] = i;
                        indices.push(j as usize);
                    }
                }
            }
            indices[begin..].sort_unstable();
            for (at, &j) in indices.iter().enumerate().skip(begin) {
                place[j] = at as u32;
            }
            for &[e, a] in own {
                let columns = columns.of(e as usize);
                let slots = &mut slot[start[e as usize] + a as usize * columns.len()..];
                for (s, &j) in slots.iter_mut().zip(columns) {
                    if kept(j) {
                        *s = place[j as usize];
                    }
                }
            }
            offsets.push(indices.len());
        }
        for s in &mut slot {
            *s = (*s).min(indices.len() as u32);
        }
        Self {
            offsets,
            columns: indices,
            start,
            slot,
        }
    }

    /// Number of stored entries.
    pub fn nnz(&self) -> usize {
        self.columns.len()
    }

    /// Places of the entries of one small matrix, row by row.
    #[inline]
    pub fn slots(&self, e: usize) -> &[u32] {
        &self.slot[self.start[e]..self.start[e + 1]]
    }

    /// The transposed lists: for each of `m` columns the rows that have it, and the place of the
    /// entry.
    pub fn by_column(&self, m: usize) -> (IndexLists, Vec<u32>) {
        let mut start = vec![0u32; m + 1];
        for &j in &self.columns {
            start[j + 1] += 1;
        }
        for j in 0..m {
            start[j + 1] += start[j];
        }
        let mut fill = start.clone();
        let mut items = vec![0; self.nnz()];
        let mut places = vec![0; self.nnz()];
        for i in 0..self.offsets.len() - 1 {
            for at in self.offsets[i]..self.offsets[i + 1] {
                let next = &mut fill[self.columns[at]];
                items[*next as usize] = i as u32;
                places[*next as usize] = at as u32;
                *next += 1;
            }
        }
        (IndexLists { start, items }, places)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_matrices_add_up_where_they_belong() {
        let rows = IndexLists {
            start: vec![0, 2, 4],
            items: vec![0, 2, 1, 9],
        };
        let columns = IndexLists {
            start: vec![0, 3, 5],
            items: vec![1, 0, 7, 1, 0],
        };
        let c = ScatterMap::new(&rows, &columns, 3, 2, false);
        assert_eq!(c.offsets, [0, 2, 4, 6]);
        assert_eq!(c.columns, [0, 1, 0, 1, 0, 1]);
        assert_eq!(c.slots(0), [1, 0, 6, 5, 4, 6]);
        assert_eq!(c.slots(1), [3, 2, 6, 6]);
        let (by_column, places) = c.by_column(2);
        assert_eq!(by_column.of(1), [0, 1, 2]);
        assert_eq!(places[3..], [1, 3, 5]);
        let upper = ScatterMap::new(&columns, &columns, 2, 2, true);
        assert_eq!(upper.columns, [0, 1, 1]);
        assert_eq!(upper.slots(1), [2, 3, 1, 0]);
    }
}
