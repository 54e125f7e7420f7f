//! The report, without a window.

use std::path::PathBuf;
use std::sync::Arc;

use super::*;
use crate::analysis::{AnalysisOptions, analyze, measures_csv};
use crate::app::action::{
    ControlsAction, EditAction, FileAction, RunAction, SelectAction, SelectHow, Switch, TaskAction,
    ViewAction,
};
use crate::app::chains::Places;
use crate::app::document::{Document, Source};
use crate::app::faces::{BrushStamp, FaceEdit};
use crate::app::model::{Effect, Model};
use crate::app::project;
use crate::app::tests::{filled, last_message, model, opened, until};
use crate::app::update::{act, replace, tick};
use crate::app::view_state::Task;
use crate::fill::Continuity;
use crate::io;
use crate::mesh::FaceId;
use crate::render::Vertex;
use crate::shapes::icosphere;

/// The report of what is shown now.
fn measured(m: &mut Model) -> Arc<Measured> {
    if !m.view.windows.analysis {
        act(m, ViewAction::Toggle(Switch::Analysis));
    }
    until(m, |m| {
        let current = |found: &Arc<Measured>| {
            found
                .request
                .subject
                .same(&Subject::of(&m.document, m.run.as_ref()))
        };
        m.report.measuring.is_none() && m.report.measured.as_ref().is_some_and(current)
    });
    m.report.measured.clone().expect("just measured")
}

#[test]
fn rims_are_measured_as_smooth_or_as_creases_and_undo_is_followed() {
    let mut m = model();
    let open = measured(&mut m);
    assert!(open.analysis.chains.is_empty());
    assert_eq!(open.analysis.shape.boundary_loops, 2);
    let same = analyze(
        &m.document.mesh,
        &AnalysisOptions {
            energy: open.request.energy.clone(),
            ..AnalysisOptions::default()
        },
    );
    assert_eq!(open.analysis, same);

    // one hole with a crease, the other without, in one fill
    let mut controls = m.document.controls.clone();
    let sharp = m.document.loops[1].id;
    controls.loop_continuity.insert(sharp, Continuity::G0);
    act(&mut m, ControlsAction::Set(Box::new(controls)));
    let rim = m.document.loops[1].clone();
    act(&mut m, SelectAction::All);
    filled(&mut m);
    let running = measured(&mut m);
    assert_eq!(running.rims, 2);
    assert!(running.request.subject.words().contains("attempts"));
    act(&mut m, RunAction::Accept(0));
    let done = measured(&mut m);
    assert_eq!((done.rims, done.analysis.shape.genus), (2, 0));
    assert_eq!(done.analysis.chains, running.analysis.chains);
    let creases: Vec<_> = done
        .analysis
        .chains
        .iter()
        .filter(|c| c.is_crease)
        .collect();
    assert_eq!(creases.len(), 1);
    let smooth = done.analysis.chains.iter().find(|c| !c.is_crease);
    let smooth = smooth.expect("the other");
    assert!((creases[0].length - rim.perimeter).abs() < 1e-9);
    assert!(creases[0].normal_angle.max > 1.0 && smooth.normal_angle.max < 1e-3);
    assert!(smooth.smooth_by_construction && smooth.dihedral.max > 1.0);
    let at = DVec3::from_array(creases[0].normal_angle.max_at);
    assert!(at.distance(rim.centroid) < 0.5);

    act(&mut m, EditAction::Undo);
    assert_eq!(measured(&mut m).analysis, open.analysis);
}

#[test]
fn the_newest_request_is_answered() {
    let mut m = model();
    act(&mut m, ViewAction::Toggle(Switch::Analysis));
    for on in [true, false, true] {
        act(&mut m, ReportAction::OnSurface(on));
        tick(&mut m, std::time::Instant::now());
    }
    let found = measured(&mut m);
    assert!(found.request.on_surface);
    // points of a sphere of radius 1: the limit surface through them has its area, but for two holes
    let control = {
        act(&mut m, ReportAction::OnSurface(false));
        measured(&mut m);
        until(&mut m, |m| {
            m.report
                .measured
                .as_ref()
                .is_some_and(|f| !f.request.on_surface)
        });
        m.report.measured.clone().expect("there")
    };
    assert!(control.analysis.shape.area < found.analysis.shape.area);
    act(&mut m, ViewAction::Toggle(Switch::Analysis));
    act(&mut m, ReportAction::OnSurface(true));
    tick(&mut m, std::time::Instant::now());
    assert!(m.report.measuring.is_none(), "closed: nothing is measured");
}

#[test]
fn edges_are_chosen_and_let_go() {
    let mut m = model();
    act(&mut m, ViewAction::Toggle(Switch::Analysis));
    let t = &m.document.mesh.topology;
    let inner = t
        .halfedges()
        .find(|&h| {
            let ends = [t.origin(h), t.target(h)];
            ends.iter().all(|&v| !t.is_boundary_vertex(v))
        })
        .expect("inside");
    let rim = m.document.loops[0].halfedges[0];
    act(&mut m, ReportAction::Edge(rim));
    assert!(last_message(&m).contains("no other side"));
    act(&mut m, ReportAction::Edge(inner));
    assert_eq!(m.view.report.chains.len(), 1);
    let found = measured(&mut m);
    assert_eq!((found.rims, found.chosen), (0, 1));
    let chain = &found.analysis.chains[0];
    assert!(!chain.is_crease && chain.edges == m.view.report.chains[0].edges.len());
    // it stays when patches are added
    act(&mut m, SelectAction::Loop(0.into(), SelectHow::Replace));
    filled(&mut m);
    act(&mut m, RunAction::Accept(0));
    let after = measured(&mut m);
    assert_eq!((after.rims, after.chosen), (1, 1));
    assert_eq!(after.analysis.chains[0].length, chain.length);
    // drawn, on the limit surface
    let overlays = crate::app::scene_builder::ReportOverlays::default().of(&m);
    assert_eq!(overlays.len(), 1);
    assert_eq!(overlays[0].lines.len(), chain.edges);

    let again = Places::new(&m.document.mesh, &m.view.report.chains)
        .edge(&m.document.mesh, &m.view.report.chains[0].edges[0])
        .expect("still there");
    act(&mut m, ReportAction::Edge(again.twin()));
    assert!(m.view.report.chains.is_empty());
    act(&mut m, ReportAction::Edge(again));
    act(&mut m, ReportAction::Sharp(Some(20.0)));
    assert!(measured(&mut m).chosen == 1);
    replace(
        &mut m,
        Document::new(opened(), Source::Sample("test".into())),
    );
    assert!(m.view.report.chains.is_empty());
}

/// Erasing faces renumbers vertices, but the chosen edges do not change.
#[test]
fn chosen_edges_and_rims_outlive_erasing() {
    let mut m = model();
    act(&mut m, SelectAction::Loop(0.into(), SelectHow::Replace));
    filled(&mut m);
    act(&mut m, RunAction::Accept(0));
    let mesh = Arc::clone(&m.document.mesh);
    let t = &mesh.topology;
    // an edge of the last face of the opened mesh, and faces at the first one
    let far = FaceId::from(m.document.first_patch_face - 1);
    act(&mut m, ReportAction::Edge(t.halfedge_of_face(far)));
    let before = measured(&mut m).analysis.chains.clone();
    assert_eq!(before.len(), 2);
    let [point, ..] = mesh.corners(FaceId(0));
    act(&mut m, TaskAction::Choose(Task::Repair));
    let stamps = vec![BrushStamp {
        face: FaceId(0),
        point,
        radius: 0.15,
    }];
    act(
        &mut m,
        SelectAction::Faces(FaceEdit::Paint {
            stamps,
            take: false,
        }),
    );
    act(&mut m, ControlsAction::EndDrag);
    act(&mut m, EditAction::Erase);
    assert!(m.document.mesh.vertex_count() < mesh.vertex_count());
    let after = measured(&mut m).analysis.chains.clone();
    for (a, b) in before.iter().zip(&after) {
        assert_eq!((a.edges, &a.name), (b.edges, &b.name));
        assert!((a.length - b.length).abs() < 1e-12);
    }
    assert_eq!(after.len(), 2);
    // the faired region has a rim as well
    act(&mut m, EditAction::Undo);
    act(&mut m, RunAction::Fair);
    until(&mut m, |m| {
        m.run.as_ref().is_some_and(crate::app::Run::ended)
    });
    assert_eq!(measured(&mut m).rims, 2);
    act(&mut m, RunAction::Accept(0));
    assert_eq!(measured(&mut m).rims, 2);
}

#[test]
fn distances_to_a_reference_are_measured_and_drawn() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("ball.ply");
    let (positions, triangles) = icosphere(12);
    let larger = positions.iter().map(|p| 1.1 * *p).collect();
    let larger = Mesh::from_triangles(larger, &triangles).expect("closed");
    io::save_mesh(&path, &larger).expect("written");

    let mut m = model();
    let choose = ReportAction::Reference;
    act(&mut m, choose(folder.path().join("nothing.ply")));
    until(&mut m, |m| m.view.report.reference.is_none());
    assert!(
        last_message(&m).contains("nothing.ply"),
        "{}",
        last_message(&m)
    );
    act(&mut m, choose(path.clone()));
    until(&mut m, |m| {
        let found = m.report.measured.as_ref();
        found.is_some_and(|f| f.analysis.distances.is_some())
    });
    let found = m.report.measured.clone().expect("there");
    let d = found.analysis.distances.as_ref().expect("measured");
    assert!(
        (d.to_reference.mean - 0.1).abs() < 0.02,
        "{}",
        d.to_reference.mean
    );
    // the reference is far from the rims of the holes
    assert!(d.from_reference.max > 0.2 && d.max == d.from_reference.max);

    let mut style = m.view.style;
    style.mode = ViewMode::Distance;
    act(&mut m, ViewAction::Style(style));
    let known = |v: &Vertex| v.flags & Vertex::DISTANCE != 0;
    until(&mut m, |m| {
        let shown = m.displays[0].latest();
        shown.is_some_and(|d| d.surfaces.iter().all(|s| s.vertices.iter().all(known)))
    });
    let shown = m.displays[0].latest().expect("drawn").surfaces[0].clone();
    for v in &shown.vertices {
        // inside, so it is negative
        let value = ViewMode::Distance.value(v).expect("known");
        assert!((-0.16..-0.08).contains(&value), "{value}");
        assert_eq!(ViewMode::Deviation.value(v), None);
    }
    act(&mut m, ReportAction::DropReference);
    tick(&mut m, std::time::Instant::now());
    assert!(m.report.reference.is_none() && m.view.style.mode == ViewMode::Shaded);
}

#[test]
fn a_section_follows_the_flow_and_places_are_looked_at_from_outside() {
    let mut m = model();
    until(&mut m, |m| m.picker.is_some());
    let cut = Cut {
        point: [0.0; 3],
        normal: [0.0, 1.0, 0.0],
    };
    act(&mut m, ReportAction::Cut(cut));
    until(&mut m, |m| m.report.cut.is_some());
    let open = Arc::clone(&m.report.cut.as_ref().expect("made").section);
    assert!(
        open.curves.iter().all(|c| !c.closed),
        "it runs into the holes"
    );
    act(&mut m, SelectAction::All);
    filled(&mut m);
    until(&mut m, |m| {
        let current = |c: &SectionResult| {
            c.request
                .subject
                .same(&Subject::of(&m.document, m.run.as_ref()))
        };
        m.report.cut.as_ref().is_some_and(current)
    });
    let closed = Arc::clone(&m.report.cut.as_ref().expect("made").section);
    assert_eq!(closed.curves.len(), 1);
    assert!(closed.curves[0].closed && closed.curves[0].length > 6.0);
    let drawn = crate::app::scene_builder::ReportOverlays::default().of(&m);
    assert!(drawn[0].lines.len() > 100);
    act(&mut m, ReportAction::DropCut);
    tick(&mut m, std::time::Instant::now());
    assert!(m.report.cut.is_none());
    assert!(
        crate::app::scene_builder::ReportOverlays::default()
            .of(&m)
            .is_empty()
    );

    for place in [DVec3::Z, -DVec3::Y] {
        act(&mut m, ReportAction::Inspect(place));
        let camera = &m.view.camera;
        assert!(camera.forward().dot(place) < -0.9);
        let [x, y] = camera.project(place, 1.6).expect("in front");
        assert!(x.abs() < 1e-9 && y.abs() < 1e-9);
    }
}

#[test]
fn reports_are_copied_and_saved_as_on_the_command_line() {
    let folder = tempfile::tempdir().expect("a folder");
    let source = folder.path().join("in.obj");
    io::save_mesh(&source, &opened().mesh).expect("written");
    let mut m = model();
    act(&mut m, ReportAction::Copy(ReportFile::Json));
    assert!(last_message(&m).contains("nothing was measured"));
    act(&mut m, FileAction::Open(source.clone()));
    until(&mut m, |m| {
        m.document.origin.source == Source::File(source.clone())
    });
    let found = measured(&mut m);
    act(&mut m, ReportAction::Copy(ReportFile::Json));
    until(&mut m, |m| !m.effects.is_empty());
    let Some(Effect::CopyText(text)) = m.effects.pop() else {
        panic!("no text");
    };
    let value: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    assert_eq!(value["input"], "in.obj");
    assert_eq!(value["load"]["faces"], m.document.mesh.face_count());
    assert_eq!(value["shape"]["area"], found.analysis.shape.area);

    let path = folder.path().join("out.csv");
    let save = |file, path: &PathBuf| ReportAction::Save(file, path.clone());
    act(&mut m, save(ReportFile::Measures, &path));
    until(&mut m, |_| path.exists());
    let text = std::fs::read_to_string(&path).expect("written");
    assert_eq!(text, measures_csv(&found.analysis));
    act(&mut m, save(ReportFile::Section, &path));
    assert!(last_message(&m).contains("no section"));
    let bytes = std::fs::read(&source).expect("there");
    act(&mut m, save(ReportFile::Vertices, &source));
    assert!(last_message(&m).contains("never overwritten"));
    assert_eq!(std::fs::read(&source).expect("there"), bytes);
}

#[test]
fn stripes_lines_and_the_report_come_back_with_the_project() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut m = model();
    let mut style = m.view.style;
    style.mode = ViewMode::Zebra;
    style.stripes = 23;
    style.light = DVec3::new(0.6, 0.0, -0.8);
    style.light_follows_view = true;
    style.zebra_turn = 35.0;
    style.range = Some([-0.5, 2.0]);
    act(&mut m, ViewAction::Style(style));
    m.view.report = ReportView {
        on_surface: true,
        sharp: Some(30.0),
        reference: Some(folder.path().join("deep/ball.ply")),
        comb: Comb {
            length: Some(0.125),
            density: 33.0,
            own: true,
        },
        cut: Some(Cut {
            point: [0.1, 0.2, 0.3],
            normal: [0.0, 0.0, 1.0],
        }),
        chains: vec![Chain {
            is_crease: false,
            edges: vec![[[0.1, 0.2, 0.3], [1.0 / 3.0, -2e-17, 5.0]]],
        }],
        ..ReportView::default()
    };
    let text = project::write(&m.document, &m.view, folder.path());
    // what lies beside the project is named without the folder
    assert!(text.contains("\"deep/ball.ply\""), "{text}");
    let text = text.replace("sample = \"test\"", "sample = \"sphere\"");
    let path = folder.path().join("a.meniscus");
    // the sample of the tests is none of the program's: its mesh goes into the file
    let mut mesh = Vec::new();
    io::with_output(&m.document.mesh, |output| {
        io::write(io::Format::Obj, output, &mut mesh).expect("a vector takes everything");
    });
    let text = text + "#--- mesh (OBJ) ---\n" + &String::from_utf8_lossy(&mesh);
    std::fs::write(&path, text).expect("written");
    let (document, head) = project::read(&path).expect("a project");
    let mut other = model();
    head.view.restore(&mut other.view, &document.origin.bounds);
    let s = other.view.style;
    assert_eq!(
        (
            s.mode,
            s.stripes,
            s.light,
            s.light_follows_view,
            s.zebra_turn,
            s.range
        ),
        (
            ViewMode::Zebra,
            23,
            style.light,
            true,
            35.0,
            Some([-0.5, 2.0])
        )
    );
    assert_eq!(other.view.report, m.view.report);

    // nonsense in a file does no harm
    let wild = ReportView {
        sharp: Some(f64::NAN),
        comb: Comb {
            length: Some(-1.0),
            density: 0.0,
            own: false,
        },
        cut: Some(Cut {
            point: [0.0; 3],
            normal: [0.0; 3],
        }),
        ..ReportView::default()
    };
    assert_eq!(wild.checked(), ReportView::default());
}
