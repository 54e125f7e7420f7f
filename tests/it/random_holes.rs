//! Random holes in random spheres and tori: every fill is sound.

use std::path::Path;

use meniscus::Fill;
use meniscus::fill::{FillOptions, LoopChoice, fill_rim_sets};
use meniscus::io::{self, Format};
use meniscus::mesh::{
    self, BoundaryLoop, DVec3, Mesh, boundary_loops, check_filled, self_intersections,
};
use meniscus::shapes::{self, Hole, HoleShape};
use meniscus::warning::Warning;
use proptest::prelude::*;

fn hole_shape() -> impl Strategy<Value = HoleShape> {
    prop_oneof![
        (0.15..0.7f64).prop_map(|radius| HoleShape::Disc { radius }),
        (0.2..0.5f64).prop_map(|radius| HoleShape::Ragged { radius }),
        (0.4..0.9f64, 0.1..0.25f64).prop_map(|(length, width)| HoleShape::Slit { length, width }),
        (0.4..0.7f64, 0.15..0.25f64).prop_map(|(arm, width)| HoleShape::Angle { arm, width }),
    ]
}

fn fill_all(positions: Vec<DVec3>, triangles: &[[u32; 3]]) -> Result<(), TestCaseError> {
    let mesh = Mesh::from_triangles(positions, triangles)
        .map_err(|e| TestCaseError::reject(e.to_string()))?;
    let loops = boundary_loops(&mesh);
    prop_assume!(!loops.is_empty());
    let all: Vec<Vec<&BoundaryLoop>> = loops.iter().map(|one| vec![one]).collect();
    let filled = fill_rim_sets(&mesh, &all, &FillOptions::default(), &|_, _| true)
        .map_err(|e| TestCaseError::fail(e.to_string()))?;
    prop_assert!(filled.failed.is_empty(), "{:?}", filled.failed);
    prop_assert!(filled.complete(), "not converged");
    check_filled(&mesh, &filled.mesh, &[]).map_err(TestCaseError::fail)?;
    let faces: Vec<[u32; 3]> = filled.mesh.topology.triangles().collect();
    let cuts = self_intersections(&filled.mesh.positions, &faces, None, 1);
    prop_assert!(cuts.is_empty(), "faces {cuts:?} cut each other");
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 12, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn in_spheres(seed in 0..1000u64, shape in hole_shape(), turn in 0.0..6.0f64, vertices in 300..1200usize) {
        let hole = Hole { centre: DVec3::new(0.2, 0.5, 0.8), shape, turn, seed };
        let (positions, triangles) = shapes::cut_holes(&shapes::sphere(vertices, seed), &[hole]);
        fill_all(positions, &triangles)?;
    }

    #[test]
    fn in_tori(seed in 0..1000u64, shape in hole_shape(), turn in 0.0..6.0f64) {
        let hole = Hole { centre: DVec3::new(1.9, 0.6, 0.4), shape, turn, seed };
        let (positions, triangles) = shapes::cut_holes(&shapes::torus(1.5, 0.7, 1500, seed), &[hole]);
        fill_all(positions, &triangles)?;
    }
}

fn read(bytes: &[u8]) -> Mesh {
    let soup = io::read(Format::Obj, bytes, Path::new("in.obj")).expect("a mesh");
    mesh::build(&soup).expect("a mesh").0
}

/// The surfaces that the energy gives for the outer rims leave a box of several times their size.
#[test]
fn no_patch_leaves_the_surroundings_of_its_rim_without_a_warning() {
    for bytes in [
        &include_bytes!("../data/terrain.obj")[..],
        include_bytes!("../data/two_holes.obj"),
    ] {
        let given = read(bytes);
        let size = |positions: &[DVec3]| {
            let [low, high] = [DVec3::min, DVec3::max].map(|f| positions.iter().copied().reduce(f));
            low.zip(high).map(|(low, high)| low.distance(high))
        };
        let filled = Fill::new(&given).loops(LoopChoice::All).run();
        let filled = filled.expect("filled");
        let groups: Vec<_> = filled.groups.iter().flatten().collect();
        let mut warnings = groups
            .iter()
            .flat_map(|group| group.outcome.warnings.iter());
        let is_said = warnings.any(|warning| warning.code() == "escaped");
        assert!(is_said || size(&filled.mesh.positions) < size(&given.positions).map(|d| 3.0 * d));
    }
}

/// Beside a rim without a sound surface, a small hole gets the surface it has alone.
#[test]
fn a_hole_that_fails_spoils_no_neighbour() {
    let given = read(include_bytes!("../data/two_holes.obj"));
    let loops = boundary_loops(&given);
    let small = loops.iter().find(|l| l.edges() == 8).expect("a hole").id;
    let new = |choice: LoopChoice| {
        let filled = Fill::new(&given).loops(choice).run().expect("filled");
        let holes = filled.holes.iter();
        let own: Vec<_> = holes.filter(|hole| hole.id() == small).collect();
        let [hole] = own[..] else {
            panic!("{} holes", own.len())
        };
        let groups = filled.groups.len();
        (
            filled.mesh.positions[hole.vertices.clone()].to_vec(),
            groups,
        )
    };
    let (alone, _) = new(LoopChoice::Listed(vec![small]));
    let (beside, groups) = new(LoopChoice::All);
    assert_eq!((groups, alone.len()), (1, beside.len()));
    let radius = loops[small.index()].radius;
    for (a, b) in alone.iter().zip(&beside) {
        assert!(a.distance(*b) < 0.1 * radius, "{a} {b}");
    }
}

/// Most of a sphere is far from the rim without a defect.
#[test]
fn a_large_cap_does_not_count_as_escaped() {
    let (positions, triangles) = shapes::cut_where(&shapes::sphere(4000, 1), |p| p.z > -0.6);
    let mesh = Mesh::from_triangles(positions, &triangles).expect("a manifold");
    let filled = Fill::new(&mesh)
        .loops(LoopChoice::All)
        .run()
        .expect("filled");
    let group = filled.groups[0].as_ref().expect("a flow");
    let codes: Vec<&str> = group.outcome.warnings.iter().map(Warning::code).collect();
    assert_eq!(codes, [""; 0]);
    let top = filled
        .mesh
        .positions
        .iter()
        .map(|p| p.z)
        .fold(0.0, f64::max);
    assert!((top - 1.0).abs() < 0.05, "{top}");
}

/// A ball with one triangle that stands beside a narrow crack in the rim of its hole.
#[test]
fn a_triangle_beside_a_crack_does_not_deform_the_patch() {
    let ball = read(include_bytes!("../data/ear.obj"));
    let filled = Fill::new(&ball).loops(LoopChoice::All).run();
    let mesh = filled.expect("filled").mesh;
    let new = &mesh.positions[ball.vertex_count()..];
    assert!(new.len() > 20);
    for p in new {
        assert!((p.length() - 1.0).abs() < 0.02, "{p}");
    }
    let faces: Vec<[u32; 3]> = mesh.topology.triangles().collect();
    let pairs = self_intersections(&mesh.positions, &faces, None, 1);
    assert_eq!(pairs, [[0; 2]; 0]);
}
