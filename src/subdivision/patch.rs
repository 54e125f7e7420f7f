//! The unrolled patch of a triangle and one step of Loop subdivision on it.

use super::masks::{BAND, EDGE_END, EDGE_OPPOSITE, EXACT_VALENCE, beta};

/// The control vertices of a triangle with given corner valences, in standard order, as abstract
/// indices: corners 0, 1, 2, then the outer ring. It does not record which of them coincide in a
/// particular mesh.
///
/// Of the ring of a corner of more than [`EXACT_VALENCE`] neighbours, the [`BAND`] next to the
/// triangle are control vertices, and the mean of the whole ring is one more, after the outer ring.
/// The band is treated as a closed ring where edges are subdivided; a point meets the seam, opposite
/// the triangle, only after more than `BAND / 2 - 2` steps towards the corner.
#[derive(Clone, Copy, Debug)]
pub(super) struct Patch {
    valences: [usize; 3],
    /// Neighbours of each corner that are control vertices.
    ring: [usize; 3],
    /// The mean of the neighbours of each corner, where it is a control vertex.
    mean: [Option<usize>; 3],
    /// Position in the outer ring of the first vertex after the two other corners, by corner.
    start: [usize; 3],
    /// Length of the outer ring.
    outer: usize,
}

/// Values and derivatives of one control vertex's basis function.
pub(super) type Row = [f64; 6];

impl Patch {
    /// The patch of a triangle with corner valences of at least 3.
    ///
    /// # Panics
    /// If a valence is less.
    pub(super) fn new(valences: [usize; 3]) -> Self {
        let ring = valences.map(ring_size);
        let [a, b, c] = ring;
        assert!(
            a >= 3 && b >= 3 && c >= 3,
            "a triangle with corner valences {valences:?} has no limit surface"
        );
        // the tetrahedron, where a single vertex is opposite all three edges
        let outer = (a + b + c - 9).max(1);
        let mut len = 3 + outer;
        let mean = valences.map(|n| {
            let column = (n > EXACT_VALENCE).then_some(len);
            len += usize::from(column.is_some());
            column
        });
        Self {
            valences,
            ring,
            mean,
            start: [b - 3 + c - 3, 0, b - 3],
            outer,
        }
    }

    /// Number of control vertices.
    pub(super) fn len(&self) -> usize {
        3 + self.outer + self.mean.iter().flatten().count()
    }

    /// Neighbour `j` (modulo the valence) of a corner, counter-clockwise, of which 0 and 1 are the
    /// following two corners.
    fn neighbour(&self, corner: usize, j: usize) -> usize {
        match j % self.ring[corner] {
            0 => (corner + 1) % 3,
            1 => (corner + 2) % 3,
            j => 3 + (self.start[corner] + j - 2) % self.outer,
        }
    }

    /// Adds `value` times the weights of a corner and of each of its neighbours.
    pub(super) fn add_star(
        &self,
        corner: usize,
        (centre, ring): (f64, f64),
        value: &Row,
        out: &mut [Row],
    ) {
        add(&mut out[corner], centre, value);
        if let Some(mean) = self.mean[corner] {
            return add(&mut out[mean], self.valences[corner] as f64 * ring, value);
        }
        for j in 0..self.valences[corner] {
            add(&mut out[self.neighbour(corner, j)], ring, value);
        }
    }

    /// Adds `value` times the weights of the new position of a corner.
    fn add_vertex(&self, corner: usize, value: &Row, out: &mut [Row]) {
        let n = self.valences[corner];
        let beta = beta(n);
        self.add_star(corner, (1.0 - n as f64 * beta, beta), value, out);
    }

    /// Adds `value` times the weights of the new vertex on the edge to neighbour `j` of a corner.
    fn add_edge(&self, corner: usize, j: usize, value: &Row, out: &mut [Row]) {
        let before = j + self.ring[corner] - 1;
        add(&mut out[corner], EDGE_END, value);
        add(&mut out[self.neighbour(corner, j)], EDGE_END, value);
        add(
            &mut out[self.neighbour(corner, before)],
            EDGE_OPPOSITE,
            value,
        );
        add(
            &mut out[self.neighbour(corner, j + 1)],
            EDGE_OPPOSITE,
            value,
        );
    }

    /// Adds to the rows of this patch those of its child at `corner`: the transposed subdivision
    /// matrix. The child's corners are the old corner, then the new vertices on the edges to the
    /// following and to the preceding corner; its valences are those of the corner, 6 and 6.
    pub(super) fn lift_corner(&self, corner: usize, child: &[Row], out: &mut [Row]) {
        let [c1, c2] = [(corner + 1) % 3, (corner + 2) % 3];
        let [n0, n1, n2] = [corner, c1, c2].map(|c| self.ring[c]);
        self.add_vertex(corner, &child[0], out);
        self.add_edge(corner, 0, &child[1], out);
        self.add_edge(corner, 1, &child[2], out);
        // around the new vertex of the edge (corner, c1), then of (c2, corner)
        self.add_edge(corner, n0 - 1, &child[3], out);
        self.add_edge(c1, 2, &child[4], out);
        self.add_vertex(c1, &child[5], out);
        self.add_edge(c1, 0, &child[6], out);
        self.add_vertex(c2, &child[7], out);
        self.add_edge(c2, n2 - 1, &child[8], out);
        // the other neighbours of the corner
        for j in 2..n0 - 1 {
            self.add_edge(corner, j, &child[7 + j], out);
        }
        let own = n0 + 6;
        if let Some(mean) = self.mean[corner] {
            // the mean over a ring of the rule for edges
            add(&mut out[corner], EDGE_END, &child[own]);
            add(&mut out[mean], EDGE_END + 2.0 * EDGE_OPPOSITE, &child[own]);
        }
        debug_assert_eq!(child.len(), own + usize::from(self.mean[corner].is_some()));
        debug_assert!(n1 >= 3);
    }

    /// Adds to the rows of this patch those of its middle child, a regular patch with the new
    /// vertices opposite the corners 0, 1, 2 as its corners.
    pub(super) fn lift_middle(&self, child: &[Row], out: &mut [Row]) {
        debug_assert_eq!(child.len(), 12);
        let last = self.ring.map(|n| n - 1);
        self.add_edge(1, 0, &child[0], out);
        self.add_edge(2, 0, &child[1], out);
        self.add_edge(0, 0, &child[2], out);
        self.add_vertex(2, &child[3], out);
        self.add_edge(2, last[2], &child[4], out);
        self.add_edge(0, 2, &child[5], out);
        self.add_vertex(0, &child[6], out);
        self.add_edge(0, last[0], &child[7], out);
        self.add_edge(1, 2, &child[8], out);
        self.add_vertex(1, &child[9], out);
        self.add_edge(1, last[1], &child[10], out);
        self.add_edge(2, 2, &child[11], out);
    }
}

/// Neighbours of a corner of a given valence that are control vertices.
pub(super) fn ring_size(valence: usize) -> usize {
    if valence > EXACT_VALENCE {
        BAND
    } else {
        valence
    }
}

fn add(out: &mut Row, weight: f64, value: &Row) {
    for (o, v) in out.iter_mut().zip(value) {
        *o += weight * v;
    }
}
