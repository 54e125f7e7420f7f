//! Fills from end to end: first patches, flows, the filled mesh.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Instant;

use rayon::prelude::*;

use crate::fill::Controls;
use crate::fill::assemble::Assembly;
use crate::fill::context::FillContext;
use crate::fill::options::FillOptions;
use crate::fill::plan::Plan;
use crate::fill::prepare::prepare;
use crate::fill::result::{FillError, Filled, FilledHole, milliseconds};
use crate::fill::rim::RimSet;
use crate::fill::scheduled::run_group;
use crate::mesh::{DVec3, Mesh, VertexId, self_intersections};
use crate::runner::{Recording, Schedule, ScheduleError};
use crate::solver::StepRecord;
use crate::warning::{MAX_PAIRS, Warning};

/// A callback for every attempted step, with (group, record). Returns whether the flow of the group
/// continues.
pub type Observer<'a> = &'a (dyn Fn(usize, &StepRecord) -> bool + Sync);

/// The options a fill starts with, and the changes to them during the flow.
#[derive(Clone, Debug)]
pub struct ScheduledOptions {
    pub(super) options: FillOptions,
    pub(super) recording: Recording<Controls>,
}

impl ScheduledOptions {
    /// The options with which a fill repeats, bit-identically, a [live fill](crate::fill::LiveFill)
    /// that started with `controls` and recorded `schedule`.
    ///
    /// # Errors
    /// Invalid controls or an invalid schedule.
    pub fn new(controls: &Controls, schedule: &Schedule) -> Result<Self, ScheduleError> {
        let recording = schedule.recording(controls)?;
        let options = controls.options();
        let options = options.map_err(|error| ScheduleError::Start(error.to_string()))?;
        Ok(Self { options, recording })
    }
}

impl From<&FillOptions> for ScheduledOptions {
    /// No changes.
    fn from(options: &FillOptions) -> Self {
        Self {
            options: options.clone(),
            recording: Recording::default(),
        }
    }
}

/// Fills holes and blends: one patch for each set of rims.
///
/// # Errors
/// The result would not be a manifold. Failures of single holes are in the result.
pub fn fill_rim_sets(
    mesh: &Mesh,
    rim_sets: &[RimSet<'_>],
    options: impl Into<ScheduledOptions>,
    observe: Observer<'_>,
) -> Result<Filled, FillError> {
    let start = Instant::now();
    let options = options.into();
    let plan = prepare(mesh, rim_sets, &options.options);
    let mut filled = run_plan(mesh, plan, &options, observe)?;
    filled.milliseconds = milliseconds(start);
    Ok(filled)
}

/// Runs the flows of a plan and inserts the patches into the mesh.
pub(super) fn run_plan(
    mesh: &Mesh,
    plan: Plan,
    options: &ScheduledOptions,
    observe: Observer<'_>,
) -> Result<Filled, FillError> {
    let start = Instant::now();
    let context = FillContext { mesh, plan: &plan };
    let ScheduledOptions { options, recording } = options;
    let topologies = plan.groups.iter().map(|g| Arc::clone(&g.topology));
    let (runs, assembly) = rayon::join(
        || {
            let groups = (0..plan.groups.len()).into_par_iter();
            let run = |g| run_group(context, g, options, recording, &|record| observe(g, record));
            groups.map(run).collect::<Vec<_>>()
        },
        || Assembly::new(mesh, &plan, topologies.collect(), options.label_patches),
    );
    let mut assembly = assembly?;
    if !assembly.fits(runs.iter().map(|run| &run.topology)) {
        let topologies = runs.iter().map(|run| Arc::clone(&run.topology));
        assembly = Assembly::new(mesh, &plan, topologies.collect(), options.label_patches)?;
    }
    let positions = runs.iter().map(|run| &run.positions[..]);
    let filled = assembly.mesh(mesh, positions);
    warn_of_crossing_groups(&filled, &mut assembly.holes);
    Ok(Filled {
        mesh: filled,
        holes: assembly.holes,
        failed: plan.failed,
        moved: assembly.moved,
        groups: runs.into_iter().map(|run| run.result).collect(),
        milliseconds: milliseconds(start),
    })
}

/// Adds a warning to the holes whose patches cross one of another group, or one without new vertices.
/// Each group itself is checked at the end of its flow.
fn warn_of_crossing_groups(filled: &Mesh, holes: &mut [FilledHole]) {
    let Some(first) = holes.first().map(|hole| hole.faces.start) else {
        return;
    };
    let faces: Vec<[u32; 3]> = filled.topology.triangles().skip(first).collect();
    let hole_of = |face: u32| holes.partition_point(|hole| hole.faces.end <= first + face as usize);
    // pairs and one of the places, by hole
    let mut found: BTreeMap<usize, (usize, DVec3)> = BTreeMap::new();
    for pair in self_intersections(&filled.positions, &faces, None, usize::MAX) {
        let [h, k] = pair.map(hole_of);
        if h == k || (holes[h].group.is_some() && holes[h].group == holes[k].group) {
            continue;
        }
        let corners = pair.map(|f| faces[f as usize].map(|v| filled.position(VertexId(v))));
        let at = corners.iter().flatten().sum::<DVec3>() / 6.0;
        for h in [h, k] {
            found.entry(h).or_insert((0, at)).0 += 1;
        }
    }
    for (h, (pairs, at)) in found {
        holes[h].warnings.push(Warning::SelfIntersection {
            pairs: pairs.min(MAX_PAIRS),
            at,
            kept_step: None,
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::boundary_loops;
    use crate::shapes;

    /// Two sheets with hills towards each other, whose tops are missing.
    #[test]
    fn patches_of_two_groups_that_cross_get_a_warning() {
        for (distance, is_crossing) in [(1.2, true), (2.5, false)] {
            let hill = |height: f64| {
                let z = move |x: f64, y: f64| height * (-3.0 * (x * x + y * y)).exp();
                shapes::cut_where(&shapes::graph(2.0, 24, z, 1), |p| {
                    p.truncate().length() < 0.5
                })
            };
            let (mut positions, mut triangles) = hill(0.9);
            let count = positions.len() as u32;
            let (above, more) = hill(-0.9);
            positions.extend(above.into_iter().map(|p| p + distance * DVec3::Z));
            triangles.extend(more.into_iter().map(|t| t.map(|v| v + count)));
            let mesh = Mesh::from_triangles(positions, &triangles).expect("a manifold");
            let loops = boundary_loops(&mesh);
            let holes = loops.iter().filter(|one| !one.is_outer_boundary);
            let holes: Vec<RimSet<'_>> = holes.map(|one| vec![one]).collect();
            assert_eq!(holes.len(), 2);
            let filled = fill_rim_sets(&mesh, &holes, &FillOptions::default(), &|_, _| true);
            let filled = filled.expect("filled");
            assert_eq!(filled.groups.len(), 2);
            for hole in &filled.holes {
                let codes: Vec<&str> = hole.warnings.iter().map(Warning::code).collect();
                assert_eq!(codes.contains(&"self-intersection"), is_crossing);
            }
        }
    }
}
