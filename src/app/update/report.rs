//! Measures, sections, chains, reference, export.

use std::path::PathBuf;
use std::sync::Arc;

use super::files::ask;
use super::report_files::{copy, save};
use super::view::{fly_to, look_against};
use crate::analysis::{
    AnalysisOptions, Vertices, analyze_while, chain_through, control_points, section,
};
use crate::app::chains::Chain;
use crate::app::jobs::{Job, Reporter};
use crate::app::model::{Effect, Model};
use crate::app::report::{
    MeasureRequest, Measured, Patches, Reference, ReportAction, SectionRequest, SectionResult,
    Subject,
};
use crate::app::view_state::PathUse;
use crate::mesh::HalfedgeId;
use crate::render::ViewMode;

/// Default minimum angle of a sharp edge in degrees.
const SHARP: f64 = 40.0;

/// Executes an action of the report.
pub(crate) fn update(model: &mut Model, action: ReportAction) {
    let view = &mut model.view.report;
    match action {
        ReportAction::OnSurface(on) => view.on_surface = on,
        ReportAction::Sharp(angle) => view.sharp = angle,
        ReportAction::Pick(pick) => view.pick = pick,
        ReportAction::Curvature(which) => view.curvature = which,
        ReportAction::Edge(edge) => choose_chain(model, edge),
        ReportAction::DropChain(i) => {
            if i < view.chains.len() {
                view.chains.remove(i);
            }
        }
        ReportAction::Cut(cut) => view.cut = Some(cut),
        ReportAction::DropCut => view.cut = None,
        ReportAction::HideFront(hidden) => view.hide_front = hidden,
        ReportAction::Comb(comb) => view.comb = comb,
        ReportAction::AskReference => ask(model, PathUse::Reference),
        ReportAction::DropReference => {
            view.reference = None;
            if model.view.style.mode == ViewMode::Distance {
                model.view.style.mode = ViewMode::Shaded;
            }
        }
        ReportAction::Inspect(place) => {
            view.mark = Some(place);
            let out = model.picker.as_ref().and_then(|(mesh, picker)| {
                let [a, b, c] = mesh.corners(picker.nearest(place)?);
                (b - a).cross(c - a).try_normalize()
            });
            if let Some(out) = out {
                look_against(model, out);
            }
            fly_to(model, place);
        }
        ReportAction::Copy(file) => copy(model, file),
        ReportAction::AskSave(file) => ask(model, PathUse::Report(file)),
        ReportAction::Reference(path) => set_reference(model, path),
        ReportAction::Save(file, path) => save(model, file, path),
    }
}

/// Measures distances to a mesh file.
pub(super) fn set_reference(model: &mut Model, path: PathBuf) {
    model.view.report.reference = Some(path);
    model.view.windows.analysis = true;
}

/// Adds the chain through an edge, or removes it if it is chosen.
fn choose_chain(model: &mut Model, edge: HalfedgeId) {
    let mesh = &model.document.mesh;
    if edge.index() >= mesh.topology.halfedge_count() {
        return;
    }
    let angle = model.view.report.sharp.unwrap_or(SHARP);
    let Some(chain) = chain_through(mesh, edge, angle.to_radians()) else {
        model
            .log
            .info("this is a boundary edge: there is no other side to compare");
        return;
    };
    let ends = |h: HalfedgeId| {
        let ends = [mesh.topology.origin(h), mesh.topology.target(h)];
        ends.map(|v| mesh.position(v).to_array())
    };
    let edges: Vec<[[f64; 3]; 2]> = chain.edges.iter().map(|&h| ends(h)).collect();
    let same = |[a, b]: [[f64; 3]; 2], e: &[[f64; 3]; 2]| *e == [a, b] || *e == [b, a];
    let chains = &mut model.view.report.chains;
    let known = chains
        .iter()
        .position(|c| c.edges.iter().any(|e| same(ends(edge), e)));
    match known {
        Some(i) => {
            chains.remove(i);
        }
        None => chains.push(Chain {
            is_crease: chain.is_crease,
            edges,
        }),
    }
}

/// Advances the background jobs.
pub(super) fn tick(model: &mut Model) {
    read_reference(model);
    if model.view.windows.analysis {
        measure(model);
    } else {
        model.report.measuring = None;
    }
    cut(model);
    if let Some(result) = model.report.copying.as_ref().and_then(Job::poll) {
        model.report.copying = None;
        match result.and_then(|text| text) {
            Ok(text) => {
                model.effects.push(Effect::CopyText(text));
                model.log.info("the report was copied to the clipboard");
            }
            Err(text) => model.log.error(text),
        }
    }
}

/// Reads the chosen reference unless it is loaded.
fn read_reference(model: &mut Model) {
    let Some(path) = model.view.report.reference.clone() else {
        model.report.loading = None;
        model.report.reference = None;
        return;
    };
    let report = &mut model.report;
    if report.reference.as_ref().is_some_and(|r| r.path == path) {
        report.loading = None;
        return;
    }
    match &report.loading {
        Some((of, job)) if *of == path => {
            let Some(result) = job.poll() else { return };
            report.loading = None;
            match result.and_then(|r| r) {
                Ok(reference) => report.reference = Some(Arc::new(reference)),
                Err(text) => {
                    // keep the previous reference, if there was one
                    model.view.report.reference = report.reference.as_ref().map(|r| r.path.clone());
                    model.log.error(text);
                }
            }
        }
        _ => {
            let of = path.clone();
            let what = format!("reading {}", path.display());
            let job = Job::spawn(what, &model.wake, move |_| Reference::open(&of));
            report.loading = Some((path, job));
        }
    }
}

/// The current request.
fn requested(model: &mut Model) -> MeasureRequest {
    let energy = model.report.energy.of(&model.document.controls);
    let view = &model.view.report;
    MeasureRequest {
        subject: Subject::of(&model.document, model.run.as_ref()),
        on_surface: view.on_surface,
        energy,
        sharp: view.sharp,
        chains: view.chains.clone(),
        reference: model.report.reference.clone(),
    }
}

/// Receives measures and requests new ones. If only the state of the run has changed, the running
/// measurement is allowed to finish; otherwise it would be restarted every frame.
fn measure(model: &mut Model) {
    let request = requested(model);
    let report = &mut model.report;
    if let Some((of, job)) = &report.measuring {
        if let Some(result) = job.poll() {
            match result {
                Ok(found) => report.measured = found.map(Arc::new).or(report.measured.take()),
                Err(text) => {
                    report.failed = Some(of.clone());
                    model.log.error(text);
                }
            }
            report.measuring = None;
        } else if of.same_but_state(&request) {
            return;
        }
    }
    let is = |other: &MeasureRequest| other.same(&request);
    let known = report.measured.as_ref().is_some_and(|m| is(&m.request));
    if known || report.failed.as_ref().is_some_and(is) || model.document.is_blank() {
        report.measuring = None;
        return;
    }
    let patches = Patches::of(&model.document, model.run.as_ref());
    let job = {
        let request = request.clone();
        Job::spawn("measuring", &model.wake, move |reporter| {
            find(request, &patches, reporter)
        })
    };
    model.report.measuring = Some((request, job));
}

/// The meaning of the vertices.
pub(super) fn vertices(on_surface: bool) -> Vertices {
    if on_surface {
        Vertices::OnSurface
    } else {
        Vertices::Control
    }
}

fn find(request: MeasureRequest, patches: &Patches, reporter: &Reporter) -> Option<Measured> {
    let mesh = request.subject.mesh(request.on_surface);
    let chains = patches.chains(&mesh, &request.chains, request.sharp);
    let options = AnalysisOptions {
        vertices: vertices(request.on_surface),
        energy: request.energy.clone(),
        chains: chains.all,
        reference: request.reference.as_ref().map(|r| &r.mesh),
        planes: Vec::new(),
    };
    let analysis = analyze_while(&mesh, &options, &|done, total| {
        reporter.progress(done, total)
    })?;
    Some(Measured {
        request,
        mesh,
        analysis,
        chosen: chains.chosen,
        rims: chains.rims,
        left_out: chains.left_out,
    })
}

/// Receives sections and requests new ones, as [`measure`] does.
fn cut(model: &mut Model) {
    let Some(plane) = model.view.report.cut.map(|c| c.plane()) else {
        model.report.cutting = None;
        model.report.cut = None;
        return;
    };
    let request = SectionRequest {
        subject: Subject::of(&model.document, model.run.as_ref()),
        on_surface: model.view.report.on_surface,
        plane,
    };
    let report = &mut model.report;
    if let Some((of, job)) = &report.cutting {
        if let Some(result) = job.poll() {
            match result {
                Ok(made) => report.cut = Some(made),
                Err(text) => {
                    model.view.report.cut = None;
                    model.log.error(text);
                }
            }
            report.cutting = None;
        } else if of.same_but_state(&request) {
            return;
        }
    }
    let known = report.cut.as_ref();
    if known.is_some_and(|c| c.request.same(&request)) {
        report.cutting = None;
        return;
    }
    let job = {
        let request = request.clone();
        Job::spawn("section", &model.wake, move |_| {
            let mesh = request.subject.mesh(request.on_surface);
            let control = control_points(&mesh, vertices(request.on_surface));
            SectionResult {
                section: Arc::new(section(&mesh.topology, &control, &request.plane)),
                request,
            }
        })
    };
    report.cutting = Some((request, job));
}
