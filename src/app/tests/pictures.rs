//! Pictures and sequences.

use super::*;
use crate::app::action::PictureAction;
use crate::app::display::DisplayWorker;
use crate::app::update::pictures;
use crate::app::view_state::{PictureKind, PictureSettings};
use crate::render::SequenceFormat;

/// Settings of a small picture with this file name.
fn settings(folder: &Path, name: &str) -> PictureSettings {
    PictureSettings {
        width: 160,
        height: 100,
        path: folder.join(name).display().to_string(),
        ..PictureSettings::default()
    }
}

/// Writes pictures and returns the last message.
fn write(m: &mut Model, settings: PictureSettings) -> String {
    act(m, PictureAction::Make(Box::new(settings)));
    until(m, |m| m.jobs.is_empty());
    last_message(m).to_owned()
}

fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).expect("a folder");
    let names = entries.map(|e| e.expect("an entry").file_name());
    let mut names: Vec<String> = names.map(|n| n.to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

/// Whatever the name says, the content is PNG.
#[test]
fn pictures_have_the_extension_of_their_format() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut m = model();
    for name in ["a", "b.png", "c.bmp", "d.v2"] {
        write(&mut m, settings(folder.path(), name));
    }
    assert_eq!(
        names(folder.path()),
        ["a.png", "b.png", "c.bmp.png", "d.v2.png"]
    );
}

#[test]
fn a_picture_replaces_a_file_only_after_a_question() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut m = model();
    let turn = PictureSettings {
        kind: PictureKind::Turntable,
        frames: 2,
        ..settings(folder.path(), "turn.png")
    };
    let still = settings(folder.path(), "a.png");
    for (settings, file) in [(still, "a.png"), (turn, "turn-0000.png")] {
        let file = folder.path().join(file);
        std::fs::write(&file, "mine").expect("written");
        let is_kept = || std::fs::read(&file).expect("there") == b"mine";
        let dialog = Modal::Picture(settings.clone());
        act(&mut m, Action::Modal(dialog.clone()));
        act(&mut m, PictureAction::Make(Box::new(settings)));
        let Modal::Replace(asked) = m.view.modal.clone() else {
            panic!("no question about {}", file.display());
        };
        assert_eq!(asked.path, file);
        act(&mut m, Action::Escape);
        assert!(is_kept() && m.view.modal == dialog);
        act(&mut m, Action::Modal(Modal::Replace(asked.clone())));
        act(&mut m, asked.writing);
        until(&mut m, |m| m.jobs.is_empty());
        assert!(!is_kept() && m.view.modal == Modal::None);
    }
}

#[test]
fn a_picture_of_the_window_replaces_no_file() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut m = model();
    m.document = Document::new(opened(), Source::File(folder.path().join("a.obj")));
    for name in ["a.window.png", "a.window-2.png"] {
        let free = folder.path().join(name);
        act(&mut m, PictureAction::Window);
        let effect = m.effects.pop();
        assert!(matches!(effect, Some(Effect::WindowPicture(path)) if path == free));
        std::fs::write(free, "mine").expect("written");
    }
}

/// The dialog opens again with what was entered.
#[test]
fn settings_of_a_picture_that_cannot_be_written_are_kept() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut m = model();
    let settings = settings(&folder.path().join("missing"), "picture.png");
    write(&mut m, settings.clone());
    assert_eq!(m.view.modal, Modal::Picture(settings));
}

#[test]
fn sides_are_drawn_side_by_side_and_states_as_a_sequence() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut m = model();
    m.view.viewport_px = [79.0, 100.0];
    act(&mut m, SelectAction::Loop(0.into(), SelectHow::Replace));
    act(&mut m, ControlsAction::CompareEnergy(Some("1".into())));
    filled(&mut m);
    act(&mut m, ViewAction::Mode(ViewMode::Mean));
    let mut style = m.view.style;
    style.range = Some([-2.0, 2.0]);
    act(&mut m, ViewAction::Style(style));
    // both sides are drawn at their newest states
    tick(&mut m, Instant::now());
    until(&mut m, |m| {
        m.displays[..2].iter().all(DisplayWorker::is_settled)
    });
    let open = |name: &str| {
        let picture = image::open(folder.path().join(name)).expect("a picture");
        picture.to_rgba8()
    };
    let both = PictureSettings {
        legend: false,
        ..settings(folder.path(), "both")
    };
    let message = write(&mut m, both.clone());
    assert!(
        message.ends_with("both.png"),
        "an extension is added: {message}"
    );
    let one = PictureSettings {
        all_sides: false,
        legend: false,
        width: 79,
        ..settings(folder.path(), "one.png")
    };
    write(&mut m, one);
    let (both, one) = (open("both.png"), open("one.png"));
    assert_eq!(both.dimensions(), (160, 100));
    // below the title, the left half is the first side
    let lower = |x: u32, y: u32| y > 30 && both.get_pixel(x, y) != one.get_pixel(x, y);
    let differ = (0..79).flat_map(|x| (0..100).map(move |y| (x, y)));
    // one pixel at the border of a triangle is rounded otherwise in a part of a larger picture
    assert!(differ.filter(|&(x, y)| lower(x, y)).count() <= 3);
    assert_ne!(both.get_pixel(40, 50), both.get_pixel(79, 50), "a gap");

    let flow = PictureSettings {
        kind: PictureKind::Flow,
        states: 3,
        transparent: true,
        caption: "a caption".into(),
        ..settings(folder.path(), "flow.png")
    };
    let message = write(&mut m, flow);
    assert!(message.starts_with("3 pictures saved"), "{message}");
    let written = [
        "both.png",
        "flow-0000.png",
        "flow-0001.png",
        "flow-0002.png",
        "one.png",
    ];
    assert_eq!(names(folder.path()), written);
    assert_ne!(open("flow-0000.png"), open("flow-0002.png"));
    // the legend and the caption have ink on the transparent ground
    let picture = open("flow-0002.png");
    let inked = |x: std::ops::Range<u32>, y: std::ops::Range<u32>| {
        let places = x.flat_map(|x| y.clone().map(move |y| (x, y)));
        places
            .filter(|&(x, y)| picture.get_pixel(x, y)[3] > 128)
            .count()
    };
    assert!(inked(0..80, 88..100) > 20 && inked(125..160, 10..80) > 50);
    assert_eq!(picture.get_pixel(159, 99)[3], 0);
}

#[test]
fn a_sequence_is_cancelled_while_it_is_written() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut m = model();
    until(&mut m, |m| {
        m.displays[0].latest().is_some() && m.jobs.is_empty()
    });
    let turn = PictureSettings {
        kind: PictureKind::Turntable,
        frames: 2000,
        format: SequenceFormat::Png,
        ..settings(folder.path(), "turn.png")
    };
    act(&mut m, PictureAction::Make(Box::new(turn)));
    until(&mut m, |m| {
        let progress = m.jobs.first().and_then(super::super::jobs::Job::progress);
        progress.is_some_and(|(done, total)| done > 0 && total == 2000)
    });
    act(&mut m, SelectAction::All);
    act(&mut m, Action::Escape);
    assert!(m.jobs.is_empty());
    assert_eq!(m.document.selection.len(), 2, "Esc does nothing else");
    assert!(last_message(&m).contains("cancelled"));
    let begun = Instant::now();
    while !names(folder.path()).is_empty() {
        assert!(begun.elapsed() < Duration::from_mins(1), "files remain");
        std::thread::sleep(Duration::from_millis(5));
    }
}

#[test]
fn the_file_of_a_picture_is_browsed_for_or_typed() {
    let mut m = model();
    act(&mut m, PictureAction::Ask);
    let path = |m: &Model| match &m.view.modal {
        Modal::Picture(settings) => settings.path.clone(),
        other => panic!("another dialog: {other:?}"),
    };
    let first = path(&m);
    pictures::path_chosen(&mut m, None, Duration::ZERO);
    assert_eq!(path(&m), first);
    assert!(last_message(&m).contains("type the path"));
    pictures::path_chosen(
        &mut m,
        Some("/tmp/other.png".into()),
        Duration::from_secs(9),
    );
    assert_eq!(path(&m), "/tmp/other.png");
    // the dialog was closed in the meantime
    act(&mut m, Action::Escape);
    pictures::path_chosen(
        &mut m,
        Some("/tmp/third.png".into()),
        Duration::from_secs(9),
    );
    assert_eq!(m.view.modal, Modal::None);
}
