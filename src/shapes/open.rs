//! Surfaces with boundary: planes, graphs, cylinders, catenoids.

use std::f64::consts::TAU;

use super::TriangleMesh;
use super::relax::{jitter, relax};
use crate::mesh::DVec3;

/// A triangular lattice over `0..=columns` by `0..=rows`, odd rows shifted by half a column;
/// straight sides (`around` false) or closed to a ring.
fn lattice(
    columns: usize,
    rows: usize,
    around: bool,
    at: impl Fn(f64, f64) -> DVec3,
) -> TriangleMesh {
    let mut positions = Vec::new();
    let mut rows_of: Vec<Vec<u32>> = Vec::new();
    for r in 0..=rows {
        let odd = r % 2 == 1;
        let mut xs: Vec<f64> = if odd {
            (0..columns).map(|i| i as f64 + 0.5).collect()
        } else {
            (0..columns).map(|i| i as f64).collect()
        };
        if !around {
            if odd {
                xs.insert(0, 0.0);
            }
            xs.push(columns as f64);
        }
        let first = positions.len() as u32;
        positions.extend(xs.iter().map(|&x| at(x, r as f64)));
        let mut row: Vec<u32> = (first..positions.len() as u32).collect();
        if around {
            row.push(first);
        }
        rows_of.push(row);
    }
    let mut triangles = Vec::new();
    for r in 0..rows {
        let (even, odd, flip) = if r % 2 == 0 {
            (&rows_of[r], &rows_of[r + 1], false)
        } else {
            (&rows_of[r + 1], &rows_of[r], true)
        };
        let mut push = |a: u32, b: u32, c: u32| {
            triangles.push(if flip { [a, c, b] } else { [a, b, c] });
        };
        for i in 0..columns {
            if around {
                push(even[i], even[i + 1], odd[i]);
                push(even[i + 1], odd[i + 1], odd[i]);
            } else {
                push(even[i], odd[i + 1], odd[i]);
                push(even[i], even[i + 1], odd[i + 1]);
            }
        }
        if !around {
            push(even[columns], odd[columns + 1], odd[columns]);
        }
    }
    (positions, triangles)
}

/// Number of rows that makes the triangles of a lattice equilateral: `height` in columns.
#[allow(clippy::cast_sign_loss)] // clamped
fn rows_for(height: f64) -> usize {
    (height / 0.75_f64.sqrt()).round().max(1.0) as usize
}

/// Jitters and evens out the inside of a parameter surface; `project` is its nearest-height map.
fn irregular(mut shape: TriangleMesh, seed: u64, project: impl Fn(DVec3) -> DVec3) -> TriangleMesh {
    jitter(&mut shape, 0.45, seed, &project);
    relax(&mut shape, 2, &project);
    shape
}

/// The graph `z = f(x, y)` over the square of side `size` about the origin, `across` edges to a
/// side, normals up.
pub fn graph(size: f64, across: usize, f: impl Fn(f64, f64) -> f64, seed: u64) -> TriangleMesh {
    let across = across.max(2);
    let rows = rows_for(across as f64);
    let at = |x: f64, y: f64| {
        let x = size * (x / across as f64 - 0.5);
        let y = size * (y / rows as f64 - 0.5);
        DVec3::new(x, y, f(x, y))
    };
    let shape = lattice(across, rows, false, at);
    irregular(shape, seed, |p| DVec3::new(p.x, p.y, f(p.x, p.y)))
}

/// The square of side `size` about the origin in the plane z = 0, normals up.
pub fn plane(size: f64, across: usize, seed: u64) -> TriangleMesh {
    graph(size, across, |_, _| 0.0, seed)
}

/// A regular lattice closed to a ring of `around` edges, `height` edges high; `at` is given both
/// coordinates as fractions.
pub(super) fn tube_lattice(
    around: usize,
    height: f64,
    at: impl Fn(f64, f64) -> DVec3,
) -> TriangleMesh {
    let rows = rows_for(height);
    lattice(around, rows, true, |x, y| {
        at(x / around as f64, y / rows as f64)
    })
}

/// Side of a cylinder about the z axis, centred at the origin, open at both ends; `around` edges
/// to a turn.
pub fn cylinder(radius: f64, height: f64, around: usize, seed: u64) -> TriangleMesh {
    let around = around.max(3);
    let edge = TAU * radius / around as f64;
    let at = |x: f64, y: f64| {
        let (s, c) = (TAU * x).sin_cos();
        DVec3::new(radius * c, radius * s, height * (y - 0.5))
    };
    let shape = tube_lattice(around, height / edge, at);
    irregular(shape, seed, |p| {
        let scale = radius / p.x.hypot(p.y);
        DVec3::new(p.x * scale, p.y * scale, p.z)
    })
}

/// The catenoid `r = c cosh(z / c)` for |z| up to `half_height`, normals away from the axis;
/// `around` edges to a turn. The lattice is a conformal one: its edges grow with r.
pub fn catenoid(c: f64, half_height: f64, around: usize, seed: u64) -> TriangleMesh {
    let around = around.max(3);
    let at = |x: f64, y: f64| {
        let z = half_height * (2.0 * y - 1.0);
        let (sin, cos) = (TAU * x).sin_cos();
        let r = c * (z / c).cosh();
        DVec3::new(r * cos, r * sin, z)
    };
    let shape = tube_lattice(around, 2.0 * half_height / c * around as f64 / TAU, at);
    irregular(shape, seed, |p| {
        let scale = c * (p.z / c).cosh() / p.x.hypot(p.y);
        DVec3::new(p.x * scale, p.y * scale, p.z)
    })
}
