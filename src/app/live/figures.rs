//! Figures of flows, in rows.

use super::{Live, Shape};
use crate::fill::LiveFill;
use crate::mesh::LoopId;
use crate::refine::LiveRefine;
use crate::solver::End;

/// A row of figures: of a group of holes, or of a refinement.
#[derive(Clone, Debug, Default)]
pub struct Figures {
    /// Loops solved together; none for a refinement.
    pub holes: Vec<LoopId>,
    /// The level of a refinement.
    pub level: Option<usize>,
    /// Accepted steps at the state that is shown.
    pub step: Option<usize>,
    /// Time step over the natural time.
    pub relative_tau: Option<f64>,
    /// Energy at the state.
    pub energy: Option<f64>,
    /// Residual at the state.
    pub residual: Option<f64>,
    /// Rejected attempts.
    pub rejected: usize,
    /// Smallest angle of a triangle, degrees.
    pub angle: Option<f64>,
    /// How it has ended.
    pub end: Option<Result<End, String>>,
    /// What it is busy with.
    pub doing: String,
}

impl Live {
    /// A row for each group, at the state that is shown.
    pub fn figures(&self, shown: Option<&Shape>) -> Vec<Figures> {
        match self {
            Self::Fill(live) => fill_figures(live, shown),
            Self::Refine(live) => vec![refine_figures(live, shown)],
        }
    }
}

fn fill_figures(live: &LiveFill, shown: Option<&Shape>) -> Vec<Figures> {
    let state = match shown {
        Some(Shape::Fill(state)) => Some(state),
        _ => None,
    };
    let groups = live.groups().iter().enumerate();
    groups
        .map(|(g, group)| {
            let at = state.and_then(|s| s.groups.get(g));
            let end = match (&group.failed, group.end) {
                (Some(text), _) => Some(Err(text.clone())),
                (None, end) => end.map(Ok),
            };
            let iterations = live.records(g).last().and_then(|r| r.iterations);
            let iterations = iterations.map_or_else(String::new, |n| format!("GMRES {n}  "));
            let eta = group.eta;
            let eta = eta.map_or_else(String::new, |s| format!("about {} s to go", s.ceil()));
            Figures {
                holes: group.holes.clone(),
                level: None,
                step: at.map(|s| s.step),
                relative_tau: Some(group.tau / group.tau_ref),
                energy: at.map(|s| s.energy),
                residual: at.and_then(|s| s.residual).or(group.residual),
                rejected: group.rejected,
                angle: at.map(|s| s.worst_angle),
                end,
                doing: iterations + &eta,
            }
        })
        .collect()
}

fn refine_figures(live: &LiveRefine, shown: Option<&Shape>) -> Figures {
    let status = live.status();
    let state = match shown {
        Some(Shape::Refine(state)) => Some(state),
        _ => None,
    };
    let end = match &status.failed {
        Some(text) => Some(Err(text.clone())),
        None if status.ended => Some(Ok(match live.levels().last().map(|l| l.end) {
            Some("steps") => End::MaxSteps,
            Some("stuck") => End::StepSizeCollapsed,
            Some("cancelled") => End::Cancelled,
            _ => End::Converged,
        })),
        None => None,
    };
    Figures {
        holes: Vec::new(),
        level: state.map(|s| s.frame.level),
        step: state.map(|s| s.step),
        relative_tau: status.relative_tau,
        energy: state.map(|s| s.energy).filter(|e| e.is_finite()),
        residual: state.and_then(|s| s.residual).or(status.residual),
        rejected: live.records().iter().filter(|(_, r)| r.rejected).count(),
        angle: None,
        end,
        doing: format!(
            "level {} of {}, {} vertices",
            status.level, status.levels, status.vertices
        ),
    }
}
