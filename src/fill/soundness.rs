//! Sound patches: no triangle crosses another one or has no area, and no edge is folded.

use std::collections::{BTreeSet, HashMap};

use crate::fill::context::FillContext;
use crate::fill::options::FillOptions;
use crate::fill::patch_topology::PatchTopology;
use crate::fill::prediction::Candidate;
use crate::fill::region;
use crate::fill::self_intersection::{intersections, place};
use crate::fill::warm_start::warm_start_of;
use crate::mesh::DVec3;
use crate::solver::{Flow, Mode, SolverError, SurfaceModel, Tau};
use crate::warning::{MAX_PAIRS, Warning, Warnings};

/// Cosine of the angle between the normals of neighbours beyond which their edge counts as folded
/// (150°).
const FOLDED: f64 = -0.866_025_403_784_438_6;

/// Surface models for patches that are unsound by another one, in the order in which they are
/// tried: each next one is nearer to a membrane.
const SAFER: [Candidate; 5] = [
    Candidate::new(SurfaceModel::Diffusion, 0.0),
    Candidate::new(SurfaceModel::Diffusion, 3.0),
    Candidate::new(SurfaceModel::Diffusion, 30.0),
    Candidate::new(SurfaceModel::Diffusion, 300.0),
    Candidate::new(SurfaceModel::Diffusion, 1e5),
];

/// The patches of a group after the check for soundness.
pub(super) struct Checked {
    /// The new vertices, if a patch was replaced.
    pub replaced: Option<Vec<DVec3>>,
    /// What was replaced, and which defects are left.
    pub warnings: Warnings,
}

/// Checks the patches of a group with new vertices at `positions`, filled with `options`. An unsound
/// patch is replaced by the first sound surface of [other models](SAFER), or else by the least
/// unsound.
pub(super) fn make_sound(
    context: FillContext<'_>,
    group: usize,
    topology: &PatchTopology,
    mut positions: Vec<DVec3>,
    options: &FillOptions,
) -> Checked {
    let present = Candidate::new(options.flow.surface, options.flow.tension);
    let mut warnings = Warnings::default();
    let mut is_replaced = false;
    for (k, hole) in context.plan.holes_of(group).enumerate() {
        let defects = |positions: &[DVec3]| defects(context, group, k, topology, positions);
        let Some(found) = defects(&positions) else {
            continue;
        };
        let mut left = Some(found);
        let mut best = None;
        for model in SAFER.into_iter().filter(|&model| model != present) {
            let moved = hole_by(context, group, k, topology, model, &positions, options);
            let Ok(moved) = moved else {
                continue;
            };
            let after = defects(&moved);
            let severity = |defects: &Option<Defects>| defects.map(|d| d.severity());
            if severity(&after) < severity(&left) {
                left = after;
                best = Some((model, moved));
            }
            if left.is_none() {
                break;
            }
        }
        if let Some((model, moved)) = best {
            positions = moved;
            is_replaced = true;
            let (pairs, folds) = found.severity();
            warnings.push(Warning::Replaced {
                hole: hole.rims.id(),
                model: present.words(),
                by: model.words(),
                pairs,
                folds,
            });
        }
        warnings.extend(left.iter().flat_map(Defects::warnings));
    }
    Checked {
        replaced: is_replaced.then_some(positions),
        warnings,
    }
}

/// New vertices of a group with one hole filled by another surface model, from its warm start.
fn hole_by(
    context: FillContext<'_>,
    group: usize,
    hole: usize,
    topology: &PatchTopology,
    model: Candidate,
    positions: &[DVec3],
    options: &FillOptions,
) -> Result<Vec<DVec3>, SolverError> {
    let problem = region::problem(context, group, topology, positions, options)?;
    let own = topology.split(problem.interior()).nth(hole);
    let own = own.map_or(&[][..], |(_, own)| own);
    let start = warm_start_of(problem.clone(), own)?;
    let mut flow = options.flow.clone();
    flow.surface = model.surface;
    flow.tension = model.tension;
    flow.mode = Mode::Fast;
    flow.tau = Tau::Auto;
    let mut flow = Flow::new(start.moving_only(own)?, flow)?;
    flow.run(|_, _| true)?;
    Ok(problem.to_world(flow.positions()))
}

/// What is wrong with a patch.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Defects {
    /// Pairs of triangles that cross, [`MAX_PAIRS`] at most, and one of the places.
    pub crossings: Option<(usize, DVec3)>,
    /// Folded edges and triangles without area, and one of the places.
    pub folds: Option<(usize, DVec3)>,
}

impl Defects {
    /// How bad they are: crossings first, then folds.
    pub fn severity(&self) -> (usize, usize) {
        let count = |found: Option<(usize, DVec3)>| found.map_or(0, |found| found.0);
        (count(self.crossings), count(self.folds))
    }

    /// The warnings of a result that has these defects.
    pub fn warnings(&self) -> impl Iterator<Item = Warning> {
        let crossing = self.crossings.map(|(pairs, at)| Warning::SelfIntersection {
            pairs,
            at,
            kept_step: None,
        });
        let fold = self.folds.map(|(edges, at)| Warning::Folded { edges, at });
        crossing.into_iter().chain(fold)
    }
}

/// The defects of the patch of one hole of a group, `hole` among the holes of the group, with the
/// group's new vertices at `positions`; `None` if it is sound.
fn defects(
    context: FillContext<'_>,
    group: usize,
    hole: usize,
    topology: &PatchTopology,
    positions: &[DVec3],
) -> Option<Defects> {
    let mesh = context.mesh;
    let mut others = context.patch_triangles(group, topology);
    let count = |k: usize| topology.holes[k].triangles.len();
    let first: usize = (0..hole).map(count).sum();
    let own: Vec<[u32; 3]> = others.drain(first..first + count(hole)).collect();
    let obstacles = &context.plan.obstacles;
    let places = intersections(mesh, obstacles, &own, &others, positions, MAX_PAIRS);
    let folds = folds(context, group, hole, &own, positions);
    let found = Defects {
        crossings: places.first().map(|&at| (places.len(), at)),
        folds: folds.first().map(|&at| (folds.len(), at)),
    };
    (found.severity() != (0, 0)).then_some(found)
}

/// Places of folded edges, those of the rims included, and of triangles without area.
fn folds(
    context: FillContext<'_>,
    group: usize,
    hole: usize,
    triangles: &[[u32; 3]],
    positions: &[DVec3],
) -> Vec<DVec3> {
    let mesh = context.mesh;
    let corners = |t: [u32; 3]| t.map(|v| place(mesh, positions, v));
    let normal = |[a, b, c]: [DVec3; 3]| (b - a).cross(c - a).normalize_or_zero();
    // unit normal of the face to the left of each directed edge
    let mut left: HashMap<[u32; 2], DVec3> = HashMap::new();
    let rims = context.plan.holes_of(group).nth(hole).into_iter();
    let rims = rims.flat_map(|hole| &hole.rims.loops);
    for h in rims.flat_map(|l| &l.halfedges).map(|h| h.twin()) {
        let t = mesh.topology.face_vertices(mesh.topology.face(h));
        let edge = [mesh.topology.origin(h).0, mesh.topology.target(h).0];
        left.insert(edge, normal(corners(t.map(|v| v.0))));
    }
    let mut found = Vec::new();
    for &t in triangles {
        let normal = normal(corners(t));
        if normal == DVec3::ZERO {
            found.push(corners(t).iter().sum::<DVec3>() / 3.0);
        }
        for k in 0..3 {
            left.insert([t[k], t[(k + 1) % 3]], normal);
        }
    }
    let mut folded = BTreeSet::new();
    for t in triangles {
        for k in 0..3 {
            let (a, b) = (t[k], t[(k + 1) % 3]);
            let (Some(own), Some(other)) = (left.get(&[a, b]), left.get(&[b, a])) else {
                continue;
            };
            if own.dot(*other) < FOLDED {
                folded.insert([a.min(b), a.max(b)]);
            }
        }
    }
    let middle = |[a, b]: [u32; 2]| place(mesh, positions, a).midpoint(place(mesh, positions, b));
    found.extend(folded.into_iter().map(middle));
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fill::prepare::prepare;
    use crate::fill::{RimSet, fill_rim_sets};
    use crate::mesh::{Mesh, boundary_loops};
    use crate::shapes;

    fn cap() -> Mesh {
        let (positions, triangles) = shapes::cut_where(&shapes::sphere(1000, 1), |p| p.z > 0.8);
        Mesh::from_triangles(positions, &triangles).expect("a manifold")
    }

    #[test]
    fn crossings_folds_and_triangles_without_area_are_found() {
        let mesh = cap();
        let loops = boundary_loops(&mesh);
        let plan = prepare(&mesh, &[vec![&loops[0]]], &FillOptions::default());
        let context = FillContext {
            mesh: &mesh,
            plan: &plan,
        };
        let topology = &plan.groups[0].topology;
        let start = plan.start_positions(&mesh, 0);
        let defects = |positions: &[DVec3]| defects(context, 0, 0, topology, positions);
        assert_eq!(defects(&start), None);
        // a vertex pulled through the opposite side of the sphere
        let mut crossing = start.clone();
        crossing[0] = DVec3::new(0.1, 0.2, -2.0);
        let found = defects(&crossing).expect("defects");
        assert!(found.crossings.is_some());
        // a vertex on another one: the triangles between have no area
        let t = topology.holes[0].triangles.iter();
        let rim = plan.holes()[0].rims.vertices.len() as u32;
        let inner = t
            .copied()
            .find(|t| t.iter().all(|&v| v >= rim))
            .expect("an inner triangle");
        let mut flat = start.clone();
        flat[(inner[0] - rim) as usize] = flat[(inner[1] - rim) as usize];
        assert!(defects(&flat).expect("defects").folds.is_some());
        // a vertex reflected across its neighbours: folded edges
        let mut folded = start.clone();
        let across = folded[(inner[1] - rim) as usize].midpoint(folded[(inner[2] - rim) as usize]);
        let v = &mut folded[(inner[0] - rim) as usize];
        *v = across + 1.5 * (across - *v);
        assert!(defects(&folded).expect("defects").folds.is_some());
    }

    #[test]
    fn an_unsound_patch_is_replaced_with_a_warning() {
        // two parallel walls with a plate between them: a spherical cap over the hole of the lower
        // wall would pass through the plate
        let (mut positions, mut triangles) =
            shapes::cut_where(&shapes::sphere(1000, 1), |p| p.z > 0.5);
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
        let mesh = Mesh::from_triangles(positions, &triangles).expect("a manifold");
        let loops = boundary_loops(&mesh);
        let hole = loops.iter().filter(|l| l.edges() > 4);
        let hole: Vec<RimSet<'_>> = hole.map(|l| vec![l]).collect();
        let filled = fill_rim_sets(&mesh, &hole, &FillOptions::default(), &|_, _| true);
        let filled = filled.expect("filled");
        let group = filled.groups[0].as_ref().expect("a flow");
        let codes: Vec<&str> = group.outcome.warnings.iter().map(Warning::code).collect();
        assert_eq!(codes, ["surface-replaced"]);
        let new = &filled.mesh.positions[mesh.vertex_count()..];
        assert!(new.iter().all(|p| p.z < 0.8));
    }
}
