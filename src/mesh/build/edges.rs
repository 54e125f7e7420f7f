//! Corners grouped by the undirected edge they start.

/// The corner-edge `3 f + k` runs from corner `k` of triangle `f` to the next one.
#[inline]
pub(super) fn ends(triangles: &[[u32; 3]], edge: u32) -> (u32, u32) {
    let t = &triangles[edge as usize / 3];
    let k = edge as usize % 3;
    (t[k], t[(k + 1) % 3])
}

/// The corner opposite to a corner-edge.
#[inline]
pub(super) fn opposite(triangles: &[[u32; 3]], edge: u32) -> u32 {
    triangles[edge as usize / 3][(edge as usize + 2) % 3]
}

/// The corner-edge after this one in its triangle.
#[inline]
pub(super) fn following(edge: u32) -> u32 {
    if edge % 3 == 2 { edge - 2 } else { edge + 1 }
}

/// Corner-edges sorted by the undirected edge, then by index.
pub(super) struct EdgeTable {
    sorted: Vec<u32>,
}

impl EdgeTable {
    /// Sorts the given corner-edges of `triangles`, whose corners are below `vertex_count`.
    pub fn new(
        triangles: &[[u32; 3]],
        vertex_count: usize,
        members: impl Iterator<Item = u32> + Clone,
    ) -> Self {
        let low = |c: u32| {
            let (a, b) = ends(triangles, c);
            a.min(b) as usize
        };
        let mut start = vec![0u32; vertex_count + 1];
        for c in members.clone() {
            start[low(c) + 1] += 1;
        }
        for v in 0..vertex_count {
            start[v + 1] += start[v];
        }
        let mut sorted = vec![0u32; start[vertex_count] as usize];
        let mut fill = start.clone();
        for c in members {
            let slot = &mut fill[low(c)];
            sorted[*slot as usize] = c;
            *slot += 1;
        }
        for v in 0..vertex_count {
            sorted[start[v] as usize..start[v + 1] as usize].sort_unstable_by_key(|&c| {
                let (a, b) = ends(triangles, c);
                (a.max(b), c)
            });
        }
        Self { sorted }
    }

    /// The corner-edges of each undirected edge.
    pub fn groups<'a>(&'a self, triangles: &'a [[u32; 3]]) -> impl Iterator<Item = &'a [u32]> + 'a {
        self.sorted.chunk_by(move |&c, &d| {
            let (a, b) = ends(triangles, c);
            (a, b) == ends(triangles, d) || (b, a) == ends(triangles, d)
        })
    }
}
