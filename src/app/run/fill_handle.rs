//! Fills in the window.

use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;

use super::handle::{Figures, RunEvent, StateView, WindowProcess, hole_list, with_hint};
use crate::fill::{Controls, FillEvent, FillProcess, FillSnapshot, GroupStatus};
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
        let words = |(hole, warning): &(LoopId, Warning)| of_holes(&[*hole], &with_hint(warning));
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

    fn events(event: FillEvent, runner: &Runner<Self>) -> Vec<RunEvent> {
        match event {
            FillEvent::Step { group, record } => vec![RunEvent::Step(group, record)],
            FillEvent::SelfIntersection {
                group,
                place,
                last_good,
                text,
            } => {
                let timeline = runner.timeline();
                let is_last_good = |s: &Arc<FillSnapshot>| Some(s.groups[group].step) == last_good;
                let back = timeline.states.iter().rposition(is_last_good);
                let back = back.map_or_else(String::new, |at| {
                    format!(
                        "; state {} is the last checked state without an intersection",
                        at + 1
                    )
                });
                let text = format!("the surface intersects itself or the mesh: {text}{back}");
                let text = of_holes(&runner.groups()[group].holes, &text);
                vec![RunEvent::SelfIntersection { text, place }]
            }
            FillEvent::Finished { group, outcome } => {
                let holes = &runner.groups()[group].holes;
                let warnings = outcome.warnings.iter();
                // the controls and the hatching show ill-posed points
                let told = warnings.filter(|w| !matches!(w, Warning::NotParabolic { .. }));
                let event = |w| RunEvent::Warning(of_holes(holes, &with_hint(w)));
                told.map(event).collect()
            }
            FillEvent::Warned { hole, warning } => {
                vec![RunEvent::Warning(of_holes(&[hole], &with_hint(&warning)))]
            }
            FillEvent::Failed { holes, text, .. } => {
                vec![RunEvent::Error(of_holes(&holes, &text))]
            }
        }
    }

    fn radius(groups: &Vec<GroupStatus>) -> f64 {
        groups.iter().map(|g| g.radius).fold(0.0, f64::max)
    }

    fn tau(groups: &Vec<GroupStatus>) -> Option<(f64, f64)> {
        groups.first().map(|g| (g.tau, g.tau_ref))
    }

    fn figures(runner: &Runner<Self>, shown: Option<&FillSnapshot>) -> Vec<Figures> {
        let names = part_names(runner.groups().iter().map(|group| &group.holes[..]));
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
                names: names[g].clone(),
                level: None,
                step: at.map(|s| s.step),
                relative_tau: Some(at.and_then(|s| s.tau).unwrap_or(group.tau) / group.tau_ref),
                energy: at.map(|s| s.energy),
                residual: at.and_then(|s| s.residual),
                rejected: group.rejected,
                angle: at.map(|s| s.worst_angle),
                end,
                unsound: group.unsound.clone(),
                surface: Some(group.surface.clone()),
                uses_energy: group.surface.model.uses_energy(),
                eta: eta.filter(|_| group.end.is_none()),
                doing: iterations + &words,
            }
        };
        groups.map(row).collect()
    }
}

/// The names of the holes of each group: their numbers. A hole that occurs several times is in parts, and each
/// of them has a number of its own.
fn part_names<'a>(groups: impl Iterator<Item = &'a [LoopId]> + Clone) -> Vec<Vec<String>> {
    let mut parts: BTreeMap<LoopId, [usize; 2]> = BTreeMap::new();
    for id in groups.clone().flatten() {
        parts.entry(*id).or_default()[1] += 1;
    }
    let mut name = |id: &LoopId| {
        let [number, count] = parts.entry(*id).or_default();
        *number += 1;
        if *count > 1 {
            format!("{id}.{number}")
        } else {
            id.to_string()
        }
    };
    groups
        .map(|holes| holes.iter().map(&mut name).collect())
        .collect()
}

/// A message with the numbers of its holes before it.
fn of_holes(holes: &[LoopId], text: &str) -> String {
    let names: Vec<String> = holes.iter().map(LoopId::to_string).collect();
    let s = if holes.len() == 1 { "" } else { "s" };
    format!("hole{s} {}: {text}", hole_list(&names))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_of_a_hole_have_names_of_their_own() {
        let groups: [&[LoopId]; 4] = [
            &[0.into()],
            &[3.into()],
            &[1.into(), 3.into()],
            &[3.into(), 3.into()],
        ];
        let names = part_names(groups.into_iter());
        let one = |id: usize| LoopId::from(id).to_string();
        let part = |k| format!("{}.{k}", one(3));
        let wanted = [
            vec![one(0)],
            vec![part(1)],
            vec![one(1), part(2)],
            vec![part(3), part(4)],
        ];
        assert_eq!(names, wanted);
    }
}
