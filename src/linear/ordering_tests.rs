use super::super::test_matrices::{Graph, identity_order, noise};
use super::super::{CholeskySymbolic, SymmetricPattern};
use super::*;
use glam::Vec3Swizzles;

fn order(graph: &Graph) -> Vec<u32> {
    nested_dissection(&graph.points, &graph.offsets, &graph.adjacency)
}

fn assert_permutation(perm: &[u32]) {
    let mut sorted = perm.to_vec();
    sorted.sort_unstable();
    assert_eq!(sorted, identity_order(perm.len()));
}

fn fill(graph: &Graph, perm: &[u32]) -> usize {
    let pattern = SymmetricPattern::of_permuted_graph(&graph.offsets, &graph.adjacency, perm);
    CholeskySymbolic::new(&pattern).expect("small").factor_len()
}

#[test]
fn every_kind_of_input_gives_a_permutation() {
    for n in [0, 1, 2, 48, 49, 500] {
        let edges: Vec<_> = (1..n).map(|i| (i - 1, i)).collect();
        let line = (0..n)
            .map(|i| DVec3::new(i as f64, 2.0 * i as f64, 0.0))
            .collect();
        assert_permutation(&order(&Graph::new(line, &edges)));
        assert_permutation(&order(&Graph::new(vec![DVec3::splat(7.0); n], &edges)));
        assert_permutation(&order(&Graph::new(vec![DVec3::NAN; n], &edges)));
        let spread = (0..n)
            .map(|i| DVec3::splat(1e200 * (i % 7) as f64))
            .collect();
        assert_permutation(&order(&Graph::new(spread, &[])));
    }
    let complete: Vec<_> = (0..120).flat_map(|a| (0..a).map(move |b| (a, b))).collect();
    let points = (0..120)
        .map(|i| DVec3::new(f64::from(i), 0.0, 0.0))
        .collect();
    assert_permutation(&order(&Graph::new(points, &complete)));
    assert_permutation(&order(&Graph::grid(40, 30, 3)));
}

#[test]
fn two_separate_grids_stay_separate() {
    let one = Graph::grid(20, 20, 2);
    let n = one.n();
    let mut points = one.points.clone();
    points.extend(one.points.iter().map(|p| *p + DVec3::new(0.5, 0.5, 1.0)));
    let edges: Vec<_> = (0..n)
        .flat_map(|a| one.neighbours(a).iter().map(move |&b| (a, b as usize)))
        .filter(|(a, b)| a < b)
        .flat_map(|(a, b)| [(a, b), (n + a, n + b)])
        .collect();
    let both = Graph::new(points, &edges);
    let perm = order(&both);
    assert_permutation(&perm);
    assert!(fill(&both, &perm) < fill(&both, &identity_order(2 * n)));
}

#[test]
fn fill_grows_almost_linearly_on_a_grid() {
    let small = Graph::grid(24, 24, 1);
    let large = Graph::grid(72, 72, 1);
    let (fill_small, fill_large) = (fill(&small, &order(&small)), fill(&large, &order(&large)));
    assert!(fill_large < fill(&large, &identity_order(large.n())) / 2);
    // n log n predicts a factor of 12.1; natural order (n^1.5) gives 27.
    assert!(fill_large < 16 * fill_small, "{fill_small} -> {fill_large}");
}

#[test]
fn rotation_and_offset_leave_the_fill_alone() {
    let mut graph = Graph::grid(50, 20, 2);
    let before = fill(&graph, &order(&graph));
    let rotation = glam::DQuat::from_scaled_axis(DVec3::new(0.3, -0.9, 1.1));
    for p in &mut graph.points {
        *p = rotation * *p + DVec3::splat(1e4);
    }
    let after = fill(&graph, &order(&graph));
    assert!(after.abs_diff(before) * 10 < before, "{before} -> {after}");
}

/// No plane separates the vertices of a crumpled surface well, but its graph is that of a flat one.
#[test]
fn crumpled_surfaces_are_divided_in_the_graph() {
    for reach in [1, 3] {
        let mut graph = Graph::grid(60, 60, reach);
        let flat = fill(&graph, &order(&graph));
        for (point, z) in graph.points.chunks_exact_mut(3).zip(noise(1, 1200)) {
            point[0].z = 100.0 * z;
            point[1] = point[0].yzx();
            point[2] = point[0].zxy();
        }
        let perm = order(&graph);
        assert_permutation(&perm);
        let crumpled = fill(&graph, &perm);
        assert!(
            2 * crumpled < 3 * flat,
            "reach {reach}: {flat} -> {crumpled}"
        );
    }
}

/// Vertices that are neighbours of all others leave the separators of the rest small.
#[test]
fn hubs_are_eliminated_last() {
    let grid = Graph::grid(40, 30, 1);
    let n = grid.n();
    let mut points = grid.points.clone();
    points.extend([DVec3::ZERO, DVec3::new(20.0, 15.0, 0.0)]);
    let own = (0..n).flat_map(|a| grid.neighbours(a).iter().map(move |&b| (a, b as usize)));
    let mut edges: Vec<_> = own.filter(|(a, b)| a < b).collect();
    edges.extend((0..n).flat_map(|a| [(a, n), (a, n + 1)]));
    edges.push((n, n + 1));
    let perm = order(&Graph::new(points, &edges));
    assert_permutation(&perm);
    assert_eq!(perm[n..], [n as u32, n as u32 + 1]);
    assert_eq!(perm[..n], order(&grid));
}
