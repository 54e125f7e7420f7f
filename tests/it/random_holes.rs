//! Random holes in random spheres and tori: every fill is sound.

use std::path::Path;

use meniscus::fill::{FillOptions, LoopChoice, fill_rim_sets};
use meniscus::io::{self, Format};
use meniscus::mesh::{
    self, BoundaryLoop, DVec3, Mesh, boundary_loops, check_filled, self_intersections,
};
use meniscus::shapes::{self, Hole, HoleShape};
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

/// A ball with one triangle that stands beside a narrow crack in the rim of its hole.
#[test]
fn a_triangle_beside_a_crack_does_not_deform_the_patch() {
    let bytes = include_bytes!("../data/ear.obj");
    let soup = io::read(Format::Obj, bytes, Path::new("ear.obj")).expect("a mesh");
    let (ball, _) = mesh::build(&soup).expect("a mesh");
    let filled = meniscus::Fill::new(&ball).loops(LoopChoice::All).run();
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
