//! Refinements in the window.

use std::sync::Arc;

use super::*;
use crate::app::document::Work;
use crate::app::run::Run;
use crate::app::view_state::Refining;
use crate::mesh::shapes::icosphere;
use crate::refine::Method;

fn on_icosahedron(refining: Refining) -> Model {
    let (positions, triangles) = icosphere(1);
    let soup = Soup {
        positions,
        offsets: (0..=triangles.len() as u32).map(|i| 3 * i).collect(),
        corners: triangles.into_iter().flatten().collect(),
        ..Soup::default()
    };
    let opened = io::from_soup(soup, Path::new("test")).expect("sound");
    let document = Document::new(opened, Source::Sample("test".into()));
    let wake: crate::app::jobs::Wake = Arc::new(|| ());
    let mut m = Model::new(document, Settings::default(), Autosave::off(), wake);
    m.act(Action::Pace(240.0));
    m.act(Action::Task(Task::Refine));
    m.act(Action::Refining(Box::new(refining)));
    m
}

#[test]
fn three_methods_side_by_side_and_one_is_taken() {
    let mut m = on_icosahedron(Refining {
        levels: 2,
        own_energy: false,
        beside: [Some(Method::Butterfly), Some(Method::Loop)],
        ..Refining::default()
    });
    let before = Arc::clone(&m.document.mesh);
    m.act(Action::Fill);
    m.act(Action::Finish);
    until(&mut m, |m| m.run.as_ref().is_some_and(Run::ended));
    let run = m.run.as_ref().expect("there");
    assert_eq!(run.names(), ["PDE", "Butterfly", "Loop"]);
    for side in &run.sides {
        let state = side.state().expect("a state");
        assert_eq!(state.topology().face_count(), 16 * before.face_count());
    }
    until(&mut m, |m| {
        m.displays.iter().all(|d| {
            let asked = d.asked().and_then(|r| r.state.as_ref());
            asked.is_some() && d.latest().is_some()
        })
    });
    // states can be scrubbed over all levels
    m.act(Action::Scrub(Some(0)));
    let first = m
        .run
        .as_ref()
        .and_then(|r| r.sides[0].state())
        .expect("a state");
    assert_eq!(first.topology().face_count(), before.face_count());
    m.act(Action::Scrub(None));
    m.act(Action::Accept(0));
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
    let Work::Refine(work) = &m.document.accepted[0].work else {
        panic!("a refinement");
    };
    assert!(!work.changed && work.words[..2] == ["--levels", "2"]);
    m.act(Action::Undo);
    assert!(Arc::ptr_eq(&before, &m.document.mesh));
}

#[test]
fn a_refinement_needs_its_selected_faces() {
    let mut m = on_icosahedron(Refining {
        levels: 1,
        selected_only: true,
        ..Refining::default()
    });
    m.act(Action::Fill);
    assert!(m.run.is_none() && last_message(&m).starts_with("no face is selected"));
    m.document.faces = Arc::new(vec![0, 1, 2]);
    m.act(Action::Fill);
    m.act(Action::Finish);
    until(&mut m, |m| m.run.as_ref().is_some_and(Run::ended));
    m.act(Action::Accept(0));
    let faces = m.document.mesh.face_count();
    assert!((20 + 9..80).contains(&faces), "{faces}");
}
