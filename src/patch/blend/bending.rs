//! The bending of a triangulated surface, by which starting surfaces are compared.

use crate::mesh::DVec3;

/// Normals of neighbours that differ by more than this are a fold.
const FOLD: f64 = 2.4;

/// Bending of a surface by the angles between its triangles: `3/2 Σ θ² |e|² / A` over the edges e
/// with angle θ between the normals of their two triangles, whose total area is A. On equilateral
/// triangles this converges to `∫ 6 H² - 4 K`, where the integral of K depends on the rims alone.
/// Infinite if the surface is folded or has triangles without area.
pub fn bending(points: &[DVec3], triangles: &[[u32; 3]]) -> f64 {
    let mut sides: Vec<([u32; 2], u32)> = Vec::with_capacity(3 * triangles.len());
    for (f, t) in triangles.iter().enumerate() {
        for k in 0..3 {
            let (a, b) = (t[k], t[(k + 1) % 3]);
            sides.push(([a.min(b), a.max(b)], f as u32));
        }
    }
    sides.sort_unstable();
    let normal = |f: u32| {
        let [a, b, c] = triangles[f as usize].map(|v| points[v as usize]);
        (b - a).cross(c - a)
    };
    let mut sum = 0.0;
    for pair in sides.windows(2).filter(|pair| pair[0].0 == pair[1].0) {
        let [a, b] = pair[0].0.map(|v| points[v as usize]);
        let (m, n) = (normal(pair[0].1), normal(pair[1].1));
        let angle = m.cross(n).length().atan2(m.dot(n));
        let area = 0.5 * (m.length() + n.length());
        if angle > FOLD || area <= 0.0 {
            return f64::INFINITY;
        }
        sum += 1.5 * angle * angle * a.distance_squared(b) / area;
    }
    sum
}
