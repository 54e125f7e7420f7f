//! The repair of the whole mesh, in the background.

use std::sync::Arc;

use super::refuse_while_running;
use super::runs::has_valid_energy;
use crate::app::jobs::Reporter;
use crate::app::model::{Done, Model, Repaired};
use crate::fill::Controls;
use crate::mesh::Mesh;
use crate::ops::{CleanSpec, Condition, DamageSpec, FlowSpec, Operation, Repair, RepairStep};
use crate::solver::Mode;
use crate::warning::{Place, Warning};

/// The name of the job.
pub(crate) const REPAIRING: &str = "repair of the mesh";

/// Whether a repair is in progress.
pub(crate) fn is_repairing(model: &Model) -> bool {
    model.jobs.iter().any(|job| job.what == REPAIRING)
}

/// Starts a repair.
pub(super) fn start(model: &mut Model) {
    if refuse_while_running(model, "a repair") || !has_valid_energy(model) {
        return;
    }
    let base = Arc::clone(&model.document.mesh);
    let controls = Controls {
        // no state of the flow is shown
        mode: Mode::Fast,
        // these loops are not those of the repaired mesh
        loop_continuity: Controls::default().loop_continuity,
        ..model.document.controls.clone()
    };
    model.log.info("the mesh is being repaired; Esc cancels");
    model.spawn(REPAIRING, move |reporter| {
        let repaired = repair(&base, controls, reporter);
        Done::Repaired(base, repaired.map(Box::new))
    });
}

/// Cancels the repair. Returns whether there was one.
pub(super) fn cancel(model: &mut Model) -> bool {
    let is_cancelled = is_repairing(model);
    if is_cancelled {
        model.jobs.retain(|job| job.what != REPAIRING);
        model
            .log
            .info("the repair was cancelled; the mesh is unchanged");
    }
    is_cancelled
}

/// # Errors
/// Why there is no result, for the user.
fn repair(base: &Mesh, controls: Controls, reporter: &Reporter) -> Result<Repaired, String> {
    let flow = FlowSpec::from(controls);
    let mut repair = Repair::new(CleanSpec::default(), DamageSpec::default(), flow);
    let (mut steps, mut notes) = (Vec::<RepairStep>::new(), Vec::new());
    loop {
        let mesh = steps.last().map_or(base, |step| step.outcome.mesh());
        if !reporter.is_wanted() {
            return Err("the repair was cancelled".into());
        }
        let step = repair.step(
            mesh,
            |operation| operation.run(mesh, &|_, _| reporter.is_wanted()),
            |error| notes.push(format!("damaged faces were not replaced: {error}")),
        );
        match step {
            Ok(Some(step)) => steps.push(step),
            Ok(None) => {
                let after = Condition::of(mesh);
                return Ok(Repaired {
                    steps,
                    notes,
                    after,
                });
            }
            Err(error) => return Err(format!("the mesh could not be repaired: {error}")),
        }
    }
}

/// Makes the repaired mesh that of the document, in one change.
pub(super) fn repaired(model: &mut Model, base: &Arc<Mesh>, result: Result<Box<Repaired>, String>) {
    if !Arc::ptr_eq(base, &model.document.mesh) {
        let text = "the mesh has changed during its repair, whose result was discarded";
        return model.log.warning(text);
    }
    let Repaired {
        steps,
        notes,
        after,
    } = match result {
        Ok(repaired) => *repaired,
        Err(text) => return model.log.error(text),
    };
    for note in notes {
        model.log.warning(note);
    }
    let mut done: Vec<String> = steps.iter().map(RepairStep::words).collect();
    if steps.is_empty() {
        done.push("nothing was found that can be repaired".into());
    } else {
        model.history.record(&model.document, "repair", None);
        for step in steps {
            for warning in warnings(&step) {
                model.log.warning(warning);
            }
            model.document.accept_outcome(step.operation, step.outcome);
        }
        model.revision += 1;
        model.view.hover.clear();
    }
    model.log.info(format!(
        "repair: {}. The mesh has {}",
        done.join("; "),
        after.words()
    ));
    if let Some(at) = after.place {
        model
            .log
            .warning(format!("{} left, one near {}", after.pairs(), Place(at)));
    }
    let open = model.document.loops.iter();
    let reasons: Vec<String> = open
        .filter(|l| l.is_outer_boundary)
        .map(|l| format!("loop {} ({} edges): {}", l.id, l.edges(), l.reason))
        .take(MAX_REASONS)
        .collect();
    if !reasons.is_empty() {
        model.log.warning(format!(
            "{} left open; select one in Fill to fill it nevertheless. {}",
            model.document.loop_count(),
            reasons.join("; ")
        ));
    }
}

/// Maximum number of open loops whose reasons are listed.
const MAX_REASONS: usize = 3;

/// Warnings about the patches of all holes.
fn warnings(step: &RepairStep) -> Vec<String> {
    let filled = match &step.operation {
        Operation::Fill(_) => step.outcome.filled(),
        // the next steps replace what is wrong
        _ => None,
    };
    let patches = filled.into_iter().flat_map(|filled| &filled.holes);
    // the numbers of the filled loops are no longer those in the list
    let warnings = patches.flat_map(|hole| {
        let named = |w: &Warning| format!("hole with {} edges: {w}", hole.edges);
        hole.warnings.iter().map(named)
    });
    let failed = filled.into_iter().flat_map(|filled| &filled.failed);
    warnings.chain(failed.map(ToString::to_string)).collect()
}
