//! Approximate symmetries: isometries of space that take a surface nearly to itself.
//!
//! A symmetric shape has its principal axes of inertia along the normals and axes of its reflections
//! and half-turns. Every combination of signs along these axes is therefore a start, which is then
//! [fitted](Isometry::fitted): the points of the surface are moved until their distances along the
//! normals of the nearest points are least (point-to-plane, Chen & Medioni 1992).

mod isometry;
mod target;

use std::panic::resume_unwind;
use std::thread;

use glam::DMat3;
use nalgebra_sparse::na;

use crate::mesh::{DVec3, Mesh};
pub use isometry::Isometry;
use target::Target;
pub use target::{Sample, alike, inside, smooth};

/// Largest median distance of the moved surface from itself, relative to its RMS radius, up to which
/// an isometry counts as a symmetry. On scans (`real/`) those of the shapes have up to 0.016, others from
/// 0.033 on.
const TOLERANCE: [f64; 2] = [0.05, 0.02];
/// Maximum number of points of the surface to which others are moved.
const TARGETS: usize = 2000;
/// Number of points that are moved for the starts and for the symmetries.
const MOVED: [usize; 2] = [50, 150];
/// Maximum number of rounds of fitting the starts and the symmetries, and the share of the points that count.
const ROUNDS: [usize; 2] = [8, 20];
const SHARE: [f64; 2] = [0.7, 0.4];
/// Maximum number of symmetries of a mesh.
const MOST: usize = 3;

/// Approximate symmetries of a mesh other than the identity, the most exact ones first, at most
/// three.
pub fn symmetries(mesh: &Mesh) -> Vec<Isometry> {
    let Some(inertia) = Inertia::new(mesh) else {
        return Vec::new();
    };
    let all = Target::coarse(mesh, TARGETS);
    let fit_once = |start: Isometry, stage: usize| {
        let moved = all.some(MOVED[stage]);
        let fit = start.fitted(&moved, SHARE[stage], ROUNDS[stage], |_, sample| {
            all.nearest(sample)
        })?;
        let distance = fit.median(&moved, |_, sample| all.nearest(sample))?;
        (distance <= TOLERANCE[stage] * inertia.radius).then_some((fit, distance))
    };
    let starts = (1..8u8).map(|signs| {
        let sign = |axis: u8| if signs >> axis & 1 == 1 { -1.0 } else { 1.0 };
        let flips = DMat3::from_diagonal(DVec3::new(sign(0), sign(1), sign(2)));
        let matrix = inertia.axes * flips * inertia.axes.transpose();
        Isometry::about(inertia.centre, matrix)
    });
    let fit = &|start: Isometry| fit_once(fit_once(start, 0)?.0, 1);
    // threads of their own: the caller may hold a lock for which other tasks of a thread pool wait, and a thread
    // of the pool that waits here could begin one of these tasks
    let found: Vec<Option<(Isometry, f64)>> = thread::scope(|scope| {
        let fits: Vec<_> = starts
            .map(|start| scope.spawn(move || fit(start)))
            .collect();
        let joined = fits.into_iter().map(thread::ScopedJoinHandle::join);
        joined
            .map(|fit| fit.unwrap_or_else(|panic| resume_unwind(panic)))
            .collect()
    });
    let mut found: Vec<(Isometry, f64)> = found.into_iter().flatten().collect();
    found.sort_by(|a, b| a.1.total_cmp(&b.1));
    found.truncate(MOST);
    found.into_iter().map(|found| found.0).collect()
}

/// Centre, principal axes and size of a surface.
struct Inertia {
    /// Centre of mass.
    centre: DVec3,
    /// Unit vectors along the principal axes.
    axes: DMat3,
    /// RMS distance from the centre.
    radius: f64,
}

impl Inertia {
    /// By the centroids of the faces, weighted by area. `None` for a surface without area.
    fn new(mesh: &Mesh) -> Option<Self> {
        let faces = mesh.topology.faces().map(|f| {
            let [a, b, c] = mesh.corners(f);
            ((a + b + c) / 3.0, (b - a).cross(c - a).length())
        });
        let (sum, area) = faces
            .clone()
            .fold((DVec3::ZERO, 0.0), |(sum, area), (p, w)| {
                (sum + w * p, area + w)
            });
        let centre = sum / area;
        let mut moments = na::Matrix3::zeros();
        for (p, w) in faces {
            let d = na::Vector3::from((p - centre).to_array());
            moments += w / area * d * d.transpose();
        }
        let radius = moments.trace().sqrt();
        if !(radius.is_finite() && radius > 0.0) {
            return None;
        }
        let axes: [[f64; 3]; 3] = moments.symmetric_eigen().eigenvectors.into();
        Some(Self {
            centre,
            axes: DMat3::from_cols_array_2d(&axes),
            radius,
        })
    }
}

#[cfg(test)]
mod tests;
