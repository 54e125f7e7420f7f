//! Cubes, spheres, ellipsoids and tori.

use std::f64::consts::PI;

use rustc_hash::FxHashMap;

use super::TriangleMesh;
use super::implicit::implicit_surface;
use super::relax::{jitter, relax};
use crate::mesh::DVec3;

/// Cube with the corners (±1, ±1, ±1), regular: each side has `across`² squares of two triangles, which
/// gives 6 `across`² + 2 vertices.
pub fn cube(across: usize) -> TriangleMesh {
    let n = across.max(1);
    let mut positions = Vec::new();
    let mut triangles = Vec::new();
    let mut numbers: FxHashMap<[usize; 3], u32> = FxHashMap::default();
    let mut vertex = |place: [usize; 3]| {
        *numbers.entry(place).or_insert_with(|| {
            positions.push(DVec3::from_array(
                place.map(|i| 2.0 * i as f64 / n as f64 - 1.0),
            ));
            positions.len() as u32 - 1
        })
    };
    for (axis, side) in (0..3).flat_map(|axis| [(axis, 0), (axis, n)]) {
        for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
            // counterclockwise from the positive end of the axis
            let [a, b, c, d] = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)].map(|(i, j)| {
                let mut place = [0; 3];
                for (k, at) in [side, i, j].into_iter().enumerate() {
                    place[(axis + k) % 3] = at;
                }
                vertex(place)
            });
            triangles.extend(if side == n {
                [[a, b, c], [a, c, d]]
            } else {
                [[a, c, b], [a, d, c]]
            });
        }
    }
    (positions, triangles)
}

/// Geodesic sphere of radius 1: each edge of the icosahedron is divided into `frequency` parts,
/// which gives 10 f² + 2 vertices. Regular; the twelve corners come first.
pub fn icosphere(frequency: u32) -> TriangleMesh {
    let f = frequency.max(1);
    let (corners, faces) = icosahedron();
    let mut positions = corners.to_vec();
    // the inner points of an edge, counted from its smaller end
    let mut edge_start = [[0u32; 12]; 12];
    for face in faces {
        for k in 0..3 {
            let (p, q) = (face[k], face[(k + 1) % 3]);
            if p < q {
                edge_start[p][q] = positions.len() as u32;
                for i in 1..f {
                    positions.push(on_arc(corners[p], corners[q], i, f));
                }
            }
        }
    }
    let mut triangles = Vec::with_capacity(20 * (f * f) as usize);
    for face in faces {
        let on_edge = |p: usize, q: usize, i: u32| match i {
            0 => p as u32,
            i if i == f => q as u32,
            i if p < q => edge_start[p][q] + i - 1,
            i => edge_start[q][p] + f - i - 1,
        };
        let [a, b, c] = face;
        let mut row: Vec<u32> = vec![a as u32];
        for j in 1..=f {
            let (left, right) = (on_edge(a, b, j), on_edge(a, c, j));
            let mut below = vec![left];
            for i in 1..j {
                if j == f {
                    below.push(on_edge(b, c, i));
                } else {
                    below.push(positions.len() as u32);
                    let (l, r) = (positions[left as usize], positions[right as usize]);
                    positions.push(on_arc(l, r, i, j));
                }
            }
            below.push(right);
            for i in 0..j as usize {
                triangles.push([row[i], below[i], below[i + 1]]);
                if i + 1 < j as usize {
                    triangles.push([row[i], below[i + 1], row[i + 1]]);
                }
            }
            row = below;
        }
    }
    (positions, triangles)
}

/// The point at the fraction `i / n` of the great-circle arc from `p` to `q`.
fn on_arc(p: DVec3, q: DVec3, i: u32, n: u32) -> DVec3 {
    let angle = p.dot(q).clamp(-1.0, 1.0).acos();
    let t = f64::from(i) / f64::from(n);
    (p * ((1.0 - t) * angle).sin() + q * (t * angle).sin()).normalize()
}

fn icosahedron() -> ([DVec3; 12], [[usize; 3]; 20]) {
    let g = f64::midpoint(1.0, 5.0_f64.sqrt());
    let mut corners = [DVec3::ZERO; 12];
    for (k, corner) in corners.iter_mut().enumerate() {
        let a = if k % 2 == 0 { 1.0 } else { -1.0 };
        let b = if (k / 2) % 2 == 0 { g } else { -g };
        *corner = match k / 4 {
            0 => DVec3::new(a, b, 0.0),
            1 => DVec3::new(0.0, a, b),
            _ => DVec3::new(b, 0.0, a),
        }
        .normalize();
    }
    // faces are the triples at mutual edge distance, oriented outwards
    let mut faces = [[0; 3]; 20];
    let mut count = 0;
    let near = |p: usize, q: usize| corners[p].dot(corners[q]) > 0.4;
    for p in 0..12 {
        for q in p + 1..12 {
            for r in q + 1..12 {
                if near(p, q) && near(q, r) && near(p, r) {
                    let volume = corners[p].dot(corners[q].cross(corners[r]));
                    faces[count] = if volume > 0.0 { [p, q, r] } else { [p, r, q] };
                    count += 1;
                }
            }
        }
    }
    (corners, faces)
}

/// Irregular sphere of radius 1 with about `vertices` vertices (the nearest 10 f² + 2), valences
/// mostly 5 to 7.
pub fn sphere(vertices: usize, seed: u64) -> TriangleMesh {
    // the frequency whose 10 f² + 2 comes nearest: between f - ½ and f + ½
    let tenth = vertices.saturating_sub(2) / 10;
    let root = tenth.isqrt().max(1);
    let frequency = if tenth > root * (root + 1) {
        root + 1
    } else {
        root
    };
    let mut shape = icosphere(frequency as u32);
    jitter(&mut shape, 0.55, seed, DVec3::normalize);
    relax(&mut shape, 2, DVec3::normalize);
    shape
}

/// Ellipsoid `Σ (x_i / axes_i)² = 1` of even density with about `vertices` vertices.
pub fn ellipsoid(axes: [f64; 3], vertices: usize, seed: u64) -> TriangleMesh {
    let a = DVec3::from_array(axes);
    let field = |p: DVec3| {
        let q = p / a;
        let length = q.length();
        (length - 1.0, q / a / length.max(f64::MIN_POSITIVE))
    };
    // Thomsen's formula for the area, good to a percent
    let e = 1.6;
    let mean = ((a.x * a.y).powf(e) + (a.x * a.z).powf(e) + (a.y * a.z).powf(e)) / 3.0;
    let cell = cell_for(4.0 * PI * mean.powf(1.0 / e), vertices);
    implicit_surface(&field, -a - 2.1 * cell, a + 2.1 * cell, cell, seed)
}

/// Torus about the z axis of even density with about `vertices` vertices: tube of radius `minor`
/// around a circle of radius `major`.
pub fn torus(major: f64, minor: f64, vertices: usize, seed: u64) -> TriangleMesh {
    let field = |p: DVec3| {
        let rho = p.x.hypot(p.y).max(f64::MIN_POSITIVE);
        let centre = DVec3::new(p.x, p.y, 0.0) * (major / rho);
        let offset = p - centre;
        (offset.length() - minor, offset.normalize_or_zero())
    };
    let cell = cell_for(4.0 * PI * PI * major * minor, vertices);
    let reach = DVec3::new(major + minor, major + minor, minor) + 2.1 * cell;
    implicit_surface(&field, -reach, reach, cell, seed)
}

/// A surface meets 1.5 area / cell² cells, averaged over its directions.
fn cell_for(area: f64, vertices: usize) -> f64 {
    (1.5 * area / vertices.max(8) as f64).sqrt()
}
