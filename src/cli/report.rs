//! The JSON report of a fill.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::fill::{Candidate, FillOptions, Filled, GroupSurface, Timings};
use crate::mesh::{BoundaryLoop, LoadReport, LoopId};
use crate::options::Choice;
use crate::solver::End;
use crate::warning::{Warning, Warnings};

/// The report of a fill.
#[derive(Debug, Serialize)]
pub struct FillReport {
    /// Program and version.
    pub version: &'static str,
    /// File read.
    pub input: String,
    /// File written.
    pub output: String,
    /// Energy, as typed.
    pub energy: String,
    /// Scheme.
    pub scheme: &'static str,
    /// Mode.
    pub mode: &'static str,
    /// Counts, repairs and the index map of the input.
    pub load: LoadReport,
    /// Filled holes.
    pub holes: Vec<HoleReport>,
    /// Holes that could not be filled.
    pub failed: Vec<FailedHole>,
    /// Loops left open.
    pub skipped: Vec<SkippedLoop>,
    /// Sums over all holes.
    pub totals: Totals,
    /// Peak resident memory of the process in bytes.
    pub peak_memory: u64,
    /// What the flows were expected to take of it.
    pub memory_estimate: u64,
}

impl FillReport {
    /// RMS of the errors to expect over the new vertices of holes with a prediction.
    pub fn expected_error(&self) -> Option<f64> {
        let (mut sum, mut count) = (0.0, 0.0);
        for hole in &self.holes {
            let surface = hole.surface.as_ref();
            if let Some(error) = surface.and_then(|s| s.expected_error) {
                let vertices = hole.vertices_added as f64;
                sum += vertices * error * error;
                count += vertices;
            }
        }
        (count > 0.0).then(|| (sum / count).sqrt())
    }
}

/// One filled hole. Holes of one group were solved together and share steps, energies and times.
#[derive(Debug, Serialize)]
pub struct HoleReport {
    /// The loop.
    #[serde(rename = "loop")]
    pub id: LoopId,
    /// Number of the part, from 1, of a hole that creases divide; each part has its own entry.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub part: Option<usize>,
    /// All loops that its patch joins.
    pub loops: Vec<LoopId>,
    /// Continuity at each of them.
    pub continuity: Vec<&'static str>,
    /// Edges of the rims.
    pub edges: usize,
    /// Radius: RMS distance of the rim vertices from their mean, the maximum over several rims.
    pub radius: f64,
    /// New vertices.
    pub vertices_added: usize,
    /// New triangles.
    pub faces_added: usize,
    /// Group of holes solved together, counted from 0; null if there was nothing to solve.
    pub group: Option<usize>,
    /// Surface model of the group; null if nothing had to be solved.
    pub surface: Option<SurfaceReport>,
    /// Accepted steps.
    pub steps: usize,
    /// Rejected steps.
    pub rejected: usize,
    /// Whether the stopping rule was met.
    pub converged: bool,
    /// Energy at the warm start, 12-point rule; null if there was nothing to solve.
    pub energy_start: Option<f64>,
    /// Energy at the end.
    pub energy_end: Option<f64>,
    /// Wall-clock time of the hole's patch and its group's flow.
    pub seconds: f64,
    /// Stages in milliseconds.
    pub timings: Timings,
    /// Mixed schemes: iterations of GMRES summed over the steps.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gmres_iterations: Option<usize>,
    /// Mixed schemes: maximum relative residual of a linear solve.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub linear_residual: Option<f64>,
    /// Warnings: their texts and codes.
    #[serde(flatten)]
    pub warnings: Warnings,
}

/// The surface model of a group, and how it was chosen.
#[derive(Debug, Serialize)]
pub struct SurfaceReport {
    /// The model and its tension.
    #[serde(flatten)]
    pub model: Candidate,
    /// The other model or triangulation of the patch, if an unsound one was replaced.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub replaced_by: Option<String>,
    /// RMS error to expect of the fill, relative to the hole radius, from the pseudo-holes of the hole itself;
    /// null without a prediction, and if an unsound patch was replaced by one of another model.
    pub expected_error: Option<f64>,
    /// Ratio of the error to expect of the holes of the group to that of their pseudo-holes.
    pub error_scale: Option<f64>,
    /// Number of pseudo-holes.
    pub pseudo_holes: usize,
    /// Each candidate's error on the pseudo-holes.
    pub candidates: Vec<CandidateReport>,
}

/// A candidate for the surface model.
#[derive(Debug, Serialize)]
pub struct CandidateReport {
    /// The model and its tension.
    #[serde(flatten)]
    pub model: Candidate,
    /// RMS error on the pseudo-holes, relative to their radius.
    pub error: f64,
}

impl SurfaceReport {
    fn new(surface: &GroupSurface, hole: LoopId) -> Self {
        let prediction = surface.prediction.as_deref();
        let errors = prediction.iter().flat_map(|p| &p.errors);
        Self {
            model: surface.model,
            replaced_by: surface.other_of(hole).map(str::to_owned),
            expected_error: surface.expected_error_of(hole),
            error_scale: prediction.map(|p| p.scale),
            pseudo_holes: prediction.map_or(0, |p| p.discs),
            candidates: errors
                .map(|&(model, error)| CandidateReport { model, error })
                .collect(),
        }
    }
}

/// A hole that could not be filled.
#[derive(Debug, Serialize)]
pub struct FailedHole {
    /// The loop.
    #[serde(rename = "loop")]
    pub id: LoopId,
    /// Reason why the hole could not be filled.
    pub reason: String,
}

/// A loop that was left open.
#[derive(Debug, Serialize)]
pub struct SkippedLoop {
    /// The loop.
    #[serde(rename = "loop")]
    pub id: LoopId,
    /// Its edges.
    pub edges: usize,
    /// Reason why the loop was left open.
    pub reason: String,
}

/// Sums over all holes.
#[derive(Debug, Serialize)]
pub struct Totals {
    /// Holes filled; one that creases divide counts once.
    pub holes: usize,
    /// New vertices.
    pub vertices_added: usize,
    /// New triangles.
    pub faces_added: usize,
    /// Vertices written.
    pub vertices: usize,
    /// Triangles written.
    pub faces: usize,
    /// Whether every hole converged.
    pub converged: bool,
    /// Wall-clock seconds of the fill, without reading and writing files.
    pub seconds: f64,
    /// Wall-clock milliseconds of the fill, and of its stages summed over the holes.
    pub timings: TotalTimings,
}

/// Milliseconds.
#[derive(Debug, Serialize)]
pub struct TotalTimings {
    /// Each stage, summed over the holes.
    #[serde(flatten)]
    pub stages: Timings,
    /// The whole fill; stages of different holes overlap.
    pub total: f64,
}

/// Reports of all filled holes, in order.
pub fn hole_reports(filled: &Filled, options: &FillOptions) -> Vec<HoleReport> {
    let mut parts: BTreeMap<LoopId, usize> = BTreeMap::new();
    for hole in &filled.holes {
        *parts.entry(hole.id()).or_default() += 1;
    }
    parts.retain(|_, count| *count > 1);
    for count in parts.values_mut() {
        *count = 0;
    }
    filled
        .holes
        .iter()
        .map(|hole| {
            let group = hole.group.and_then(|g| filled.groups[g].as_ref().ok());
            let mut flow = options.flow.clone();
            flow.surface = group.map_or(flow.surface, |group| group.surface.model.surface);
            let order = flow.order();
            let continuity = |id| options.continuity_at(id).under(order);
            let mut report = HoleReport {
                id: hole.id(),
                part: parts.get_mut(&hole.id()).map(|number| {
                    *number += 1;
                    *number
                }),
                loops: hole.loops.clone(),
                continuity: hole.loops.iter().map(|&id| continuity(id).name()).collect(),
                edges: hole.edges,
                radius: hole.radius,
                vertices_added: hole.vertices.len(),
                faces_added: hole.faces.len(),
                group: hole.group,
                surface: None,
                steps: 0,
                rejected: 0,
                converged: true,
                energy_start: None,
                energy_end: None,
                seconds: 0.0,
                timings: Timings::default(),
                gmres_iterations: None,
                linear_residual: None,
                warnings: hole.warnings.clone(),
            };
            match hole.group.map(|g| &filled.groups[g]) {
                Some(Ok(group)) => {
                    let outcome = &group.outcome;
                    report.surface = Some(SurfaceReport::new(&group.surface, hole.id()));
                    report.steps = outcome.steps;
                    report.rejected = outcome.rejected;
                    report.converged = outcome.end == End::Converged;
                    report.energy_start = Some(outcome.energy_start);
                    report.energy_end = Some(outcome.energy_end);
                    report.timings = group.timings;
                    report.warnings.extend(outcome.warnings.iter().cloned());
                    let iterations = group.records.iter().filter_map(|r| r.iterations);
                    report.gmres_iterations = iterations.reduce(|a, b| a + b);
                    let residuals = group.records.iter().filter_map(|r| r.linear_residual);
                    report.linear_residual = residuals.reduce(f64::max);
                }
                Some(Err(error)) => {
                    report.converged = false;
                    let reason = error.to_string();
                    report.warnings.push(Warning::FlowFailed { reason });
                }
                None => {}
            }
            report.timings.patch = hole.patch_ms;
            report.seconds = report.timings.total() / 1e3;
            report
        })
        .collect()
}

/// Sums of a report.
pub fn totals(filled: &Filled, holes: &[HoleReport]) -> Totals {
    let mut stages = Timings::default();
    for hole in &filled.holes {
        stages.patch += hole.patch_ms;
    }
    for group in filled.groups.iter().flatten() {
        stages.prediction += group.timings.prediction;
        stages.setup += group.timings.setup;
        stages.warm_start += group.timings.warm_start;
        stages.flow += group.timings.flow;
        stages.soundness += group.timings.soundness;
    }
    Totals {
        holes: holes
            .iter()
            .filter(|hole| hole.part.is_none_or(|p| p == 1))
            .count(),
        vertices_added: filled.vertices_added(),
        faces_added: filled.faces_added(),
        vertices: filled.mesh.vertex_count(),
        faces: filled.mesh.all_triangles().count(),
        converged: filled.complete(),
        seconds: filled.milliseconds / 1e3,
        timings: TotalTimings {
            stages,
            total: filled.milliseconds,
        },
    }
}

/// The loops that were not chosen, with reasons.
pub fn skipped(
    loops: &[BoundaryLoop],
    chosen: &[LoopId],
    reason: impl Fn(&BoundaryLoop) -> String,
) -> Vec<SkippedLoop> {
    loops
        .iter()
        .filter(|l| !chosen.contains(&l.id))
        .map(|l| SkippedLoop {
            id: l.id,
            edges: l.edges(),
            reason: reason(l),
        })
        .collect()
}
