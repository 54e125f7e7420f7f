//! Sharp edges.

use crate::mesh::{FOLD_DEGREES, HalfedgeId, Mesh, dihedral_angle};

/// Edges with a larger angle between their faces are sharp, in degrees.
const SHARP: f64 = 40.0;

/// Whether the faces beside an edge meet at a sharp angle.
pub(super) fn is_sharp(mesh: &Mesh, h: HalfedgeId) -> bool {
    dihedral_angle(&mesh.positions, &mesh.topology, h) > SHARP.to_radians()
}

/// Whether faces at an angle, in radians, meet in a sharp edge that is no fold.
pub(super) fn is_sharp_angle(angle: f64) -> bool {
    angle > SHARP.to_radians() && angle < FOLD_DEGREES.to_radians()
}
