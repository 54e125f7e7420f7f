//! Fills from end to end: flows, the filled mesh.

use std::sync::Arc;
use std::time::Instant;

use rayon::prelude::*;

use crate::fill::assemble::Assembly;
use crate::fill::attributes::Look;
use crate::fill::context::FillContext;
use crate::fill::defects::defects_between_groups;
use crate::fill::estimate::memory_of;
use crate::fill::prepared::{PreparedFill, ScheduledOptions};
use crate::fill::result::{FillError, Filled, milliseconds};
use crate::fill::rim::RimSet;
use crate::fill::scheduled::run_group;
use crate::memory::require;
use crate::mesh::Mesh;
use crate::solver::StepRecord;

/// A callback for every attempted step, with (group, record). Returns whether the flow of the group
/// continues.
pub type Observer<'a> = &'a (dyn Fn(usize, &StepRecord) -> bool + Sync);

/// Fills holes and blends: one patch for each set of rims.
///
/// # Errors
/// The result would not be a manifold, or the flows need more memory than is free. Failures of single
/// holes are in the result.
pub fn fill_rim_sets(
    mesh: &Mesh,
    rim_sets: &[RimSet<'_>],
    options: impl Into<ScheduledOptions>,
    observe: Observer<'_>,
) -> Result<Filled, FillError> {
    PreparedFill::new(mesh, rim_sets, &[], options).run(observe)
}

impl PreparedFill<'_> {
    /// Runs the flows and inserts the patches into the mesh.
    ///
    /// # Errors
    /// As [`fill_rim_sets`].
    pub fn run(self, observe: Observer<'_>) -> Result<Filled, FillError> {
        let start = Instant::now();
        let Self {
            mesh,
            plan,
            options: ScheduledOptions { options, recording },
            milliseconds: preparation,
        } = self;
        let mesh: &Mesh = &mesh;
        let (options, recording) = (&options, &recording);
        let context = FillContext { mesh, plan: &plan };
        let memory = memory_of(mesh, &plan, options);
        require(memory)?;
        let look = Look::new(options);
        let topologies = plan.groups.iter().map(|g| Arc::clone(&g.topology));
        let (runs, assembly) = rayon::join(
            || {
                let groups = (0..plan.groups.len()).into_par_iter();
                let run =
                    |g| run_group(context, g, options, recording, &|record| observe(g, record));
                groups.map(run).collect::<Vec<_>>()
            },
            || Assembly::new(mesh, &plan, topologies.collect(), &look),
        );
        let mut assembly = assembly?;
        if !assembly.fits(runs.iter().map(|run| &run.topology)) {
            let topologies = runs.iter().map(|run| Arc::clone(&run.topology));
            assembly = Assembly::new(mesh, &plan, topologies.collect(), &look)?;
        }
        let positions = runs.iter().map(|run| &run.positions[..]);
        let (filled, without_texture) = assembly.mesh(mesh, positions);
        let between = defects_between_groups(&filled.topology, &filled.positions, &assembly.holes);
        let of_patches = runs
            .iter()
            .flat_map(|run| run.patch_warnings.iter().cloned());
        for (id, warning) in of_patches.chain(between).chain(without_texture) {
            if let Some(hole) = assembly.holes.iter_mut().find(|hole| hole.id() == id) {
                hole.warnings.push(warning);
            }
        }
        Ok(Filled {
            mesh: filled,
            holes: assembly.holes,
            failed: plan.failed,
            moved: assembly.moved,
            groups: runs.into_iter().map(|run| run.result).collect(),
            milliseconds: preparation + milliseconds(start),
            memory_estimate: memory as u64,
        })
    }
}
