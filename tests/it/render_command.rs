//! `meniscus render` and `--picture`, on small generated meshes.

use std::fmt::Write as _;

use crate::common::desk::{Desk, Run};
use meniscus::shapes;

/// A folder with a sphere that has a hole at the top, `cup.obj`.
fn cup() -> Desk {
    let desk = Desk::new();
    let (positions, triangles) = shapes::cut_where(&shapes::sphere(400, 1), |p| p.y > 0.8);
    let mut text = String::new();
    for p in positions {
        let _ = writeln!(text, "v {} {} {}", p.x, p.y, p.z);
    }
    for [a, b, c] in triangles {
        let _ = writeln!(text, "f {} {} {}", a + 1, b + 1, c + 1);
    }
    desk.write("cup.obj", &text);
    desk
}

fn image_of(desk: &Desk, name: &str) -> image::RgbaImage {
    image::open(desk.path(name)).expect("a picture").to_rgba8()
}

#[test]
fn pictures_of_any_kind() {
    let desk = cup();
    let render = |name: &str, options: &str| {
        let mut words = vec!["render", "cup.obj", "-o", name];
        words.extend(options.split_whitespace());
        desk.runs(&words);
        image_of(&desk, name)
    };
    let plain = render("a.png", "--size 120x90");
    assert_eq!(plain.dimensions(), (120, 90));
    assert_eq!(render("b.png", "--size 120x90"), plain);
    assert!(plain.pixels().all(|p| p[3] == 255));
    let clear = render("c.png", "--size 120x90 --transparent");
    assert_eq!(clear.get_pixel(0, 0)[3], 0);
    assert_eq!(clear.get_pixel(60, 45)[3], 255);
    for options in [
        "--view isophotes",
        "--view shaded --material clay",
        "--view zebra",
        "--view H",
        "--view k1 --range -3,3",
        "--camera top --rims",
        "--grid",
        "--cut 0,0,0,0,0,1",
        "--camera top --up z",
        "--orthographic",
        "--view isophotes --stripes 3",
        "--view isophotes --light -1,0,0",
        "--wireframe --control-mesh",
        "--dark",
        "--caption test",
        "--camera 0,0,0,0,0,0,1,4,35,persp",
    ] {
        let image = render("d.png", &format!("--size 120x90 {options}"));
        assert_ne!(image, plain, "{options}");
    }
}

/// The half of the surface on the side of the eye is hidden, whichever way the normal points.
#[test]
fn a_plane_hides_what_is_in_front_of_it() {
    let desk = cup();
    let covered = |cut: &str| {
        let look = ["--camera", "front", "--transparent", "--size", "120x90"];
        let words = ["render", "cup.obj", "-o", "cut.png"];
        let cut = ["--cut", cut];
        let cut = &cut[..if cut[1].is_empty() { 0 } else { 2 }];
        desk.runs(&[&words[..], &look, cut].concat());
        let image = image_of(&desk, "cut.png");
        image.pixels().filter(|p| p[3] > 128).count()
    };
    let whole = covered("");
    assert!(whole > 2000, "{whole}");
    assert_eq!(covered("0,0,2,0,0,1"), whole);
    assert_eq!(covered("0,0,-2,0,0,1"), 0);
    // of a cup that is cut lengthwise the inside is seen, within the same outline
    for normal in ["1", "-1"] {
        let half = covered(&format!("0,0,0,0,0,{normal}"));
        assert!(half <= whole && 10 * half > 8 * whole, "{half} of {whole}");
    }
}

/// The legend is beside the surface, with the colours of the ends of the map, and the caption below it.
#[test]
fn a_legend_and_a_caption_have_their_own_room() {
    let desk = cup();
    let render = |name: &str, options: &[&str]| {
        let words = [
            "render", "cup.obj", "-o", name, "--view", "H", "--size", "400x300",
        ];
        desk.runs(&[&words[..], options].concat());
        image_of(&desk, name)
    };
    let plain = render("plain.png", &[]);
    let options = [
        "--legend",
        "--caption",
        "Mean curvature of a cup",
        "--transparent",
    ];
    let labelled = render("labelled.png", &options);
    assert_eq!(labelled.dimensions(), plain.dimensions());
    let has = |color: [u8; 3]| {
        labelled
            .pixels()
            .any(|p| p.0 == [color[0], color[1], color[2], 255])
    };
    for t in [0.005, 0.995] {
        let color = meniscus::render::colormap(t).map(|c| (255.0 * c).round() as u8);
        let near = |p: &image::Rgba<u8>| p[3] == 255 && (0..3).all(|k| p[k].abs_diff(color[k]) < 6);
        let bar = labelled
            .enumerate_pixels()
            .filter(|(x, _, p)| *x > 300 && near(p));
        assert!(bar.count() > 10, "{t}");
    }
    let ink = [24, 30, 38];
    assert!(has(ink));
    // the caption is in the last rows, and nothing else
    let rows = |from: u32| {
        let below = labelled
            .enumerate_pixels()
            .filter(move |(_, y, _)| *y >= from);
        below.filter(|(.., p)| p[3] > 0).count()
    };
    assert!(rows(272) > 100 && rows(272) < 2500, "{}", rows(272));
}

#[test]
fn a_filled_hole_is_tinted() {
    let desk = cup();
    let words = "fill cup.obj -o ball.obj -q --picture ball.png --size 120x90 --camera top";
    desk.runs(&words.split_whitespace().collect::<Vec<_>>());
    let middle = *image_of(&desk, "ball.png").get_pixel(60, 45);
    let warm = |p: image::Rgba<u8>| i32::from(p[0]) > i32::from(p[2]) + 20;
    assert!(warm(middle), "{middle:?}");
    desk.runs(&[
        "render",
        "ball.obj",
        "-o",
        "plain.png",
        "--size",
        "120x90",
        "--camera",
        "top",
    ]);
    assert!(!warm(*image_of(&desk, "plain.png").get_pixel(60, 45)));
    let words = ["fill", "cup.obj", "-o", "x.obj", "--view", "H"];
    desk.run(&words).fails(2, &["--picture"]);
}

#[test]
fn a_crease_shows_as_one() {
    let desk = cup();
    let look = "--size 120x90 --no-tint --view isophotes";
    let words =
        format!("fill cup.obj -o flat.obj -q --energy 1 --continuity g0 --picture a.png {look}");
    desk.runs(&words.split_whitespace().collect::<Vec<_>>());
    let words = format!("render flat.obj -o b.png {look}");
    desk.runs(&words.split_whitespace().collect::<Vec<_>>());
    // the file contains no creases, so the second picture rounds the rim
    let (sharp, round) = (image_of(&desk, "a.png"), image_of(&desk, "b.png"));
    let differ = sharp
        .pixels()
        .zip(round.pixels())
        .filter(|(a, b)| a[0].abs_diff(b[0]) > 60)
        .count();
    assert!((30..2000).contains(&differ), "{differ}");
}

#[test]
fn turntables() {
    let desk = cup();
    let turn = [
        "render",
        "cup.obj",
        "--size",
        "40x30",
        "--turntable",
        "3",
        "-o",
    ];
    let with = |name| [&turn[..], &[name]].concat();
    desk.runs(&with("turn.png"));
    desk.runs(&with("turn.gif"));
    desk.runs(&with("turn.apng"));
    assert_eq!(
        desk.names(),
        [
            "cup.obj",
            "turn-0000.png",
            "turn-0001.png",
            "turn-0002.png",
            "turn.apng",
            "turn.gif"
        ]
    );
    assert_ne!(
        image_of(&desk, "turn-0000.png"),
        image_of(&desk, "turn-0001.png")
    );
}

#[test]
fn mistakes_are_explained() {
    let desk = cup();
    let render = |options: &str| {
        let mut words = vec!["render", "cup.obj"];
        words.extend(options.split_whitespace());
        desk.run(&words)
    };
    for (options, code, part) in [
        ("-o a.png --view sideways", 2, "isophotes"),
        ("-o a.png --size 9000x10", 2, "8192"),
        ("-o a.png --size 10", 2, "1920x1080"),
        ("-o a.png --camera nowhere", 2, "front"),
        ("-o a.jpg", 2, ".png"),
        ("-o a.gif", 2, "--turntable"),
        ("-o a.png --format gif", 2, "--turntable"),
        ("-o a.png --range 2,1", 2, "lower first"),
        ("-o a.png --legend", 2, "--view H"),
        ("-o no/such/a.png", 1, "no/such"),
    ] {
        render(options).fails(code, &[part]);
    }
    assert_eq!(desk.names(), ["cup.obj"]);
}

#[test]
fn without_an_adapter_it_says_what_to_install() {
    let desk = cup();
    let mut command = desk.command(&["render", "cup.obj", "-o", "a.png"]);
    command
        .env("VK_ICD_FILENAMES", "/none")
        .env("VK_DRIVER_FILES", "/none")
        .env("__EGL_VENDOR_LIBRARY_FILENAMES", "/none");
    Run::of(command).fails(1, &["mesa-vulkan-drivers", "libegl1"]);
    assert_eq!(desk.names(), ["cup.obj"]);
}
