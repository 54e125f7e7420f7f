//! A plane that cuts the scene: what is in front of it is hidden.

use super::Camera;
use crate::mesh::DVec3;

/// A plane whose side towards the eye is hidden.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CutPlane {
    /// A point of the plane.
    pub point: DVec3,
    /// The normal, of any length.
    pub normal: DVec3,
}

impl Camera {
    /// The hidden half space, if there is one: points `p` with `n·p > d`, for the unit vector `n` and
    /// the number `d` that are returned.
    pub fn cut_away(&self) -> Option<(DVec3, f64)> {
        let cut = self.cut?;
        let n = cut.normal.try_normalize()?;
        let towards_eye = if self.orthographic {
            -self.forward()
        } else {
            self.eye() - cut.point
        };
        let n = if n.dot(towards_eye) < 0.0 { -n } else { n };
        Some((n, n.dot(cut.point)))
    }

    /// Whether the cut hides a point.
    pub fn hides(&self, point: DVec3) -> bool {
        self.cut_away().is_some_and(|(n, d)| n.dot(point) > d)
    }

    /// Distance from its origin at which a line of sight enters what is not hidden: infinite if it
    /// never does, and −∞ in a parallel projection without a cut.
    pub fn first_visible(&self, origin: DVec3, direction: DVec3) -> f64 {
        let start = if self.orthographic {
            f64::NEG_INFINITY
        } else {
            0.0
        };
        let Some((n, d)) = self.cut_away() else {
            return start;
        };
        let (height, fall) = (n.dot(origin) - d, -n.dot(direction));
        if fall > 0.0 {
            start.max(height / fall)
        } else if height > 0.0 {
            f64::INFINITY
        } else {
            start
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::Bounds;

    /// The half in front is hidden from either side, in both projections, and lines of sight begin at
    /// the plane.
    #[test]
    fn the_half_towards_the_eye_is_hidden() {
        for orthographic in [false, true] {
            for turn in [0.0, 3.0] {
                let mut camera = Camera::fit(&Bounds::new(-DVec3::ONE, DVec3::ONE));
                camera.orthographic = orthographic;
                camera.orbit(turn, 0.0, true);
                let origin = camera.eye();
                let without = camera.first_visible(origin, camera.forward());
                assert_eq!(without, if orthographic { f64::NEG_INFINITY } else { 0.0 });
                camera.cut = Some(CutPlane {
                    point: DVec3::ZERO,
                    normal: DVec3::new(0.0, 0.0, 3.0),
                });
                let in_front = -0.1 * camera.forward();
                assert!(camera.hides(in_front) && !camera.hides(-in_front));
                let start = camera.first_visible(origin, camera.forward());
                assert!((start - camera.distance).abs() < 1e-9, "{start}");
                // away from the plane
                if !orthographic {
                    let up = camera.first_visible(origin, -camera.forward());
                    assert_eq!(up, f64::INFINITY);
                }
            }
        }
    }
}
