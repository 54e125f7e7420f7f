use super::*;
use crate::solver::test_surfaces::lattice;

/// Two triangles of a square with a common edge from 0 to 2, the second turned up by an angle.
fn book(degrees: f64) -> Vec<DVec3> {
    let (hinge, out) = (DVec3::new(1.0, 1.0, 0.0), DVec3::new(-1.0, 1.0, 0.0));
    let (sin, cos) = degrees.to_radians().sin_cos();
    let tip = 0.5 * hinge + 0.5 * (out * cos + DVec3::Z * 2f64.sqrt() * sin);
    vec![DVec3::ZERO, DVec3::X, hinge, tip]
}

fn guard(degrees: f64) -> FoldGuard {
    let topology = Topology::from_triangles(4, &[[0, 1, 2], [0, 2, 3]]).expect("a square");
    let discretization = Discretization::new(Arc::new(topology), vec![FaceId(0), FaceId(1)]);
    FoldGuard::new(&discretization, Rule::Twelve, &book(degrees))
}

/// The two triangles close by small steps until they nearly meet, and no further.
#[test]
fn a_pair_of_triangles_does_not_close() {
    let mut guard = guard(0.0);
    let mut degrees = 0.0;
    while degrees < 180.0 && !guard.would_fold(&book(degrees + 5.0)) {
        guard.accept();
        degrees += 5.0;
    }
    assert!((90.0..175.0).contains(&degrees), "{degrees}");
    assert!(guard.marked().iter().all(|&m| m));
    // the state is that of the last accepted step
    assert!(!guard.would_fold(&book(degrees)));
    assert!(guard.marked().iter().all(|&m| !m));
}

#[test]
fn a_pair_that_is_folded_may_unfold() {
    let mut guard = guard(0.0);
    guard.reset(&book(178.0));
    for degrees in [178.0, 179.0, 170.0, 150.0] {
        assert!(!guard.would_fold(&book(degrees)), "{degrees}");
    }
}

/// A large rotation in one step is rejected even if nothing is folded at its end.
#[test]
fn a_facet_turns_by_no_more_than_60_degrees() {
    assert!(!guard(0.0).would_fold(&book(40.0)));
    assert!(guard(0.0).would_fold(&book(110.0)));
}

/// A vertex moved across its neighbours flips facets; only nearby vertices are marked.
#[test]
fn a_flipped_facet_is_found() {
    let problem = lattice(5);
    let v = problem.interior()[12] as usize;
    let start = problem.positions();
    let mut guard = FoldGuard::new(problem.discretization(), Rule::OneNinetyTwo, start);
    let moved = |by: DVec3| {
        let mut x = start.to_vec();
        x[v] += by;
        x
    };
    assert!(!guard.would_fold(&moved(0.2 * DVec3::X)));
    assert!(!guard.would_fold(&moved(0.2 * DVec3::Z)));
    assert!(guard.would_fold(&moved(4.0 * DVec3::X)));
    let marked = (0..start.len()).filter(|&w| guard.marked()[w]);
    let far = marked
        .clone()
        .map(|w| start[w].distance(start[v]))
        .fold(0.0, f64::max);
    assert!(guard.marked()[v] && far < 5.0, "{far}");
}
