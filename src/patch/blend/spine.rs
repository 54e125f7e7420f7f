//! A cubic curve with rotation-minimising frames.

use crate::mesh::DVec3;
use glam::DMat3;

/// Places at which frames are kept.
const PIECES: usize = 64;

/// The cubic Hermite curve with derivatives `leave` at the start and `arrive` at the end.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cubic {
    pub ends: [DVec3; 2],
    pub slopes: [DVec3; 2],
}

impl Cubic {
    /// From `a` with the unit direction `leave` to `b` with the direction `arrive`. The end
    /// derivatives are `pull` times as long as those of the circular arc that turns from the one
    /// direction to the other. With `pull` 1 the cubic is close to that arc.
    pub fn turning(a: DVec3, leave: DVec3, b: DVec3, arrive: DVec3, pull: f64) -> Self {
        let turn = leave.angle_between(arrive);
        // not a number where a direction is missing: max drops it
        let reach = pull * a.distance(b) / (0.25 * turn).cos().powi(2).max(0.5);
        Self {
            ends: [a, b],
            slopes: [reach * leave, reach * arrive],
        }
    }

    pub fn at(&self, t: f64) -> DVec3 {
        let s = 1.0 - t;
        let ends = (1.0 + 2.0 * t) * s * s * self.ends[0] + (3.0 - 2.0 * t) * t * t * self.ends[1];
        ends + t * s * s * self.slopes[0] - t * t * s * self.slopes[1]
    }

    pub fn slope(&self, t: f64) -> DVec3 {
        let s = 1.0 - t;
        6.0 * t * s * (self.ends[1] - self.ends[0])
            + s * (1.0 - 3.0 * t) * self.slopes[0]
            + t * (3.0 * t - 2.0) * self.slopes[1]
    }

    fn bend(&self, t: f64) -> DVec3 {
        (6.0 - 12.0 * t) * (self.ends[1] - self.ends[0])
            + (6.0 * t - 4.0) * self.slopes[0]
            + (6.0 * t - 2.0) * self.slopes[1]
    }

    /// Angular velocity of the tangent, in radians per unit of `t`.
    pub fn turning_rate(&self, t: f64) -> DVec3 {
        let slope = self.slope(t);
        slope.cross(self.bend(t)) / slope.length_squared().max(f64::MIN_POSITIVE)
    }
}

/// A cubic with a frame at every place that does not turn about the tangent.
#[derive(Clone, Debug)]
pub(super) struct Spine {
    pub curve: Cubic,
    frames: Vec<DMat3>,
}

impl Spine {
    pub fn new(curve: Cubic) -> Self {
        let tangent = |i: usize| curve.slope(i as f64 / PIECES as f64).normalize_or_zero();
        let mut last = tangent(0);
        let mut frame = DMat3::IDENTITY;
        let mut frames = vec![frame];
        for i in 1..=PIECES {
            let next = tangent(i);
            frame = shortest_turn(last, next) * frame;
            frames.push(frame);
            last = next;
        }
        Self { curve, frames }
    }

    /// The rotation from the start to `t`.
    pub fn frame(&self, t: f64) -> DMat3 {
        let x = t.clamp(0.0, 1.0) * PIECES as f64;
        let i = (x as usize).min(PIECES - 1);
        let f = x - i as f64;
        let mixed = self.frames[i] * (1.0 - f) + self.frames[i + 1] * f;
        // orthonormal again
        let u = mixed.x_axis.normalize_or_zero();
        let v = mixed.y_axis.reject_from_normalized(u).normalize_or_zero();
        DMat3::from_cols(u, v, u.cross(v))
    }
}

/// The rotation in their plane that takes one unit vector to another.
fn shortest_turn(from: DVec3, to: DVec3) -> DMat3 {
    match from.cross(to).try_normalize() {
        Some(about) => DMat3::from_axis_angle(about, from.angle_between(to)),
        None => DMat3::IDENTITY,
    }
}
