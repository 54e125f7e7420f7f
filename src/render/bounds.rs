//! Axis-parallel bounding boxes of drawn surfaces.

use crate::mesh::DVec3;

/// A bounding box of points, with the radius of a bounding sphere around its centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Minimum coordinates in units of the file.
    pub low: DVec3,
    /// Maximum coordinates.
    pub high: DVec3,
    /// Maximum distance of a point from the centre, at most half the diagonal.
    radius: f64,
}

impl Bounds {
    /// The box between two corners.
    pub fn new(low: DVec3, high: DVec3) -> Self {
        Self {
            low,
            high,
            radius: 0.5 * low.distance(high),
        }
    }

    /// The bounding box of the finite points; `None` if there are none.
    pub fn of(points: impl IntoIterator<Item = DVec3> + Clone) -> Option<Self> {
        let finite = |p: &DVec3| p.is_finite();
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for p in points.clone().into_iter().filter(finite) {
            low = low.min(p);
            high = high.max(p);
        }
        if low.x > high.x {
            return None;
        }
        let centre = low.midpoint(high);
        let squared = points
            .into_iter()
            .filter(finite)
            .fold(0.0f64, |r, p| r.max(p.distance_squared(centre)));
        Some(Self {
            low,
            high,
            radius: squared.sqrt(),
        })
    }

    /// The centre of the box.
    pub fn centre(&self) -> DVec3 {
        self.low.midpoint(self.high)
    }

    /// Radius of a bounding sphere around [`Self::centre`]. It is never 0, so that a single point
    /// can be viewed.
    pub fn radius(&self) -> f64 {
        if self.radius > 0.0 {
            self.radius
        } else {
            let size = self.low.abs().max(self.high.abs()).max_element();
            (1e-6 * size).max(1e-12)
        }
    }
}

impl Default for Bounds {
    /// The unit cube around the origin, used for an empty view.
    fn default() -> Self {
        Self::new(DVec3::splat(-0.5), DVec3::splat(0.5))
    }
}
