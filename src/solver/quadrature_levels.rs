//! What a surface held at points is measured and watched with, beside the elements of its energy.

use std::borrow::Cow;

use crate::solver::FlowProblem;
use crate::solver::assembly::Assembler;
use crate::solver::unknowns::Unknowns;
use crate::subdivision::{self, Elements, Rule};

/// Points that are enough for the metric of a step, which need not be exact.
pub const PRECONDITIONER_RULE: Rule = Rule::Twelve;
/// Points at which normals are watched for folds.
pub const FOLD_CHECK_RULE: Rule = Rule::FortyEight;

/// The elements of a problem with tables for `rule` or, if that is finer, for `most`; `elements` have
/// those for `rule`.
pub fn coarsened<'a>(
    problem: &FlowProblem,
    elements: &'a Elements,
    rule: Rule,
    most: Rule,
) -> Cow<'a, Elements> {
    if rule <= most {
        return Cow::Borrowed(elements);
    }
    Cow::Owned(subdivision::elements(
        problem.topology(),
        problem.active_faces(),
        most,
    ))
}

/// What energies and gradients are assembled by, at the points of `rule`, and what makes matrices, at no
/// more points than `most` has, where that is not the same; both with the unknowns in one order.
pub fn energy_and_preconditioner(
    problem: &FlowProblem,
    elements: &Elements,
    rule: Rule,
    most: Rule,
) -> (Assembler, Option<Assembler>) {
    let unknowns = Unknowns::new(elements, problem.positions(), &problem.moving());
    if rule <= most {
        return (Assembler::new(elements, rule, unknowns), None);
    }
    let coarse = coarsened(problem, elements, rule, most);
    let mut maker = Assembler::new(&coarse, most, unknowns);
    // takes from the unknowns what only a matrix needs
    maker.pattern();
    let exact = Assembler::new(elements, rule, maker.unknowns().clone());
    (exact, Some(maker))
}
