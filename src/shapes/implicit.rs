//! Closed surfaces from implicit functions, by surface nets.

use super::TriangleMesh;
use super::relax::{jitter, relax};
use crate::mesh::DVec3;

const NONE: u32 = u32::MAX;

/// The surface where `field` vanishes within the box `low..=high`.
///
/// `field` gives the value, negative inside, and its gradient (which may be approximate; Newton's
/// method towards the surface uses it). Triangles have edges of about `cell` units (0.9 on the
/// average). The surface must keep away from the box's sides by a cell, and its features should
/// be some cells wide. Surface nets (Gibson 1998) with a vertex per sheet, then sweeps that even
/// them out.
pub fn implicit_surface(
    field: &impl Fn(DVec3) -> (f64, DVec3),
    low: DVec3,
    high: DVec3,
    cell: f64,
    seed: u64,
) -> TriangleMesh {
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

    fn is_inside(&self, i: [usize; 3]) -> bool {
        self.values[self.index(i)] < 0.0
    }
}

/// A cell that the surface crosses: the vertex of each of its edges that do.
struct Cell {
    vertex_of_edge: [u32; 12],
}

/// The edge of a cell along `axis` whose other two offsets are those of `at`.
const fn edge_index(axis: usize, at: [usize; 3]) -> usize {
    4 * axis + at[(axis + 1) % 3] + 2 * at[(axis + 2) % 3]
}

fn surface_net(
    field: &impl Fn(DVec3) -> (f64, DVec3),
    low: DVec3,
    high: DVec3,
    cell: f64,
) -> TriangleMesh {
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
    let mut cell_at = vec![NONE; grid.values.len()];
    let mut cells = Vec::new();
    let mut positions = Vec::new();
    for k in 0..n[2] - 1 {
        for j in 0..n[1] - 1 {
            for i in 0..n[0] - 1 {
                let first = positions.len();
                if let Some(found) = cross_cell(&grid, [i, j, k], &mut positions) {
                    cell_at[grid.index([i, j, k])] = cells.len() as u32;
                    cells.push(found);
                    for p in &mut positions[first..] {
                        *p = at([i, j, k]) + cell * *p;
                    }
                }
            }
        }
    }
    let triangles = net_triangles(&grid, &cell_at, &cells, &positions);
    (positions, triangles)
}

/// Groups the crossed edges of a cell into sheets and appends, for each sheet, the mean of its
/// crossings in units of the cell. `None` if the surface does not cross the cell.
fn cross_cell(grid: &Grid, base: [usize; 3], positions: &mut Vec<DVec3>) -> Option<Cell> {
    let corner = |o: [usize; 3]| [base[0] + o[0], base[1] + o[1], base[2] + o[2]];
    let mut points = [None; 12];
    for axis in 0..3 {
        for (du, dv) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            let mut start = [0; 3];
            start[(axis + 1) % 3] = du;
            start[(axis + 2) % 3] = dv;
            let mut end = start;
            end[axis] = 1;
            let f = grid.values[grid.index(corner(start))];
            let g = grid.values[grid.index(corner(end))];
            if (f < 0.0) != (g < 0.0) {
                let point = |o: [usize; 3]| DVec3::from_array(o.map(|x| x as f64));
                let crossing = point(start).lerp(point(end), f / (f - g));
                points[edge_index(axis, start)] = Some(crossing);
            }
        }
    }
    if points.iter().all(Option::is_none) {
        return None;
    }
    let sheet = sheets(|o| grid.is_inside(corner(o)), &points);
    let mut vertex_of_edge = [NONE; 12];
    for s in 0..12 {
        let (mut sum, mut count) = (DVec3::ZERO, 0.0);
        for e in 0..12 {
            if let Some(point) = points[e].filter(|_| sheet[e] == s) {
                sum += point;
                count += 1.0;
                vertex_of_edge[e] = positions.len() as u32;
            }
        }
        if count > 0.0 {
            positions.push(sum / count);
        }
    }
    Some(Cell { vertex_of_edge })
}

/// For each edge of a cell the least edge of its sheet. On a face with two crossings they belong
/// together; with four, those around a corner inside do, whichever cell visits the face, so that
/// the sheets of neighbouring cells fit (dual marching cubes, Nielson 2004).
fn sheets(is_inside: impl Fn([usize; 3]) -> bool, points: &[Option<DVec3>; 12]) -> [usize; 12] {
    let mut sheet = std::array::from_fn(|e| e);
    let mut join = |a: usize, b: usize| {
        let (a, b): (usize, usize) = (sheet[a], sheet[b]);
        for s in &mut sheet {
            if *s == a.max(b) {
                *s = a.min(b);
            }
        }
    };
    for normal in 0..3 {
        let (u, v) = ((normal + 1) % 3, (normal + 2) % 3);
        for side in 0..2 {
            let corners = [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(a, b)| {
                let mut o = [0; 3];
                (o[normal], o[u], o[v]) = (side, a, b);
                o
            });
            // edge k joins corners k and k + 1
            let edges = [
                edge_index(u, corners[0]),
                edge_index(v, corners[1]),
                edge_index(u, corners[3]),
                edge_index(v, corners[0]),
            ];
            let crossed: Vec<usize> = edges.into_iter().filter(|&e| points[e].is_some()).collect();
            match crossed[..] {
                [a, b] => join(a, b),
                [_, _, _, _] => {
                    let first = usize::from(!is_inside(corners[0]));
                    join(edges[(first + 3) % 4], edges[first]);
                    join(edges[first + 1], edges[first + 2]);
                }
                _ => {}
            }
        }
    }
    sheet
}

/// A quad around every grid edge that crosses the surface, split along its shorter diagonal.
fn net_triangles(
    grid: &Grid,
    cell_at: &[u32],
    cells: &[Cell],
    positions: &[DVec3],
) -> Vec<[u32; 3]> {
    let mut triangles = Vec::new();
    for k in 1..grid.n[2] - 1 {
        for j in 1..grid.n[1] - 1 {
            for i in 1..grid.n[0] - 1 {
                let base = [i, j, k];
                let here = grid.is_inside(base);
                for axis in 0..3 {
                    let mut there = base;
                    there[axis] += 1;
                    if here == grid.is_inside(there) {
                        continue;
                    }
                    // the four cells around the edge, counterclockwise seen from its end
                    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
                    let quad = [(1, 1), (0, 1), (0, 0), (1, 0)].map(|(du, dv)| {
                        let (mut c, mut offset) = (base, [0; 3]);
                        c[u] -= du;
                        c[v] -= dv;
                        (offset[u], offset[v]) = (du, dv);
                        let cell = &cells[cell_at[grid.index(c)] as usize];
                        cell.vertex_of_edge[edge_index(axis, offset)]
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Topology;

    #[test]
    fn nets_with_ambiguous_cells_are_manifold() {
        // a hyperboloid pinched at the origin: saddle cells for any grid
        for shift in 0..20 {
            let offset = DVec3::new(0.31, 0.17, 0.11) * (0.1 * f64::from(shift));
            let field = |p: DVec3| {
                let q = p + offset;
                let neck = q.x * q.x + q.y * q.y - q.z * q.z - 0.02;
                let ball = q.length_squared() - 2.0;
                (neck.max(ball), DVec3::ZERO)
            };
            let reach = DVec3::splat(2.0);
            let (positions, triangles) = surface_net(&field, -reach - offset, reach, 0.13);
            let topology = Topology::from_triangles(positions.len(), &triangles);
            let topology = topology.expect("manifold");
            assert!(topology.boundary_loops().is_empty());
        }
    }
}
