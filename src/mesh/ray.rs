//! Rays against the triangles of a hierarchy.

use super::{DVec3, DepthStack, Node, TriangleBvh};

/// The intersection of a ray with a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayHit {
    /// The triangle (of several at the same place, the lowest).
    pub face: u32,
    /// Place on the ray, in lengths of its direction.
    pub t: f64,
}

/// A line `origin + t · direction`.
struct Ray {
    origin: DVec3,
    direction: DVec3,
    inverse: DVec3,
    /// The axis along which the direction is longest, and the two others.
    axes: [usize; 3],
    /// Change of the other two coordinates per unit of the first.
    shear: [f64; 2],
}

impl TriangleBvh {
    /// The first triangle on `origin + t · direction` with `t` strictly between the ends of
    /// `within`, which may be infinite; both sides of a triangle count.
    ///
    /// Neighbouring triangles use the same exact test for their common edge and corners, so no ray
    /// passes between them.
    pub fn first_hit(&self, origin: DVec3, direction: DVec3, within: [f64; 2]) -> Option<RayHit> {
        let ray = Ray::new(origin, direction);
        let [start, mut end] = within;
        let mut best: Option<RayHit> = None;
        let mut stack = DepthStack::default();
        if let Some(t) = self.nodes.first().and_then(|n| ray.enters(n, start, end)) {
            stack.push((0, t));
        }
        while let Some((index, entry)) = stack.pop() {
            if entry > end {
                continue;
            }
            let node = &self.nodes[index as usize];
            if node.count == 0 {
                let child = |i: u32| {
                    let entry = ray.enters(&self.nodes[i as usize], start, end);
                    entry.map(|t| (i, t))
                };
                match (child(index + 1), child(node.first)) {
                    (Some(a), Some(b)) => {
                        let (near, far) = if b.1 < a.1 { (b, a) } else { (a, b) };
                        stack.push(far);
                        stack.push(near);
                    }
                    (Some(one), None) | (None, Some(one)) => stack.push(one),
                    (None, None) => {}
                }
                continue;
            }
            for slot in node.first as usize..(node.first + node.count) as usize {
                let Some(t) = ray.meets(self.corners[slot]) else {
                    continue;
                };
                let face = self.faces[slot];
                let wins = t < end || (t == end && best.is_some_and(|b| face < b.face));
                if t > start && wins {
                    end = t;
                    best = Some(RayHit { face, t });
                }
            }
        }
        best
    }
}

impl Ray {
    fn new(origin: DVec3, direction: DVec3) -> Self {
        let size = direction.abs();
        let z = if size.x >= size.y && size.x >= size.z {
            0
        } else if size.y >= size.z {
            1
        } else {
            2
        };
        let axes = [z, (z + 1) % 3, (z + 2) % 3];
        Self {
            origin,
            direction,
            inverse: direction.recip(),
            axes,
            shear: [1, 2].map(|k| direction[axes[k]] / direction[z]),
        }
    }

    /// Where the ray enters a box, if it meets it between `start` and `end`.
    fn enters(&self, node: &Node, start: f64, end: f64) -> Option<f64> {
        let (mut near, mut far) = (start, end);
        for k in 0..3 {
            if self.direction[k] == 0.0 {
                // 0 · ∞ in the plane of a side is undefined
                if self.origin[k] < node.low[k] || self.origin[k] > node.high[k] {
                    return None;
                }
                continue;
            }
            let a = (node.low[k] - self.origin[k]) * self.inverse[k];
            let b = (node.high[k] - self.origin[k]) * self.inverse[k];
            near = near.max(a.min(b));
            far = far.min(a.max(b));
        }
        // rounding of the sides must not lose a triangle that lies in one
        let slack = 1e-12 * (near.abs() + far.abs()).min(f64::MAX);
        let slack = if slack.is_finite() { slack } else { 0.0 };
        (near <= far + slack).then_some(near - slack)
    }

    /// Where the ray meets a triangle.
    ///
    /// Sheared so that the ray is the first axis (Woop, Benthin and Wald, Watertight Ray/Triangle
    /// Intersection, 2013); the signs are exact for the sheared corners, which neighbours share.
    fn meets(&self, corners: [DVec3; 3]) -> Option<f64> {
        let [z, x, y] = self.axes;
        let relative = corners.map(|p| p - self.origin);
        let [a, b, c] = relative.map(|p| robust::Coord {
            x: p[x] - self.shear[0] * p[z],
            y: p[y] - self.shear[1] * p[z],
        });
        let ray = robust::Coord { x: 0.0, y: 0.0 };
        let u = robust::orient2d(b, c, ray);
        let v = robust::orient2d(c, a, ray);
        let w = robust::orient2d(a, b, ray);
        let inside = (u >= 0.0 && v >= 0.0 && w >= 0.0) || (u <= 0.0 && v <= 0.0 && w <= 0.0);
        let area = u + v + w;
        if !inside || area == 0.0 {
            return None;
        }
        let [az, bz, cz] = relative.map(|p| p[z]);
        Some((u * az + v * bz + w * cz) / (area * self.direction[z]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::SplitMix;
    use crate::shapes;

    #[test]
    fn hits_agree_with_all_triangles() {
        let (positions, triangles) = shapes::torus(2.0, 0.7, 800, 3);
        let bvh = TriangleBvh::new(&positions, &triangles);
        let mut random = SplitMix::new(5);
        let mut hits = 0;
        for _ in 0..300 {
            let origin = random.direction() * random.range(0.0, 4.0);
            let ray = Ray::new(origin, random.direction());
            let expected = triangles
                .iter()
                .filter_map(|t| ray.meets(t.map(|v| positions[v as usize])))
                .filter(|&t| t > 0.0)
                .fold(f64::INFINITY, f64::min);
            let found = bvh.first_hit(ray.origin, ray.direction, [0.0, f64::INFINITY]);
            assert_eq!(found.map_or(f64::INFINITY, |h| h.t), expected);
            hits += usize::from(found.is_some());
        }
        assert!((80..290).contains(&hits), "{hits}");
    }

    #[test]
    fn no_ray_slips_through_between_neighbours() {
        // from the centre to vertices, points on edges, and along the axes
        let (positions, triangles) = shapes::icosphere(4);
        let bvh = TriangleBvh::new(&positions, &triangles);
        let onto = |p: DVec3| bvh.first_hit(DVec3::ZERO, p, [0.0, f64::INFINITY]);
        for t in &triangles {
            let [a, b, _] = t.map(|v| positions[v as usize]);
            for s in [0.0, 0.25, 0.5, 0.7] {
                let p = a + s * (b - a);
                let hit = onto(p).expect("the sphere is closed");
                assert!((hit.t - 1.0).abs() < 1e-12);
            }
        }
        for axis in [DVec3::X, DVec3::NEG_Y, DVec3::Z] {
            assert!(onto(axis).is_some());
        }
    }

    #[test]
    fn ends_are_respected() {
        let (positions, triangles) = shapes::icosphere(3);
        let bvh = TriangleBvh::new(&positions, &triangles);
        let eye = DVec3::new(0.02, 0.03, 5.0);
        let hit = |within| bvh.first_hit(eye, DVec3::NEG_Z, within).map(|h| h.t);
        let all = [f64::NEG_INFINITY, f64::INFINITY];
        let near = hit(all).expect("through the sphere");
        assert!((3.9..4.2).contains(&near));
        assert_eq!(hit([near, near + 1.0]), None);
        let far = hit([near, f64::INFINITY]).expect("the other side");
        assert!((5.8..6.1).contains(&far));
        assert_eq!(hit([far, f64::INFINITY]), None);
        let none = TriangleBvh::new(&positions, &[]);
        assert_eq!(none.first_hit(eye, DVec3::NEG_Z, all), None);
    }
}
