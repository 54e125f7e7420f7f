//! Faces: selected, erased, refilled, faired.

use std::sync::Arc;

use super::*;
use crate::app::document::AppliedOperation;
use crate::app::faces::{BrushStamp, FaceEdit};
use crate::app::run::Run;
use crate::app::view_state::{Bridging, Part};
use crate::mesh::{FaceId, Flaw, face_list, flawed_faces};
use crate::ops::{BridgeSpec, FacesSpec, FillPartSpec, Operation};

/// A stroke far from both holes, ended.
fn paint(m: &mut Model, radius: f64) {
    let mesh = Arc::clone(&m.document.mesh);
    let high = |f: &u32| mesh.corners(FaceId(*f))[0].z;
    let faces = 0..mesh.face_count() as u32;
    let face = faces
        .max_by(|a, b| high(a).total_cmp(&high(b)))
        .map(FaceId)
        .expect("faces");
    let point = mesh.corners(face)[0];
    for radius in [0.5 * radius, radius] {
        let stamps = vec![BrushStamp {
            face,
            point,
            radius,
        }];
        act(
            m,
            SelectAction::Faces(FaceEdit::Paint {
                stamps,
                take: false,
            }),
        );
    }
    act(m, ControlsAction::EndDrag);
}

fn in_repair() -> Model {
    let mut m = model();
    act(&mut m, TaskAction::Choose(Task::Repair));
    act(&mut m, RunAction::Pace(240.0));
    m
}

fn run_to_end(m: &mut Model) {
    until(m, |m| m.run.as_ref().is_some_and(Run::ended));
}

fn last(m: &Model) -> &AppliedOperation {
    m.document.accepted.last().expect("something was accepted")
}

#[test]
fn flawed_faces_are_added_to_the_selection() {
    let mut m = in_repair();
    paint(&mut m, 0.4);
    let painted = Arc::clone(&m.document.faces);
    let flaw = Flaw::WorseThan(35.0);
    act(&mut m, SelectAction::Faces(FaceEdit::Flawed(flaw)));
    until(&mut m, |m| m.document.faces.len() > painted.len());
    let flawed = face_list(&flawed_faces(&m.document.mesh, flaw));
    let mut wanted = [&painted[..], &flawed].concat();
    wanted.sort_unstable();
    wanted.dedup();
    assert_eq!(*m.document.faces, wanted);
    act(&mut m, EditAction::Undo);
    assert_eq!(m.document.faces, painted);
}

#[test]
fn a_stroke_is_one_undo_entry() {
    let mut m = in_repair();
    paint(&mut m, 0.4);
    let painted = m.document.faces.len();
    assert!(painted > 10);
    act(&mut m, SelectAction::Faces(FaceEdit::Grow));
    assert!(m.document.faces.len() > painted);
    act(&mut m, EditAction::Undo);
    assert_eq!(m.document.faces.len(), painted);
    act(&mut m, EditAction::Undo);
    assert!(m.document.faces.is_empty());
    act(&mut m, EditAction::Redo);
    assert_eq!(m.document.faces.len(), painted);
    act(&mut m, SelectAction::Faces(FaceEdit::Invert));
    assert_eq!(
        m.document.faces.len(),
        m.document.mesh.face_count() - painted
    );
    act(&mut m, SelectAction::None);
    assert!(m.document.faces.is_empty());
    // nothing to be done without faces
    for action in [
        Action::from(RunAction::Start),
        RunAction::Fair.into(),
        EditAction::Erase.into(),
    ] {
        act(&mut m, action);
        assert!(m.run.is_none());
        assert!(last_message(&m).starts_with("no face is selected"));
    }
}

#[test]
fn refill_replaces_the_faces_and_can_be_rejected_and_undone() {
    let mut m = in_repair();
    let before = Arc::clone(&m.document.mesh);
    paint(&mut m, 0.5);
    let selected = Arc::clone(&m.document.faces);
    act(&mut m, RunAction::Start);
    run_to_end(&mut m);
    act(&mut m, RunAction::Reject);
    assert!(Arc::ptr_eq(&before, &m.document.mesh));
    assert!(Arc::ptr_eq(&selected, &m.document.faces), "still selected");
    act(&mut m, RunAction::Start);
    run_to_end(&mut m);
    let told = format!("refill of {} faces: converged", selected.len());
    assert_eq!(last_message(&m), told);
    act(&mut m, RunAction::Accept(0));
    let after = Arc::clone(&m.document.mesh);
    check_mesh(&after).expect("sound");
    assert_eq!(m.document.loops.len(), 2, "the holes are open as before");
    assert_eq!(
        m.document.first_patch_face,
        before.face_count() - selected.len()
    );
    let Operation::Refill(spec) = &last(&m).operation else {
        panic!("a refill");
    };
    assert_eq!(spec.faces, selected);
    assert_eq!(
        last(&m).faces,
        m.document.first_patch_face..after.face_count()
    );
    // what was not selected is as it was
    let old = &after.positions[..after.vertex_count()];
    let kept = before.positions.iter().filter(|p| old.contains(p)).count();
    assert!(kept > before.vertex_count() / 2);
    for p in m.document.patches().expect("one").positions {
        assert!((p.length() - 1.0).abs() < 5e-3, "the sphere goes on: {p}");
    }
    act(&mut m, EditAction::Undo);
    assert!(Arc::ptr_eq(&before, &m.document.mesh));
}

/// It has one while it flows and when it is accepted.
#[test]
fn a_patch_inside_an_older_one_has_a_seam() {
    let mut m = in_repair();
    act(&mut m, TaskAction::Choose(Task::Fill));
    act(&mut m, SelectAction::Loop(0.into(), SelectHow::Replace));
    filled(&mut m);
    act(&mut m, RunAction::Accept(0));
    let segments = |m: &mut Model| {
        tick(m, Instant::now());
        until(m, |m| m.displays[0].is_settled());
        let display = m.displays[0].latest().expect("drawn");
        let seams = display.surfaces.iter().map(|surface| surface.seam.len());
        seams.sum::<usize>()
    };
    let around = segments(&mut m);
    act(&mut m, TaskAction::Choose(Task::Repair));
    let patch = last(&m).faces.clone();
    m.document.faces = Arc::new((patch.start as u32..patch.end as u32).collect());
    act(&mut m, SelectAction::Faces(FaceEdit::Shrink));
    assert!(!m.document.faces.is_empty());
    act(&mut m, RunAction::Start);
    run_to_end(&mut m);
    let both = segments(&mut m);
    assert!(both > around, "{both} {around}");
    act(&mut m, RunAction::Accept(0));
    assert_eq!(segments(&mut m), both);
}

#[test]
fn fairing_moves_inner_vertices_only_and_shows_them() {
    let mut m = in_repair();
    let before = Arc::clone(&m.document.mesh);
    paint(&mut m, 0.5);
    act(&mut m, RunAction::Fair);
    until(&mut m, |m| {
        m.run.as_ref().is_some_and(|r| r.state_count() > 3)
    });
    let run = m.run.as_ref().expect("a run");
    assert!(!run.faired().is_empty());
    let state = run.sides[0].state().expect("a state");
    assert_eq!(state.positions(false).len(), before.vertex_count());
    act(&mut m, RunAction::Scrub(Some(1)));
    act(&mut m, RunAction::ContinueFromShown);
    run_to_end(&mut m);
    assert!(
        m.run
            .as_ref()
            .is_some_and(|r| r.sides[0].handle.radius() > 0.1)
    );
    act(&mut m, RunAction::Accept(0));
    let after = Arc::clone(&m.document.mesh);
    assert_eq!(before.topology, after.topology);
    assert_eq!(m.document.first_patch_face, before.face_count());
    let Operation::Fair(FacesSpec { faces, .. }) = &last(&m).operation else {
        panic!("a fairing");
    };
    let flags = crate::mesh::face_flags(faces, before.face_count());
    let inner = crate::mesh::inner_vertices(&before.topology, &flags);
    let moved = |v: usize| before.positions[v] != after.positions[v];
    assert!((0..before.vertex_count()).all(|v| inner.contains(&v.into()) || !moved(v)));
    assert!(inner.iter().any(|v| moved(v.index())));
}

#[test]
fn erasing_leaves_a_hole_to_be_filled() {
    let mut m = in_repair();
    act(&mut m, TaskAction::Choose(Task::Fill));
    act(&mut m, SelectAction::Loop(0.into(), SelectHow::Replace));
    filled(&mut m);
    act(&mut m, RunAction::Accept(0));
    let patch = last(&m).faces.clone();
    act(&mut m, TaskAction::Choose(Task::Repair));
    paint(&mut m, 0.3);
    let count = m.document.faces.len();
    act(&mut m, EditAction::Erase);
    assert_eq!(m.document.loops.len(), 2);
    // the earlier patch is known by its new faces
    assert_eq!(
        m.document.accepted[0].faces,
        patch.start - count..patch.end - count
    );
    assert_eq!(m.document.first_patch_face, patch.start - count);
    act(&mut m, SelectAction::Faces(FaceEdit::Invert));
    act(&mut m, EditAction::Erase);
    assert!(last_message(&m).starts_with("all faces are selected"));
}

#[test]
fn turning_over_keeps_the_rims_gathered() {
    let mut m = model();
    act(&mut m, TaskAction::Choose(Task::Blend));
    act(&mut m, SelectAction::Loop(1.into(), SelectHow::Replace));
    let place = m.document.loops[1].centroid;
    let face = m.document.mesh.topology.face_vertices(FaceId(0));
    act(&mut m, EditAction::Flip(1.into()));
    let [a, b, c] = m.document.mesh.topology.face_vertices(FaceId(0));
    assert!([[a, c, b], [c, b, a], [b, a, c]].contains(&face));
    let gathered: Vec<_> = m.document.selected().iter().map(|l| l.centroid).collect();
    assert_eq!(gathered.len(), 1);
    assert!(gathered[0].distance(place) < 1e-12);
    act(&mut m, EditAction::Undo);
    assert_eq!(m.document.mesh.topology.face_vertices(FaceId(0)), face);
}

#[test]
fn a_bridge_makes_two_holes_of_one() {
    let mut m = model();
    act(
        &mut m,
        TaskAction::Bridging(Some(Bridging {
            from: None,
            width: 1,
        })),
    );
    act(&mut m, Action::Escape);
    assert!(m.view.bridging.is_none());
    let l = &m.document.loops[0];
    let at = |i: usize| m.document.mesh.position(l.vertices[i]);
    let ends = [at(0), at(l.edges() / 2)];
    let first = m.document.mesh.face_count();
    act(&mut m, EditAction::Bridge(ends, 1));
    assert_eq!(m.document.loops.len(), 3);
    assert!(m.document.ends_with_bridge());
    assert_eq!(
        last(&m).operation,
        Operation::Bridge(BridgeSpec { ends, width: 1 })
    );
    assert_eq!(last(&m).faces, first..m.document.mesh.face_count());
    // from a place to itself there is none
    act(&mut m, EditAction::Bridge([ends[0], ends[0]], 1));
    assert_eq!(m.document.loops.len(), 3);
    assert!(last_message(&m).contains("ends of the bridge meet"));
    act(&mut m, EditAction::Undo);
    assert_eq!(m.document.loops.len(), 2);
    assert!(!m.document.ends_with_bridge());
}

#[test]
fn a_bridge_flows_with_the_fills_beside_it() {
    let mut m = model();
    let before = Arc::clone(&m.document.mesh);
    let l = &m.document.loops[0];
    let at = |i: usize| m.document.mesh.position(l.vertices[i]);
    let ends = [at(0), at(l.edges() / 2)];
    act(&mut m, EditAction::Bridge(ends, 2));
    let strip = m.document.bridge_faces();
    assert_eq!(
        strip.len(),
        m.document.mesh.face_count() - before.face_count()
    );
    filled(&mut m);
    let run = m.run.as_ref().expect("a run");
    assert_eq!(run.base.positions, before.positions, "the strip is gone");
    // numbers are those of the list
    let mut numbered: Vec<LoopId> = run.loops.iter().map(|l| l.id).collect();
    numbered.sort_unstable();
    let rows = run.sides[0].handle.figures(None);
    let mut holes: Vec<LoopId> = rows.iter().flat_map(|row| row.holes.clone()).collect();
    holes.sort_unstable();
    assert_eq!(holes, numbered);
    assert!(holes.iter().all(|&id| m.document.loop_of(id).is_some()));
    // each loop of the list is in the name of one hole
    let names = rows.iter().flat_map(|row| &row.names);
    let mut named: Vec<String> = names
        .flat_map(|name| name.split('+').map(str::to_owned))
        .collect();
    named.sort();
    let listed: Vec<String> = m.document.loops.iter().map(|l| l.id.to_string()).collect();
    assert_eq!(named, listed);
    act(&mut m, RunAction::Accept(0));
    assert!(m.document.loops.is_empty());
    check_mesh(&m.document.mesh).expect("sound");
    let given = before.vertex_count();
    assert_eq!(m.document.mesh.positions[..given], before.positions);
    let triangles = m.document.mesh.topology.triangles();
    assert!(
        triangles
            .take(before.face_count())
            .eq(before.topology.triangles())
    );
    assert_eq!(m.document.first_patch_face, before.face_count());
    assert!(m.document.bridge_faces().is_empty());
    act(&mut m, EditAction::Undo);
    assert_eq!(m.document.bridge_faces(), strip);
}

#[test]
fn part_of_a_hole_is_filled_between_two_clicks() {
    let mut m = model();
    act(&mut m, TaskAction::Part(Some(Part::default())));
    act(&mut m, RunAction::Proceed);
    assert!(m.run.is_none());
    assert!(last_message(&m).starts_with("click the two rim vertices"));
    let before = Arc::clone(&m.document.mesh);
    let l = &m.document.loops[0];
    let (edges, count) = (l.edges(), m.document.loops.len());
    let at = |i: usize| m.document.mesh.position(l.vertices[i]);
    let ends = [at(1), at(1 + edges / 2)];
    let part = Part::default().with(ends[0]).with(ends[0]).with(ends[1]);
    assert_eq!([part.from, part.to], ends.map(Some));
    // a third click begins another part
    assert_eq!(part.with(ends[0]).to, None);
    act(&mut m, TaskAction::Part(Some(part)));
    act(&mut m, RunAction::Start);
    let asks = |m: &Model| m.log.latest().is_some_and(|e| e.text.starts_with("click"));
    assert!(m.run.is_some() && !asks(&m));
    filled(&mut m);
    assert!(m.view.part.is_none());
    act(&mut m, RunAction::Accept(0));
    assert_eq!(m.document.loops.len(), count);
    check_mesh(&m.document.mesh).expect("sound");
    assert!(m.document.mesh.face_count() > before.face_count());
    assert_eq!(m.history.next_undo(), Some("fill of part of a hole"));
    let flow = m.document.controls.clone().into();
    let spec = FillPartSpec { ends, flow };
    assert_eq!(last(&m).operation, Operation::FillPart(spec));
    act(&mut m, EditAction::Undo);
    assert_eq!(*m.document.mesh, *before);
}

#[test]
fn a_project_keeps_repairs_and_the_selection() {
    let mut m = in_repair();
    let l = &m.document.loops[0];
    let at = |i: usize| m.document.mesh.position(l.vertices[i]);
    let ends = [at(0), at(l.edges() / 2)];
    act(&mut m, EditAction::Bridge(ends, 2));
    paint(&mut m, 0.4);
    act(&mut m, EditAction::Erase);
    paint(&mut m, 0.5);
    act(&mut m, RunAction::Fair);
    run_to_end(&mut m);
    act(&mut m, RunAction::Accept(0));
    paint(&mut m, 0.2);
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("work.meniscus");
    let text = project::write(&m.document, &m.view, folder.path());
    std::fs::write(&path, text).expect("written");
    let (again, _) = project::read(&path).expect("read");
    assert_eq!(again.mesh.positions, m.document.mesh.positions);
    assert_eq!(again.accepted, m.document.accepted);
    assert_eq!(again.faces, m.document.faces);
    assert_eq!(again.first_patch_face, m.document.first_patch_face);
}

/// The parts of the faces that stitching divides belong to no patch.
#[test]
fn stitching_divides_faces_and_is_undone() {
    let corners = [[0., 0.], [2., 0.], [1., -1.], [0.5, 0.], [1., 1.]];
    let positions = corners.map(|[x, y]| DVec3::new(x, y, 0.0)).to_vec();
    let triangles = vec![[1, 0, 2], [0, 3, 4], [3, 1, 4]];
    let mut m = model_of(from_triangles((positions, triangles)));
    let before = Arc::clone(&m.document.mesh);
    assert_eq!(m.document.loops.len(), 2);
    act(&mut m, EditAction::Stitch);
    assert_eq!(m.document.loops.len(), 1);
    assert_eq!(m.document.mesh.face_count(), 4);
    assert_eq!(m.document.first_patch_face, 4);
    assert!(m.document.patches().is_none());
    act(&mut m, EditAction::Undo);
    assert!(Arc::ptr_eq(&before, &m.document.mesh));
}
