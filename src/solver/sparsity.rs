//! Sparsity of assembled matrices, and where the entries of element matrices go.
//!
//! An assembled matrix is a sum `Σ_e P_eᵀ a_e Q_e`: each element `e` has a small dense matrix `a_e`
//! whose rows belong to the unknowns of one list and whose columns belong to those of another list.
//!
//! ```text
//!   rows of e: [2, 0, 7]                 unknowns   0  1  2 …
//!   columns of e: [5, 4]                         0  .  .  .
//!        ⎡ a b ⎤       a → (2, 5), b → (2, 4)    1
//!   a_e  ⎢ c d ⎥       c → (0, 5), d → (0, 4)    2
//!        ⎣ e f ⎦       e → (7, 5), f → (7, 4)    …
//! ```
//!
//! A scatter map stores for each entry of each `a_e` its place in the values of the sparse matrix.
//! Assembly therefore only adds. Indices greater than or equal to the number of unknowns represent
//! fixed values. Their entries go to one extra place after the last.

use crate::linear::{SymmetricPattern, nested_dissection};
use crate::mesh::DVec3;

/// Lists of indices, one after another.
#[derive(Clone, Debug)]
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

    /// For each value below `n`, the lists that contain it and its place there, by a counting sort.
    /// Other values are ignored.
    pub fn incidence(&self, n: usize) -> Incidence {
        let mut start = vec![0u32; n + 1];
        for &i in self.items.iter().filter(|&&i| (i as usize) < n) {
            start[i as usize + 1] += 1;
        }
        for i in 0..n {
            start[i + 1] += start[i];
        }
        let mut next = start.clone();
        let mut entries = vec![[0; 2]; start[n] as usize];
        for list in 0..self.len() {
            for (place, &i) in self.of(list).iter().enumerate() {
                if (i as usize) < n {
                    entries[next[i as usize] as usize] = [list as u32, place as u32];
                    next[i as usize] += 1;
                }
            }
        }
        Incidence { start, entries }
    }
}

/// For each unknown the lists that contain it.
#[derive(Clone, Debug)]
pub struct Incidence {
    start: Vec<u32>,
    entries: Vec<[u32; 2]>,
}

impl Incidence {
    /// The lists that contain an unknown, each with its place in the list.
    #[inline]
    pub fn of(&self, unknown: usize) -> &[[u32; 2]] {
        &self.entries[self.start[unknown] as usize..self.start[unknown + 1] as usize]
    }
}

/// The graph in which the members of each list are neighbours of each other.
pub struct ListGraph<'a> {
    lists: &'a IndexLists,
    incidence: Incidence,
    offsets: Vec<u32>,
    adjacency: Vec<u32>,
}

impl<'a> ListGraph<'a> {
    /// For the unknowns `0..n`.
    pub fn new(lists: &'a IndexLists, n: usize) -> Self {
        let incidence = lists.incidence(n);
        let mut offsets = Vec::with_capacity(n + 1);
        let mut adjacency = Vec::with_capacity(36 * n);
        // the unknown that visited each neighbour last; fixed values count as visited
        let mut visited_by = vec![u32::MAX; n];
        offsets.push(0);
        for j in 0..n as u32 {
            visited_by[j as usize] = j;
            for &[list, _] in incidence.of(j as usize) {
                for &i in lists.of(list as usize) {
                    if let Some(visitor) = visited_by.get_mut(i as usize)
                        && *visitor != j
                    {
                        *visitor = j;
                        adjacency.push(i);
                    }
                }
            }
            offsets.push(adjacency.len() as u32);
        }
        Self {
            lists,
            incidence,
            offsets,
            adjacency,
        }
    }

    /// A fill-reducing order of the unknowns, with positions `points`, by nested dissection:
    /// `order[new] = old`.
    pub fn dissect(&self, points: &[DVec3]) -> Vec<u32> {
        nested_dissection(points, &self.offsets, &self.adjacency)
    }

    /// The matrix with an element matrix for each list, in an order of its unknowns
    /// (`order[new] = old`).
    pub fn scatter(&self, order: &[u32]) -> SymmetricScatter {
        let n = order.len();
        let pattern = SymmetricPattern::of_permuted_graph(&self.offsets, &self.adjacency, order);
        let mut new_of_old = vec![0u32; n];
        for (new, &old) in order.iter().enumerate() {
            new_of_old[old as usize] = new as u32;
        }
        let new_of = |old: &u32| new_of_old.get(*old as usize).copied().unwrap_or(n as u32);
        let items: Vec<u32> = self.lists.items.iter().map(new_of).collect();
        let mut start = Vec::with_capacity(self.lists.len() + 1);
        let mut total = 0;
        start.push(0);
        for list in 0..self.lists.len() {
            let k = self.lists.of(list).len();
            total += k * (k + 1) / 2;
            start.push(total as u32);
        }
        let mut slot = vec![pattern.nnz() as u32; total];
        let mut place = vec![0u32; n];
        for (j, &old) in order.iter().enumerate() {
            for at in pattern.col_ptr[j]..pattern.col_ptr[j + 1] {
                place[pattern.row_idx[at]] = at as u32;
            }
            for &[list, lj] in self.incidence.of(old as usize) {
                let slots = &mut slot[start[list as usize] as usize..];
                let [from, to] = [list, list + 1].map(|l| self.lists.start[l as usize] as usize);
                for (li, &i) in items[from..to].iter().enumerate() {
                    if j <= i as usize && (i as usize) < n {
                        slots[packed(li, lj as usize)] = place[i as usize];
                    }
                }
            }
        }
        SymmetricScatter {
            pattern,
            start,
            slot,
        }
    }
}

/// Index of the pair `{i, j}` in a packed lower triangle.
pub fn packed(i: usize, j: usize) -> usize {
    let (a, b) = if i >= j { (i, j) } else { (j, i) };
    a * (a + 1) / 2 + b
}

/// Sparsity of a symmetric matrix, and the places of the packed lower triangle of each element
/// matrix.
#[derive(Clone, Debug)]
pub struct SymmetricScatter {
    /// Lower triangle in the order of the unknowns.
    pub pattern: SymmetricPattern,
    start: Vec<u32>,
    slot: Vec<u32>,
}

impl SymmetricScatter {
    /// For lists of unknowns numbered in their final order.
    pub fn new(lists: &IndexLists, n: usize) -> Self {
        let order: Vec<u32> = (0..n as u32).collect();
        ListGraph::new(lists, n).scatter(&order)
    }

    /// Places of one element matrix: row by row, up to the diagonal.
    #[inline]
    pub fn slots(&self, element: usize) -> &[u32] {
        &self.slot[self.start[element] as usize..self.start[element + 1] as usize]
    }
}

/// Sparsity of a rectangular matrix, and the places of all entries of each element matrix.
#[derive(Clone, Debug)]
pub struct ScatterMap {
    /// Columns of each row, ascending.
    pub columns: IndexLists,
    start: Vec<u32>,
    slot: Vec<u32>,
}

impl ScatterMap {
    /// Rows from `rows`, below `n`, and columns from `columns`, below `m`, of each element.
    pub fn new(rows: &IndexLists, columns: &IndexLists, n: usize, m: usize) -> Self {
        let mut start = Vec::with_capacity(rows.len() + 1);
        let mut total = 0;
        start.push(0);
        for e in 0..rows.len() {
            total += rows.of(e).len() * columns.of(e).len();
            start.push(total as u32);
        }
        let incidence = rows.incidence(n);
        let mut slot = vec![u32::MAX; total];
        let mut visited_by = vec![usize::MAX; m];
        let mut place = vec![0u32; m];
        let mut offsets = vec![0];
        let mut indices: Vec<u32> = Vec::new();
        for i in 0..n {
            let begin = indices.len();
            for &[e, _] in incidence.of(i) {
                for &j in columns.of(e as usize) {
                    if let Some(visitor) = visited_by.get_mut(j as usize)
                        && *visitor != i
                    {
                        *visitor = i;
                        indices.push(j);
                    }
                }
            }
            indices[begin..].sort_unstable();
            for (at, &j) in indices.iter().enumerate().skip(begin) {
                place[j as usize] = at as u32;
            }
            for &[e, a] in incidence.of(i) {
                let columns = columns.of(e as usize);
                let slots = &mut slot[start[e as usize] as usize + a as usize * columns.len()..];
                for (s, &j) in slots.iter_mut().zip(columns) {
                    if let Some(&place) = place.get(j as usize) {
                        *s = place;
                    }
                }
            }
            offsets.push(indices.len() as u32);
        }
        for s in &mut slot {
            *s = (*s).min(indices.len() as u32);
        }
        Self {
            columns: IndexLists {
                start: offsets,
                items: indices,
            },
            start,
            slot,
        }
    }

    /// Number of stored entries.
    pub fn nnz(&self) -> usize {
        self.columns.items.len()
    }

    /// Places of the entries of one element matrix, row by row.
    #[inline]
    pub fn slots(&self, element: usize) -> &[u32] {
        &self.slot[self.start[element] as usize..self.start[element + 1] as usize]
    }

    /// The transposed sparsity: for each of `m` columns the rows that have it, and the place of the
    /// entry.
    pub fn by_column(&self, m: usize) -> (IndexLists, Vec<u32>) {
        let Incidence { start, entries } = self.columns.incidence(m);
        let place = |&[i, k]: &[u32; 2]| self.columns.start[i as usize] + k;
        let places = entries.iter().map(place).collect();
        let items = entries.iter().map(|e| e[0]).collect();
        (IndexLists { start, items }, places)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lists(start: &[u32], items: &[u32]) -> IndexLists {
        IndexLists {
            start: start.to_vec(),
            items: items.to_vec(),
        }
    }

    #[test]
    fn small_matrices_add_up_where_they_belong() {
        let rows = lists(&[0, 2, 4], &[0, 2, 1, 9]);
        let columns = lists(&[0, 3, 5], &[1, 0, 7, 1, 0]);
        let map = ScatterMap::new(&rows, &columns, 3, 2);
        assert_eq!(map.columns.start, [0, 2, 4, 6]);
        assert_eq!(map.columns.items, [0, 1, 0, 1, 0, 1]);
        assert_eq!(map.slots(0), [1, 0, 6, 5, 4, 6]);
        assert_eq!(map.slots(1), [3, 2, 6, 6]);
        let (by_column, places) = map.by_column(2);
        assert_eq!(by_column.of(1), [0, 1, 2]);
        assert_eq!(places[3..], [1, 3, 5]);
    }

    /// Two triangles with a common edge; vertex 4 is fixed.
    #[test]
    fn symmetric_matrices_keep_the_lower_triangle() {
        let triangles = lists(&[0, 3, 6], &[0, 1, 2, 2, 1, 4]);
        let map = SymmetricScatter::new(&triangles, 3);
        assert_eq!(map.pattern.col_ptr, [0, 3, 5, 6]);
        assert_eq!(map.pattern.row_idx, [0, 1, 2, 1, 2, 2]);
        assert_eq!(map.slots(0), [0, 1, 3, 2, 4, 5]);
        assert_eq!(map.slots(1), [5, 4, 3, 6, 6, 6]);
    }

    /// Reordered, each entry still goes to the place of its pair of unknowns.
    #[test]
    fn orders_permute_the_places() {
        let triangles = lists(&[0, 3, 6], &[0, 1, 2, 2, 1, 3]);
        let order = [3, 0, 2, 1];
        let map = ListGraph::new(&triangles, 4).scatter(&order);
        let new_of = |old: u32| order.iter().position(|&o| o == old).expect("in the order");
        for e in 0..2 {
            let members = triangles.of(e);
            let mut slots = map.slots(e).iter();
            for (i, &a) in members.iter().enumerate() {
                for &b in &members[..=i] {
                    let (row, column) = (new_of(a).max(new_of(b)), new_of(a).min(new_of(b)));
                    let at = *slots.next().expect("one for each pair") as usize;
                    assert_eq!(map.pattern.row_idx[at], row);
                    assert!(
                        (map.pattern.col_ptr[column]..map.pattern.col_ptr[column + 1])
                            .contains(&at)
                    );
                }
            }
        }
    }
}
