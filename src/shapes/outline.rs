//! Outlines of holes in the plane.

use std::f64::consts::{PI, TAU};

use glam::DVec2;

use crate::random::SplitMix;

/// Outline of a hole, in units of length on the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum HoleShape {
    /// Disc; on a unit sphere the radius is the angle.
    Disc {
        /// Geodesic radius.
        radius: f64,
    },
    /// Disc whose radius varies with the direction, by about a third.
    Ragged {
        /// Mean radius.
        radius: f64,
    },
    /// Long thin hole with round ends.
    Slit {
        /// From end to end.
        length: f64,
        /// Across.
        width: f64,
    },
    /// Two bars at a right angle; the centre is in the middle of the square around it.
    Angle {
        /// Outer length of each bar.
        arm: f64,
        /// Width of the bars.
        width: f64,
    },
    /// Star with straight sides.
    Star {
        /// Radius of the points.
        outer: f64,
        /// Radius of the notches.
        inner: f64,
        /// Number of points.
        points: u32,
    },
    /// Union of random overlapping discs, some of them bitten.
    Blots {
        /// Radius of the disc that contains the outline.
        radius: f64,
    },
}

/// An outline with its random parts drawn.
pub struct Outline {
    shape: HoleShape,
    /// Ragged: amplitude and phase of the harmonics 2, 3, ...
    waves: Vec<(f64, f64)>,
    /// Blots: centre and radius; all but the first touch it.
    discs: Vec<(DVec2, f64)>,
}

impl Outline {
    pub fn new(shape: &HoleShape, seed: u64) -> Self {
        let mut rng = SplitMix::new(seed);
        let mut waves = Vec::new();
        let mut discs = Vec::new();
        match *shape {
            HoleShape::Ragged { .. } => {
                waves = (0..10)
                    .map(|_| (rng.range(0.2, 1.0), rng.range(0.0, TAU)))
                    .collect();
                let sum: f64 = waves.iter().map(|w| w.0).sum();
                // amplitudes sum to 1; the harmonics hardly ever peak together
                for wave in &mut waves {
                    wave.0 /= sum;
                }
            }
            HoleShape::Blots { radius } => {
                discs.push((DVec2::ZERO, 0.45 * radius));
                for _ in 0..5 {
                    let at = DVec2::from_angle(rng.range(0.0, TAU)) * rng.range(0.4, 0.65) * radius;
                    discs.push((at, rng.range(0.2, 0.35) * radius));
                }
            }
            _ => {}
        }
        Self {
            shape: *shape,
            waves,
            discs,
        }
    }

    /// A radius around the origin that covers the outline.
    pub fn reach(&self) -> f64 {
        match self.shape {
            HoleShape::Disc { radius } | HoleShape::Blots { radius } => radius,
            HoleShape::Ragged { radius } => 2.0 * radius,
            HoleShape::Slit { length, .. } => 0.5 * length,
            HoleShape::Angle { arm, .. } => arm,
            HoleShape::Star { outer, .. } => outer,
        }
    }

    pub fn contains(&self, p: DVec2) -> bool {
        match self.shape {
            HoleShape::Disc { radius } => p.length() < radius,
            HoleShape::Ragged { radius } => {
                let direction = p.y.atan2(p.x);
                let waves = self.waves.iter().zip(2..);
                let waver: f64 = waves
                    .map(|(&(size, phase), k)| size * (f64::from(k) * direction + phase).cos())
                    .sum();
                p.length() < radius * (1.0 + waver)
            }
            HoleShape::Slit { length, width } => {
                let half = 0.5 * (length - width).max(0.0);
                p.distance(DVec2::new(p.x.clamp(-half, half), 0.0)) < 0.5 * width
            }
            HoleShape::Angle { arm, width } => {
                let q = p + 0.5 * arm;
                let square = q.cmpge(DVec2::ZERO).all() && q.cmple(DVec2::splat(arm)).all();
                square && q.min_element() < width
            }
            HoleShape::Star {
                outer,
                inner,
                points,
            } => {
                // fold into half a sector, then compare with the straight side
                let half = PI / f64::from(points.max(2));
                let turn = p.y.atan2(p.x).rem_euclid(2.0 * half);
                let turn = if turn > half { 2.0 * half - turn } else { turn };
                let q = DVec2::from_angle(turn) * p.length();
                let (tip, notch) = (DVec2::new(outer, 0.0), DVec2::from_angle(half) * inner);
                (notch - tip).perp_dot(q - tip) > 0.0
            }
            HoleShape::Blots { .. } => {
                let (first, rest) = self.discs.split_at(1);
                let within = |d: &(DVec2, f64)| p.distance(d.0) < d.1;
                // the last one is a bite
                let (bite, more) = rest.split_at(1);
                (first.iter().any(within) && !bite.iter().any(within)) || more.iter().any(within)
            }
        }
    }
}
