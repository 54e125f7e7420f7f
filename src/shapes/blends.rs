//! Surfaces to be blended: open tubes that face each other, and a tube above a hole in a plane.

use std::f64::consts::{FRAC_PI_6, TAU};

use super::TriangleMesh;
use super::open::tube_lattice;
use super::{cut_where, plane};
use crate::mesh::DVec3;

/// An open circular tube.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tube {
    /// Middle of the end that is nearer to where the tubes are joined.
    pub mouth: DVec3,
    /// Direction from `mouth` to the other end; its length is that of the tube.
    pub axis: DVec3,
    /// Radius.
    pub radius: f64,
    /// Edges to a turn.
    pub around: usize,
}

/// Open tubes, one after the other, normals outwards. The lattices are regular: equilateral
/// triangles wrapped around the cylinder.
pub fn tubes(tubes: &[Tube]) -> TriangleMesh {
    let mut all: TriangleMesh = (Vec::new(), Vec::new());
    for tube in tubes {
        append(&mut all, one_tube(tube));
    }
    all
}

fn one_tube(tube: &Tube) -> TriangleMesh {
    let length = tube.axis.length();
    let along = tube.axis.normalize_or(DVec3::Z);
    let (u, v) = along.any_orthonormal_pair();
    let around = tube.around.max(3);
    tube_lattice(
        around,
        length * around as f64 / (TAU * tube.radius),
        |x, y| {
            let (sin, cos) = (TAU * x).sin_cos();
            tube.mouth + tube.radius * (cos * u + sin * v) + length * y * along
        },
    )
}

fn append(all: &mut TriangleMesh, part: TriangleMesh) {
    let first = all.0.len() as u32;
    all.0.extend(part.0);
    all.1
        .extend(part.1.into_iter().map(|t| t.map(|v| v + first)));
}

/// Tubes of radius 1/2 and length 1.6 that leave the origin in the given directions; their mouths
/// are 1 away from it.
fn star_of_tubes(directions: &[DVec3], around: usize) -> TriangleMesh {
    let tube = |&direction: &DVec3| Tube {
        mouth: direction,
        axis: 1.6 * direction,
        radius: 0.5,
        around,
    };
    tubes(&directions.iter().map(tube).collect::<Vec<_>>())
}

/// Four tubes along ±x and ±y, as in Fig. 2 of the paper; `around` edges to a turn.
pub fn four_cylinders(around: usize) -> TriangleMesh {
    star_of_tubes(&[DVec3::X, -DVec3::X, DVec3::Y, -DVec3::Y], around)
}

/// Three tubes in the xy plane, 120° from each other; `around` edges to a turn.
pub fn three_y(around: usize) -> TriangleMesh {
    let direction = |k: i32| {
        let (sin, cos) = (FRAC_PI_6 * f64::from(4 * k - 1)).sin_cos();
        DVec3::new(cos, sin, 0.0)
    };
    star_of_tubes(&[0, 1, 2].map(direction), around)
}

/// A tube of radius 0.4 upright above a hole of radius 3/4 in a square of side 3.2; `around` edges
/// to a turn of the tube, and edges of the same length in the square.
pub fn tube_onto_plane(around: usize) -> TriangleMesh {
    let radius = 0.4;
    let edge = TAU * radius / around as f64;
    let square = plane(3.2, (3.2 / edge).round().max(2.0) as usize, 1);
    let mut all = cut_where(&square, |p| p.length() < 0.75);
    let upright = Tube {
        mouth: 0.6 * DVec3::Z,
        axis: 1.2 * DVec3::Z,
        radius,
        around,
    };
    append(&mut all, one_tube(&upright));
    all
}
