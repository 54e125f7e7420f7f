//! Axis-parallel boxes around what is drawn.

use crate::mesh::DVec3;

/// A box around points, with the radius of a sphere around its centre that holds them too.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Least coordinates, in units of the file.
    pub low: DVec3,
    /// Greatest coordinates.
    pub high: DVec3,
    /// Largest distance of a point from the centre, at most half the diagonal.
    radius: f64,
}

impl Bounds {
    /// A box by two corners.
    pub fn new(low: DVec3, high: DVec3) -> Self {
        Self {
            low,
            high,
            radius: 0.5 * low.distance(high),
        }
    }

    /// The box of points; points that are not finite are left out. `None` if none is left.
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

    /// The middle of the box.
    pub fn centre(&self) -> DVec3 {
        self.low.midpoint(self.high)
    }

    /// Radius of a sphere around [`Self::centre`] that holds everything; never 0, so that a single
    /// point can be viewed.
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
    /// The unit cube around the origin: what an empty view shows.
    fn default() -> Self {
        Self::new(DVec3::splat(-0.5), DVec3::splat(0.5))
    }
}
