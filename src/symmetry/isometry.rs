//! Isometries of space, and how they are fitted to pairs of points.

use glam::{DMat3, DQuat};
use nalgebra_sparse::na;

use super::target::Sample;
use crate::mesh::DVec3;

/// A map `x ↦ Q x + t` of space with an orthogonal matrix Q: a motion, or a motion after a reflection.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Isometry {
    matrix: DMat3,
    shift: DVec3,
}

/// Weight of staying where it is, relative to the mean weight of the pairs. It decides where the
/// pairs do not, as along a plane.
const DAMPING: f64 = 1e-6;
/// Movement, relative to the extent of the points, below which a fit has ended.
const SETTLED: f64 = 1e-4;

impl Isometry {
    /// The isometry with the orthogonal `matrix` that fixes the point `centre`.
    pub fn about(centre: DVec3, matrix: DMat3) -> Self {
        Self {
            matrix,
            shift: centre - matrix * centre,
        }
    }

    /// The image of a point.
    pub fn apply(&self, p: DVec3) -> DVec3 {
        self.matrix * p + self.shift
    }

    /// The point whose image is `p`.
    pub fn invert(&self, p: DVec3) -> DVec3 {
        self.matrix.transpose() * (p - self.shift)
    }

    /// The image of a sample, whose normal points to the same side of the image of the surface.
    pub fn image(&self, sample: &Sample) -> Sample {
        Sample {
            point: self.apply(sample.point),
            normal: self.matrix * sample.normal,
        }
    }

    /// This isometry after a motion that brings the images of `samples` nearer to a surface, of which
    /// `nearest` gives points near to the image of a sample with its number. Only the `share` of the nearest pairs counts: parts of a
    /// surface that have no counterpart must not move the others. `None` if fewer than half have one.
    pub fn fitted(
        self,
        samples: &[Sample],
        share: f64,
        rounds: usize,
        nearest: impl Fn(usize, &Sample) -> Option<Sample>,
    ) -> Option<Self> {
        let mut fit = self;
        for _ in 0..rounds {
            let (next, movement) = fit.step(samples, share, &nearest)?;
            fit = next;
            if movement < SETTLED {
                break;
            }
        }
        Some(fit)
    }

    /// One Gauss-Newton step, and how far it moves the samples relative to their extent.
    fn step(
        self,
        samples: &[Sample],
        share: f64,
        nearest: impl Fn(usize, &Sample) -> Option<Sample>,
    ) -> Option<(Self, f64)> {
        let mut pairs = self.pairs(samples, nearest)?;
        pairs.truncate((share * pairs.len() as f64) as usize);
        let count = pairs.len() as f64;
        let centre = pairs.iter().map(|(p, _)| p.point).sum::<DVec3>() / count;
        let spread = pairs.iter().map(|(p, _)| p.point.distance_squared(centre));
        let extent = (spread.sum::<f64>() / count).sqrt();
        // unknowns: rotation about the centre, then shift, both relative to the extent
        let mut matrix = na::Matrix6::zeros();
        let mut right = na::Vector6::zeros();
        for (p, q) in &pairs {
            let turn = ((p.point - centre) / extent).cross(q.normal).to_array();
            let shift = q.normal.to_array();
            let row = na::Vector6::from_iterator(turn.into_iter().chain(shift));
            matrix += row * row.transpose();
            right += (q.point - p.point).dot(q.normal) / extent * row;
        }
        let damping = DAMPING * matrix.trace() / 6.0;
        let step = (matrix + damping * na::Matrix6::identity()).cholesky()?;
        let step: [f64; 6] = step.solve(&right).into();
        let [rotation, shift] = [&step[..3], &step[3..]].map(DVec3::from_slice);
        let rotation = DMat3::from_quat(DQuat::from_scaled_axis(rotation));
        let moved = |p: DVec3| centre + rotation * (p - centre) + extent * shift;
        let next = Self {
            matrix: rotation * self.matrix,
            shift: moved(self.shift),
        };
        let movement = rotation.x_axis.distance(DVec3::X) + shift.length();
        let movement = movement + rotation.y_axis.distance(DVec3::Y);
        movement.is_finite().then_some((next, movement))
    }

    /// The images of samples with the nearest samples of a surface, nearest pairs first. `None` if
    /// fewer than half have one.
    fn pairs(
        &self,
        samples: &[Sample],
        nearest: impl Fn(usize, &Sample) -> Option<Sample>,
    ) -> Option<Vec<(Sample, Sample)>> {
        let images = samples.iter().map(|sample| self.image(sample)).enumerate();
        let pairs = images.filter_map(|(i, p)| nearest(i, &p).map(|q| (p, q)));
        let mut pairs: Vec<(Sample, Sample)> = pairs.collect();
        let distance = |(p, q): &(Sample, Sample)| p.point.distance_squared(q.point);
        pairs.sort_by(|a, b| distance(a).total_cmp(&distance(b)));
        (2 * pairs.len() > samples.len()).then_some(pairs)
    }

    /// Median of the distances of the images of samples from a surface along its normals; infinite
    /// for samples that are not near to it. `None` if fewer than half have a nearest sample.
    pub fn median(
        &self,
        samples: &[Sample],
        nearest: impl Fn(usize, &Sample) -> Option<Sample>,
    ) -> Option<f64> {
        let pairs = self.pairs(samples, nearest)?;
        let distance = |(p, q): &(Sample, Sample)| (p.point - q.point).dot(q.normal).abs();
        let mut distances: Vec<f64> = pairs.iter().map(distance).collect();
        distances.sort_by(f64::total_cmp);
        distances.get(samples.len() / 2).copied()
    }
}
