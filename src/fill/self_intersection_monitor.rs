//! Checks of blends for self-intersections while they flow.

use std::sync::Arc;

use crate::fill::context::FillContext;
use crate::fill::patch_topology::PatchTopology;
use crate::fill::self_intersection::{intersections, place};
use crate::mesh::{DVec3, Mesh};
use crate::warning::{MAX_PAIRS, pairs_near};

/// Maximum number of accepted steps between two checks.
const STEPS_BETWEEN: usize = 5;
/// Movement of a vertex, in mean edge lengths of the patches, after which a check is due at once.
const FAR: f64 = 0.5;

/// A surface that intersects itself or the mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SelfIntersection {
    /// One of the places.
    pub place: DVec3,
    /// Intersecting pairs of triangles, [`MAX_PAIRS`] at most.
    pub pairs: usize,
    /// Accepted steps up to the last surface known to be free of intersections.
    pub last_clean: Option<usize>,
}

impl SelfIntersection {
    /// Number of pairs and place, for a message.
    pub fn words(&self) -> String {
        pairs_near(self.pairs, self.place)
    }
}

/// A surface to return to.
#[derive(Clone, Debug)]
pub(super) struct CheckedSurface {
    pub topology: Arc<PatchTopology>,
    pub positions: Vec<DVec3>,
    pub steps: usize,
}

/// Checks the blends of a group every few steps, and after every long one.
#[derive(Debug, Default)]
pub(super) struct SelfIntersectionMonitor {
    checked: Option<CheckedSurface>,
    clean: Option<CheckedSurface>,
    found: Option<SelfIntersection>,
}

impl SelfIntersectionMonitor {
    /// The result of the last check.
    pub fn found(&self) -> Option<&SelfIntersection> {
        self.found.as_ref()
    }

    /// The last surface that was checked and had no intersection.
    pub fn clean(&self) -> Option<&CheckedSurface> {
        self.clean.as_ref()
    }

    /// Forgets everything, for a group that continues from another surface.
    pub fn restart(&mut self) {
        *self = Self::default();
    }

    /// Checks a group's surface after `steps` accepted steps, if a check is due or the flow has
    /// `ended`.
    pub fn check(
        &mut self,
        context: FillContext<'_>,
        group: usize,
        topology: &Arc<PatchTopology>,
        positions: &[DVec3],
        steps: usize,
        ended: bool,
    ) {
        if !context
            .plan
            .holes_of(group)
            .any(|hole| hole.rims.is_blend())
        {
            return;
        }
        let mesh = context.mesh;
        let triangles = context.patch_triangles(group, topology);
        if !ended && !self.is_due(mesh, topology, &triangles, positions, steps) {
            return;
        }
        let now = CheckedSurface {
            topology: Arc::clone(topology),
            positions: positions.to_vec(),
            steps,
        };
        let obstacles = &context.plan.obstacles;
        let places = intersections(mesh, obstacles, &triangles, &[], positions, MAX_PAIRS);
        self.found = places.first().map(|&place| SelfIntersection {
            place,
            pairs: places.len(),
            last_clean: self.clean.as_ref().map(|clean| clean.steps),
        });
        if self.found.is_none() {
            self.clean = Some(now.clone());
        }
        self.checked = Some(now);
    }

    fn is_due(
        &self,
        mesh: &Mesh,
        topology: &Arc<PatchTopology>,
        triangles: &[[u32; 3]],
        positions: &[DVec3],
        steps: usize,
    ) -> bool {
        let Some(last) = &self.checked else {
            return true;
        };
        if !Arc::ptr_eq(&last.topology, topology) || steps >= last.steps + STEPS_BETWEEN {
            return true;
        }
        let pairs = last.positions.iter().zip(positions);
        let moved = pairs.map(|(a, b)| a.distance(*b)).fold(0.0, f64::max);
        moved > FAR * mean_edge(mesh, triangles, positions)
    }
}

fn mean_edge(mesh: &Mesh, triangles: &[[u32; 3]], positions: &[DVec3]) -> f64 {
    let place = |v: u32| place(mesh, positions, v);
    let (mut sum, mut count) = (0.0, 0.0);
    for t in triangles {
        for k in 0..3 {
            sum += place(t[k]).distance(place(t[(k + 1) % 3]));
            count += 1.0;
        }
    }
    sum / count
}
