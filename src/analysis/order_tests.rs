//! The orders of the errors of docs/accuracy.md.

use std::f64::consts::{PI, TAU};

use super::tests::{mesh, on_surface};
use super::*;
use crate::mesh::{DVec3, FaceId};
use crate::shapes::{TriangleMesh, icosphere};
use crate::subdivision::{Rule, elements};
use crate::surface::each_point;

/// Relative errors of area and `∫ H² dA` at three densities have the orders of docs/accuracy.md:
/// fourth on a regular grid, and lower at vertices of valence 5, where Loop's surfaces
/// cannot have the curvature of the approximated surface.
#[test]
fn integrals_have_their_orders() {
    let clifford = 2.0_f64.sqrt();
    let ball = |n: usize| closed(icosphere(n as u32), [4.0 * PI, 4.0 * PI]);
    let torus_exact = [4.0 * PI * PI * clifford, 2.0 * PI * PI];
    let ring = |n: usize| closed(grid_torus(6 * n, 4 * n), torus_exact);
    check_orders(&[3, 6, 12].map(ball), [2.2, 1.3]);
    check_orders(&[3, 6, 12].map(ring), [3.9, 3.9]);
}

/// Relative errors of the area and of `∫ H² dA`.
fn closed(shape: TriangleMesh, exact: [f64; 2]) -> [f64; 2] {
    let s = on_surface(&mesh(shape)).shape;
    [
        s.area / exact[0] - 1.0,
        s.energies.willmore / exact[1] - 1.0,
    ]
    .map(f64::abs)
}

/// Between successive rows of errors, each halving the edges, the orders are at `least` these.
fn check_orders<const N: usize>(errors: &[[f64; N]], least: [f64; N]) {
    for pair in errors.windows(2) {
        for i in 0..N {
            let order = (pair[0][i] / pair[1][i]).log2();
            assert!(order > least[i], "measure {i}: {order} of {errors:?}");
        }
    }
}

/// A regular grid on the torus of radii √2 and 1.
fn grid_torus(n: usize, m: usize) -> TriangleMesh {
    let r = |v: f64| 2.0_f64.sqrt() + v.cos();
    grid(n, m, true, |u, y| {
        let v = TAU * y;
        DVec3::new(r(v) * u.cos(), r(v) * u.sin(), v.sin())
    })
}

/// A regular grid of `n` by `m` squares, each cut in two, row by row; the rows are rings about an
/// axis, the columns closed or open; `point` is given the angle about the axis and the part of the
/// column, from 0 to 1.
fn grid(n: usize, m: usize, is_closed: bool, point: impl Fn(f64, f64) -> DVec3) -> TriangleMesh {
    let rows = if is_closed { m } else { m + 1 };
    let at = |i: usize, j: usize| ((j % rows) * n + i % n) as u32;
    let mut shape = (Vec::new(), Vec::new());
    for j in 0..rows {
        for i in 0..n {
            shape
                .0
                .push(point(TAU * i as f64 / n as f64, j as f64 / m as f64));
        }
    }
    for j in 0..m {
        for i in 0..n {
            shape.1.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
            shape.1.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
    }
    shape
}

/// A cylinder of radius 1 is regular up to its rims, for which the ghosts beyond are on it: fourth
/// order in the integrals, second in the curvature at a point, and no Gaussian curvature but by
/// rounding.
#[test]
fn a_cylinder_s_measures_have_their_orders() {
    let errors = [1, 2, 4].map(|k| {
        let tube = |u: f64, z: f64| DVec3::new(u.cos(), u.sin(), z);
        let found = Piece::measure(k, 0, tube, |_| [-0.5, 0.0]);
        // a difference of products of size 1 / h², h at least 0.06
        assert!(
            found.worst[1] < 1e-11 && found.total_curvature.abs() < 1e-10,
            "{found:?}"
        );
        [
            found.area / (4.0 * PI) - 1.0,
            found.willmore / PI - 1.0,
            found.worst[0],
        ]
        .map(f64::abs)
    });
    check_orders(&errors, [3.9, 3.9, 1.9]);
}

/// The catenoid `r = cosh z` on a conformal grid. Beyond its rims the ghosts go on straight, which
/// leaves curvatures wrong there by a constant; where the rims are far, in the middle half, the
/// orders are those of the cylinder.
#[test]
fn a_catenoid_s_measures_have_their_orders() {
    let inner = [2, 4, 8].map(|k| catenoid(k, 2 * k));
    check_orders(&inner, [3.9, 3.9, 1.9, 1.9, 1.9]);
    let whole = [1, 2, 4].map(|k| {
        let [area, gauss, root_mean, ..] = catenoid(k, 0);
        [area, gauss, root_mean]
    });
    check_orders(&whole, [2.9, 0.9, 0.5]);
}

/// Relative errors of the area and of `∫ K dA`, the root of the mean of `H²`, and the largest
/// errors of `H` and `K`, on `|z| ≤ 1` but for `skipped` rings at each end.
fn catenoid(k: usize, skipped: usize) -> [f64; 5] {
    let tube = |u: f64, z: f64| DVec3::new(z.cosh() * u.cos(), z.cosh() * u.sin(), z);
    let found = Piece::measure(k, skipped, tube, |x| [0.0, -x.z.cosh().powi(-4)]);
    let end = 1.0 - skipped as f64 / (4 * k) as f64;
    let (area, gauss) = (
        PI * (2.0 * end + (2.0 * end).sinh()),
        -4.0 * PI * end.tanh(),
    );
    let root_mean = (found.willmore / found.area).sqrt();
    let [h, k] = found.worst;
    let relative = [found.area / area, found.total_curvature / gauss].map(|q| (q - 1.0).abs());
    [relative[0], relative[1], root_mean, h, k]
}

/// Integrals over a tube, and the largest errors of `H` and `K`.
#[derive(Debug, Default)]
struct Piece {
    area: f64,
    willmore: f64,
    total_curvature: f64,
    worst: [f64; 2],
}

impl Piece {
    /// Of a tube of `8 k` rings of `24 k` squares over `|z| ≤ 1`, but for `skipped` rings at each
    /// end. `point` is given angle and `z`; `curvatures` are the true `H` and `K` at a place.
    fn measure(
        k: usize,
        skipped: usize,
        point: impl Fn(f64, f64) -> DVec3,
        curvatures: impl Fn(DVec3) -> [f64; 2],
    ) -> Self {
        let (around, rings) = (24 * k, 8 * k);
        let tube = mesh(grid(around, rings, false, |u, y| point(u, 2.0 * y - 1.0)));
        let control = control_points(&tube, Vertices::OnSurface);
        let chosen = 2 * around * skipped..2 * around * (rings - skipped);
        let faces: Vec<FaceId> = chosen.map(FaceId::from).collect();
        let rule = Rule::Twelve;
        let elements = elements(&tube.topology, &faces, rule);
        let mut sums = Self::default();
        for e in 0..elements.len() {
            each_point(&elements, e, &control, |x, p| {
                let area = rule.weight() * 0.5 * p.sqrt_g;
                sums.area += area;
                sums.willmore += area * p.mean * p.mean;
                sums.total_curvature += area * p.gauss;
                let [h, k] = curvatures(x);
                let errors = [p.mean - h, p.gauss - k];
                for (worst, error) in sums.worst.iter_mut().zip(errors) {
                    *worst = worst.max(error.abs());
                }
            });
        }
        sums
    }
}
