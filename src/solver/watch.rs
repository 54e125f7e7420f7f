//! What a surface held at points is watched and measured with, beside the elements of its energy.

use std::borrow::Cow;

use crate::solver::FlowProblem;
use crate::subdivision::{self, Elements, Rule, TableCache};

/// Points that are enough for the metric of a step, which need not be exact.
pub const METRIC: Rule = Rule::Twelve;
/// Points at which normals are watched for folds.
pub const FOLDS: Rule = Rule::FortyEight;

/// The elements of a problem with tables for `rule` or, if that is coarser, for `most`; `elements` have
/// those for `rule`.
pub fn at_most<'a>(
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
        &mut TableCache::default(),
    ))
}
