//! Textures of patches over holes of a painted sample.

use std::collections::BTreeSet;
use std::sync::Arc;

use super::extension::{Extension, overlapping};
use crate::fill::{
    Controls, LiveFill, PatchTexture, PreparedFill, ScheduledOptions, Surface, fill_rim_sets,
};
use crate::images::Pixels;
use crate::mesh::{
    Attributes, Column, FaceId, Mesh, NO_VALUE, OwnMaterial, boundary_loops, build, to_light,
};
use crate::runner::{Event, RunSettings, Schedule};
use crate::shapes::Sample;
use crate::warning::Warning;
use robust::Coord;

fn egg() -> Mesh {
    let sample = Sample::named("egg").expect("a sample");
    build(&sample.soup()).expect("sound").0
}

/// The egg as PLY files have it: texture coordinates of vertices, which are repeated along the seam.
fn egg_of_vertices() -> Mesh {
    let mut soup = Sample::named("egg").expect("a sample").soup();
    let all = &mut soup.attributes;
    let corners = std::mem::take(&mut all.faces.texture);
    all.vertices = std::mem::take(&mut all.texture).to_vec();
    let mut positions = vec![soup.positions[0]; all.vertices[0].numbers.len()];
    for (&row, &v) in corners.iter().zip(&soup.corners) {
        positions[row as usize] = soup.positions[v as usize];
    }
    (soup.positions, soup.corners) = (positions, corners);
    let mesh = build(&soup).expect("sound").0;
    assert!(mesh.vertex_count() < mesh.attributes.vertex_of_row.len());
    mesh
}

/// The mesh with texture coordinates of vertices as those of corners.
fn of_corners(mesh: Mesh) -> Mesh {
    let (given, triangles) = (&mesh.attributes, mesh.topology.triangles());
    let changed = given.with_texture_of_corners(triangles, &[]);
    let attributes = changed.unwrap_or_else(|| given.clone());
    Mesh { attributes, ..mesh }
}

fn controls(patch_texture: PatchTexture) -> Controls {
    Controls {
        patch_texture,
        surface: Surface::Energy,
        ..Controls::default()
    }
}

/// The filled mesh, and its warnings about textures.
fn filled(mesh: &Mesh, patch_texture: PatchTexture) -> (Mesh, Vec<Warning>) {
    let loops = boundary_loops(mesh);
    let rims: Vec<_> = loops.iter().map(|l| vec![l]).collect();
    let options = controls(patch_texture).options().expect("valid");
    let filled = fill_rim_sets(mesh, &rims, &options, &|_, _| true).expect("filled");
    let warnings = filled.holes.iter().flat_map(|hole| hole.warnings.iter());
    let of_texture = warnings.filter(|w| matches!(w, Warning::NoTexture { .. }));
    let of_texture = of_texture.cloned().collect();
    (filled.mesh, of_texture)
}

fn material_at(mesh: &Mesh, face: usize) -> &str {
    mesh.attributes.material_of(face)
}

/// The colour that a face shows at a mix of its corners, as signals in 0..=255.
fn shown(mesh: &Mesh, face: usize, weights: [f64; 3]) -> [f64; 3] {
    let all = &mesh.attributes;
    let material = material_at(mesh, face);
    let own = all.own_materials.iter().find(|m| m.name == material);
    let pixels = Pixels::decode(&own.expect("a material").png).expect("an image");
    let mut at = [0.0; 2];
    for k in 0..3 {
        let row = all.faces.texture[3 * face + k] as usize;
        let [u, v] = [0, 1].map(|c| all.texture[c].numbers.get(row));
        at[0] += weights[k] * u * f64::from(pixels.width);
        at[1] += weights[k] * (1.0 - v) * f64::from(pixels.height);
    }
    let texel = |x: f64, y: f64| {
        let (x, y) = (x as usize, y as usize);
        let first = 4 * (y * pixels.width as usize + x);
        [0, 1, 2].map(|k| to_light(f64::from(pixels.rgba[first + k]) / 255.0))
    };
    let [x, y] = at.map(|x| x - 0.5);
    let (s, t) = (x.fract(), y.fract());
    let mut light = [0.0; 3];
    for (dx, dy, w) in [
        (0.0, 0.0, (1.0 - s) * (1.0 - t)),
        (1.0, 0.0, s * (1.0 - t)),
        (0.0, 1.0, (1.0 - s) * t),
        (1.0, 1.0, s * t),
    ] {
        let one = texel(x + dx, y + dy);
        light = [0, 1, 2].map(|k| light[k] + w * one[k]);
    }
    light.map(|x| 255.0 * crate::mesh::to_signal(x))
}

/// Two patches cross the seam and get an image, one extends its chart; across every rim edge the colours
/// are the same.
#[test]
fn colours_agree_across_rims() {
    for given in [egg(), egg_of_vertices()] {
        let (mesh, warnings) = filled(&given, PatchTexture::Auto);
        assert_eq!(warnings, []);
        assert_colours_agree(&of_corners(given), &of_corners(mesh));
    }
}

fn assert_colours_agree(given: &Mesh, mesh: &Mesh) {
    let all = &mesh.attributes;
    let names: Vec<&str> = all.own_materials.iter().map(|m| m.name.as_str()).collect();
    assert_eq!(names, ["egg", "patches"]);
    assert_eq!(all.own_materials[1].like, "egg");
    let new = given.face_count()..mesh.face_count();
    assert!(!all.faces.texture.contains(&NO_VALUE));
    let materials: BTreeSet<&str> = new.clone().map(|f| material_at(mesh, f)).collect();
    assert_eq!(materials, BTreeSet::from(["egg", "patches"]));
    let old = &given.attributes.faces;
    assert_eq!(all.faces.texture[..old.texture.len()], old.texture[..]);
    assert_eq!(all.faces.tags[..old.tags.len()], old.tags[..]);
    let (mut worst, mut sum, mut samples) = (0.0_f64, 0.0, 0);
    for face in new
        .filter(|&f| material_at(mesh, f) == "patches")
        .map(FaceId::from)
    {
        for (k, h) in mesh.topology.face_halfedges(face).into_iter().enumerate() {
            let beyond = mesh.topology.face(h.twin());
            if beyond.index() >= given.face_count() {
                continue;
            }
            let corners = mesh.topology.face_vertices(beyond);
            let corner = |v| corners.iter().position(|&c| c == v).expect("a common edge");
            let ends = [mesh.topology.origin(h), mesh.topology.target(h)].map(corner);
            for t in [0.0, 0.3, 0.5, 0.8] {
                let (mut inside, mut outside) = ([0.0; 3], [0.0; 3]);
                (inside[k], inside[(k + 1) % 3]) = (1.0 - t, t);
                (outside[ends[0]], outside[ends[1]]) = (1.0 - t, t);
                let a = shown(mesh, face.index(), inside);
                let b = shown(mesh, beyond.index(), outside);
                let apart = (0..3).map(|k| (a[k] - b[k]).abs()).fold(0.0, f64::max);
                worst = worst.max(apart);
                sum += apart;
                samples += 1;
            }
        }
    }
    assert!(samples > 100, "{samples}");
    let mean = sum / f64::from(samples);
    // of 255; measured: 8 and 1, because the colours come from half a texel inside the given faces, and
    // one texel at the edge of a band makes 16
    assert!(worst < 10.0 && mean < 1.5, "{worst}, {mean}");
}

/// Where vertices have texture coordinates, those of a patch across the seam are in no chart of the given faces.
#[test]
fn texture_coordinates_of_vertices_do_not_cross_seams() {
    let given = egg_of_vertices();
    let rows = given.attributes.vertices[0].numbers.len();
    for patch_texture in [PatchTexture::Extend, PatchTexture::None] {
        let (mesh, warnings) = filled(&given, patch_texture);
        let extends = patch_texture == PatchTexture::Extend;
        assert_eq!(warnings.len(), if extends { 2 } else { 0 });
        let all = &mesh.attributes;
        for (old, new) in given.attributes.vertices.iter().zip(&all.vertices) {
            let is_same = |row: usize| old.numbers.get(row) == new.numbers.get(row);
            assert!((0..rows).all(is_same));
        }
        let old = &given.attributes.faces.rows;
        assert_eq!(all.faces.rows[..old.len()], old[..]);
        let corners: Vec<u32> = mesh.topology.triangles().flatten().collect();
        assert!(
            (all.faces.rows.iter().zip(&corners))
                .all(|(&row, &v)| all.vertex_of_row[row as usize] == v)
        );
        let number = |row: u32| [0, 1].map(|k| all.vertices[k].numbers.get(row as usize));
        // no triangle reaches from one chart into another
        let (mut blank, mut count) = (0, 0);
        for rows in all.faces.rows[old.len()..].chunks_exact(3) {
            let at = [0, 1, 2].map(|k| number(rows[k]));
            let apart = [1, 2].map(|k| (at[k][0] - at[0][0]).hypot(at[k][1] - at[0][1]));
            assert!(apart.iter().all(|x| *x < 0.1), "{at:?}");
            blank += usize::from(at == [[0.0; 2]; 3]);
            count += 1;
        }
        assert!(blank > 0 && (blank < count) == extends);
    }
}

/// Where the image is blank inside a rim, the chart is not extended.
#[test]
fn blank_parts_of_an_image_are_not_shown() {
    let mut given = egg();
    let own = &mut given.attributes.own_materials[0];
    let mut pixels = Pixels::decode(&own.png).expect("an image");
    // black where no face is
    let mut painted = vec![false; (pixels.width * pixels.height) as usize];
    let all = &given.attributes.texture;
    let size = [pixels.width, pixels.height].map(f64::from);
    for rows in given.attributes.faces.texture.chunks_exact(3) {
        let at = |row: u32| {
            let [u, v] = [0, 1].map(|k| all[k].numbers.get(row as usize));
            [u * size[0], (1.0 - v) * size[1]]
        };
        let [a, b, c] = [at(rows[0]), at(rows[1]), at(rows[2])];
        for i in 0..=20 {
            for j in 0..=20 - i {
                let [s, t] = [i, j].map(|k| f64::from(k) / 20.0);
                let [x, y] = [0, 1].map(|k| a[k] + s * (b[k] - a[k]) + t * (c[k] - a[k]));
                painted[y as usize * pixels.width as usize + x as usize] = true;
            }
        }
    }
    for (pixel, _) in pixels
        .rgba
        .chunks_exact_mut(4)
        .zip(painted)
        .filter(|p| !p.1)
    {
        pixel.copy_from_slice(&[0, 0, 0, u8::MAX]);
    }
    own.png = Arc::new(pixels.to_png().expect("written"));
    let (mesh, _) = filled(&given, PatchTexture::Auto);
    let new = given.face_count()..mesh.face_count();
    assert!(new.clone().all(|f| material_at(&mesh, f) == "patches"));
    // no patch shows the black
    for face in new {
        let shade = shown(&mesh, face, [1.0 / 3.0; 3]);
        assert!(shade.iter().sum::<f64>() > 90.0, "{shade:?}");
    }
    let (mesh, _) = filled(&given, PatchTexture::Extend);
    let egg = |f: &usize| {
        material_at(&mesh, *f) == "egg" && mesh.attributes.faces.texture[3 * f] != NO_VALUE
    };
    assert!((given.face_count()..mesh.face_count()).any(|f| egg(&f)));
}

#[test]
fn the_option_decides() {
    let given = egg();
    let count = |patch_texture| {
        let (mesh, warnings) = filled(&given, patch_texture);
        assert_eq!(warnings, []);
        let new = given.face_count()..mesh.face_count();
        let rows = &mesh.attributes.faces.texture;
        let blank = new.clone().filter(|f| rows[3 * f] == NO_VALUE).count();
        let own = new
            .clone()
            .filter(|&f| material_at(&mesh, f) == "patches")
            .count();
        [blank, own, new.len()]
    };
    let [blank, own, all] = count(PatchTexture::Extend);
    assert!(own == 0 && blank > 0 && blank < all);
    let [blank, own, all] = count(PatchTexture::Own);
    assert!(blank == 0 && own == all);
    let [blank, own, all] = count(PatchTexture::None);
    assert!(own == 0 && blank == all);
}

/// Several images in one mesh have names of their own, and an image that is no image gives a reason.
#[test]
fn names_differ_and_unreadable_images_are_said() {
    let (once, _) = filled(&egg(), PatchTexture::Own);
    let mut again = once.clone();
    again.attributes.own_materials[0].png = Arc::new(b"no image".to_vec());
    let kept: Vec<[u32; 3]> = again.topology.triangles().collect();
    let seen = again.positions[kept[0][0] as usize];
    let near = |f: &FaceId| again.corners(*f)[0].distance(seen) < 0.25;
    let chosen: Vec<bool> = again.topology.faces().map(|f| near(&f)).collect();
    let left = crate::mesh::erase(&again, &chosen).mesh;
    let (mesh, warnings) = filled(&left, PatchTexture::Own);
    let names = |mesh: &Mesh| -> Vec<String> {
        let own = mesh.attributes.own_materials.iter();
        own.map(|m| m.name.clone()).collect()
    };
    assert_eq!(names(&mesh), ["egg", "patches"]);
    let [Warning::NoTexture { reason, .. }] = &warnings[..] else {
        panic!("{warnings:?}");
    };
    assert!(reason.contains("is not read"), "{reason}");
    let mut sound = left;
    sound.attributes.own_materials[0] = OwnMaterial::clone(&once.attributes.own_materials[0]);
    let (mesh, warnings) = filled(&sound, PatchTexture::Own);
    assert_eq!(
        (names(&mesh), warnings),
        (
            ["egg", "patches", "patches_2"].map(str::to_owned).to_vec(),
            vec![]
        )
    );
}

/// The window and the command line make the same image.
#[test]
fn a_live_fill_is_repeated_to_the_bit() {
    let given = Arc::new(egg());
    let loops = boundary_loops(&given);
    let controls = controls(PatchTexture::Auto);
    let settings = RunSettings {
        playing: true,
        pace: None,
        timeline_bytes: 1 << 24,
    };
    let (bell, woken) = std::sync::mpsc::channel();
    let wake = Arc::new(move || {
        bell.send(()).ok();
    });
    let options = ScheduledOptions::new(&controls, &Schedule::default()).expect("valid");
    let live = LiveFill::spawn(
        Arc::clone(&given),
        controls.clone(),
        settings,
        wake,
        |mesh| {
            let loops = boundary_loops(mesh);
            let rims: Vec<_> = loops.iter().map(|l| vec![l]).collect();
            Ok::<_, String>(PreparedFill::new(mesh, &rims, &[], options))
        },
    );
    let mut live = live.expect("a thread");
    while !live.ended() {
        woken.recv().expect("a wake");
        for event in live.poll() {
            assert!(!matches!(event, Event::Failed { .. }));
        }
    }
    let last = live.timeline().states.last().expect("a state").state.mesh();
    let options = ScheduledOptions::new(&controls, &live.schedule()).expect("valid");
    let rims: Vec<_> = loops.iter().map(|l| vec![l]).collect();
    let filled = fill_rim_sets(&given, &rims, options, &|_, _| true).expect("filled");
    assert!(filled.mesh == last);
    assert_eq!(last.attributes.own_materials.len(), 2);
}

#[test]
fn extensions_over_other_faces_are_found() {
    // a face of a chart, and one of another chart
    let attributes = |shift: f64| {
        let column = |name, numbers: [f64; 6]| Column::decimals(name, numbers.to_vec());
        let mut all = Attributes {
            texture: Arc::new(vec![
                column("u", [0.0, 0.5, 0.0, 0.3 + shift, 0.4 + shift, 0.3 + shift]),
                column("v", [0.0, 0.0, 0.5, 0.3, 0.3, 0.4]),
            ]),
            ..Attributes::default()
        };
        all.faces.texture = (0..6).collect();
        all
    };
    let extension = |corners: [[f64; 2]; 3]| {
        Some(Extension {
            rim: [(0, 0)].into(),
            new: Vec::new(),
            triangles: vec![corners.map(|[x, y]| Coord { x, y })],
            like: 0,
            beside: vec![0],
        })
    };
    // the other half of the square: it shares a side with the first face
    let half = || extension([[0.5, 0.0], [0.5, 0.5], [0.0, 0.5]]);
    let overlap = |shift: f64, all: &[Option<Extension>]| overlapping(&attributes(shift), 2, all);
    assert_eq!(overlap(0.0, &[half(), None]), [true, false]);
    assert_eq!(overlap(0.3, &[half(), half()]), [false, true]);
    // beyond the image, which repeats
    assert_eq!(overlap(3.0, &[half(), half()]), [false, false]);
    assert_eq!(
        overlap(
            0.0,
            &[None, extension([[0.0; 2], [-0.1, 0.0], [0.0, -0.1]])]
        ),
        [false; 2]
    );
    // the first face is stacked on a mirrored one, so the patch may be as well
    let mut stacked = attributes(0.0);
    stacked.faces.texture.extend([1, 0, 2]);
    assert_eq!(overlapping(&stacked, 3, &[half(), half()]), [false; 2]);
}
