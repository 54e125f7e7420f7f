//! The bending of a triangulated surface, by which starting surfaces are compared.

use crate::mesh::{DVec3, bends};

/// Normals of neighbours that differ by more than this are a fold.
const FOLD: f64 = 2.4;

/// Twice the [bending](crate::mesh::bending) of a surface: on equilateral triangles it converges to `∫ 6 H² - 4 K`,
/// where the integral of K depends on the rims alone. Infinite if the surface is folded or has triangles
/// without area.
pub fn bending(points: &[DVec3], triangles: &[[u32; 3]]) -> f64 {
    let bends = bends(points, triangles);
    if bends
        .iter()
        .any(|bend| bend.angle > FOLD || bend.area <= 0.0)
    {
        return f64::INFINITY;
    }
    bends.iter().map(|bend| 1.5 * bend.cost()).sum()
}
