//! What is under the cursor.

use super::Camera;
use crate::mesh::{BoundaryLoop, DVec3, FaceId, Topology};

/// A point of the surface under the cursor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// The face.
    pub face: FaceId,
    /// The point.
    pub point: DVec3,
    /// Its distance from the eye, in units of the file.
    pub distance: f64,
}

/// Answers what is under the cursor for a mesh that stays as it is.
#[derive(Clone, Debug)]
pub struct Picker {
    loops: usize,
}

impl Picker {
    /// Prepares a mesh with its boundary loops; for a large mesh not on the thread of the window.
    pub fn new(positions: &[DVec3], topology: &Topology, loops: &[BoundaryLoop]) -> Self {
        let _ = (positions, topology);
        Self { loops: loops.len() }
    }

    /// The nearest point of the surface under the cursor (pixels from the upper left).
    pub fn surface(&self, camera: &Camera, size_px: [f64; 2], cursor_px: [f64; 2]) -> Option<Hit> {
        let _ = (camera, size_px, cursor_px, self.loops);
        None
    }

    /// The loop under the cursor, as index into the loops given.
    pub fn pick_loop(
        &self,
        camera: &Camera,
        size_px: [f64; 2],
        cursor_px: [f64; 2],
        tolerance_px: f64,
    ) -> Option<usize> {
        let _ = (camera, size_px, cursor_px, tolerance_px);
        None
    }
}
