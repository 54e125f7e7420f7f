//! Polygons to triangles.

use crate::mesh::{DVec3, Soup};
use robust::{Coord, orient2d};

/// Triangles over the vertices of a file, with their polygons.
pub(super) struct Triangles {
    /// Corners: three different vertices each.
    pub corners: Vec<[u32; 3]>,
    /// The polygon of each triangle; empty if the numbers are equal.
    pub file_face: Option<Vec<u32>>,
    /// The place of each corner in the list of corners of the polygons; empty if the numbers are
    /// equal.
    pub file_corners: Option<Vec<[u32; 3]>>,
    /// Number of polygons with more than three corners.
    pub polygons: usize,
    /// Polygons with fewer than three different corners, which have no triangles.
    pub degenerate: Vec<u32>,
}

impl Triangles {
    /// Whether they are the polygons of the file, with the same corners.
    pub fn are_polygons(&self) -> bool {
        self.file_face.is_none() && self.file_corners.is_none()
    }

    /// The places of a triangle's corners in the list of corners of the polygons.
    pub fn file_corners(&self, triangle: usize) -> [u32; 3] {
        let t = triangle as u32;
        self.file_corners
            .as_ref()
            .map_or([3 * t, 3 * t + 1, 3 * t + 2], |of| of[triangle])
    }

    /// The polygon of a triangle.
    pub fn file_face(&self, triangle: usize) -> u32 {
        self.file_face
            .as_ref()
            .map_or(triangle as u32, |of| of[triangle])
    }
}

/// Above this many corners ears are clipped in order, not best first.
const BEST_EAR_LIMIT: usize = 2048;

/// Triangulates every polygon along diagonals.
pub(super) fn triangulate(soup: &Soup) -> Triangles {
    let plain = soup.corners.len() == 3 * soup.face_count()
        && soup
            .offsets
            .iter()
            .enumerate()
            .all(|(f, &o)| o as usize == 3 * f)
        && soup
            .corners
            .chunks_exact(3)
            .all(|t| different(t[0], t[1], t[2]));
    if plain {
        return Triangles {
            corners: soup
                .corners
                .chunks_exact(3)
                .map(|t| [t[0], t[1], t[2]])
                .collect(),
            file_face: None,
            file_corners: None,
            polygons: 0,
            degenerate: Vec::new(),
        };
    }
    let mut out = Triangles {
        corners: Vec::with_capacity(soup.corners.len()),
        file_face: None,
        file_corners: None,
        polygons: 0,
        degenerate: Vec::new(),
    };
    let mut file_corners = Vec::with_capacity(soup.corners.len());
    let mut file_face = Vec::with_capacity(soup.corners.len());
    // the corners of a polygon: places in the list of all corners
    let mut ring: Vec<u32> = Vec::new();
    let vertex = |corner: u32| soup.corners[corner as usize];
    let mut points = Vec::new();
    let mut local = Vec::new();
    for f in 0..soup.face_count() {
        ring.clear();
        ring.extend(soup.offsets[f]..soup.offsets[f + 1]);
        ring.dedup_by_key(|corner| vertex(*corner));
        while ring.len() > 1 && vertex(ring[0]) == vertex(ring[ring.len() - 1]) {
            ring.pop();
        }
        let before = out.corners.len();
        out.polygons += usize::from(ring.len() > 3);
        local.clear();
        if ring.len() == 3 {
            local.push([0, 1, 2]);
        } else if ring.len() > 3 {
            points.clear();
            points.extend(ring.iter().map(|&c| soup.positions[vertex(c) as usize]));
            cut_polygon(&points, &mut local);
        }
        for triangle in &local {
            let corners = triangle.map(|i| ring[i as usize]);
            let [a, b, c] = corners.map(vertex);
            if different(a, b, c) {
                out.corners.push([a, b, c]);
                file_corners.push(corners);
            }
        }
        if out.corners.len() == before {
            out.degenerate.push(f as u32);
        }
        file_face.resize(out.corners.len(), f as u32);
    }
    out.file_face = Some(file_face);
    out.file_corners = Some(file_corners);
    out
}

fn different(a: u32, b: u32, c: u32) -> bool {
    a != b && b != c && c != a
}

/// Appends the triangles of one polygon of at least four corners.
fn cut_polygon(points: &[DVec3], out: &mut Vec<[u32; 3]>) {
    let normal = newell(points);
    if points.len() == 4 {
        // Choose the better diagonal, which is also correct for a concave or non-planar
        // quadrilateral.
        let worst =
            |s: [[usize; 3]; 2]| quality(points, s[0], normal).min(quality(points, s[1], normal));
        let (one, other) = ([[0, 1, 2], [0, 2, 3]], [[1, 2, 3], [1, 3, 0]]);
        let cut = if worst(other) > worst(one) {
            other
        } else {
            one
        };
        out.extend(cut.map(|t| t.map(|i| i as u32)));
        return;
    }
    EarClipper::new(points, normal).run(out);
}

/// Twice the area vector of a polygon, planar or not.
fn newell(points: &[DVec3]) -> DVec3 {
    let origin = points[0];
    let mut sum = DVec3::ZERO;
    for i in 1..points.len() - 1 {
        sum += (points[i] - origin).cross(points[i + 1] - origin);
    }
    sum
}

/// Area along the polygon's normal over the sum of squared edges. It is scale-free, and negative
/// for the opposite orientation.
fn quality(points: &[DVec3], t: [usize; 3], normal: DVec3) -> f64 {
    let [a, b, c] = t.map(|i| points[i]);
    let area = (b - a).cross(c - a).dot(normal.normalize_or_zero());
    let squares = a.distance_squared(b) + b.distance_squared(c) + c.distance_squared(a);
    if squares > 0.0 { area / squares } else { 0.0 }
}

/// Ear clipping in the coordinate plane nearest to the polygon's own, with exact orientation.
struct EarClipper {
    flat: Vec<Coord<f64>>,
    next: Vec<usize>,
    prev: Vec<usize>,
    /// Scale-free size of the ear at each remaining corner.
    size: Vec<f64>,
    /// Non-convex corners. Only these can lie inside an ear.
    reflex: Vec<usize>,
}

impl EarClipper {
    fn new(points: &[DVec3], normal: DVec3) -> Self {
        let n = points.len();
        let along = normal.abs();
        let (axis, sign) = if along.x >= along.y && along.x >= along.z {
            (0, normal.x)
        } else if along.y >= along.z {
            (1, normal.y)
        } else {
            (2, normal.z)
        };
        let flat = points
            .iter()
            .map(|p| {
                let (x, y) = (p[(axis + 1) % 3], p[(axis + 2) % 3]);
                if sign < 0.0 {
                    Coord { x: y, y: x }
                } else {
                    Coord { x, y }
                }
            })
            .collect();
        let mut clipper = Self {
            flat,
            next: (0..n).map(|i| (i + 1) % n).collect(),
            prev: (0..n).map(|i| (i + n - 1) % n).collect(),
            size: vec![0.0; n],
            reflex: Vec::new(),
        };
        for i in 0..n {
            clipper.size[i] = clipper.measure(i);
        }
        clipper.reflex = (0..n).filter(|&i| clipper.size[i] <= 0.0).collect();
        clipper
    }

    fn measure(&self, i: usize) -> f64 {
        let [a, b, c] = [self.prev[i], i, self.next[i]].map(|k| self.flat[k]);
        let square = |p: Coord<f64>, q: Coord<f64>| (p.x - q.x).powi(2) + (p.y - q.y).powi(2);
        let squares = square(a, b) + square(b, c) + square(c, a);
        if squares > 0.0 {
            orient2d(a, b, c) / squares
        } else {
            0.0
        }
    }

    fn is_ear(&self, i: usize) -> bool {
        if self.size[i] <= 0.0 {
            return false;
        }
        let [a, b, c] = [self.prev[i], i, self.next[i]].map(|k| self.flat[k]);
        !self.reflex.iter().any(|&k| {
            let p = self.flat[k];
            p != a
                && p != b
                && p != c
                && orient2d(a, b, p) >= 0.0
                && orient2d(b, c, p) >= 0.0
                && orient2d(c, a, p) >= 0.0
        })
    }

    fn run(mut self, out: &mut Vec<[u32; 3]>) {
        let mut left = self.flat.len();
        let mut at = 0;
        while left > 3 {
            let ear = if self.flat.len() <= BEST_EAR_LIMIT {
                self.best_ear(at)
            } else {
                self.first_ear(at)
            };
            let (p, n) = (self.prev[ear], self.next[ear]);
            out.push([p as u32, ear as u32, n as u32]);
            self.next[p] = n;
            self.prev[n] = p;
            left -= 1;
            at = n;
            self.reflex.retain(|&k| k != ear);
            for k in [p, n] {
                self.size[k] = self.measure(k);
                if self.size[k] > 0.0 {
                    self.reflex.retain(|&r| r != k);
                }
            }
        }
        out.push([self.prev[at] as u32, at as u32, self.next[at] as u32]);
    }

    /// The largest valid ear, or the largest corner if the polygon intersects itself.
    fn best_ear(&self, at: usize) -> usize {
        let mut corners = Vec::new();
        let mut i = at;
        loop {
            corners.push(i);
            i = self.next[i];
            if i == at {
                break;
            }
        }
        let mut fallback = at;
        while !corners.is_empty() {
            let (slot, &corner) = corners
                .iter()
                .enumerate()
                .max_by(|x, y| self.size[*x.1].total_cmp(&self.size[*y.1]))
                .expect("not empty");
            if self.size[corner] > self.size[fallback] {
                fallback = corner;
            }
            if self.size[corner] <= 0.0 {
                break;
            }
            if self.is_ear(corner) {
                return corner;
            }
            corners.swap_remove(slot);
        }
        fallback
    }

    /// The first valid ear from `at` on.
    fn first_ear(&self, at: usize) -> usize {
        let mut i = at;
        loop {
            if self.is_ear(i) {
                return i;
            }
            i = self.next[i];
            if i == at {
                return at;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn one_polygon(points: &[[f64; 3]]) -> (Vec<[u32; 3]>, Vec<DVec3>) {
        let positions: Vec<_> = points.iter().map(|&p| DVec3::from(p)).collect();
        let soup = Soup {
            corners: (0..positions.len() as u32).collect(),
            offsets: vec![0, positions.len() as u32],
            positions,
            ..Soup::default()
        };
        (triangulate(&soup).corners, soup.positions)
    }

    /// Every triangle has the orientation of the polygon, and the areas add up to its area.
    fn assert_exact_cover(points: &[[f64; 3]]) {
        let (triangles, p) = one_polygon(points);
        assert_eq!(triangles.len(), points.len() - 2);
        let whole = newell(&p);
        let mut sum = 0.0;
        for t in triangles {
            let [a, b, c] = t.map(|v| p[v as usize]);
            let area = (b - a).cross(c - a).dot(whole.normalize());
            assert!(area > 0.0, "{t:?} is flipped");
            sum += area;
        }
        assert!((sum - whole.length()).abs() < 1e-12 * whole.length());
    }

    #[test]
    fn quadrilaterals() {
        assert_exact_cover(&[[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]]);
        // an arrow head, its notch at either diagonal
        assert_exact_cover(&[[0., 0., 1.], [2., -1., 1.], [0.5, 0., 1.], [2., 1., 1.]]);
        assert_exact_cover(&[[2., -1., 1.], [0.5, 0., 1.], [2., 1., 1.], [0., 0., 1.]]);
    }

    #[test]
    fn concave_polygons_in_any_plane() {
        let comb = [
            [0., 0.],
            [5., 0.],
            [5., 4.],
            [4., 4.],
            [4., 1.],
            [3., 1.],
            [3., 4.],
            [2., 4.],
            [2., 1.],
            [1., 1.],
            [1., 4.],
            [0., 4.],
        ];
        for turn in [false, true] {
            for axis in 0..3 {
                let mut points: Vec<[f64; 3]> = comb
                    .iter()
                    .map(|p| {
                        let mut q = [0.0; 3];
                        q[axis] = p[0];
                        q[(axis + 1) % 3] = p[1];
                        q[(axis + 2) % 3] = 0.25 * p[0] - 0.5 * p[1];
                        q
                    })
                    .collect();
                if turn {
                    points.reverse();
                }
                assert_exact_cover(&points);
            }
        }
    }

    #[test]
    fn many_corners_take_the_fast_way() {
        let n = BEST_EAR_LIMIT + 500;
        let star: Vec<[f64; 3]> = (0..n)
            .map(|i| {
                let (s, c) = (std::f64::consts::TAU * i as f64 / n as f64).sin_cos();
                let r = if i % 2 == 0 { 1.0 } else { 0.9 };
                [r * c, r * s, 0.0]
            })
            .collect();
        assert_exact_cover(&star);
    }

    #[test]
    fn hopeless_polygons_still_give_triangles() {
        let (bow, _) = one_polygon(&[
            [0., 0., 0.],
            [1., 1., 0.],
            [1., 0., 0.],
            [0., 1., 0.],
            [0.5, 2., 0.],
        ]);
        assert_eq!(bow.len(), 3);
        let (line, _) = one_polygon(&[
            [0., 0., 0.],
            [1., 0., 0.],
            [2., 0., 0.],
            [3., 0., 0.],
            [4., 0., 0.],
        ]);
        assert_eq!(line.len(), 3);
    }

    #[test]
    fn repeated_corners() {
        let soup = Soup {
            positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::new(1., 1., 0.)],
            corners: vec![0, 1, 1, 0, 1, 2, 2, 1, 3, 2, 1, 0, 1],
            offsets: vec![0, 3, 7, 10, 13],
            ..Soup::default()
        };
        let t = triangulate(&soup);
        assert_eq!(t.corners, [[0, 1, 2], [1, 3, 2]]);
        assert_eq!(t.degenerate, [0, 3]);
        assert_eq!(t.file_face, Some(vec![1, 2]));
        assert_eq!(t.file_corners, Some(vec![[3, 4, 5], [7, 8, 9]]));
    }
}
