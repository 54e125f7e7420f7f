//! Edge flips towards a Delaunay triangulation of the points on their surface.

use crate::mesh::DVec3;

const NONE: u32 = u32::MAX;

/// Triangles with their neighbours: corner `3 f + k` is opposite to the edge that `opposite` joins
/// to a corner of the face across, or to `NONE`.
struct Corners<'a> {
    vertex: &'a mut [[u32; 3]],
    opposite: Vec<u32>,
    valence: Vec<u32>,
}

const fn next(c: u32) -> u32 {
    if c % 3 == 2 { c - 2 } else { c + 1 }
}

const fn prev(c: u32) -> u32 {
    if c.is_multiple_of(3) { c + 2 } else { c - 1 }
}

impl Corners<'_> {
    fn at(&self, c: u32) -> u32 {
        self.vertex[c as usize / 3][c as usize % 3]
    }

    fn join(&mut self, c: u32, o: u32) {
        self.opposite[c as usize] = o;
        if o != NONE {
            self.opposite[o as usize] = c;
        }
    }

    /// Whether an edge joins the vertex of corner `c` to `w`; walks the fan both ways, for it may
    /// be open.
    fn is_joined(&self, c: u32, w: u32) -> bool {
        for turn in [next, prev] {
            let mut at = c;
            // no more rotations than there are faces around the vertex
            for _ in 0..=self.valence[self.at(c) as usize] {
                if self.at(next(at)) == w || self.at(prev(at)) == w {
                    return true;
                }
                let across = self.opposite[turn(at) as usize];
                if across == NONE {
                    break;
                }
                at = turn(across);
                if at == c {
                    return false;
                }
            }
        }
        false
    }

    /// Flips the edge opposite to corner `c`, so that it joins the two corners it separated.
    fn flip(&mut self, c: u32) {
        let o = self.opposite[c as usize];
        let (a, b, d, e) = (self.at(c), self.at(next(c)), self.at(prev(c)), self.at(o));
        let (da, be) = (
            self.opposite[next(c) as usize],
            self.opposite[next(o) as usize],
        );
        self.vertex[c as usize / 3][prev(c) as usize % 3] = e;
        self.vertex[o as usize / 3][prev(o) as usize % 3] = a;
        self.join(c, be);
        self.join(o, da);
        self.join(next(c), next(o));
        for (v, change) in [(a, 1), (e, 1), (b, -1), (d, -1)] {
            let valence = &mut self.valence[v as usize];
            *valence = valence.saturating_add_signed(change);
        }
    }
}

fn corners(vertex_count: usize, triangles: &mut [[u32; 3]]) -> Corners<'_> {
    let mut edges = Vec::with_capacity(3 * triangles.len());
    let mut valence = vec![0; vertex_count];
    for (f, t) in triangles.iter().enumerate() {
        for k in 0..3 {
            let (p, q) = (t[(k + 1) % 3], t[(k + 2) % 3]);
            edges.push((p.min(q), p.max(q), (3 * f + k) as u32));
            valence[t[k] as usize] += 1;
        }
    }
    edges.sort_unstable();
    let mut opposite = vec![NONE; 3 * triangles.len()];
    for pair in edges.windows(2) {
        if (pair[0].0, pair[0].1) == (pair[1].0, pair[1].1) {
            opposite[pair[0].2 as usize] = pair[1].2;
            opposite[pair[1].2 as usize] = pair[0].2;
        }
    }
    Corners {
        vertex: triangles,
        opposite,
        valence,
    }
}

/// Flips edges whose opposite angles sum to more than π, unless the flip would fold the surface or
/// duplicate an edge. Connectivity stays manifold; a fixed number of sweeps bounds the time.
pub fn delaunay_flips(positions: &[DVec3], triangles: &mut [[u32; 3]]) {
    let mut mesh = corners(positions.len(), triangles);
    for _ in 0..10 {
        let mut flips = 0;
        for c in 0..mesh.opposite.len() as u32 {
            if should_flip(&mesh, positions, c) {
                mesh.flip(c);
                flips += 1;
            }
        }
        if flips == 0 {
            break;
        }
    }
}

fn should_flip(mesh: &Corners<'_>, positions: &[DVec3], c: u32) -> bool {
    let o = mesh.opposite[c as usize];
    if o == NONE || o < c {
        return false;
    }
    let ids = [mesh.at(c), mesh.at(next(c)), mesh.at(prev(c)), mesh.at(o)];
    let [a, b, d, e] = ids.map(|v| positions[v as usize]);
    let (ab, ad, eb, ed) = (b - a, d - a, b - e, d - e);
    let (n, m) = (ab.cross(ad), ed.cross(eb));
    // sin(α + β) |..| < 0, with a margin against flipping back and forth
    let sum = n.length() * eb.dot(ed) + m.length() * ab.dot(ad);
    let scale = ab.length() * ad.length() * eb.length() * ed.length();
    if sum >= -1e-9 * scale {
        return false;
    }
    let (p, q) = ((b - a).cross(e - a), (e - a).cross(d - a));
    let normal = n.normalize_or_zero() + m.normalize_or_zero();
    let keeps_orientation = p.dot(normal) > 0.0 && q.dot(normal) > 0.0;
    let keeps_valence = mesh.valence[ids[1] as usize] > 4 && mesh.valence[ids[2] as usize] > 4;
    keeps_orientation && keeps_valence && !mesh.is_joined(c, ids[3])
}
