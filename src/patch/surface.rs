//! An editable triangulation: the patch between its first triangulation and the finished mesh.
//!
//! Triangle `t` has the half-edges `3 t`, `3 t + 1` and `3 t + 2`. Half-edge `h` runs from
//! `corner[h]` to the corner of the next half-edge; `apex` is the corner opposite to it:
//!
//! ```text
//!            apex(h) = corner[prev(h)]
//!              / \
//!    prev(h)  /   \  next(h)
//!            /     \
//!  from(h) --- h ---> to(h)
//!          <--- g ---           g = twin(h), in the neighbouring triangle; NONE on the rim
//! ```
//!
//! So `next` and `prev` are arithmetic, and only `twin` is stored. To visit the edges of a vertex
//! counter-clockwise, start at `out[v]` and go from `h` to `twin(prev(h))`. At a rim vertex
//! `out[v]` is the rim edge, so that the walk covers the whole fan before it ends at [`NONE`].

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::data::Patch;
use crate::mesh::DVec3;

/// The largest change of the wanted edge length, a length: the triangles of the next ring are 1.3 times as
/// large, or those of a finer patch than its rim that much smaller.
pub(super) const STEEPEST: f64 = 0.3;

/// Stands for "no half-edge": the other side of a rim edge.
pub(super) const NONE: u32 = u32::MAX;

/// Patches of fewer triangles fit into the cache in any order.
const MIN_REORDERED: usize = 4000;

/// Triangles with twin links. Half-edge `3 t + k` runs from corner `k` of triangle `t` to the next
/// one. The first `rim` vertices are those of the rim (or of several rims, one after the other), in
/// order, and never move; rim edges have no twin.
/// Removed triangles stay in the arrays with their corners set to [`NONE`].
#[derive(Clone, Debug)]
pub(super) struct Surface {
    pub points: Vec<DVec3>,
    /// Wanted edge length at each vertex.
    pub size: Vec<f64>,
    /// Rise of the wanted edge length with the distance from the rim, per length; 0 if it follows the
    /// rim alone.
    pub growth: f64,
    /// The wanted edge length at the rim over that far from it, at least 1.
    pub refinement: f64,
    pub corner: Vec<u32>,
    pub twin: Vec<u32>,
    /// An outgoing half-edge of each vertex; of a rim vertex the rim edge itself, so that turning
    /// counter-clockwise from it covers the fan. `NONE` for a removed vertex.
    pub out: Vec<u32>,
    pub valence: Vec<u32>,
    pub rim: usize,
}

#[inline]
pub(super) fn next(h: u32) -> u32 {
    if h % 3 == 2 { h - 2 } else { h + 1 }
}

#[inline]
pub(super) fn prev(h: u32) -> u32 {
    if h.is_multiple_of(3) { h + 2 } else { h - 1 }
}

impl Surface {
    /// Area of all triangles.
    pub fn area(&self) -> f64 {
        let triangles = (0..self.corner.len() as u32).step_by(3);
        let alive = triangles.filter(|&h| !self.is_dead(h));
        alive.map(|h| 0.5 * self.normal(h).length()).sum()
    }

    /// Links `triangles` (a disc whose boundary is `0 → 1 → … → rim−1 → 0`, or a sphere with
    /// several holes whose rims are numbered one after the other) over `points`.
    pub fn new(points: Vec<DVec3>, size: Vec<f64>, rim: usize, triangles: &[[u32; 3]]) -> Self {
        let n = points.len();
        let corner: Vec<u32> = triangles.iter().flatten().copied().collect();
        let mut s = Self {
            size,
            growth: 0.0,
            refinement: 1.0,
            twin: vec![NONE; corner.len()],
            out: vec![NONE; n],
            valence: vec![0; n],
            points,
            corner,
            rim,
        };
        s.link();
        s
    }

    /// Matches opposite half-edges by a counting sort over the smaller end.
    fn link(&mut self) {
        let n = self.points.len();
        let count = self.corner.len();
        let mut start = vec![0u32; n + 1];
        let low = |s: &Self, h: usize| s.corner[h].min(s.corner[next(h as u32) as usize]) as usize;
        for h in 0..count {
            start[low(self, h) + 1] += 1;
        }
        for v in 0..n {
            start[v + 1] += start[v];
        }
        let mut bucket = vec![0u32; count];
        let mut fill = start.clone();
        for h in 0..count {
            let slot = &mut fill[low(self, h)];
            bucket[*slot as usize] = h as u32;
            *slot += 1;
        }
        for v in 0..n {
            let group = &bucket[start[v] as usize..start[v + 1] as usize];
            for (i, &h) in group.iter().enumerate() {
                if self.twin[h as usize] != NONE {
                    continue;
                }
                let (a, b) = (self.from(h), self.to(h));
                for &g in &group[i + 1..] {
                    if self.from(g) == b && self.to(g) == a {
                        self.twin[h as usize] = g;
                        self.twin[g as usize] = h;
                        break;
                    }
                }
            }
        }
        self.index_edges();
    }

    /// Finds a half-edge for every vertex and counts its edges.
    fn index_edges(&mut self) {
        for h in 0..self.corner.len() as u32 {
            let v = self.from(h) as usize;
            let is_rim = self.twin[h as usize] == NONE;
            self.valence[v] += 1;
            if is_rim {
                // the rim edge that arrives at a vertex is an edge of it too
                let end = self.to(h) as usize;
                self.valence[end] += 1;
            }
            if is_rim || self.out[v] == NONE {
                self.out[v] = h;
            }
        }
    }

    /// Joins parts of the rim of a disc. Corner `i` of the rim becomes the vertex `name[i]` of
    /// `points`, all of which are rim vertices. The rim edges that start at the two corners of each
    /// of `bridges` become two sides of one edge.
    pub fn sew(&mut self, name: &[u32], points: Vec<DVec3>, bridges: &[[u32; 2]]) {
        for &[i, j] in bridges {
            let (h, g) = (self.out[i as usize], self.out[j as usize]);
            self.pair(h, g);
        }
        for corner in &mut self.corner {
            *corner = name[*corner as usize];
        }
        let n = points.len();
        self.points = points;
        self.size = vec![0.0; n];
        self.out = vec![NONE; n];
        self.valence = vec![0; n];
        self.rim = n;
        self.index_edges();
    }

    #[inline]
    pub fn from(&self, h: u32) -> u32 {
        self.corner[h as usize]
    }

    #[inline]
    pub fn to(&self, h: u32) -> u32 {
        self.corner[next(h) as usize]
    }

    /// The corner opposite the half-edge in its triangle.
    #[inline]
    pub fn apex(&self, h: u32) -> u32 {
        self.corner[prev(h) as usize]
    }

    #[inline]
    pub fn twin(&self, h: u32) -> u32 {
        self.twin[h as usize]
    }

    #[inline]
    pub fn is_rim(&self, v: u32) -> bool {
        (v as usize) < self.rim
    }

    #[inline]
    pub fn point(&self, v: u32) -> DVec3 {
        self.points[v as usize]
    }

    /// Squared edge length.
    #[inline]
    pub fn length2(&self, h: u32) -> f64 {
        self.point(self.from(h))
            .distance_squared(self.point(self.to(h)))
    }

    /// Whether the half-edge's triangle was removed.
    #[inline]
    pub fn is_dead(&self, h: u32) -> bool {
        self.corner[h as usize] == NONE
    }

    /// Calls `f` with the far end of every edge at `v`, counter-clockwise.
    #[inline]
    pub fn for_neighbours(&self, v: u32, mut f: impl FnMut(u32)) {
        let first = self.out[v as usize];
        let mut h = first;
        loop {
            f(self.to(h));
            let back = prev(h);
            let t = self.twin(back);
            if t == NONE {
                // the rim edge that arrives at v
                f(self.from(back));
                return;
            }
            h = t;
            if h == first {
                return;
            }
        }
    }

    /// Whether an edge joins `a` and `b`.
    pub fn joined(&self, a: u32, b: u32) -> bool {
        let mut found = false;
        self.for_neighbours(a, |w| found |= w == b);
        found
    }

    /// The interior half-edge from `a` to `b`, if an edge joins them.
    pub fn edge_between(&self, a: u32, b: u32) -> Option<u32> {
        let first = self.out[a as usize];
        let mut h = first;
        loop {
            if self.to(h) == b {
                return (self.twin(h) != NONE).then_some(h);
            }
            h = self.twin(prev(h));
            if h == NONE || h == first {
                return None;
            }
        }
    }

    /// Normal of the half-edge's triangle, twice its area long.
    #[inline]
    pub fn normal(&self, h: u32) -> DVec3 {
        let (a, b, c) = (
            self.point(self.from(h)),
            self.point(self.to(h)),
            self.point(self.apex(h)),
        );
        (b - a).cross(c - a)
    }

    /// Sum of the normals of the triangles at an interior vertex, each twice its area long.
    pub fn vertex_normal(&self, v: u32) -> DVec3 {
        let first = self.out[v as usize];
        let (mut h, mut sum) = (first, DVec3::ZERO);
        loop {
            sum += self.normal(h);
            h = self.twin(prev(h));
            if h == first || h == NONE {
                return sum;
            }
        }
    }

    fn pair(&mut self, a: u32, b: u32) {
        self.twin[a as usize] = b;
        if b != NONE {
            self.twin[b as usize] = a;
        }
    }

    /// Replaces the diagonal `h` of its quadrilateral by the other one. The caller has checked
    /// that the new edge does not exist yet.
    pub fn flip(&mut self, h: u32) {
        let g = self.twin(h);
        let (hn, hp, gn, gp) = (next(h), prev(h), next(g), prev(g));
        let (a, b, c, d) = (self.from(h), self.from(g), self.from(hp), self.from(gp));
        //      c                 c         before: h = a→b with apex c, g = b→a with apex d
        //  hp / \ hn         hn /|\ gp
        //    a-h-b     ->      a h|g b     after: (h, hn, hp) = (d→c, c→a, a→d)
        //  gn \ / gp         hp \|/ gn            (g, gn, gp) = (c→d, d→b, b→c)
        //      d                 d
        let (bc, ca, ad, db) = (self.twin(hn), self.twin(hp), self.twin(gn), self.twin(gp));
        self.corner[h as usize] = d;
        self.corner[hn as usize] = c;
        self.corner[hp as usize] = a;
        self.corner[g as usize] = c;
        self.corner[gn as usize] = d;
        self.corner[gp as usize] = b;
        self.pair(hn, ca);
        self.pair(hp, ad);
        self.pair(gn, db);
        self.pair(gp, bc);
        self.out[a as usize] = self.keep_rim_first(a, hp);
        self.out[b as usize] = self.keep_rim_first(b, gp);
        self.out[c as usize] = self.keep_rim_first(c, hn);
        self.out[d as usize] = self.keep_rim_first(d, gn);
        self.valence[a as usize] -= 1;
        self.valence[b as usize] -= 1;
        self.valence[c as usize] += 1;
        self.valence[d as usize] += 1;
    }

    /// The half-edge to store for `v`, given that `h` leaves it: the rim edge for rim vertices.
    fn keep_rim_first(&self, v: u32, h: u32) -> u32 {
        if !self.is_rim(v) || self.twin(h) == NONE {
            return h;
        }
        // clockwise until the rim edge
        let mut h = h;
        loop {
            let t = self.twin(h);
            if t == NONE {
                return h;
            }
            h = next(t);
        }
    }

    /// Splits the interior edge `h` at `point`; returns the new vertex.
    pub fn split(&mut self, h: u32, point: DVec3) -> u32 {
        let g = self.twin(h);
        let (hn, gp) = (next(h), prev(g));
        let (a, b, c, d) = (self.from(h), self.from(g), self.apex(h), self.apex(g));
        let m = self.points.len() as u32;
        self.points.push(point);
        self.size
            .push(f64::midpoint(self.size[a as usize], self.size[b as usize]));
        //      c
        //    / | \          h = a→m and g = m→a keep their triangles, (a, m, c) and (m, a, d);
        //   a--m--b         the halves at b are the new triangles (m, b, c) and (b, m, d)
        //    \ | /
        //      d
        let t = self.corner.len() as u32;
        self.corner.extend([m, b, c, b, m, d]);
        self.twin.extend([NONE; 6]);
        let (bc, db) = (self.twin(hn), self.twin(gp));
        self.corner[hn as usize] = m;
        self.corner[g as usize] = m;
        self.pair(t, t + 3);
        self.pair(t + 1, bc);
        self.pair(t + 2, hn);
        self.pair(t + 4, gp);
        self.pair(t + 5, db);
        self.pair(h, g);
        self.out.push(t);
        self.valence.push(4);
        self.valence[c as usize] += 1;
        self.valence[d as usize] += 1;
        self.out[b as usize] = self.keep_rim_first(b, t + 1);
        // d's rim edge may have been the second half of g's triangle
        self.out[d as usize] = self.keep_rim_first(d, t + 5);
        m
    }

    /// Whether the interior vertex at the start of `h` may be merged into its end without making
    /// the patch non-manifold or joining two rim vertices.
    pub fn may_collapse(&self, h: u32) -> bool {
        let (v, u) = (self.from(h), self.to(h));
        let g = self.twin(h);
        if self.is_rim(v) || g == NONE {
            return false;
        }
        let (c, d) = (self.apex(h), self.apex(g));
        if self.is_thin(c) || self.is_thin(d) {
            return false;
        }
        let mut fine = true;
        self.for_neighbours(v, |w| {
            if w == u || w == c || w == d {
                return;
            }
            fine &= !(self.is_rim(w) && self.is_rim(u) || self.joined(u, w));
        });
        fine
    }

    /// Whether losing one edge would leave the vertex without a proper fan.
    fn is_thin(&self, v: u32) -> bool {
        self.valence[v as usize] <= if self.is_rim(v) { 2 } else { 3 }
    }

    /// Merges the start of `h` into its end (see [`Self::may_collapse`]) and puts it at `point`.
    pub fn collapse(&mut self, h: u32, point: DVec3) {
        let g = self.twin(h);
        let (v, u, c, d) = (self.from(h), self.to(h), self.apex(h), self.apex(g));
        let (uc, cv) = (self.twin(next(h)), self.twin(prev(h)));
        let (vd, du) = (self.twin(next(g)), self.twin(prev(g)));
        // the triangles (v, u, c) and (u, v, d) vanish; every other corner v becomes u
        let mut e = h;
        loop {
            self.corner[e as usize] = u;
            e = self.twin(prev(e));
            if e == h {
                break;
            }
        }
        // the outer sides of the two vanishing triangles become twins; a rim edge stays one
        self.pair(cv, uc);
        self.pair(vd, du);
        for e in [h, next(h), prev(h), g, next(g), prev(g)] {
            self.corner[e as usize] = NONE;
            self.twin[e as usize] = NONE;
        }
        self.out[v as usize] = NONE;
        self.valence[u as usize] = self.valence[u as usize] + self.valence[v as usize] - 4;
        self.valence[c as usize] -= 1;
        self.valence[d as usize] -= 1;
        self.points[u as usize] = point;
        self.out[u as usize] = self.keep_rim_first(u, cv);
        self.out[d as usize] = self.keep_rim_first(d, vd);
        let leaves_c = if uc == NONE { next(cv) } else { uc };
        self.out[c as usize] = self.keep_rim_first(c, leaves_c);
    }

    /// Whether the wanted edge lengths depend on the distance from the rim.
    pub fn is_graded(&self) -> bool {
        self.growth > 0.0 || self.refinement > 1.0
    }

    /// Sets the wanted edge lengths of interior vertices. Without refinement they are the least that the
    /// rim allows along edges: `min (size(r) + growth · length of the path from r)` over rim vertices r.
    /// With refinement they shrink from that of the nearest rim vertex, and then grow again.
    pub fn grade(&mut self) {
        let (rim, count) = (self.rim, self.points.len());
        if self.refinement > 1.0 {
            // the edges of the rim stay whole, and much smaller triangles beside them would be thin
            for (v, (path, nearest)) in self.nearest_of_rim().into_iter().enumerate().skip(rim) {
                let coarse = self.size[nearest as usize];
                let fine = coarse / self.refinement + self.growth * path;
                self.size[v] = fine.max(coarse - STEEPEST * path);
            }
            // where places of different density meet
            self.limit_slope(self.growth.max(STEEPEST), count);
        } else {
            self.size[rim..].fill(f64::INFINITY);
            self.limit_slope(self.growth, rim);
        }
    }

    /// The length of the shortest path along edges from the rim to each vertex, and the rim vertex where
    /// it begins (Dijkstra).
    fn nearest_of_rim(&self) -> Vec<(f64, u32)> {
        let mut found = vec![(f64::INFINITY, 0); self.points.len()];
        let mut queue = BinaryHeap::new();
        for v in 0..self.rim as u32 {
            found[v as usize] = (0.0, v);
            queue.push(Reverse((0f64.to_bits(), v)));
        }
        while let Some(Reverse((bits, v))) = queue.pop() {
            let (path, nearest) = found[v as usize];
            if f64::from_bits(bits) > path {
                continue;
            }
            self.for_neighbours(v, |w| {
                let longer = path + self.point(v).distance(self.point(w));
                if longer < found[w as usize].0 {
                    found[w as usize] = (longer, nearest);
                    queue.push(Reverse((longer.to_bits(), w)));
                }
            });
        }
        found
    }

    /// Lowers the wanted edge lengths of interior vertices until none exceeds that of one of the first
    /// `sources` vertices by more than `slope` times the length of the path from it (Dijkstra).
    fn limit_slope(&mut self, slope: f64, sources: usize) {
        // lengths are not negative, so that their bits are ordered like them
        let key = |size: f64, v: u32| Reverse((size.to_bits(), v));
        let present = (0..sources as u32).filter(|&v| self.out[v as usize] != NONE);
        let mut queue: BinaryHeap<_> = present.map(|v| key(self.size[v as usize], v)).collect();
        let mut reached = Vec::new();
        while let Some(Reverse((bits, v))) = queue.pop() {
            let size = f64::from_bits(bits);
            if size > self.size[v as usize] {
                continue;
            }
            reached.clear();
            self.for_neighbours(v, |w| reached.push(w));
            for &w in &reached {
                let longer = size + slope * self.point(v).distance(self.point(w));
                if !self.is_rim(w) && longer < self.size[w as usize] {
                    self.size[w as usize] = longer;
                    queue.push(key(longer, w));
                }
            }
        }
    }

    /// Renumbers vertices and triangles breadth first from the rim's first edge, the rim keeping
    /// its numbers: neighbours end up near each other in memory, which halves the time of every
    /// pass over a large patch. Nothing may have been removed yet.
    pub fn reorder(&mut self) {
        let count = self.corner.len() / 3;
        if count < MIN_REORDERED {
            return;
        }
        let mut new_vertex = vec![NONE; self.points.len()];
        let mut order: Vec<u32> = (0..self.rim as u32).collect();
        for v in 0..self.rim {
            new_vertex[v] = v as u32;
        }
        let mut seen = vec![false; count];
        let mut queue = Vec::with_capacity(count);
        let first = self.out[0] / 3;
        queue.push(first);
        seen[first as usize] = true;
        let mut at = 0;
        while at < queue.len() {
            let t = queue[at];
            at += 1;
            for h in 3 * t..3 * t + 3 {
                let v = self.from(h) as usize;
                if new_vertex[v] == NONE {
                    new_vertex[v] = order.len() as u32;
                    order.push(v as u32);
                }
                let g = self.twin(h);
                if g != NONE && !std::mem::replace(&mut seen[g as usize / 3], true) {
                    queue.push(g / 3);
                }
            }
        }
        let mut new_triangle = vec![0; count];
        for (new, &old) in queue.iter().enumerate() {
            new_triangle[old as usize] = new as u32;
        }
        let new_halfedge = |h: u32| {
            if h == NONE {
                NONE
            } else {
                3 * new_triangle[h as usize / 3] + h % 3
            }
        };
        let old_halfedges = || queue.iter().flat_map(|&t| 3 * t..3 * t + 3);
        self.corner = old_halfedges()
            .map(|h| new_vertex[self.from(h) as usize])
            .collect();
        self.twin = old_halfedges()
            .map(|h| new_halfedge(self.twin(h)))
            .collect();
        self.out = order
            .iter()
            .map(|&v| new_halfedge(self.out[v as usize]))
            .collect();
        self.points = order.iter().map(|&v| self.points[v as usize]).collect();
        self.size = order.iter().map(|&v| self.size[v as usize]).collect();
        self.valence = order.iter().map(|&v| self.valence[v as usize]).collect();
    }

    /// The patch without the removed vertices and triangles.
    pub fn compact(self) -> Patch {
        let mut index = vec![NONE; self.points.len()];
        let mut points = Vec::with_capacity(self.points.len());
        for (v, &p) in self.points.iter().enumerate() {
            if self.out[v] != NONE {
                index[v] = points.len() as u32;
                points.push(p);
            }
        }
        let triangles = self
            .corner
            .chunks_exact(3)
            .filter(|t| t[0] != NONE)
            .map(|t| [0, 1, 2].map(|k| index[t[k] as usize]))
            .collect();
        Patch {
            rim: self.rim,
            points,
            triangles,
        }
    }
}

#[cfg(test)]
#[path = "surface_tests.rs"]
mod tests;
