//! Fills in the window.

use std::ops::Range;
use std::sync::Arc;

use super::handle::{Figures, RunEvent, StateView, WindowProcess, warning_event, with_hint};
use crate::fill::{Controls, FillEvent, FillProcess, FillSnapshot, FillTimeline, GroupStatus};
use crate::mesh::{DVec3, LoopId, Mesh, Topology};
use crate::runner::{Runner, Schedule};
use crate::warning::Warning;

impl StateView for FillSnapshot {
    fn serial(&self) -> usize {
        self.serial
    }

    fn schedule(&self) -> Schedule {
        self.schedule()
    }

    fn topology(&self) -> &Arc<Topology> {
        self.state.topology()
    }

    fn positions(&self, _flat: bool) -> Vec<DVec3> {
        self.state.positions()
    }

    fn mesh(&self) -> Mesh {
        self.state.mesh()
    }

    fn mesh_with_warnings(&self) -> (Mesh, Vec<String>) {
        let (mesh, warnings) = self.state.mesh_with_warnings();
        let words = |(hole, warning): &(LoopId, Warning)| of_hole(*hole, warning);
        (mesh, warnings.iter().map(words).collect())
    }

    fn makes_images(&self) -> bool {
        self.state.makes_images()
    }

    fn patch_faces(&self) -> Option<Range<usize>> {
        Some(self.state.patch_faces())
    }

    fn has_limit(&self) -> bool {
        true
    }

    fn is_cut(&self) -> bool {
        false
    }

    fn attempt(&self) -> usize {
        self.clock
    }
}

impl WindowProcess for FillProcess {
    fn controls(_: &Controls, window: &Controls) -> Controls {
        window.clone()
    }

    fn events(event: FillEvent, timeline: &FillTimeline) -> Vec<RunEvent> {
        match event {
            FillEvent::Step { group, record } => vec![RunEvent::Step(group, record)],
            FillEvent::SelfIntersection {
                group,
                place,
                last_good,
                text,
            } => {
                let is_last_good = |s: &Arc<FillSnapshot>| Some(s.groups[group].step) == last_good;
                let back = timeline.states.iter().rposition(is_last_good);
                let back = back.map_or_else(String::new, |at| {
                    format!(
                        "; state {} is the last checked state without an intersection",
                        at + 1
                    )
                });
                let text = format!("the surface intersects itself or the mesh: {text}{back}");
                vec![RunEvent::SelfIntersection { text, place }]
            }
            FillEvent::Finished { outcome, .. } => {
                outcome.warnings.iter().filter_map(warning_event).collect()
            }
            FillEvent::Warned { hole, warning } => {
                vec![RunEvent::Warning(of_hole(hole, &warning))]
            }
            FillEvent::Failed { text, .. } => vec![RunEvent::Error(text)],
        }
    }

    fn radius(groups: &Vec<GroupStatus>) -> f64 {
        groups.iter().map(|g| g.radius).fold(0.0, f64::max)
    }

    fn tau(groups: &Vec<GroupStatus>) -> Option<(f64, f64)> {
        groups.first().map(|g| (g.tau, g.tau_ref))
    }

    fn figures(runner: &Runner<Self>, shown: Option<&FillSnapshot>) -> Vec<Figures> {
        let groups = runner.groups().iter().enumerate();
        let row = |(g, group): (usize, &GroupStatus)| {
            let at = shown.and_then(|s| s.groups.get(g));
            let end = match (&group.failed, group.end) {
                (Some(text), _) => Some(Err(text.clone())),
                (None, end) => end.map(Ok),
            };
            let iterations = group.iterations;
            let iterations = iterations.map_or_else(String::new, |n| format!("GMRES {n}  "));
            let eta = group.eta;
            let words = eta.map_or_else(String::new, |s| format!("about {} s left", s.ceil()));
            Figures {
                holes: group.holes.clone(),
                level: None,
                step: at.map(|s| s.step),
                relative_tau: Some(at.and_then(|s| s.tau).unwrap_or(group.tau) / group.tau_ref),
                energy: at.map(|s| s.energy),
                residual: at.and_then(|s| s.residual),
                rejected: group.rejected,
                angle: at.map(|s| s.worst_angle),
                end,
                surface: group.surface.words(),
                eta: eta.filter(|_| group.end.is_none()),
                doing: iterations + &words,
            }
        };
        groups.map(row).collect()
    }
}

/// A warning about a hole with its remedy in the window.
fn of_hole(hole: LoopId, warning: &Warning) -> String {
    format!("hole {hole}: {}", with_hint(warning))
}
