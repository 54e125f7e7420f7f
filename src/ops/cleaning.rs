//! Operations that clean a mesh before holes are filled.

use super::OperationError;
use crate::mesh::{LOOSE_FACES, LooseParts, Mesh, loose_parts, stitch, stitching_tolerance};
use crate::options::options;

options! {
    /// A removal of loose parts.
    pub struct CleanSpec {
        /// Remove components with fewer faces; the largest component stays.
        min_faces("N"): usize = LOOSE_FACES,
        /// Remove flaps of at most N faces: parts in a hole that one edge joins to the rest.
        flap_faces("N"): usize = 4,
    }
}

options! {
    /// A stitching of slits.
    pub struct StitchSpec {
        /// Join boundary edges whose ends are within this distance [default: 1 % of the mean length
        /// of boundary edges].
        tolerance("LENGTH"): Option<f64> = None,
    }
}

impl CleanSpec {
    /// The parts that are removed.
    pub fn parts(&self, mesh: &Mesh) -> LooseParts {
        loose_parts(mesh, self.min_faces, self.flap_faces)
    }
}

impl StitchSpec {
    /// The distance within which vertices of a mesh are joined, in its units.
    pub fn tolerance(&self, mesh: &Mesh) -> f64 {
        self.tolerance.unwrap_or_else(|| stitching_tolerance(mesh))
    }

    /// The stitched mesh.
    ///
    /// # Errors
    /// The tolerance is no length, or the mesh has no faces.
    pub(super) fn run(&self, mesh: &Mesh) -> Result<Mesh, OperationError> {
        let tolerance = self.tolerance(mesh);
        if !(tolerance.is_finite() && tolerance >= 0.0) {
            return Err(OperationError::Tolerance(tolerance));
        }
        Ok(stitch(mesh, tolerance)?)
    }
}
