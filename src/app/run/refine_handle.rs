//! Refinements in the window.

use std::ops::Range;
use std::sync::Arc;

use super::handle::{Figures, RunEvent, StateView, WindowProcess, with_hint};
use crate::fill::Controls;
use crate::mesh::{DVec3, Mesh, Topology};
use crate::refine::{RefineControls, RefineEvent, RefineProcess, RefineSnapshot, RefineStatus};
use crate::render::{grouped, long_number};
use crate::runner::{Runner, Schedule};
use crate::solver::End;

/// The controls of a refinement after those of the window have changed. Without an energy of its
/// own, energy and tension are adapted to the mesh.
pub fn with_controls(refinement: &RefineControls, window: &Controls) -> RefineControls {
    let mut out = RefineControls {
        mode: window.mode,
        tau: window.tau,
        growth: window.growth,
        bulge: window.bulge,
        steps: window.steps,
        ..refinement.clone()
    };
    if refinement.energy.is_some() {
        out.energy = Some(window.energy.clone());
        out.param.clone_from(&window.param);
        out.tension = Some(window.tension);
    }
    out
}

impl StateView for RefineSnapshot {
    fn serial(&self) -> usize {
        self.serial
    }

    fn schedule(&self) -> Schedule {
        self.schedule()
    }

    fn topology(&self) -> &Arc<Topology> {
        &self.frame.topology
    }

    fn positions(&self, flat: bool) -> Vec<DVec3> {
        if flat || !self.frame.has_limit {
            self.points.to_vec()
        } else {
            self.control.to_vec()
        }
    }

    fn mesh(&self) -> Mesh {
        self.state.mesh()
    }

    fn patch_faces(&self) -> Option<Range<usize>> {
        None
    }

    fn has_limit(&self) -> bool {
        self.frame.has_limit
    }

    fn is_cut(&self) -> bool {
        self.frame.weld.is_some()
    }

    fn attempt(&self) -> usize {
        self.attempts
    }
}

impl WindowProcess for RefineProcess {
    fn controls(previous: &RefineControls, window: &Controls) -> RefineControls {
        with_controls(previous, window)
    }

    fn events(event: RefineEvent, _: &Runner<Self>) -> Vec<RunEvent> {
        let mut events = Vec::new();
        match event {
            RefineEvent::Step { record, .. } => events.push(RunEvent::Step(0, record)),
            RefineEvent::LevelDone(report) => {
                // subdivision schemes have no steps
                if report.steps > 0 {
                    events.push(RunEvent::Note(format!(
                        "level {}: {} vertices, energy {}, {} steps, {}",
                        report.level,
                        grouped(report.vertices),
                        long_number(report.energy_end),
                        report.steps,
                        report.end_name()
                    )));
                }
                let level = report.level;
                let warning = |w| RunEvent::Warning(format!("level {level}: {}", with_hint(w)));
                events.extend(report.warnings.iter().map(warning));
            }
            RefineEvent::Level { .. } => {}
        }
        events
    }

    fn radius(_: &RefineStatus) -> f64 {
        0.0
    }

    fn tau(_: &RefineStatus) -> Option<(f64, f64)> {
        None
    }

    fn figures(runner: &Runner<Self>, shown: Option<&RefineSnapshot>) -> Vec<Figures> {
        let status = runner.status();
        let end = match runner.failed() {
            Some(text) => Some(Err(text.to_owned())),
            None => runner.ended().then(|| {
                let last = status.reports.last();
                Ok(last.map_or(End::Converged, |level| level.end))
            }),
        };
        vec![Figures {
            holes: Vec::new(),
            names: Vec::new(),
            level: shown.map(|s| s.frame.level),
            step: shown.map(|s| s.step),
            relative_tau: status.relative_tau,
            energy: shown.map(|s| s.energy).filter(|e| e.is_finite()),
            residual: shown.and_then(|s| s.residual),
            rejected: status.rejected,
            angle: None,
            is_last: shown.is_none_or(|shown| {
                let timeline = runner.timeline();
                let last = timeline.states.last();
                last.is_some_and(|last| std::ptr::eq(last.as_ref(), shown))
            }),
            end,
            unsound: Vec::new(),
            surface: None,
            uses_energy: true,
            eta: None,
            doing: format!(
                "level {} of {}, {} vertices",
                status.level,
                status.levels,
                grouped(status.vertices)
            ),
        }]
    }
}
