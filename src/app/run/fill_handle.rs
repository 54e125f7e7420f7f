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
        let words = |(hole, warning): &(LoopId, Warning)| {
            of_holes(&[hole.to_string()], &with_hint(warning))
        };
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
        let names = |group: usize| part_names(runner.groups()).swap_remove(group);
        let name = |hole: LoopId| name_of(runner.groups(), hole);
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
                let names = names(group);
                let text = format!(
                    "the patch intersects itself or the mesh, and the run is paused; continue, or choose \
                     another energy or more tension ({text}{back})"
                );
                let text = of_holes(&names, &text);
                let holes = hole_list(&names);
                vec![RunEvent::SelfIntersection { holes, text, place }]
            }
            FillEvent::Finished { group, outcome } => {
                let names = names(group);
                let warnings = outcome.warnings.iter();
                // the controls and the hatching show ill-posed points
                let told = warnings.filter(|w| !matches!(w, Warning::NotParabolic { .. }));
                let event = |w| RunEvent::Warning(of_holes(&names, &with_hint(w)));
                told.map(event).collect()
            }
            FillEvent::Warned { hole, warning } => {
                vec![RunEvent::Warning(of_holes(
                    &[name(hole)],
                    &with_hint(&warning),
                ))]
            }
            FillEvent::Failed { group, holes, text } => {
                let names = group.map_or_else(|| holes.into_iter().map(name).collect(), names);
                vec![RunEvent::Error(of_holes(&names, &text))]
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
        let names = part_names(runner.groups());
        let newest = runner.timeline().states.last().cloned();
        let groups = runner.groups().iter().enumerate();
        let row = |(g, group): (usize, &GroupStatus)| {
            let at = shown.and_then(|s| s.groups.get(g));
            let last = newest.as_ref().and_then(|s| s.groups.get(g));
            let end = match (&group.failed, group.end) {
                (Some(text), _) => Some(Err(text.clone())),
                (None, end) => end.map(Ok),
            };
            let iterations = group.iterations;
            let iterations = iterations.map_or_else(String::new, |n| format!("GMRES {n}  "));
            // nothing is left to wait for in a pause
            let eta = group.eta.filter(|_| runner.playing());
            let words = match eta {
                Some(seconds) => format!("about {} s left", seconds.ceil()),
                None if runner.playing() => String::new(),
                None => "paused".into(),
            };
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
                is_last: at
                    .zip(last)
                    .is_none_or(|(shown, last)| Arc::ptr_eq(shown, last)),
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

/// The name of a hole: the numbers of the loops that its patch closes.
fn hole_name(closed: &[LoopId]) -> String {
    let numbers: Vec<String> = closed.iter().map(LoopId::to_string).collect();
    numbers.join("+")
}

/// The name of the hole that a loop stands for.
fn name_of(groups: &[GroupStatus], hole: LoopId) -> String {
    let mut holes = groups
        .iter()
        .flat_map(|group| group.holes.iter().zip(&group.closed));
    let found = holes.find(|(id, _)| **id == hole);
    found.map_or_else(|| hole.to_string(), |(_, closed)| hole_name(closed))
}

/// The names of the holes of each group.
fn part_names(groups: &[GroupStatus]) -> Vec<Vec<String>> {
    names_of_parts(groups.iter().map(|group| &group.closed[..]))
}

/// The names of holes by the loops that their patches close. A hole that occurs several times is in parts, and each
/// of them has a number of its own.
fn names_of_parts<'a>(groups: impl Iterator<Item = &'a [Vec<LoopId>]> + Clone) -> Vec<Vec<String>> {
    let mut parts: BTreeMap<&[LoopId], [usize; 2]> = BTreeMap::new();
    for closed in groups.clone().flatten() {
        parts.entry(closed.as_slice()).or_default()[1] += 1;
    }
    let mut name = |closed: &'a Vec<LoopId>| {
        let [number, count] = parts.entry(closed.as_slice()).or_default();
        *number += 1;
        let name = hole_name(closed);
        if *count > 1 {
            format!("{name}.{number}")
        } else {
            name
        }
    };
    groups
        .map(|holes| holes.iter().map(&mut name).collect())
        .collect()
}

/// A message with the names of its holes before it.
fn of_holes(names: &[String], text: &str) -> String {
    let s = if names.len() == 1 { "" } else { "s" };
    format!("hole{s} {}: {text}", hole_list(names))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_of_a_hole_have_names_of_their_own() {
        let closed =
            |ids: &[usize]| -> Vec<Vec<LoopId>> { ids.iter().map(|&id| vec![id.into()]).collect() };
        let groups = [
            closed(&[0]),
            closed(&[3]),
            closed(&[1, 3]),
            closed(&[3, 3]),
            vec![vec![4.into(), 6.into()]],
        ];
        let names = names_of_parts(groups.iter().map(Vec::as_slice));
        let one = |id: usize| LoopId::from(id).to_string();
        let part = |k| format!("{}.{k}", one(3));
        let wanted = [
            vec![one(0)],
            vec![part(1)],
            vec![one(1), part(2)],
            vec![part(3), part(4)],
            vec![format!("{}+{}", one(4), one(6))],
        ];
        assert_eq!(names, wanted);
    }
}
