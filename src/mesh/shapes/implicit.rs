//! Closed surfaces from implicit functions, by surface nets.

use super::Shape;
use super::relax::{jitter, relax};
use crate::mesh::DVec3;

const NONE: u32 = u32::MAX;

/// The surface where `field` vanishes within the box `low..=high`.
///
/// `field` gives the value, negative inside, and its gradient (which may be approximate; Newton's
/// method towards the surface uses it). Triangles have edges of about `cell` units (0.9 on the
/// average). The surface must keep away from the box's sides by a cell, and its features must be some cells
/// wide or the mesh is not manifold. Surface nets (Gibson 1998), then sweeps that even it out.
pub fn implicit_surface(
    field: &impl Fn(DVec3) -> (f64, DVec3),
    low: DVec3,
    high: DVec3,
    cell: f64,
    seed: u64,
) -> Shape {
    let mut shape = surface_net(field, low, high, cell);
    let project = |p| project(field, p, 1);
    jitter(&mut shape, 0.2, seed, project);
    relax(&mut shape, 8, project);
    for p in &mut shape.0 {
        *p = self::project(field, *p, 8);
    }
    shape
}

/// Number of samples, ends included, that cover `cells` cells.
#[allow(clippy::cast_sign_loss)] // clamped
fn points_along(cells: f64) -> usize {
    cells.ceil().max(1.0) as usize + 1
}

/// Newton's method along the gradient.
fn project(field: &impl Fn(DVec3) -> (f64, DVec3), mut p: DVec3, steps: usize) -> DVec3 {
    for _ in 0..steps {
        let (value, gradient) = field(p);
        let square = gradient.length_squared();
        if value == 0.0 || square == 0.0 {
            break;
        }
        p -= gradient * (value / square);
    }
    p
}

struct Grid {
    /// Number of sample points along each axis.
    n: [usize; 3],
    values: Vec<f64>,
}

impl Grid {
    const fn index(&self, [i, j, k]: [usize; 3]) -> usize {
        (k * self.n[1] + j) * self.n[0] + i
    }
}

fn surface_net(
    field: &impl Fn(DVec3) -> (f64, DVec3),
    low: DVec3,
    high: DVec3,
    cell: f64,
) -> Shape {
    let n = ((high - low) / cell).to_array().map(points_along);
    let mut grid = Grid {
        n,
        values: Vec::with_capacity(n[0] * n[1] * n[2]),
    };
    let at = |i: [usize; 3]| low + cell * DVec3::from_array(i.map(|x| x as f64));
    for k in 0..n[2] {
        for j in 0..n[1] {
            for i in 0..n[0] {
                grid.values.push(field(at([i, j, k])).0);
            }
        }
    }
    let mut vertex_of_cell = vec![NONE; grid.values.len()];
    let mut positions = Vec::new();
    for k in 0..n[2] - 1 {
        for j in 0..n[1] - 1 {
            for i in 0..n[0] - 1 {
                if let Some(offset) = cell_vertex(&grid, [i, j, k]) {
                    vertex_of_cell[grid.index([i, j, k])] = positions.len() as u32;
                    positions.push(at([i, j, k]) + cell * offset);
                }
            }
        }
    }
    let triangles = net_triangles(&grid, &vertex_of_cell, &positions);
    (positions, triangles)
}

/// Mean of the crossings on the cell's edges, in units of the cell; `None` if there are none.
fn cell_vertex(grid: &Grid, base: [usize; 3]) -> Option<DVec3> {
    let corner = |c: usize| [c & 1, (c >> 1) & 1, (c >> 2) & 1];
    let value = |c: usize| {
        let o = corner(c);
        grid.values[grid.index([base[0] + o[0], base[1] + o[1], base[2] + o[2]])]
    };
    let point = |c: usize| DVec3::from_array(corner(c).map(|x| x as f64));
    let (mut sum, mut count) = (DVec3::ZERO, 0.0);
    for c in 0..8 {
        for axis in 0..3 {
            let d = c | (1 << axis);
            let (f, g) = (value(c), value(d));
            if d != c && (f < 0.0) != (g < 0.0) {
                sum += point(c).lerp(point(d), f / (f - g));
                count += 1.0;
            }
        }
    }
    (count > 0.0).then(|| sum / count)
}

/// A quad around every grid edge that crosses the surface, split along its shorter diagonal.
fn net_triangles(grid: &Grid, vertex_of_cell: &[u32], positions: &[DVec3]) -> Vec<[u32; 3]> {
    let mut triangles = Vec::new();
    for k in 1..grid.n[2] - 1 {
        for j in 1..grid.n[1] - 1 {
            for i in 1..grid.n[0] - 1 {
                let base = [i, j, k];
                let here = grid.values[grid.index(base)] < 0.0;
                for axis in 0..3 {
                    let mut there = base;
                    there[axis] += 1;
                    if here == (grid.values[grid.index(there)] < 0.0) {
                        continue;
                    }
                    // the four cells around the edge, counterclockwise seen from its end
                    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
                    let quad = [(1, 1), (0, 1), (0, 0), (1, 0)].map(|(du, dv)| {
                        let mut c = base;
                        c[u] -= du;
                        c[v] -= dv;
                        vertex_of_cell[grid.index(c)]
                    });
                    let [a, b, c, d] = if here {
                        quad
                    } else {
                        [quad[3], quad[2], quad[1], quad[0]]
                    };
                    let length =
                        |p: u32, q: u32| positions[p as usize].distance(positions[q as usize]);
                    if length(a, c) <= length(b, d) {
                        triangles.extend([[a, b, c], [a, c, d]]);
                    } else {
                        triangles.extend([[a, b, d], [b, c, d]]);
                    }
                }
            }
        }
    }
    triangles
}
