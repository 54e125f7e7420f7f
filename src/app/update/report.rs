//! Measures, sections, chains, reference, export.

use std::sync::Arc;

use super::files::ask;
use super::report_files::{copy, save};
use super::view::{fly_to, look_against};
use crate::analysis::{
    AnalysisOptions, Vertices, analyze_while, chain_through, control_points, section,
};
use crate::app::jobs::{Job, Reporter};
use crate::app::model::{Effect, Model};
use crate::app::report::{
    Chain, CutMade, Measured, Patches, Reference, ReportAction, Subject, Wanted,
};
use crate::app::view_state::PathUse;
use crate::energy::Energy;
use crate::mesh::HalfedgeId;
use crate::render::ViewMode;

/// A clicked edge is sharp from this angle on, in degrees, where the report says nothing else.
const SHARP: f64 = 40.0;

/// Carries out an action of the report.
pub fn update(model: &mut Model, action: ReportAction) {
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
        ReportAction::Path(PathUse::Reference, path) => {
            view.reference = Some(path);
            model.view.windows.analysis = true;
        }
        ReportAction::Path(PathUse::Report(file), path) => save(model, file, path),
        ReportAction::Path(..) => {}
    }
}

/// The chain through an edge in, or out if it is in already.
fn choose_chain(model: &mut Model, edge: HalfedgeId) {
    let mesh = &model.document.mesh;
    if edge.index() >= mesh.topology.halfedge_count() {
        return;
    }
    let angle = model.view.report.sharp.unwrap_or(SHARP);
    let Some(chain) = chain_through(mesh, edge, angle.to_radians()) else {
        model
            .log
            .info("the mesh ends at that edge: there is no other side to compare");
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

/// Looks after what goes on in the background.
pub fn tick(model: &mut Model) {
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

/// Reads the chosen reference, unless it is there.
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
                    // the one before stays, if there was one
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

/// What the report is to show now.
fn wanted(model: &Model) -> Wanted {
    let controls = &model.document.controls;
    let view = &model.view.report;
    Wanted {
        subject: Subject::of(model),
        on_surface: view.on_surface,
        energy: Energy::parse(&controls.energy, &controls.param).ok(),
        sharp: view.sharp,
        chains: view.chains.clone(),
        reference: model.report.reference.clone(),
    }
}

/// Takes in measures and asks for new ones. Those of another moment of a run are awaited, or none
/// would ever be finished while it plays; all others are dropped.
fn measure(model: &mut Model) {
    let wanted = wanted(model);
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
        } else if of.same_but_state(&wanted) {
            return;
        }
    }
    let is = |other: &Wanted| other.same(&wanted);
    let known = report.measured.as_ref().is_some_and(|m| is(&m.wanted));
    if known || report.failed.as_ref().is_some_and(is) || model.document.is_blank() {
        report.measuring = None;
        return;
    }
    let patches = Patches::of(model);
    let job = {
        let wanted = wanted.clone();
        Job::spawn("measuring", &model.wake, move |reporter| {
            find(wanted, &patches, reporter)
        })
    };
    model.report.measuring = Some((wanted, job));
}

/// What the vertices are.
pub(super) fn vertices(on_surface: bool) -> Vertices {
    if on_surface {
        Vertices::OnSurface
    } else {
        Vertices::Control
    }
}

fn find(wanted: Wanted, patches: &Patches, reporter: &Reporter) -> Option<Measured> {
    let mesh = wanted.subject.mesh(wanted.on_surface);
    let chains = patches.chains(&mesh, &wanted.chains, wanted.sharp);
    let options = AnalysisOptions {
        vertices: vertices(wanted.on_surface),
        energy: wanted.energy.clone(),
        chains: chains.all,
        reference: wanted.reference.as_ref().map(|r| &r.mesh),
        planes: Vec::new(),
    };
    let analysis = analyze_while(&mesh, &options, &|done, total| {
        reporter.progress(done, total)
    })?;
    Some(Measured {
        wanted,
        mesh,
        analysis,
        chosen: chains.chosen,
        rims: chains.rims,
        left_out: chains.left_out,
    })
}

/// Takes in sections and asks for new ones, as [`measure`] does.
fn cut(model: &mut Model) {
    let Some(plane) = model.view.report.cut.map(|c| c.plane()) else {
        model.report.cutting = None;
        model.report.cut = None;
        return;
    };
    let subject = Subject::of(model);
    let on_surface = model.view.report.on_surface;
    let report = &mut model.report;
    if let Some(((of, surface, by), job)) = &report.cutting {
        if let Some(result) = job.poll() {
            match result {
                Ok(made) => report.cut = Some(made),
                Err(text) => {
                    model.view.report.cut = None;
                    model.log.error(text);
                }
            }
            report.cutting = None;
        } else if of.same_but_state(&subject) && (*surface, *by) == (on_surface, plane) {
            return;
        }
    }
    let known = report.cut.as_ref().is_some_and(|c| {
        c.subject.same(&subject) && (c.on_surface, c.plane) == (on_surface, plane)
    });
    if known {
        report.cutting = None;
        return;
    }
    let asked = (subject.clone(), on_surface, plane);
    let job = Job::spawn("section", &model.wake, move |_| {
        let mesh = subject.mesh(on_surface);
        let control = control_points(&mesh, vertices(on_surface));
        CutMade {
            section: Arc::new(section(&mesh.topology, &control, &plane)),
            subject,
            on_surface,
            plane,
        }
    });
    report.cutting = Some((asked, job));
}
