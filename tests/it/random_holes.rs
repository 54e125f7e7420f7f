//! Random holes in random spheres and tori: every fill is sound.

use meniscus::fill::{FillOptions, fill_rim_sets};
use meniscus::mesh::{BoundaryLoop, DVec3, Mesh, boundary_loops, check_filled, self_intersections};
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
