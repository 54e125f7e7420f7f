//! Replacement of unsound patches by sound surfaces: by local repair, by other models, and on other
//! triangulations.

mod first_patch;
mod hole;
mod replacement;
mod solve;
#[cfg(test)]
mod tests;

use rayon::prelude::*;

use crate::cancel::is_cancelled;
use crate::fill::context::FillContext;
use crate::fill::defects::{Defects, Patches, severity};
use crate::fill::options::FillOptions;
use crate::fill::patch_topology::PatchTopology;
use crate::fill::surface_choice::Counterpart;
use crate::fill::surface_choice::{Candidate, OtherSurface};
use crate::mesh::{DVec3, LoopId};
use crate::warning::{MAX_PAIRS, Warning};
pub(super) use first_patch::plan_of;
use hole::HoleOfGroup;
use replacement::{Origin, Replacement, Surface};
use solve::{SAFER, solved};

/// The patches of a group after the check for soundness.
pub(super) struct Checked {
    /// The patches and their new vertices, if one was replaced.
    pub replaced: Option<(PatchTopology, Vec<DVec3>)>,
    /// What was replaced, and which defects are left, by hole.
    pub warnings: Vec<(LoopId, Warning)>,
    /// The holes with patches by another surface model or on another triangulation.
    pub others: Vec<OtherSurface>,
}

/// Checks the patches of a group with new vertices at `positions`, filled by `model` with `options`. A wrinkled patch
/// by a predicted model is replaced by a [smoother](HoleOfGroup::smoother) one. An unsound
/// patch is [repaired](HoleOfGroup::repaired) near its defects or else replaced by the first sound surface of
/// [other models](SAFER) or of other triangulations, or by the least unsound. The
/// other patches of its group are solved again beside it. Where a
/// [part of the mesh passes](HoleOfGroup::passing_part) through a hole, only the first of the other models and the
/// first patch are tried.
pub(super) fn make_sound(
    context: FillContext<'_>,
    group: usize,
    topology: &PatchTopology,
    positions: Vec<DVec3>,
    model: Candidate,
    counterparts: &[Option<Counterpart>],
    options: &FillOptions,
) -> Checked {
    let given = (topology.clone(), positions);
    let mut check = Check::new(context, group, given.clone(), model, counterparts, options);
    if options.predicts_surface {
        check.replace_wrinkled();
    }
    // a smoother patch stays when others of the group are filled again by the chosen model
    let (sound, unsound): (Vec<usize>, Vec<usize>) = (0..check.holes.len())
        .filter(|&k| check.origins[k].is_none())
        .partition(|&k| check.found[k].is_none());
    let (passed, unsound): (Vec<usize>, Vec<usize>) = unsound
        .into_iter()
        .partition(|&k| check.passing[k].is_some());
    check.replace_worse(&passed);
    check.repair(&unsound);
    let is_left = |&k: &usize| check.origins[k].is_none() && !check.holes[k].rims.is_blend();
    let left: Vec<usize> = unsound.into_iter().filter(is_left).collect();
    check.fill_alike(&left);
    check.fill_otherwise(&left);
    let again = check.solve_again(sound, left);
    check.outcome(&given, &again)
}

/// Maximum number of holes that are filled alike. Rims side by side are two, seldom more; for the dozens of unsound holes of a
/// riddled mesh the trials take minutes.
const MAX_ALIKE: usize = 4;

/// The check of the patches of a group. Holes have their numbers in the group.
struct Check<'a> {
    holes: Vec<HoleOfGroup<'a>>,
    /// Those that the holes follow; none unless the model is symmetric.
    counterparts: &'a [Option<Counterpart>],
    options: &'a FillOptions,
    /// The chosen model.
    model: Candidate,
    present: Surface,
    /// The defects of the patches at the beginning.
    found: Vec<Option<Defects>>,
    /// Where a part of the mesh passes through holes whose patches intersect something.
    passing: Vec<Option<DVec3>>,
    /// What the patches were replaced by.
    origins: Vec<Option<Origin>>,
}

impl<'a> Check<'a> {
    fn new(
        context: FillContext<'a>,
        group: usize,
        present: Surface,
        model: Candidate,
        counterparts: &'a [Option<Counterpart>],
        options: &'a FillOptions,
    ) -> Self {
        let holes = context.plan.holes_of(group).enumerate();
        let holes: Vec<HoleOfGroup<'_>> = holes
            .map(|(number, hole)| HoleOfGroup {
                context,
                group,
                number,
                rims: &hole.rims,
            })
            .collect();
        let mut check = Self {
            counterparts,
            options,
            model,
            present,
            found: Vec::new(),
            passing: Vec::new(),
            origins: vec![None; holes.len()],
            holes,
        };
        check.found = check.defects();
        let passing = |(hole, found): (&HoleOfGroup<'_>, &Option<Defects>)| {
            found.as_ref()?.crossings?;
            hole.passing_part()
        };
        let found = check.holes.par_iter().zip(&check.found);
        check.passing = found.map(passing).collect();
        check
    }

    /// The defects of the present patches.
    fn defects(&self) -> Vec<Option<Defects>> {
        let Some(HoleOfGroup { context, group, .. }) = self.holes.first() else {
            return Vec::new();
        };
        let (topology, positions) = &self.present;
        let patches = Patches::new(*context, *group, topology, positions);
        let of = |hole: &HoleOfGroup<'_>| hole.defects_among(&patches, positions);
        self.holes.par_iter().map(of).collect()
    }

    /// Takes another surface, by which the patch of a hole is replaced.
    fn replace(&mut self, k: usize, by: Option<Replacement>) {
        if let Some(by) = by {
            self.present = by.surface;
            self.origins[k] = Some(by.origin);
        }
    }

    /// Replaces wrinkled and far patches by smoother and nearer ones.
    fn replace_wrinkled(&mut self) {
        for k in 0..self.holes.len() {
            let smoother = self.holes[k].smoother(&self.present, self.options);
            self.replace(k, smoother);
        }
    }

    /// Replaces patches by those of the first of the [safer models](SAFER) or by the first patches, if these have
    /// fewer defects.
    fn replace_worse(&mut self, some: &[usize]) {
        for &k in some {
            if is_cancelled() {
                break;
            }
            let hole = &self.holes[k];
            let is_other = self.model != SAFER[0];
            let safer = is_other.then(|| hole.by(&self.present, SAFER[0], self.options));
            let safer = safer
                .flatten()
                .map(|by| hole.replacement(by, Some(SAFER[0].words())));
            let first = hole.at_first_patch(&self.present, self.options);
            let first = hole.replacement(first, Some("the first patch".into()));
            let others = safer.into_iter().chain([first]);
            let better = others.filter(|by| severity(by.defects) < severity(self.found[k]));
            let best = better.min_by_key(|by| severity(by.defects));
            self.replace(k, best);
        }
    }

    /// Repairs patches near their defects where these are local. There is no other surface for a blend.
    fn repair(&mut self, unsound: &[usize]) {
        for &k in unsound {
            if is_cancelled() {
                break;
            }
            let hole = &self.holes[k];
            let unsound = hole.replacement(self.present.clone(), None);
            let is_repaired = hole.rims.is_blend() || hole.has_local_defects(&unsound);
            let repaired = is_repaired.then(|| hole.repaired(&unsound)).flatten();
            self.replace(k, repaired);
        }
    }

    /// Fills several unsound holes by the first of the [safer models](SAFER) by which all
    /// are sound, repaired if need be: the patches over two rims side by side cross each
    /// other unless both are flat. Nothing happens for fewer than two holes, for more than [`MAX_ALIKE`], and if
    /// some stay unsound.
    fn fill_alike(&mut self, unsound: &[usize]) {
        if !(2..=MAX_ALIKE).contains(&unsound.len()) {
            return;
        }
        let holes = || unsound.iter().map(|&k| &self.holes[k]);
        let filled = |safer: Candidate| {
            let mut surface = self.present.clone();
            for hole in holes() {
                surface = hole.by(&surface, safer, self.options)?;
            }
            for hole in holes() {
                let next = hole.replacement(surface.clone(), None);
                if !next.is_sound() {
                    surface = hole.repaired(&next)?.surface;
                }
            }
            Some((surface, safer.words()))
        };
        let mut safer = SAFER.into_iter().filter(|&safer| safer != self.model);
        if let Some((surface, by)) = safer.find_map(filled) {
            self.present = surface;
            for &k in unsound {
                self.origins[k] = Some(Origin {
                    other: Some(by.clone()),
                    ..Origin::default()
                });
            }
        }
    }

    /// Fills the holes that are still unsound one by one: repaired, by other models, on other triangulations.
    fn fill_otherwise(&mut self, unsound: &[usize]) {
        for &k in unsound {
            if is_cancelled() {
                break;
            }
            let hole = &self.holes[k];
            let by = self.origins[k].clone().and_then(|origin| origin.other);
            let unsound = hole.replacement(self.present.clone(), by);
            if unsound.is_sound() {
                continue;
            }
            let repaired = || hole.repaired(&unsound);
            let better = || hole.better(&unsound, self.model, self.options);
            let better = if hole.has_local_defects(&unsound) {
                repaired().or_else(better)
            } else {
                let better = better();
                let is_sound = better.as_ref().is_some_and(Replacement::is_sound);
                let repaired = (!is_sound).then(repaired).flatten();
                repaired.or(better)
            };
            self.replace(k, better);
        }
    }

    /// If some of the holes that were `left` unsound have other patches now, fills the `sound` holes together and
    /// then each of the others by the chosen model again. Returns those for which that gave sound patches.
    fn solve_again(&mut self, sound: Vec<usize>, left: Vec<usize>) -> Vec<usize> {
        let mut again = Vec::new();
        if self.holes.len() == 1 || left.iter().all(|&k| self.origins[k].is_none()) {
            return again;
        }
        let alone = left.into_iter().map(|k| vec![k]);
        for some in std::iter::once(sound).chain(alone) {
            if let Some(surface) = self.solved_again(&some) {
                self.present = surface;
                again.extend(some);
            }
        }
        again
    }

    /// Some holes filled by the chosen model from their first patches with the other patches
    /// fixed. `None` if that fails or one of them is not sound.
    fn solved_again(&self, some: &[usize]) -> Option<Surface> {
        let HoleOfGroup { context, group, .. } = self.holes[*some.first()?];
        let mut start = self.present.clone();
        for &k in some {
            start = self.holes[k].at_first_patch(&start, self.options);
        }
        let of_some = |(k, counterpart): (usize, &Option<Counterpart>)| {
            counterpart.filter(|_| some.contains(&k))
        };
        let counterparts: Vec<_> = self.counterparts.iter().enumerate().map(of_some).collect();
        let surface = solved(context, group, some, &start, &counterparts, self.options)?;
        let patches = Patches::new(context, group, &surface.0, &surface.1);
        let is_sound = |&k: &usize| self.holes[k].defects_among(&patches, &surface.1).is_none();
        some.iter().all(is_sound).then_some(surface)
    }

    /// What became of the patches that were `given`. Patches that were solved `again` have no other model.
    fn outcome(mut self, given: &Surface, again: &[usize]) -> Checked {
        let (mut warnings, mut others) = (Vec::new(), Vec::new());
        let is_replaced = self.origins.iter().any(Option::is_some);
        if is_replaced || self.found.iter().any(Option::is_some) {
            let left = self.defects();
            for ((k, hole), left) in self.holes.iter().enumerate().zip(left) {
                let id = hole.rims.id();
                let by = self.origins[k].take().filter(|_| !again.contains(&k));
                if let Some(by) = by {
                    if let Some(by) = by.other.clone() {
                        others.push(OtherSurface { hole: id, by });
                    }
                    let [pairs, escaped, folds] = severity(self.found[k]);
                    let replaced = Warning::Replaced {
                        model: self.model.words(),
                        by: by.other,
                        is_repaired: by.is_repaired,
                        pairs: pairs.min(MAX_PAIRS),
                        escaped,
                        folds,
                        bending: by.bending,
                        reach: by.reach,
                    };
                    warnings.push((id, replaced));
                }
                let crosses = left.as_ref().is_some_and(|left| left.crossings.is_some());
                let passed = self.passing[k].filter(|_| crosses);
                let passed = passed.map(|at| Warning::PassedThrough { at });
                let left = left.iter().flat_map(Defects::warnings).chain(passed);
                warnings.extend(left.map(|warning| (id, warning)));
            }
        }
        Checked {
            replaced: (self.present != *given).then_some(self.present),
            warnings,
            others,
        }
    }
}
