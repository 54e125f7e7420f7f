//! Triangulation of a rim without new vertices.

use super::data::Rim;
use super::planar::constrained_delaunay;
use crate::cancel::is_cancelled;
use crate::mesh::DVec3;

/// Loops of up to this many edges get the minimum-weight triangulation at once: it takes less than
/// 0.2 ms and avoids existing faces, which matters for narrow holes with few new vertices.
const SMALL: usize = 40;
/// Loops of up to this many edges get the minimum-weight triangulation if they have no simple
/// projection (8 ms).
const AFFORDABLE: usize = 150;
/// Minimum perimeter of a projection, relative to the loop's.
const MIN_LENGTH: f64 = 0.7;

/// A triangulation of the rim without new vertices; triangles contain the edges `i → i + 1`.
///
/// By size and shape: [`flattest`] for small loops; the constrained Delaunay triangulation
/// of a simple projection, O(n log n); [`flattest`] for other loops while it is affordable;
/// beyond that the loop is cut in two by its best chord ([`best_chord`], O(n²) at the first cut,
/// 30 ms for 5,000 edges) and the parts are treated the same way.
pub(super) fn triangulate(rim: &Rim) -> Vec<[u32; 3]> {
    let n = rim.points.len();
    if n <= SMALL {
        return flattest(rim);
    }
    let mut triangles = Vec::with_capacity(n - 2);
    let mut forbidden: Vec<[u32; 2]> = rim.forbidden.clone();
    forbidden.sort_unstable();
    let mut parts: Vec<Vec<u32>> = vec![(0..n as u32).collect()];
    while let Some(part) = parts.pop() {
        let points: Vec<DVec3> = part.iter().map(|&v| rim.points[v as usize]).collect();
        let local = if part.len() > SMALL {
            constrained_delaunay(&points, MIN_LENGTH)
        } else {
            None
        };
        let affordable = part.len() <= AFFORDABLE;
        let local = match local {
            Some(t) if !affordable || !folds_back(rim, &part, &t) => t,
            _ if affordable => flattest(&sub_rim(rim, &part, points)),
            _ => {
                let [i, j] = best_chord(&points, &part, &forbidden);
                let mut rest = part[..=i].to_vec();
                rest.extend(&part[j..]);
                parts.push(rest);
                parts.push(part[i..=j].to_vec());
                continue;
            }
        };
        triangles.extend(local.iter().map(|t| t.map(|k| part[k as usize])));
    }
    triangles
}

/// Whether a triangle lies back to back with the existing face at a rim edge. This occurs where a
/// loose triangle of the mesh stands up from an otherwise flat projection.
fn folds_back(rim: &Rim, part: &[u32], triangles: &[[u32; 3]]) -> bool {
    let n = rim.points.len();
    triangles.iter().any(|t| {
        let corners = t.map(|k| part[k as usize] as usize);
        let [a, b, c] = corners.map(|v| rim.points[v]);
        let normal = (b - a).cross(c - a).normalize_or_zero();
        (0..3).any(|k| {
            let (i, j) = (corners[k], corners[(k + 1) % 3]);
            (i + 1) % n == j && bend(normal, existing_normal(rim, i)) < BACK_TO_BACK
        })
    })
}

/// Cosine of the dihedral angle beyond which two faces count as back to back (105°; the missing
/// cap of a sphere up to a hemisphere stays below 90°).
const BACK_TO_BACK: f64 = -0.26;

/// The part of a rim between chords. An edge that is a chord has no existing face yet.
fn sub_rim(rim: &Rim, part: &[u32], points: Vec<DVec3>) -> Rim {
    let n = rim.points.len();
    let opposite = (0..part.len())
        .map(|k| {
            let (i, j) = (part[k] as usize, part[(k + 1) % part.len()] as usize);
            if (i + 1) % n == j {
                rim.opposite[i]
            } else {
                // on the edge: a degenerate face, which has no influence
                rim.points[i]
            }
        })
        .collect();
    let mut index = vec![u32::MAX; n];
    for (k, &v) in part.iter().enumerate() {
        index[v as usize] = k as u32;
    }
    let forbidden = rim
        .forbidden
        .iter()
        .map(|pair| pair.map(|v| index[v as usize]))
        .filter(|pair| pair[1] != u32::MAX && pair[0] != u32::MAX)
        .collect();
    Rim {
        points,
        opposite,
        forbidden,
    }
}

/// The chord (i < j) that cuts the loop best: shortest against the rim's length between its ends,
/// among those that leave at least a sixth of the vertices on either side and are not forbidden.
fn best_chord(points: &[DVec3], part: &[u32], forbidden: &[[u32; 2]]) -> [usize; 2] {
    let n = points.len();
    let mut along = vec![0.0; n + 1];
    for i in 0..n {
        along[i + 1] = along[i] + points[i].distance(points[(i + 1) % n]);
    }
    let least = n / 6;
    let mut best = [0, n / 2];
    let mut best_ratio = f64::INFINITY;
    for i in 0..n - least {
        for j in i + least..n.min(i + n - least + 1) {
            let between = along[j] - along[i];
            let shorter = between.min(along[n] - between);
            let ratio = points[i].distance_squared(points[j]) / (shorter * shorter);
            if ratio < best_ratio && forbidden.binary_search(&[part[i], part[j]]).is_err() {
                best_ratio = ratio;
                best = [i, j];
            }
        }
    }
    best
}

/// Weight of a triangulated stretch of the rim: its faults, then the worst dihedral angle among the
/// others, as the cosine between neighbouring face normals (1 flat) in whole steps, then its area.
#[derive(Clone, Copy)]
struct Weight {
    /// Number of excluded triangles and, if they are counted, of folded edges, and [`FORBIDDEN`] for each
    /// chord that the mesh has.
    faults: u32,
    /// Larger is flatter.
    flatness: i32,
    area: f64,
}

impl Weight {
    fn is_better_than(&self, other: &Self) -> bool {
        let ranks = |w: &Self| (w.faults, -w.flatness);
        ranks(self) < ranks(other) || ranks(self) == ranks(other) && self.area < other.area
    }

    /// With another dihedral angle; those with a cosine below `folded`, in steps, are faults.
    fn bent(mut self, cosine: f64, folded: i32) -> Self {
        let flatness = quantised(cosine);
        if flatness < folded {
            self.faults += 1;
        } else {
            self.flatness = self.flatness.min(flatness);
        }
        self
    }
}

/// Cosines are compared in steps of 1/STEPS, so that rounding does not decide between
/// triangulations of a flat loop; a step at 0° is an angle of 2.5°.
const STEPS: f64 = 1024.0;
/// The cosine of 150° in such steps.
const FOLDED: i32 = -886;
const FORBIDDEN: u32 = 1 << 20;
/// Stands for the normal of a degenerate existing face.
const NO_NORMAL: DVec3 = DVec3::splat(2.0);
/// The flatness of a triangle that has no neighbour yet.
const FLAT: i32 = 1024;

fn quantised(cosine: f64) -> i32 {
    (cosine * STEPS).floor() as i32
}

/// The triangulation of the rim without new vertices whose worst dihedral angle is least.
fn flattest(rim: &Rim) -> Vec<[u32; 3]> {
    minimum_weight(rim, i32::MIN, &|_| false)
}

/// The triangulation of the rim without new vertices with the fewest excluded triangles and folded
/// edges, those of the rim included.
pub(super) fn soundest(rim: &Rim, excluded: &impl Fn([u32; 3]) -> bool) -> Vec<[u32; 3]> {
    minimum_weight(rim, FOLDED, excluded)
}

/// The triangulation of the rim without new vertices that has the fewest faults, whose worst dihedral
/// angle, the one with the existing faces included, is least, and whose area is least among those
/// (P. Liepa, "Filling holes in meshes", SGP 2003; the recursion is that of G. Barequet and
/// M. Sharir, 1995). Faults are forbidden chords, triangles that are `excluded`, and dihedral angles
/// with a cosine below `folded`, in steps of 1/[`STEPS`].
///
/// Cubic time, quadratic memory: 3 ms for 108 edges. Triangles contain the edges `i → i + 1`.
fn minimum_weight(rim: &Rim, folded: i32, excluded: &impl Fn([u32; 3]) -> bool) -> Vec<[u32; 3]> {
    let n = rim.points.len();
    if n == 3 {
        return vec![[0, 1, 2]];
    }
    let p = &rim.points;
    // Entry [i n + j], i < j: the stretch i..j closed by the chord (i, j); `column` is the same
    // transposed, so that both operands of the inner loop are contiguous.
    let empty = Weight {
        faults: 0,
        flatness: FLAT,
        area: 0.0,
    };
    let mut row = vec![empty; n * n];
    let mut column = vec![empty; n * n];
    let mut row_normal = vec![DVec3::ZERO; n * n];
    let mut column_normal = vec![DVec3::ZERO; n * n];
    let mut split = vec![0u32; n * n];
    for i in 0..n - 1 {
        let normal = existing_normal(rim, i);
        row_normal[i * n + i + 1] = normal;
        column_normal[(i + 1) * n + i] = normal;
    }
    let closing = existing_normal(rim, n - 1);
    let mut forbidden = vec![false; n * n];
    for &[i, j] in &rim.forbidden {
        forbidden[i as usize * n + j as usize] = true;
    }

    for j in 2..n {
        if is_cancelled() {
            return (1..n as u32 - 1).map(|k| [0, k, k + 1]).collect();
        }
        for i in (0..j - 1).rev() {
            let is_root = i == 0 && j == n - 1;
            let base = p[j] - p[i];
            let mut best = Weight {
                faults: u32::MAX,
                flatness: FLAT,
                area: f64::INFINITY,
            };
            let mut best_normal = DVec3::ZERO;
            let mut best_k = i + 1;
            let left = &row[i * n..(i + 1) * n];
            let right = &column[j * n..(j + 1) * n];
            let left_normal = &row_normal[i * n..(i + 1) * n];
            let right_normal = &column_normal[j * n..(j + 1) * n];
            for k in i + 1..j {
                let mut weight = Weight {
                    faults: left[k].faults + right[k].faults,
                    flatness: left[k].flatness.min(right[k].flatness),
                    area: left[k].area + right[k].area,
                };
                if !weight.is_better_than(&best) {
                    continue;
                }
                let cross = (p[k] - p[i]).cross(base);
                let double = cross.length();
                weight.area += 0.5 * double;
                let normal = if double > 0.0 {
                    cross / double
                } else {
                    DVec3::ZERO
                };
                weight = weight.bent(bend(normal, left_normal[k]), folded);
                weight = weight.bent(bend(normal, right_normal[k]), folded);
                if is_root {
                    weight = weight.bent(bend(normal, closing), folded);
                }
                if weight.is_better_than(&best) && excluded([i, k, j].map(|v| v as u32)) {
                    weight.faults += 1;
                }
                if weight.is_better_than(&best) {
                    best = weight;
                    best_normal = normal;
                    best_k = k;
                }
            }
            if forbidden[i * n + j] {
                best.faults += FORBIDDEN;
            }
            row[i * n + j] = best;
            column[j * n + i] = best;
            row_normal[i * n + j] = best_normal;
            column_normal[j * n + i] = best_normal;
            split[i * n + j] = best_k as u32;
        }
    }
    collect(&split, n)
}

/// Cosine between two unit normals. A degenerate triangle (normal zero) counts as folded, so that
/// it is used only where nothing else is left; a degenerate existing face (no normal) as flat.
fn bend(normal: DVec3, other: DVec3) -> f64 {
    if other.x > 1.0 {
        1.0
    } else if normal == DVec3::ZERO || other == DVec3::ZERO {
        -1.0
    } else {
        normal.dot(other)
    }
}

/// Unit normal of the existing face at rim edge `i`, or [`NO_NORMAL`] if it is degenerate.
fn existing_normal(rim: &Rim, i: usize) -> DVec3 {
    let a = rim.points[i];
    let b = rim.points[(i + 1) % rim.points.len()];
    // the face contains the edge b → a
    (a - b)
        .cross(rim.opposite[i] - b)
        .try_normalize()
        .unwrap_or(NO_NORMAL)
}

/// Reads the triangles off the table of best splits, with an explicit stack.
fn collect(split: &[u32], n: usize) -> Vec<[u32; 3]> {
    let mut triangles = Vec::with_capacity(n - 2);
    let mut stack = vec![(0usize, n - 1)];
    while let Some((i, j)) = stack.pop() {
        if j - i < 2 {
            continue;
        }
        let k = split[i * n + j] as usize;
        triangles.push([i as u32, k as u32, j as u32]);
        stack.push((k, j));
        stack.push((i, k));
    }
    triangles
}
