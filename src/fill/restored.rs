//! Pseudo-holes as restored by `g2`.

use rayon::prelude::*;

use crate::cancel::is_cancelled;
use crate::fill::pseudo_hole::{Disc, FAILED, Surroundings};
use crate::fill::surface_choice::TENSIONS;
use crate::mesh::DVec3;
use crate::solver::LocalG2;

/// A pseudo-hole as restored by `g2`.
pub(super) struct Restored {
    system: LocalG2<{ TENSIONS.len() }>,
    /// Distances of the restored vertices from the true ones along the normals, by [`TENSIONS`].
    pub errors: Vec<[f64; TENSIONS.len()]>,
}

impl Restored {
    /// Some of the discs around a hole; none if the run was cancelled.
    pub fn all(surroundings: &Surroundings, discs: &[Disc]) -> Vec<Self> {
        let restore = |disc: &Disc| {
            let tensions = TENSIONS.map(|tension| tension / (disc.radius * disc.radius));
            let laplacian = &surroundings.laplacian;
            let system = LocalG2::new(laplacian, &disc.vertices, &disc.ends, tensions);
            let mut restored = Self {
                system,
                errors: Vec::new(),
            };
            let shape = disc
                .vertices
                .iter()
                .map(|&v| surroundings.points[v as usize]);
            let shape: Vec<Option<DVec3>> = shape.map(Some).collect();
            restored.errors = restored.along_normals(disc, &shape);
            restored
        };
        let restore = |disc: &Disc| (!is_cancelled()).then(|| restore(disc));
        let all: Option<Vec<Self>> = discs.par_iter().map(restore).collect();
        all.unwrap_or_default()
    }

    /// Displacements of the vertices along the normals from a shape of the disc and its rings to the
    /// minimum of the energy.
    pub fn along_normals(
        &self,
        disc: &Disc,
        shape: &[Option<DVec3>],
    ) -> Vec<[f64; TENSIONS.len()]> {
        let steps = self.system.steps(shape).into_iter().zip(&disc.normals);
        let along = |([x, y, z], n): ([[f64; TENSIONS.len()]; 3], &DVec3)| {
            std::array::from_fn(|k| DVec3::new(x[k], y[k], z[k]).dot(*n))
        };
        steps.map(along).collect()
    }

    /// Squared error with the tension number `k`, relative to the radius.
    pub fn error(&self, disc: &Disc, k: usize) -> f64 {
        let error = disc.mean_square(self.errors.iter().map(|errors| errors[k]));
        if error.is_finite() { error } else { FAILED }
    }
}
