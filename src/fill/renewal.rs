//! New triangles for patches on their way: other densities, and mending what a large deformation has
//! spoilt.

use crate::fill::run::{ChangeError, Ground};
use crate::fill::shape::{HoleShape, Shape};
use crate::fill::{FillOptions, gap_of};
use crate::mesh::{DVec3, LoopId};
use crate::patch::{self, PatchMesh};

/// Blends with a triangle sharper than this (in degrees) are remeshed; every time costs the steps in which
/// the new triangles find their places.
const SHARP: f64 = 18.0;
/// Accepted steps from one remeshing to the next at least.
const STEPS_BETWEEN: usize = 3;
/// Remeshings of a group at most.
const MOST: usize = 8;

/// Where a flow stands.
#[derive(Clone, Copy, Debug)]
pub(super) struct Moment {
    /// Accepted steps.
    pub steps: usize,
    /// Whether it has just converged.
    pub converged: bool,
}

/// When the blends of a group were remeshed.
#[derive(Debug, Default)]
pub(super) struct Renewals {
    count: usize,
    last: usize,
}

impl Renewals {
    /// The group's shape at this moment with its blends remeshed, where they have got
    /// sharp triangles and remeshing helps.
    pub fn next(
        &mut self,
        ground: Ground<'_>,
        group: usize,
        shape: &Shape,
        positions: &[DVec3],
        options: &FillOptions,
        now: Moment,
    ) -> Option<(Shape, Vec<DVec3>)> {
        let recent = now.steps < self.last + STEPS_BETWEEN && !now.converged;
        if self.count >= MOST || recent {
            return None;
        }
        let mut first = 0;
        let mut out = Shape { holes: Vec::new() };
        let mut moved = Vec::new();
        let mut any = false;
        for (&h, hole) in ground.plan.groups[group].holes.iter().zip(&shape.holes) {
            let planned = &ground.plan.holes[h];
            let here = &positions[first..first + hole.new_vertices];
            first += hole.new_vertices;
            let mut next = (hole.clone(), here.to_vec());
            if planned.loops.len() > 1 {
                let present = Present::of(ground, planned.id, hole, here);
                let before = present.patch.sharpest_angle();
                if before < SHARP {
                    let fresh = patch::reblend(&present.gap, &present.patch, &options.patch);
                    if fresh.sharpest_angle() > before {
                        next = present.shape_of(fresh);
                        any = true;
                    }
                }
            }
            out.holes.push(next.0);
            moved.extend(next.1);
        }
        if any {
            self.count += 1;
            self.last = now.steps;
        }
        any.then_some((out, moved))
    }
}

/// New triangulations of a group's holes that take over the present shape.
pub(super) fn remesh(
    ground: Ground<'_>,
    group: usize,
    shape: &Shape,
    positions: &[DVec3],
    options: &FillOptions,
) -> Result<(Shape, Vec<DVec3>), ChangeError> {
    let mut first = 0;
    let mut out = Shape { holes: Vec::new() };
    let mut moved = Vec::new();
    for (&h, hole) in ground.plan.groups[group].holes.iter().zip(&shape.holes) {
        let id = ground.plan.holes[h].id;
        let end = first + hole.new_vertices;
        let hole = remesh_hole(ground, id, hole, &positions[first..end], options)?;
        out.holes.push(hole.0);
        moved.extend(hole.1);
        first = end;
    }
    Ok((out, moved))
}

fn remesh_hole(
    ground: Ground<'_>,
    id: LoopId,
    hole: &HoleShape,
    positions: &[DVec3],
    options: &FillOptions,
) -> Result<(HoleShape, Vec<DVec3>), ChangeError> {
    let present = Present::of(ground, id, hole, positions);
    let fresh = match &present.gap.rims[..] {
        [rim] => {
            let patch = |source| ChangeError::Patch { hole: id, source };
            let transfer = |source| ChangeError::Transfer { hole: id, source };
            let mut fresh = patch::fill(rim, &options.patch).map_err(patch)?;
            patch::transfer(&present.patch, &mut fresh, present.rim.len()).map_err(transfer)?;
            fresh
        }
        _ => patch::reblend(&present.gap, &present.patch, &options.patch),
    };
    Ok(present.shape_of(fresh))
}

/// A hole's patch as it is on its way.
struct Present {
    gap: patch::Gap,
    /// Vertices of the rims.
    rim: Vec<u32>,
    /// Vertices of the mesh.
    old: u32,
    /// The patch, the rims first.
    patch: PatchMesh,
}

impl Present {
    fn of(ground: Ground<'_>, id: LoopId, hole: &HoleShape, positions: &[DVec3]) -> Self {
        let old = ground.mesh.positions.len() as u32;
        let found = ground.gaps.iter().find(|gap| gap[0].id == id);
        let gap = gap_of(ground.mesh, found.expect("a planned hole has rims"));
        let rims = found.into_iter().flatten();
        let rim: Vec<u32> = rims.flat_map(|l| l.vertices.iter().map(|v| v.0)).collect();
        let count = rim.len() as u32;
        let mut place: Vec<(u32, u32)> = (0..).zip(&rim).map(|(i, &v)| (v, i)).collect();
        place.sort_unstable();
        let local = |v: u32| match place.binary_search_by_key(&v, |p| p.0) {
            Ok(at) => place[at].1,
            Err(_) => count + (v - old),
        };
        let mut points: Vec<DVec3> = gap.rims.iter().flat_map(|r| r.points.clone()).collect();
        points.extend_from_slice(positions);
        let triangles = hole.triangles.iter().map(|t| t.map(local)).collect();
        Self {
            gap,
            rim,
            old,
            patch: PatchMesh { points, triangles },
        }
    }

    /// Another patch over the same rims as a shape, and the positions of its new vertices.
    fn shape_of(&self, mut fresh: PatchMesh) -> (HoleShape, Vec<DVec3>) {
        let count = self.rim.len();
        let global = |v: u32| match self.rim.get(v as usize) {
            Some(&v) => v,
            None => self.old + (v - count as u32),
        };
        let shape = HoleShape {
            triangles: fresh.triangles.iter().map(|t| t.map(global)).collect(),
            new_vertices: fresh.points.len() - count,
        };
        (shape, fresh.points.split_off(count))
    }
}
