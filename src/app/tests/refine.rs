//! Refinements in the window.

use std::sync::Arc;

use super::*;
use crate::app::chains::Chain;
use crate::app::run::Run;
use crate::app::view_state::Refining;
use crate::mesh::VertexId;
use crate::ops::Operation;
use crate::refine::{Method, RefineControls};

fn levels(levels: usize) -> RefineControls {
    RefineControls {
        levels,
        ..RefineControls::default()
    }
}

fn on_icosahedron(refining: Refining) -> Model {
    on_mesh(icosphere(1), refining)
}

fn on_mesh(mesh: TriangleMesh, refining: Refining) -> Model {
    let mut m = model_of(from_triangles(mesh));
    act(&mut m, RunAction::Pace(240.0));
    act(&mut m, TaskAction::Choose(Task::Refine));
    act(&mut m, TaskAction::Refining(Box::new(refining)));
    m
}

#[test]
fn refined_meshes_are_drawn_in_their_colours() {
    let colors: Vec<[f32; 4]> = vec![[0.5, 0.25, 1.0, 1.0]; 12];
    for creases in [false, true] {
        let mut m = on_icosahedron(Refining::default());
        let mut document = m.document.clone();
        let mesh = Arc::make_mut(&mut document.mesh);
        mesh.attributes.vertices = crate::mesh::color_columns(&colors);
        replace(&mut m, document);
        act(&mut m, ViewAction::Mode(ViewMode::Color));
        act(&mut m, TaskAction::Choose(Task::Refine));
        let refining = Refining {
            controls: RefineControls {
                crease_angle: creases.then_some(10.0),
                ..levels(1)
            },
            ..Refining::default()
        };
        act(&mut m, TaskAction::Refining(Box::new(refining)));
        act(&mut m, RunAction::Start);
        act(&mut m, RunAction::Finish);
        until(&mut m, |m| m.run.as_ref().is_some_and(Run::ended));
        let is_colored = |m: &Model| {
            let display = m.displays[0].latest();
            let mut drawn = display.iter().flat_map(|d| &d.surfaces);
            drawn.all(|s| s.vertices.iter().all(|v| v.color == [128, 64, 255, 255]))
        };
        until(&mut m, |m| m.displays[0].is_settled());
        assert!(is_colored(&m), "creases: {creases}");
        act(&mut m, RunAction::Accept(0));
        tick(&mut m, Instant::now());
        until(&mut m, |m| m.displays[0].is_settled());
        assert!(is_colored(&m), "creases: {creases}");
    }
}

#[test]
fn a_rejected_refinement_leaves_no_warnings_on_screen() {
    let mut m = on_icosahedron(Refining {
        controls: levels(1),
        ..Refining::default()
    });
    act(&mut m, RunAction::Start);
    act(&mut m, RunAction::Finish);
    until(&mut m, |m| m.run.as_ref().is_some_and(Run::ended));
    assert!(last_message(&m).starts_with("refinement: "));
    act(&mut m, RunAction::Reject);
    assert!(last_message(&m).starts_with("the refinement was rejected"));
    assert_eq!(m.log.toasts(Instant::now()).len(), 1);
    assert_eq!(m.next_undo(), Some("reject the refinement"));
}

#[test]
fn three_methods_side_by_side_and_one_is_taken() {
    let mut m = on_icosahedron(Refining {
        controls: RefineControls {
            energy: Some("H^2".into()),
            ..levels(2)
        },
        beside: [Some(Method::Butterfly), Some(Method::Loop)],
        ..Refining::default()
    });
    let before = Arc::clone(&m.document.mesh);
    act(&mut m, RunAction::Start);
    act(&mut m, RunAction::Finish);
    until(&mut m, |m| m.run.as_ref().is_some_and(Run::ended));
    let run = m.run.as_ref().expect("there");
    assert_eq!(run.names(), ["PDE", "Butterfly", "Loop"]);
    for side in &run.sides {
        let state = side.state().expect("a state");
        assert_eq!(state.topology().face_count(), 16 * before.face_count());
    }
    until(&mut m, |m| {
        m.displays.iter().all(|d| {
            let asked = d.requested().and_then(|r| r.state.as_ref());
            asked.is_some() && d.latest().is_some()
        })
    });
    // states can be scrubbed over all levels
    act(&mut m, RunAction::Scrub(Some(0)));
    let first = m
        .run
        .as_ref()
        .and_then(|r| r.sides[0].state())
        .expect("a state");
    assert_eq!(first.topology().face_count(), before.face_count());
    act(&mut m, RunAction::Scrub(None));
    act(&mut m, RunAction::Accept(0));
    let after = Arc::clone(&m.document.mesh);
    check_mesh(&after).expect("sound");
    assert_eq!(after.positions[..before.vertex_count()], before.positions);
    assert_eq!(m.document.first_patch_face, after.face_count());
    // H² alone makes a sphere of it
    assert!(
        after
            .positions
            .iter()
            .all(|p| (p.length() - 1.0).abs() < 0.02)
    );
    let Operation::Refine(spec) = &m.document.accepted[0].operation else {
        panic!("a refinement");
    };
    assert_eq!(spec.controls.levels, 2);
    act(&mut m, EditAction::Undo);
    assert!(Arc::ptr_eq(&before, &m.document.mesh));
}

#[test]
fn a_refinement_needs_its_selected_faces() {
    let mut m = on_icosahedron(Refining {
        controls: levels(1),
        selected_only: true,
        ..Refining::default()
    });
    act(&mut m, RunAction::Start);
    assert!(m.run.is_none() && last_message(&m).starts_with("no face is selected"));
    m.document.faces = Arc::new(vec![0, 1, 2]);
    act(&mut m, RunAction::Start);
    act(&mut m, RunAction::Finish);
    until(&mut m, |m| m.run.as_ref().is_some_and(Run::ended));
    act(&mut m, RunAction::Accept(0));
    let faces = m.document.mesh.face_count();
    assert!((20 + 9..80).contains(&faces), "{faces}");
}

/// What is drawn of the newest request, once it is there.
fn drawn(m: &mut Model, is_asked: impl Fn(&Model) -> bool) -> Vec<[f32; 3]> {
    m.displays[0].clear();
    until(m, |m| is_asked(m) && m.displays[0].latest().is_some());
    let display = m.displays[0].latest().expect("there");
    let vertices = display.surfaces.iter().flat_map(|s| &s.vertices);
    vertices.map(|v| v.position).collect()
}

/// An accepted refinement is drawn as before, sharp edges and all, until something else is done.
#[test]
fn an_accepted_surface_stays_as_it_was() {
    let mut m = on_icosahedron(Refining {
        controls: RefineControls {
            crease_angle: Some(1.0),
            ..levels(2)
        },
        ..Refining::default()
    });
    act(&mut m, RunAction::Start);
    act(&mut m, RunAction::Finish);
    until(&mut m, |m| m.run.as_ref().is_some_and(Run::ended));
    let before = drawn(&mut m, |m| m.run.is_some());
    act(&mut m, RunAction::Accept(0));
    let after = drawn(&mut m, |m| m.run.is_none());
    assert!(!before.is_empty() && before == after);
    let mesh = Arc::clone(&m.document.mesh);
    check_mesh(&mesh).expect("welded");
    assert!(mesh.topology.boundary_loops().is_empty());
    // undone, done again, and gone with the next change
    act(&mut m, EditAction::Undo);
    assert!(m.document.surface.is_none());
    act(&mut m, EditAction::Redo);
    assert!(Arc::ptr_eq(&mesh, &m.document.mesh));
    assert!(drawn(&mut m, |_| true) == before);
    m.document.faces = Arc::new(vec![0, 1]);
    act(&mut m, EditAction::Erase);
    assert!(m.document.surface.is_none() && m.document.is_changed());
}

#[test]
fn chosen_edges_and_the_rim_of_the_selection_stay_sharp() {
    let mut m = on_mesh(
        icosphere(2),
        Refining {
            controls: RefineControls {
                method: Method::Butterfly,
                ..levels(1)
            },
            chosen_edges: true,
            selection_rim: true,
            ..Refining::default()
        },
    );
    let mesh = Arc::clone(&m.document.mesh);
    // a fan is selected, and two edges elsewhere are chosen
    let v = VertexId(0);
    let fan = mesh.topology.outgoing(v).map(|h| mesh.topology.face(h).0);
    let mut faces: Vec<u32> = fan.collect();
    faces.sort_unstable();
    let rim = faces.len();
    m.document.faces = Arc::new(faces);
    let far = (1..mesh.vertex_count()).map(VertexId::from);
    let far = far.max_by(|&a, &b| {
        let distance = |v| mesh.position(v).distance(mesh.position(VertexId(0)));
        distance(a).total_cmp(&distance(b))
    });
    let far = far.expect("vertices");
    let ends: Vec<VertexId> = mesh.topology.neighbours(far).take(2).collect();
    let place = |v: VertexId| mesh.position(v).to_array();
    m.view.report.chains = vec![Chain {
        is_crease: true,
        edges: vec![[place(ends[0]), place(far)], [place(far), place(ends[1])]],
    }];
    act(&mut m, RunAction::Start);
    act(&mut m, RunAction::Finish);
    until(&mut m, |m| m.run.as_ref().is_some_and(Run::ended));
    let state = m.run.as_ref().and_then(|r| r.sides[0].state());
    let state = state.expect("a state");
    // the fan is a separate piece, and the chosen edges are a slit
    let copies = state.topology().vertex_count() - {
        act(&mut m, RunAction::Accept(0));
        m.document.mesh.vertex_count()
    };
    assert_eq!(copies, 2 * rim + 3);
    let Operation::Refine(spec) = &m.document.accepted[0].operation else {
        panic!("a refinement");
    };
    assert!(
        (2..=1 + rim).contains(&spec.creases.len()),
        "{:?}",
        spec.creases
    );
    let slit = vec![ends[0].0, far.0, ends[1].0];
    assert!(spec.creases.contains(&slit), "{:?}", spec.creases);
}

#[test]
fn a_crease_that_is_none_is_said() {
    let mut m = on_icosahedron(Refining {
        chosen_edges: true,
        ..Refining::default()
    });
    let mesh = Arc::clone(&m.document.mesh);
    let near = mesh.topology.neighbours(VertexId(0)).next();
    let ends = [VertexId(0), near.expect("a neighbour")];
    m.view.report.chains = vec![Chain {
        is_crease: true,
        edges: vec![ends.map(|v| mesh.position(v).to_array())],
    }];
    act(&mut m, RunAction::Start);
    assert!(m.run.is_none() && last_message(&m).contains("single edge"));
}

/// A refinement to millions of faces is not started by mistake.
#[test]
fn a_large_refinement_is_asked_about() {
    let mut refining = Refining::default();
    refining.controls.levels = 9;
    let mut m = on_icosahedron(refining);
    act(&mut m, RunAction::Proceed);
    let Modal::Large(faces, estimate) = m.view.modal else {
        panic!("no question: {:?}", m.view.modal);
    };
    assert_eq!(faces, 20 << 18);
    // 3.5 kB for each face of the last level; the seconds are at the rate of this process
    assert!((18.3e9..18.4e9).contains(&estimate.bytes), "{estimate:?}");
    assert!(estimate.seconds > 0.0, "{estimate:?}");
    assert!(m.run.is_none());
    act(&mut m, Action::Escape);
    assert!(m.run.is_none() && m.view.modal == Modal::None);
    m.view.refining.controls.levels = 1;
    act(&mut m, RunAction::Proceed);
    assert!(m.run.is_some() && m.view.modal == Modal::None);
    // the answer starts what was asked about
    act(&mut m, RunAction::Reject);
    m.view.modal = Modal::Large(80, estimate);
    act(&mut m, RunAction::StartLarge);
    assert!(m.run.is_some() && m.view.modal == Modal::None);
}
