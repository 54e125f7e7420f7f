use super::hole::MUCH_MORE;
use super::*;
use crate::energy::Energy;
use crate::fill::plan::Plan;
use crate::fill::prepare::prepare;
use crate::fill::{Filled, RimSet, fill_rim_sets};
use crate::mesh::{FOLD_DEGREES, Mesh, VertexId, boundary_loops, folded_edges, self_intersections};
use crate::shapes;
use crate::solver::{End, SurfaceModel};
use crate::warning::Warnings;

/// The lower of two parallel walls with a plate between them: a spherical cap over its hole would pass
/// through the plate.
fn below_plate() -> Mesh {
    let (mut positions, mut triangles) = shapes::cut_where(&shapes::sphere(1000, 1), |p| p.z > 0.5);
    let first = positions.len() as u32;
    let corner = |x: f64, y: f64| DVec3::new(x, y, 0.8);
    positions.extend([
        corner(-2.0, -2.0),
        corner(2.0, -2.0),
        corner(2.0, 2.0),
        corner(-2.0, 2.0),
    ]);
    triangles.push([first, first + 1, first + 2]);
    triangles.push([first, first + 2, first + 3]);
    Mesh::from_triangles(positions, &triangles).expect("a manifold")
}

/// The fill of the hole [below the plate](below_plate).
fn filled_below_plate(mesh: &Mesh, options: &FillOptions) -> Filled {
    let loops = boundary_loops(mesh);
    let hole = loops.iter().filter(|l| l.edges() > 4);
    let hole: Vec<RimSet<'_>> = hole.map(|l| vec![l]).collect();
    let filled = fill_rim_sets(mesh, &hole, options, &|_, _| true).expect("filled");
    let new = &filled.mesh.positions[mesh.vertex_count()..];
    assert!(new.iter().all(|p| p.z < 0.8));
    let codes = filled.holes[0].warnings.iter().map(Warning::code);
    assert_eq!(codes.filter(|&code| code == "surface-replaced").count(), 1);
    filled
}

#[test]
fn an_unsound_patch_is_replaced_with_a_warning() {
    let filled = filled_below_plate(&below_plate(), &FillOptions::default());
    let [hole] = &filled.holes[..] else {
        panic!("one hole")
    };
    assert_eq!(hole.warnings.len(), 1);
    // no error was predicted for the model of the replacement
    let surface = &filled.groups[0].as_ref().expect("a flow").surface;
    let [other] = &surface.others[..] else {
        panic!("one replacement")
    };
    assert_eq!((other.hole, &surface.prediction), (hole.id(), &None));
    assert!(surface.words_of(other.hole).starts_with(&other.by));
}

/// A slit keeps its flat patch and names the remedy.
#[test]
fn a_slit_is_reported_as_one() {
    // the slit leads from (-1, 0) to (1, 0), and its middle is two vertices
    let places = [
        [-1_i32, 0],
        [0, 0],
        [0, 0],
        [1, 0],
        [0, 1],
        [0, -1],
        [-2, 0],
        [2, 0],
    ];
    let positions = places.map(|[x, y]| DVec3::new(x.into(), y.into(), 0.0));
    let triangles = [
        [0, 1, 4],
        [1, 3, 4],
        [0, 5, 2],
        [2, 5, 3],
        [0, 4, 6],
        [6, 5, 0],
        [3, 7, 4],
        [7, 3, 5],
    ];
    let mesh = Mesh::from_triangles(positions.to_vec(), &triangles).expect("a manifold");
    let loops = boundary_loops(&mesh);
    let slit = loops.iter().find(|l| l.perimeter < 4.1).expect("a slit");
    let filled = fill_rim_sets(&mesh, &[vec![slit]], &FillOptions::default(), &|_, _| true);
    let warnings = &filled.expect("filled").holes[0].warnings;
    let codes: Vec<&str> = warnings.iter().map(Warning::code).collect();
    assert_eq!(codes, ["slit"]);
    assert!(
        warnings[0]
            .hint()
            .is_some_and(|hint| hint.contains("stitch"))
    );
}

/// A flow may end without an accepted step: it has none left, or no step lowers its energy.
#[test]
fn patches_are_checked_however_the_flow_ends() {
    let mesh = below_plate();
    let with = |text: &str, max_steps: usize| {
        let energy = Energy::parse(text, &std::collections::BTreeMap::new());
        let mut options = FillOptions {
            predicts_surface: false,
            ..FillOptions::default()
        };
        options.flow.energy = energy.expect("an energy");
        options.flow.max_steps = max_steps;
        let filled = filled_below_plate(&mesh, &options);
        filled.groups[0].as_ref().expect("a flow").outcome.end
    };
    assert_eq!(with("H^2", 0), End::MaxSteps);
    assert_eq!(with("0-H^2", 100), End::StepSizeCollapsed);
}

/// A flow that cannot start leaves the warm start, which passes through the plate.
#[test]
fn patches_are_checked_after_a_failure() {
    let energy = Energy::parse("log(H-100)", &std::collections::BTreeMap::new());
    let mut options = FillOptions {
        predicts_surface: false,
        ..FillOptions::default()
    };
    options.flow.energy = energy.expect("an energy");
    let filled = filled_below_plate(&below_plate(), &options);
    assert!(filled.groups[0].is_err());
    let faces: Vec<[u32; 3]> = filled.mesh.topology.triangles().collect();
    let pairs = self_intersections(&filled.mesh.positions, &faces, None, 1);
    assert!(pairs.is_empty());
}

/// The warnings of a fill of all loops, and the pairs of faces that meet and folded edges of the result.
fn filled_all(positions: Vec<DVec3>, triangles: &[[u32; 3]]) -> (Vec<&'static str>, usize) {
    let mesh = Mesh::from_triangles(positions, triangles).expect("a manifold");
    let loops = boundary_loops(&mesh);
    let holes: Vec<RimSet<'_>> = loops.iter().map(|l| vec![l]).collect();
    let filled = fill_rim_sets(&mesh, &holes, &FillOptions::default(), &|_, _| true);
    let filled = filled.expect("filled");
    let warnings = filled.holes.iter().flat_map(|hole| hole.warnings.iter());
    let codes = warnings.map(Warning::code).collect();
    let result = &filled.mesh;
    let faces: Vec<[u32; 3]> = result.topology.triangles().collect();
    let pairs = self_intersections(&result.positions, &faces, None, usize::MAX);
    let folds = folded_edges(
        &result.positions,
        &result.topology,
        FOLD_DEGREES.to_radians(),
    );
    (codes, pairs.len() + folds.len())
}

fn ball_without_cap() -> Mesh {
    let (positions, triangles) = shapes::cut_where(&shapes::icosphere(24), |p| p.z > 0.7);
    Mesh::from_triangles(positions, &triangles).expect("a manifold")
}

fn first_hole<'a>(mesh: &'a Mesh, plan: &'a Plan) -> HoleOfGroup<'a> {
    HoleOfGroup {
        context: FillContext { mesh, plan },
        group: 0,
        number: 0,
        rims: &plan.holes()[0].rims,
    }
}

#[test]
fn a_wrinkled_patch_becomes_smooth() {
    let mesh = ball_without_cap();
    let loops = boundary_loops(&mesh);
    let options = FillOptions::default();
    let plan = prepare(&mesh, &[vec![&loops[0]]], &[], &options).plan;
    let hole = first_hole(&mesh, &plan);
    let topology = plan.groups[0].topology.as_ref().clone();
    let present = (topology, plan.start_positions(&mesh, 0));
    assert!(hole.smoother(&present, &options).is_none());
    let waved = |p: &DVec3| *p + 0.1 * (30.0 * p.x).sin() * (30.0 * p.y).sin() * DVec3::Z;
    let wrinkled = (present.0, present.1.iter().map(waved).collect());
    let smooth = hole.smoother(&wrinkled, &options).expect("a smooth patch");
    let ratio = smooth.origin.bending.expect("wrinkled");
    assert!(ratio > MUCH_MORE && smooth.is_sound());
    let bends = |surface: &Surface| hole.bending(surface).expect("a patch");
    assert_eq!(bends(&wrinkled) / bends(&smooth.surface), ratio);
    // as far as `diffusion` is from the cap, whose share of the sphere is 0.15
    let cap = 0.15 * 4.0 * std::f64::consts::PI;
    assert!(bends(&smooth.surface) < 1.5 * cap);
}

/// A vector flow that goes on along the walls of an open end is replaced. Another model is the choice of the user.
#[test]
fn a_far_patch_comes_back() {
    let mesh = ball_without_cap();
    let loops = boundary_loops(&mesh);
    let mut options = FillOptions::default();
    let plan = prepare(&mesh, &[vec![&loops[0]]], &[], &options).plan;
    let hole = first_hole(&mesh, &plan);
    // a paraboloid over the round rim, whose top is two radii above it
    let radius = hole.rims.radius();
    let raised = |p: &DVec3| {
        let height = 2.0 * radius * (1.0 - p.truncate().length_squared() / (radius * radius));
        p.truncate().extend(0.7 + height.max(0.0))
    };
    let first = plan.start_positions(&mesh, 0);
    let far: Vec<DVec3> = first.iter().map(raised).collect();
    let reach = hole.rims.reach(&far);
    assert!((reach - 5f64.sqrt()).abs() < 0.2, "{reach}");
    assert!(hole.rims.far_reach(&far).is_some() && hole.rims.far_reach(&first).is_none());
    let far: Surface = (plan.groups[0].topology.as_ref().clone(), far);
    let by_energy = hole.smoother(&far, &options);
    assert!(by_energy.is_none_or(|smooth| smooth.origin.reach.is_none()));
    options.flow.surface = SurfaceModel::G2;
    let nearer = hole.smoother(&far, &options).expect("another surface");
    assert_eq!(nearer.origin.reach, Some(reach));
    assert!(nearer.is_sound() && hole.rims.reach(&nearer.surface.1) < 1.2);
}

#[test]
fn a_smoother_patch_stays_when_others_of_its_group_are_filled_again() {
    // two holes side by side, and a plate through the cap over the first
    let aside = DVec3::new(80f64.to_radians().sin(), 0.0, 80f64.to_radians().cos());
    let in_hole = |p: DVec3| p.z > 0.8 || p.dot(aside) > 0.8;
    let (mut positions, mut triangles) = shapes::cut_where(&shapes::icosphere(24), in_hole);
    let first = positions.len() as u32;
    let corner = |x: f64, y: f64| DVec3::new(x, y, 0.9);
    positions.extend([corner(-0.5, -0.5), corner(0.5, -0.5), corner(0.0, 0.6)]);
    triangles.push([first, first + 1, first + 2]);
    let mesh = Mesh::from_triangles(positions, &triangles).expect("a manifold");
    let loops = boundary_loops(&mesh);
    let holes = loops.iter().filter(|l| l.edges() > 3);
    let sets: Vec<RimSet<'_>> = holes.map(|l| vec![l]).collect();
    let options = FillOptions::default();
    let plan = prepare(&mesh, &sets, &[], &options).plan;
    assert_eq!((sets.len(), plan.groups.len()), (2, 1));
    let context = FillContext {
        mesh: &mesh,
        plan: &plan,
    };
    let waved = |p: &DVec3| {
        let wave = 0.1 * (30.0 * p.y).sin() * (30.0 * p.z).sin();
        let is_aside = p.dot(aside) > 0.5;
        p.normalize() * if is_aside { 1.0 + wave } else { 1.0 }
    };
    let positions = plan.start_positions(&mesh, 0).iter().map(waved).collect();
    let topology = &plan.groups[0].topology;
    let model = Candidate::of(&options.flow);
    let checked = make_sound(context, 0, topology, positions, model, &[], &options);
    let bent = |warning: &Warning| match warning {
        Warning::Replaced { bending, .. } => Some(bending.is_some()),
        _ => None,
    };
    let replaced = checked.warnings.iter();
    let replaced: Vec<(LoopId, bool)> = replaced
        .filter_map(|(id, warning)| Some((*id, bent(warning)?)))
        .collect();
    let is_aside = |id: &LoopId| loops[id.index()].centroid.dot(aside) > 0.5;
    assert_eq!(replaced.len(), 2);
    assert!(
        replaced
            .iter()
            .all(|(id, is_bent)| is_aside(id) == *is_bent)
    );
}

#[test]
fn a_patch_over_a_flat_sheet_rises_above_it() {
    // the rim is the outer boundary of the sheet, so a flat patch lies on it
    let (positions, triangles) = shapes::graph(2.0, 12, |_, _| 0.0, 3);
    let (codes, defects) = filled_all(positions, &triangles);
    assert_eq!((codes.contains(&"surface-replaced"), defects), (true, 0));
}

#[test]
fn patches_over_rims_side_by_side_do_not_cross() {
    // two bowls, rim to rim, a third of an edge apart: round caps would cross
    let (mut positions, mut triangles) = shapes::cut_where(&shapes::sphere(800, 1), |p| p.z > 0.0);
    let top = positions.iter().map(|p| p.z).fold(f64::MIN, f64::max);
    let count = positions.len() as u32;
    let turned = |p: &DVec3| DVec3::new(p.x, p.y, 2.0 * top + 0.04 - p.z);
    let above: Vec<DVec3> = positions.iter().map(turned).collect();
    positions.extend(above);
    let above: Vec<[u32; 3]> = triangles.iter().map(|&[a, b, c]| [c, b, a]).collect();
    triangles.extend(above.iter().map(|t| t.map(|v| v + count)));
    let (_, defects) = filled_all(positions, &triangles);
    assert_eq!(defects, 0);
}

#[test]
fn a_patch_without_new_vertices_goes_around_obstacles() {
    // a bent rim of four edges: its two triangulations meet the z axis at 0 and at 1
    let mut positions = vec![
        DVec3::X,
        DVec3::new(0.0, 1.0, 1.0),
        -DVec3::X,
        DVec3::new(0.0, -1.0, 1.0),
    ];
    positions.extend(
        [(2, 2), (-2, 2), (-2, -2), (2, -2)]
            .map(|(x, y)| DVec3::new(f64::from(x), f64::from(y), 0.5)),
    );
    let mut triangles = Vec::new();
    for i in 0..4 {
        let next = (i + 1) % 4;
        triangles.extend([[next, i, 4 + i], [next, 4 + i, 4 + next]]);
    }
    for height in [0.0, 1.0] {
        let (mut positions, mut triangles) = (positions.clone(), triangles.clone());
        let at = |x, z| DVec3::new(x, 0.01, height + z);
        positions.extend([at(-0.05, -0.1), at(0.05, -0.1), at(0.0, 0.1)]);
        triangles.push([8, 9, 10]);
        let mesh = Mesh::from_triangles(positions, &triangles).expect("a manifold");
        let loops = boundary_loops(&mesh);
        let hole = loops.iter().find(|l| l.vertices.contains(&VertexId(0)));
        let hole: Vec<RimSet<'_>> = hole.into_iter().map(|l| vec![l]).collect();
        let filled = fill_rim_sets(&mesh, &hole, &FillOptions::default(), &|_, _| true);
        let filled = filled.expect("filled");
        assert_eq!(filled.faces_added(), 2);
        assert_eq!(filled.holes[0].warnings, Warnings::default());
        let faces: Vec<[u32; 3]> = filled.mesh.topology.triangles().collect();
        let pairs = self_intersections(&filled.mesh.positions, &faces, None, 1);
        assert_eq!(pairs, [[0; 2]; 0], "obstacle at {height}");
    }
}
