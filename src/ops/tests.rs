use std::path::Path;

use proptest::prelude::*;
use serde::{Deserialize, Serialize};

use super::*;
use crate::fill::Continuity;
use crate::mesh::{Mesh, boundary_loops};
use crate::options::Kind;
use crate::refine::Method;
use crate::runner::ScheduleEntry;
use crate::shapes;
use crate::solver::{Mode, Tau};

/// One operation of each kind, with options that differ from the defaults.
pub fn samples() -> Vec<Operation> {
    let controls = Controls {
        energy: "H^2 + a*K^2".into(),
        param: [("a".into(), 0.5)].into(),
        mode: Mode::Flow,
        tau: Tau::Fixed(0.25),
        loop_continuity: [(1.into(), Continuity::G0)].into(),
        ..Controls::default()
    };
    let schedule = Schedule::parse("attempt,control,value\n2,energy,\"max(H,K)\"\n3,stop,\n");
    let flow = FlowSpec {
        schedule: schedule.expect("a schedule"),
        controls: controls.clone(),
    };
    let faces = Faces::new(vec![0, 1, 2, 7]);
    let ends = [DVec3::new(-1.0, 0.1 + 0.2, 0.0), DVec3::Y];
    let on_faces = FacesSpec {
        faces: Arc::clone(&faces),
        flow: flow.clone(),
    };
    vec![
        Operation::Fill(FillSpec {
            loops: vec![0.into(), 2.into()],
            islands: false,
            bridges: Faces::new(vec![3, 4, 5]),
            flow: flow.clone(),
        }),
        Operation::Blend(BlendSpec {
            loops: vec![0.into(), 1.into()],
            flow: flow.clone(),
        }),
        Operation::Refill(on_faces.clone()),
        Operation::Fair(on_faces),
        Operation::FillPart(FillPartSpec { ends, flow }),
        Operation::Refine(RefineSpec {
            controls: RefineControls {
                levels: 2,
                energy: Some("H^2".into()),
                crease_angle: Some(40.5),
                ..RefineControls::default()
            },
            creases: vec![vec![0, 4, 5], vec![9, 8]],
            faces: Arc::clone(&faces),
            schedule: Schedule::default(),
        }),
        Operation::Erase(EraseSpec { faces }),
        Operation::Flip(FlipSpec {
            loops: vec![1.into()],
        }),
        Operation::Bridge(BridgeSpec { ends, width: 3 }),
        Operation::Clean(CleanSpec {
            min_faces: 3,
            flap_faces: 0,
        }),
        Operation::Stitch(StitchSpec {
            tolerance: Some(0.1 + 0.2),
        }),
    ]
}

/// Operations in a list, as a project file holds them.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
struct List {
    fills: Vec<Operation>,
}

#[test]
fn operations_come_back_from_a_file() {
    let list = List { fills: samples() };
    let text = toml::to_string(&list).expect("plain data");
    assert_eq!(toml::from_str::<List>(&text), Ok(list), "{text}");
}

/// Entries as version 0.1 wrote them into project files.
#[test]
fn operations_of_earlier_files_are_read() {
    let list: List = toml::from_str(include_str!("tests_0_1.toml")).expect("a list");
    let tasks: Vec<String> = list.fills.iter().map(Operation::label).collect();
    assert_eq!(
        tasks,
        [
            "fill of 2 loops",
            "refinement",
            "bridge",
            "flip at loop 2",
            "fairing of 13 faces"
        ]
    );
    let Operation::Fill(fill) = &list.fills[0] else {
        panic!("a fill");
    };
    assert!(fill.islands && fill.flow.schedule.entries.len() == 2);
    assert_eq!(fill.flow.controls.param["a"], 0.5);
    assert_eq!(fill.flow.controls.steps, 150);
    assert_eq!(fill.flow.controls.continuity_at(2.into()), Continuity::G0);
    let Operation::Refine(refine) = &list.fills[1] else {
        panic!("a refinement");
    };
    let wanted = RefineSpec {
        controls: RefineControls {
            levels: 2,
            energy: Some("H^2 + a*K^2".into()),
            param: [("a".into(), 0.1)].into(),
            tension: Some(0.5),
            mode: Mode::Flow,
            steps: 200,
            crease_angle: Some(40.0),
            ..RefineControls::default()
        },
        creases: vec![vec![0, 4, 5]],
        faces: Faces::new(vec![0, 1, 2]),
        schedule: Schedule::default(),
    };
    assert_eq!(refine, &wanted);
    let Operation::Bridge(bridge) = &list.fills[2] else {
        panic!("a bridge");
    };
    assert_eq!((bridge.ends[1], bridge.width), (DVec3::Y, 3));
}

#[test]
fn commands_name_files_for_what_is_long() {
    let faces = Faces::new((0..200).step_by(2).collect());
    let erase = Operation::Erase(EraseSpec { faces });
    let command = erase.command(Path::new("my scan.obj"), Path::new("out.obj"));
    assert_eq!(
        command.line,
        "meniscus erase 'my scan.obj' -o out.obj --faces-from out.faces.txt"
    );
    let [(path, text)] = &command.files[..] else {
        panic!("one file: {:?}", command.files);
    };
    assert_eq!(path, Path::new("out.faces.txt"));
    assert!(text.starts_with("1\n3\n5\n"));
    let flip = Operation::Flip(FlipSpec {
        loops: vec![0.into(), 2.into()],
    });
    assert_eq!(
        flip.command(Path::new("a.obj"), Path::new("b.obj")).line,
        "meniscus flip a.obj -o b.obj --component-of 1 --component-of 3"
    );
    let refine = Operation::Refine(RefineSpec {
        controls: RefineControls {
            method: Method::Loop,
            ..RefineControls::default()
        },
        ..RefineSpec::default()
    });
    assert_eq!(
        refine.command(Path::new("a.obj"), Path::new("b.obj")).line,
        "meniscus refine a.obj -o b.obj --method loop"
    );
    let clean = Operation::Clean(CleanSpec {
        min_faces: 3,
        ..CleanSpec::default()
    });
    assert_eq!(
        clean.command(Path::new("a.obj"), Path::new("b.obj")).line,
        "meniscus clean a.obj -o b.obj --min-faces 3"
    );
}

fn cup() -> Mesh {
    let (positions, triangles) = shapes::cut_where(&shapes::sphere(300, 1), |p| p.z > 0.6);
    Mesh::from_triangles(positions, &triangles).expect("a cup")
}

#[test]
fn operations_give_the_expected_meshes() {
    let cup = cup();
    let done = |operation: Operation| operation.run(&cup, &|_, _| true);
    let fill = done(Operation::Fill(FillSpec {
        loops: vec![0.into()],
        islands: true,
        bridges: Faces::default(),
        flow: FlowSpec::default(),
    }));
    let filled = fill.expect("a patch").into_mesh();
    assert!(boundary_loops(&filled).is_empty());
    assert_eq!(filled.positions[..cup.vertex_count()], cup.positions);

    let erased = done(Operation::Erase(EraseSpec {
        faces: Faces::new(vec![0]),
    }));
    assert_eq!(
        erased.expect("a hole").into_mesh().face_count() + 1,
        cup.face_count()
    );

    let flipped = done(Operation::Flip(FlipSpec {
        loops: vec![0.into()],
    }));
    let normal = |mesh: &Mesh| {
        let [a, b, c] = mesh.corners(crate::mesh::FaceId(0));
        (b - a).cross(c - a)
    };
    let flipped = flipped.expect("one component").into_mesh();
    assert!(normal(&flipped).dot(normal(&cup)) < 0.0);

    let refined = done(Operation::Refine(RefineSpec {
        controls: RefineControls {
            levels: 1,
            method: Method::Butterfly,
            ..RefineControls::default()
        },
        ..RefineSpec::default()
    }));
    let refined = refined.expect("a refinement");
    assert_eq!(refined.into_mesh().face_count(), 4 * cup.face_count());
}

#[test]
fn operations_that_do_not_fit_the_mesh_are_refused() {
    let cup = cup();
    let refused = |operation: Operation| {
        let error = operation.run(&cup, &|_, _| true).expect_err("an error");
        error.to_string()
    };
    let text = refused(Operation::Fill(FillSpec {
        loops: vec![4.into()],
        islands: true,
        bridges: Faces::default(),
        flow: FlowSpec::default(),
    }));
    assert!(text.starts_with("loop 5 does not exist"), "{text}");
    let text = refused(Operation::Blend(BlendSpec {
        loops: vec![0.into()],
        flow: FlowSpec::default(),
    }));
    assert!(text.contains("at least two loops"), "{text}");
    let text = refused(Operation::Erase(EraseSpec {
        faces: Faces::new(vec![1_000_000]),
    }));
    assert!(text.starts_with("there is no face 1000001"), "{text}");
    assert!(
        refused(Operation::Erase(EraseSpec {
            faces: Faces::default()
        }))
        .starts_with("no face")
    );
    let text = refused(Operation::Stitch(StitchSpec {
        tolerance: Some(-1.0),
    }));
    assert!(text.starts_with("the tolerance is -1"), "{text}");
}

/// Options of which some have other values than the defaults.
fn any_options<T: Options + std::fmt::Debug>() -> impl Strategy<Value = T> {
    let number = prop_oneof![
        any::<f64>().prop_filter("finite", |x| x.is_finite()),
        (0..9).prop_map(f64::from)
    ];
    let choice = (0..T::entries().len(), any::<usize>(), number, "\\PC{0,9}");
    proptest::collection::vec(choice, 0..12).prop_map(|choices| {
        let mut options = T::default();
        for (entry, choice, number, text) in choices {
            let entry = &T::entries()[entry];
            let texts = match &entry.kind {
                Kind::Flag => vec![["true", "false"][choice % 2].to_owned()],
                Kind::Choice(names) => vec![names[choice % names.len()].to_owned()],
                Kind::Pairs => vec![
                    format!("a{}={number}", choice % 3),
                    format!("{}=g1", choice % 3 + 1),
                ],
                Kind::Word | Kind::Text => {
                    vec![number.to_string(), (choice % 1000).to_string(), text]
                }
            };
            // the first text that the type of the option accepts
            let _ = texts
                .iter()
                .find(|text| options.set(&entry.name, text).is_ok());
        }
        options
    })
}

/// Ascending changes from the default controls.
fn any_schedule() -> impl Strategy<Value = Schedule> {
    let change = (0..99usize, any_options::<Controls>());
    proptest::collection::vec(change, 0..4).prop_map(|mut changes| {
        changes.sort_by_key(|change| change.0);
        let entries = changes.iter().flat_map(|(attempt, controls)| {
            let named = Controls::default().difference(controls).into_iter();
            named.map(|(control, value)| ScheduleEntry {
                attempt: *attempt,
                control,
                value,
            })
        });
        Schedule {
            entries: entries.collect(),
        }
    })
}

proptest! {
    #[test]
    fn differences_of_all_options_set_back(from in any_options::<Controls>(), to in any_options::<Controls>()) {
        let mut options = from.clone();
        for (name, text) in from.difference(&to) {
            prop_assert!(options.set(&name, &text).is_ok(), "{name} {text}");
        }
        prop_assert_eq!(options, to);
    }

    #[test]
    fn all_options_and_schedules_come_back_from_a_file(
        controls in any_options::<Controls>(),
        refine in any_options::<RefineControls>(),
        schedule in any_schedule(),
    ) {
        let flow = FlowSpec { controls, schedule: schedule.clone() };
        let fill = FillSpec { loops: vec![0.into()], islands: true, bridges: Faces::default(), flow };
        let refine = RefineSpec {
            controls: refine,
            creases: Vec::new(),
            faces: Faces::default(),
            schedule: Schedule::default(),
        };
        let list = List { fills: vec![Operation::Fill(fill), Operation::Refine(refine)] };
        let text = toml::to_string(&list).expect("plain data");
        prop_assert_eq!(toml::from_str::<List>(&text), Ok(list), "{}", text);
        prop_assert_eq!(Schedule::parse(&schedule.to_csv()), Ok(schedule));
    }
}
