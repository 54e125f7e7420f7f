//! Coordinates near the origin at unit scale: squared areas of tiny or huge meshes stay in range.

use super::data::{Patch, Rim};
use crate::mesh::DVec3;

/// The coordinates in which patches are made.
pub(super) struct Frame {
    centre: DVec3,
    radius: f64,
}

impl Frame {
    pub fn around(points: impl Iterator<Item = DVec3> + Clone) -> Self {
        let count = points.clone().count();
        let centre = points.clone().sum::<DVec3>() / count as f64;
        let radius = points.map(|p| p.distance(centre)).fold(0.0, f64::max);
        Self { centre, radius }
    }

    pub fn to_local(&self, p: DVec3) -> DVec3 {
        (p - self.centre) / self.radius
    }

    /// The rim in these coordinates, without forbidden pairs that are rim edges.
    pub fn local(&self, rim: &Rim) -> Rim {
        Rim {
            points: rim.points.iter().map(|&p| self.to_local(p)).collect(),
            opposite: rim.opposite.iter().map(|&p| self.to_local(p)).collect(),
            forbidden: rim.chords().collect(),
        }
    }

    /// The patch in the mesh's coordinates, with exactly these rim points.
    pub fn world(&self, mut patch: Patch, rim: impl Iterator<Item = DVec3>) -> Patch {
        for p in &mut patch.points {
            *p = *p * self.radius + self.centre;
        }
        for (p, rim) in patch.points.iter_mut().zip(rim) {
            *p = rim;
        }
        patch
    }
}
