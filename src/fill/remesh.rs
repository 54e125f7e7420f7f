//! New triangulations of patches during a flow, for a changed density or after a large deformation
//! has degraded the triangles.
//!
//! A triangulation is replaced in three steps: the current [`Patch`] is assembled from connectivity
//! and positions; the patch module builds another patch over the same rims with its new vertices on
//! the current surface; this patch is split into connectivity and positions.

use crate::fill::context::{ChangeError, FillContext};
use crate::fill::hole::PlannedHole;
use crate::fill::options::FillOptions;
use crate::fill::patch_topology::{HoleTopology, PatchTopology};
use crate::mesh::DVec3;
use crate::patch::{self, Patch};

/// Blends with a triangle angle below this (in degrees) are remeshed. Every remeshing costs some
/// steps in which the new triangles adjust.
const SHARP: f64 = 18.0;
/// Angle of a thin triangle, in degrees.
const THIN: f64 = 10.0;
/// Share of thin triangles above which the patch of a single rim is remeshed at the end of its flow.
const MAX_THIN: f64 = 0.04;
/// Minimum number of accepted steps between two remeshings.
const STEPS_BETWEEN: usize = 3;
/// Maximum number of remeshings of a group.
const MAX_REMESHINGS: usize = 8;

/// Decides when the patches of a group are remeshed.
#[derive(Debug, Default)]
pub(super) struct RemeshPolicy {
    count: usize,
    last: usize,
    has_evened: bool,
}

impl RemeshPolicy {
    /// Whether degraded blends may be remeshed after `steps` accepted steps.
    pub fn allows(&self, steps: usize, converged: bool) -> bool {
        self.count < MAX_REMESHINGS && (converged || steps >= self.last + STEPS_BETWEEN)
    }

    /// Counts a remeshing after `steps` accepted steps, of patches of single rims if it `evens`.
    pub fn count(&mut self, steps: usize, evens: bool) {
        self.count += 1;
        self.last = steps;
        self.has_evened |= evens;
    }

    /// Whether patches of single rims were remeshed.
    pub fn has_evened(&self) -> bool {
        self.has_evened
    }
}

/// The patches of a group, in which blends with sharp triangles are remeshed if that improves them, and, with
/// `evens`, patches of single rims with many thin triangles: a vector flow moves vertices along the surface
/// too, far where the surface is much larger than its rim. `None` if no patch is remeshed.
pub(super) fn remesh_degraded(
    context: FillContext<'_>,
    group: usize,
    topology: &PatchTopology,
    positions: &[DVec3],
    options: &FillOptions,
    evens: bool,
) -> Option<(PatchTopology, Vec<DVec3>)> {
    let mut next = Remeshed::default();
    let mut any = false;
    for (hole, (own, here)) in context.plan.holes_of(group).zip(topology.split(positions)) {
        if !hole.rims.is_blend() && !evens {
            next.keep(own, here);
            continue;
        }
        let present = hole.rims.patch(own, here);
        let fresh = || patch::reblend(&hole.rims.geometry, &present, options.patch);
        let better = if hole.rims.is_blend() {
            let before = present.sharpest_angle();
            let fresh = (before < SHARP).then(fresh);
            fresh.filter(|fresh| fresh.sharpest_angle() > before)
        } else {
            let before = present.share_below(THIN);
            let fresh = (before > MAX_THIN).then(fresh);
            fresh.filter(|fresh| 2.0 * fresh.share_below(THIN) < before)
        };
        match better {
            Some(patch) => {
                next.push(&patch);
                any = true;
            }
            None => next.keep(own, here),
        }
    }
    any.then_some((next.topology, next.positions))
}

/// New triangulations of all holes of a group, with vertices on the current surface.
///
/// # Errors
/// No patch of that density exists for a rim, or a surface cannot be mapped to a disc.
pub(super) fn remesh(
    context: FillContext<'_>,
    group: usize,
    topology: &PatchTopology,
    positions: &[DVec3],
    options: &FillOptions,
) -> Result<(PatchTopology, Vec<DVec3>), ChangeError> {
    let mut next = Remeshed::default();
    for (hole, (own, here)) in context.plan.holes_of(group).zip(topology.split(positions)) {
        next.push(&remesh_hole(hole, &hole.rims.patch(own, here), options)?);
    }
    Ok((next.topology, next.positions))
}

fn remesh_hole(
    hole: &PlannedHole,
    present: &Patch,
    options: &FillOptions,
) -> Result<Patch, ChangeError> {
    let geometry = &hole.rims.geometry;
    let [rim] = &geometry.rims[..] else {
        return Ok(patch::reblend(geometry, present, options.patch));
    };
    let hole = hole.rims.id();
    let mut fresh =
        patch::fill(rim, options.patch).map_err(|source| ChangeError::Patch { hole, source })?;
    patch::transfer(present, &mut fresh)
        .map_err(|source| ChangeError::Transfer { hole, source })?;
    Ok(fresh)
}

/// The patches of a group under construction, as connectivity and positions.
#[derive(Default)]
struct Remeshed {
    topology: PatchTopology,
    positions: Vec<DVec3>,
}

impl Remeshed {
    fn push(&mut self, patch: &Patch) {
        self.keep(&HoleTopology::of(patch), patch.new_points());
    }

    fn keep(&mut self, hole: &HoleTopology, positions: &[DVec3]) {
        self.topology.holes.push(hole.clone());
        self.positions.extend_from_slice(positions);
    }
}
