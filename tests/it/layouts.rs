//! Blends of layouts that the samples do not show, through the library with defaults.

use std::fmt::Write as _;
use std::time::Instant;

use crate::common::layouts::{self, Layout};
use meniscus::fill::{FillOptions, fill_rim_sets};
use meniscus::mesh::{DVec3, check_mesh, components, folded_edges, self_intersections};
use meniscus::solver::End;
use meniscus::warning::Warning;

/// Maximum number of steps of a blend.
const MAX_STEPS: usize = 60;
/// Normals of neighbours that differ by more than this are called a fold.
const FOLD_DEGREES: f64 = 150.0;

/// The defects of the blend of a layout, and a row of its measures.
fn blended(layout: &Layout) -> (Vec<String>, String) {
    let mesh = layout.mesh();
    let loops = Layout::loops(&mesh);
    let gap = layout.gap(&loops, &mesh);
    let start = Instant::now();
    let filled = fill_rim_sets(&mesh, &[gap], &FillOptions::default(), &|_, _| true);
    let seconds = start.elapsed().as_secs_f64();
    let mut faults = Vec::new();
    let filled = match filled {
        Ok(filled) => filled,
        Err(error) => return (vec![error.to_string()], String::new()),
    };
    faults.extend(filled.failed.iter().map(ToString::to_string));
    let out = &filled.mesh;
    if out.positions[..mesh.positions.len()] != mesh.positions[..] {
        faults.push("given vertices moved".into());
    }
    if let Err(error) = check_mesh(out) {
        faults.push(error);
    }
    let left = loops.len() - layout.rims.len();
    if Layout::loops(out).len() != left {
        faults.push(format!(
            "{} rims left, not {left}",
            Layout::loops(out).len()
        ));
    }
    if components(&out.topology).count != 1 {
        faults.push("several pieces".into());
    }
    let triangles: Vec<[u32; 3]> = out.topology.triangles().collect();
    let new: Vec<u32> = (mesh.face_count() as u32..triangles.len() as u32).collect();
    let cuts = self_intersections(&out.positions, &triangles, Some(&new), 1000).len();
    let folds = folded_edges(&out.positions, &out.topology, FOLD_DEGREES.to_radians()).len();
    if cuts > 0 {
        faults.push(format!("{cuts} intersections"));
    }
    if folds > 0 {
        faults.push(format!("{folds} folds"));
    }
    let vertices = filled.vertices_added();
    let sharpest = sharpest(&out.positions, &triangles[mesh.face_count()..]);
    let mut row = format!(
        "{:<18} {} rims, {vertices:>6} new, {sharpest:4.1}°, {seconds:5.1} s",
        layout.name,
        layout.rims.len()
    );
    for group in &filled.groups {
        match group {
            Err(error) => faults.push(error.to_string()),
            Ok(group) => {
                let o = &group.outcome;
                if o.end != End::Converged {
                    faults.push(format!("{:?}", o.end));
                }
                if o.steps > MAX_STEPS {
                    faults.push(format!("{} steps", o.steps));
                }
                write!(
                    row,
                    ", {:>2} steps, {:>2} rejected, energy {:8.4} -> {:8.4}",
                    o.steps, o.rejected, o.energy_start, o.energy_end
                )
                .expect("a string");
                for text in o.warnings.iter() {
                    write!(row, "\n      {text}").expect("a string");
                }
            }
        }
    }
    (faults, row)
}

/// The sharpest angle, in degrees.
fn sharpest(positions: &[DVec3], triangles: &[[u32; 3]]) -> f64 {
    let angle = |[a, b, c]: [DVec3; 3]| (b - a).angle_between(c - a).to_degrees();
    let corners = triangles.iter().flat_map(|t| {
        let [a, b, c] = t.map(|v| positions[v as usize]);
        [[a, b, c], [b, c, a], [c, a, b]]
    });
    corners.map(angle).fold(f64::INFINITY, f64::min)
}

/// Layouts of every kind that finish quickly.
#[test]
fn layouts_are_joined_without_crossings() {
    let quick = [
        "u_turn",
        "u_turn_close",
        "s_bend_short",
        "far",
        "elbow",
        "counts",
        "skew_axes",
        "three_side",
        "tripod",
        "oblique",
        "lip",
        "wavy",
        "slanted_ends",
        "ellipsoid_slanted",
        "two_spheres_turned",
        "tube_to_sphere",
    ];
    let list = layouts::all();
    let list = list
        .iter()
        .filter(|layout| quick.contains(&layout.name.as_str()));
    let random = [2, 3].map(layouts::random);
    for layout in list.chain(&random) {
        let (faults, row) = blended(layout);
        assert!(faults.is_empty(), "{}: {faults:?}\n{row}", layout.name);
    }
}

#[test]
fn a_flow_that_runs_into_the_mesh_ends_before_it() {
    let (mesh, gap) = layouts::with_obstacle();
    let gap = gap.iter().collect();
    let filled = fill_rim_sets(&mesh, &[gap], &FillOptions::default(), &|_, _| true);
    let filled = filled.expect("a manifold");
    let outcome = &filled.groups[0].as_ref().expect("a flow").outcome;
    assert_eq!(outcome.end, End::SelfIntersected);
    assert!(outcome.steps > 0);
    let codes: Vec<&str> = outcome.warnings.iter().map(Warning::code).collect();
    assert_eq!(codes, ["self-intersection"]);
    let triangles: Vec<[u32; 3]> = filled.mesh.topology.triangles().collect();
    assert!(self_intersections(&filled.mesh.positions, &triangles, None, 1).is_empty());
}

/// All layouts; `MENISCUS_LAYOUTS` names words of those wanted, `MENISCUS_LAYOUTS_RANDOM` how many of
/// chance there are to be, as in `20..80`.
#[test]
#[ignore = "takes minutes"]
fn all_layouts() {
    let only = std::env::var("MENISCUS_LAYOUTS").unwrap_or_default();
    let mut bad = Vec::new();
    let random = std::env::var("MENISCUS_LAYOUTS_RANDOM").unwrap_or_default();
    let range = random.split_once("..");
    let range = range.and_then(|(a, b)| Some(a.parse().ok()?..b.parse().ok()?));
    let random = range.unwrap_or(0..0).map(layouts::random);
    for layout in layouts::all().into_iter().chain(random) {
        if !only.is_empty() && !only.split(',').any(|word| layout.name.contains(word)) {
            continue;
        }
        let (faults, row) = blended(&layout);
        println!("{} {row}", if faults.is_empty() { "    " } else { "BAD " });
        if !faults.is_empty() {
            println!("      -> {}", faults.join("; "));
            bad.push(layout.name);
        }
    }
    assert!(bad.is_empty(), "{bad:?}");
}
