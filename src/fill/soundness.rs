//! Sound patches: no triangle crosses another one or has no area, no edge is folded, and no vertex is
//! far from the rim.

use std::collections::BTreeSet;

use rustc_hash::FxHashMap;

use crate::fill::assemble::appended_triangles;
use crate::fill::context::FillContext;
use crate::fill::hole::HoleRims;
use crate::fill::options::FillOptions;
use crate::fill::patch_topology::{HoleTopology, PatchTopology};
use crate::fill::prediction::Candidate;
use crate::fill::region;
use crate::fill::self_intersection::{CompactTriangles, Obstacles, intersections, place};
use crate::fill::warm_start::warm_start_of;
use crate::mesh::{DVec3, FaceId, Mesh, TriangleIntersections, VertexId};
use crate::patch::{self, OtherPatches, Patch, PatchOptions};
use crate::solver::{Flow, Mode, SurfaceModel, Tau};
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
    /// The patches and their new vertices, if one was replaced.
    pub replaced: Option<(PatchTopology, Vec<DVec3>)>,
    /// What was replaced, and which defects are left.
    pub warnings: Warnings,
}

/// Checks the patches of a group with new vertices at `positions`, filled with `options`. An unsound
/// patch is replaced by the first sound surface of [other models](SAFER) or of
/// [other triangulations](other_patches), or else by the least unsound. The other patches of its group
/// are then solved again beside it.
pub(super) fn make_sound(
    context: FillContext<'_>,
    group: usize,
    topology: &PatchTopology,
    positions: Vec<DVec3>,
    options: &FillOptions,
) -> Checked {
    let mut present = (topology.clone(), positions);
    let mut is_replaced = false;
    let holes = context.plan.holes_of(group).enumerate();
    let holes: Vec<HoleOfGroup<'_>> = holes
        .map(|(number, hole)| HoleOfGroup {
            context,
            group,
            number,
            rims: &hole.rims,
        })
        .collect();
    let mut patches = Patches::new(context, group, &present);
    let mut warnings: Vec<Warnings> = Vec::new();
    for hole in &holes {
        let mut own = Warnings::default();
        let found = hole.defects_among(&patches, &present.1);
        let mut left = found;
        if hole.rims.is_blend() {
            // intersections of blends are watched during the flow
            left = left.map(|defects| Defects {
                crossings: None,
                ..defects
            });
        } else if let Some(found) = found
            && let Some(better) = hole.better(&present, found, options)
        {
            present = better.surface;
            patches = Patches::new(context, group, &present);
            left = better.defects;
            is_replaced = true;
            let [pairs, escaped, folds] = found.severity();
            own.push(Warning::Replaced {
                hole: hole.rims.id(),
                model: Candidate::new(options.flow.surface, options.flow.tension).words(),
                by: better.words,
                pairs,
                escaped,
                folds,
            });
        }
        own.extend(left.iter().flat_map(Defects::warnings));
        warnings.push(own);
    }
    let single = holes.iter().filter(|hole| !hole.rims.is_blend());
    let (sound, unsound): (Vec<_>, Vec<_>) =
        single.partition(|hole| warnings[hole.number].is_empty());
    if holes.len() > 1 && !unsound.is_empty() {
        let alone = unsound.into_iter().map(|hole| vec![hole]);
        for some in std::iter::once(sound).chain(alone) {
            if let Some(surface) = solved_again(&some, &present, options) {
                present = surface;
                is_replaced = true;
                for hole in some {
                    warnings[hole.number] = Warnings::default();
                }
            }
        }
    }
    Checked {
        replaced: is_replaced.then_some(present),
        warnings: warnings.into_iter().flatten().collect(),
    }
}

/// Some holes of a group, filled by the chosen model from their first patches with the other patches
/// fixed. `None` if that fails or one of them is not sound.
fn solved_again(
    holes: &[&HoleOfGroup<'_>],
    present: &Surface,
    options: &FillOptions,
) -> Option<Surface> {
    let mut start = present.clone();
    for hole in holes {
        start = hole.at_first_patch(&start, options);
    }
    let numbers: Vec<usize> = holes.iter().map(|hole| hole.number).collect();
    let chosen = Candidate::new(options.flow.surface, options.flow.tension);
    let one = holes.first()?;
    let surface = solved(one.context, one.group, &numbers, &start, chosen, options)?;
    let patches = Patches::new(one.context, one.group, &surface);
    let is_sound = |hole: &&HoleOfGroup<'_>| hole.defects_among(&patches, &surface.1).is_none();
    holes.iter().all(is_sound).then_some(surface)
}

/// A group with the holes of these numbers filled by a surface model from their warm start, the
/// others fixed. `None` if that fails.
fn solved(
    context: FillContext<'_>,
    group: usize,
    numbers: &[usize],
    (topology, positions): &Surface,
    model: Candidate,
    options: &FillOptions,
) -> Option<Surface> {
    let problem = region::problem(context, group, topology, positions, options).ok()?;
    let parts: Vec<&[u32]> = topology
        .split(problem.interior())
        .map(|part| part.1)
        .collect();
    let own: Vec<u32> = numbers.iter().flat_map(|&k| parts[k]).copied().collect();
    let start = warm_start_of(problem.clone(), &own).ok()?;
    let mut flow = options.flow.clone();
    flow.surface = model.surface;
    flow.tension = model.tension;
    flow.mode = Mode::Fast;
    flow.tau = Tau::Auto;
    let mut flow = Flow::new(start.moving_only(&own).ok()?, flow).ok()?;
    flow.run(|_, _| true).ok()?;
    Some((topology.clone(), problem.to_world(flow.positions())))
}

/// Replaces an unsound patch without new vertices, which no flow changes, by a sound or less unsound
/// one. Returns the warnings about the defects that are left.
pub(super) fn make_patch_sound(
    mesh: &Mesh,
    obstacles: &Obstacles,
    rims: &HoleRims,
    patch: &mut Patch,
    options: PatchOptions,
) -> Warnings {
    let defects = |patch: &Patch| {
        let new = patch.new_points();
        let part = (&rims.vertices[..], &patch.triangles[..], new.len());
        let own = appended_triangles(mesh.vertex_count(), [part]);
        let room = Room::around(mesh, rims, &[]);
        defects(mesh, obstacles, rims, room, &own, &[], new)
    };
    if rims.is_blend() || !patch.new_points().is_empty() {
        return Warnings::default();
    }
    let mut left = defects(patch);
    let others = left.and_then(|_| other_patches(mesh, obstacles, rims, options));
    if let Some(OtherPatches { relaxed, flat }) = others {
        for other in std::iter::once(relaxed).chain(flat) {
            let after = defects(&other);
            if severity(after) < severity(left) {
                left = after;
                *patch = other;
            }
        }
    }
    if patch.new_points().is_empty() {
        left.iter().flat_map(Defects::warnings).collect()
    } else {
        Warnings::default()
    }
}

/// Other first patches of a hole; their triangulation avoids the triangles of the mesh.
fn other_patches(
    mesh: &Mesh,
    obstacles: &Obstacles,
    rims: &HoleRims,
    options: PatchOptions,
) -> Option<OtherPatches> {
    let [rim] = &rims.geometry.rims[..] else {
        return None;
    };
    let nothing = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let (low, high) = (rim.points.iter()).fold(nothing, |(a, b), &p| (a.min(p), b.max(p)));
    let near = obstacles.overlapping(mesh, low, high);
    let all = CompactTriangles::new(near, |v| mesh.position(VertexId(v)));
    let given = TriangleIntersections::new(&all.points, &all.triangles);
    let rim_numbers: Vec<Option<u32>> = rims.vertices.iter().map(|v| all.number(v.0)).collect();
    let crosses = |t: [u32; 3]| match t.map(|v| rim_numbers[v as usize]) {
        [Some(a), Some(b), Some(c)] => given.any([a, b, c]),
        _ => false,
    };
    patch::fill_excluding(rim, options, &crosses)
}

/// One hole of a group.
struct HoleOfGroup<'a> {
    context: FillContext<'a>,
    group: usize,
    /// Its place among the holes of the group.
    number: usize,
    rims: &'a HoleRims,
}

/// Parts of the way from a flat triangulation to a smooth surface that are tried.
const PARTS: [f64; 4] = [1.0, 0.5, 0.25, 0.125];

/// Words for a surface on other triangles.
const OTHERWISE: &str = " on another triangulation";

/// A surface that may replace an unsound one.
struct Replacement {
    surface: Surface,
    words: String,
    /// Those of the hole's patch; `None` if it is sound.
    defects: Option<Defects>,
}

impl Replacement {
    fn is_sound(&self) -> bool {
        self.defects.is_none()
    }
}

/// The least unsound surface of a search.
struct Best {
    severity: [usize; 3],
    replacement: Option<Replacement>,
}

impl Best {
    /// Keeps a surface if it is less unsound than those before. Returns whether it is sound.
    fn keep(&mut self, next: Option<Replacement>) -> bool {
        let Some(next) = next else { return false };
        let severity = severity(next.defects);
        if severity >= self.severity {
            return false;
        }
        self.severity = severity;
        self.replacement = Some(next);
        severity == SOUND
    }
}

/// The surface at a part of the way from one surface to another one of the same triangles.
fn between(from: &Surface, to: &Surface, part: f64) -> Surface {
    let pairs = from.1.iter().zip(&to.1);
    let positions = pairs.map(|(a, b)| a.lerp(*b, part)).collect();
    (from.0.clone(), positions)
}

/// Patches of a group, and its new vertices.
type Surface = (PatchTopology, Vec<DVec3>);

impl HoleOfGroup<'_> {
    /// The least unsound of the other surfaces, the first of them if there are several, its words
    /// and its defects. `None` if none is less unsound than `found`, the defects of `present`.
    fn better(
        &self,
        present: &Surface,
        found: Defects,
        options: &FillOptions,
    ) -> Option<Replacement> {
        let chosen = Candidate::new(options.flow.surface, options.flow.tension);
        let others = SAFER.into_iter().filter(|&model| model != chosen);
        let all = || std::iter::once(chosen).chain(others.clone());
        let by = |start: &Surface, model: Candidate, on: &str| {
            let surface = self.by(start, model, options)?;
            Some(self.replacement(surface, format!("{}{on}", model.words())))
        };
        let mut best = Best {
            severity: found.severity(),
            replacement: None,
        };
        if others
            .clone()
            .any(|model| best.keep(by(present, model, "")))
        {
            return best.replacement;
        }
        let (mesh, obstacles) = (self.context.mesh, &self.context.plan.obstacles);
        let patches = other_patches(mesh, obstacles, self.rims, options.patch);
        let Some(OtherPatches { relaxed, flat }) = patches else {
            return best.replacement;
        };
        let relaxed = self.with(present, &relaxed);
        if all().any(|model| best.keep(by(&relaxed, model, OTHERWISE))) {
            return best.replacement;
        }
        let Some(flat) = flat.map(|flat| self.with(present, &flat)) else {
            return best.replacement;
        };
        let smooth = self.by(&flat, SAFER[0], options);
        let mixed = PARTS.into_iter().filter_map(|part| {
            let surface = between(&flat, smooth.as_ref()?, part);
            let share = if part < 1.0 {
                format!("{part} of ")
            } else {
                String::new()
            };
            let words = format!("{share}{}{OTHERWISE}", SAFER[0].words());
            Some(self.replacement(surface, words))
        });
        let unchanged = self.replacement(flat.clone(), "a triangulation of the rim".into());
        if !mixed.chain([unchanged]).any(|next| best.keep(Some(next))) {
            return best.replacement;
        }
        // the same shape allows better triangles
        let even = self.remeshed(&best.replacement.as_ref()?.surface, options);
        let mut even = all().filter_map(|model| by(&even, model, OTHERWISE));
        even.find(Replacement::is_sound).or(best.replacement)
    }

    /// A surface with the defects of the hole's patch.
    fn replacement(&self, surface: Surface, words: String) -> Replacement {
        let defects = self.defects(&surface);
        Replacement {
            surface,
            words,
            defects,
        }
    }

    /// The group with the hole's patch remeshed.
    fn remeshed(&self, surface: &Surface, options: &FillOptions) -> Surface {
        let (topology, positions) = surface;
        let parts = topology.split(positions).nth(self.number);
        let patch = parts.map(|(own, here)| self.rims.patch(own, here));
        let remesh = |patch| patch::reblend(&self.rims.geometry, &patch, options.patch);
        patch.map_or_else(
            || surface.clone(),
            |patch| self.with(surface, &remesh(patch)),
        )
    }

    /// The group with the first patch of the hole, remeshed if the present one has other triangles.
    fn at_first_patch(&self, present: &Surface, options: &FillOptions) -> Surface {
        let hole = self.context.plan.holes_of(self.group).nth(self.number);
        let Some(hole) = hole else {
            return present.clone();
        };
        let first = self.with(present, &hole.patch);
        if first.0.holes[self.number] == present.0.holes[self.number] {
            return first;
        }
        self.remeshed(&first, options)
    }

    /// The group with another first patch of the hole.
    fn with(&self, (topology, positions): &Surface, patch: &Patch) -> Surface {
        let mut parts: Vec<&[DVec3]> = topology.split(positions).map(|(_, own)| own).collect();
        parts[self.number] = patch.new_points();
        let mut holes = topology.holes.clone();
        holes[self.number] = HoleTopology::of(patch);
        (PatchTopology { holes }, parts.concat())
    }

    /// The group with the hole filled by another surface model, from its warm start. `None` if that
    /// fails.
    fn by(&self, start: &Surface, model: Candidate, options: &FillOptions) -> Option<Surface> {
        solved(
            self.context,
            self.group,
            &[self.number],
            start,
            model,
            options,
        )
    }

    /// The defects of its patch; `None` if it is sound.
    fn defects(&self, surface: &Surface) -> Option<Defects> {
        let patches = Patches::new(self.context, self.group, surface);
        self.defects_among(&patches, &surface.1)
    }

    /// The same for patches with new vertices at `positions`.
    fn defects_among(&self, patches: &Patches, positions: &[DVec3]) -> Option<Defects> {
        let (mesh, obstacles) = (self.context.mesh, &self.context.plan.obstacles);
        let others = patches.near(mesh, self.number, positions);
        let own = patches.of(self.number);
        let support = &self.context.plan.groups[self.group].support[self.number];
        let room = Room::around(mesh, self.rims, support);
        defects(mesh, obstacles, self.rims, room, own, &others, positions)
    }
}

/// What is wrong with a patch.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Defects {
    /// Pairs of triangles that cross, [`MAX_PAIRS`] at most, and one of the places.
    pub crossings: Option<(usize, DVec3)>,
    /// New vertices outside the [`Room`] of the hole, and one of the places.
    pub escaped: Option<(usize, DVec3)>,
    /// Folded edges and triangles without area, and one of the places.
    pub folds: Option<(usize, DVec3)>,
}

impl Defects {
    /// How bad they are: crossings first, then vertices that escaped, then folds.
    pub fn severity(&self) -> [usize; 3] {
        let all = [self.crossings, self.escaped, self.folds];
        all.map(|found| found.map_or(0, |found| found.0))
    }

    /// The warnings of a result that has these defects.
    pub fn warnings(&self) -> impl Iterator<Item = Warning> {
        let crossing = self.crossings.map(|(pairs, at)| Warning::SelfIntersection {
            pairs,
            at,
            kept_step: None,
        });
        let escape = |(vertices, at)| Warning::Escaped { vertices, at };
        let fold = |(edges, at)| Warning::Folded { edges, at };
        let others = [self.escaped.map(escape), self.folds.map(fold)];
        crossing.into_iter().chain(others.into_iter().flatten())
    }
}

/// The severity of no defects.
const SOUND: [usize; 3] = [0; 3];

/// A cube about a hole that a patch should not leave. Its centre is that of the box of the rims and the
/// faces around them, and its edges are twice the diagonal of that box. The complement of a cap of a
/// sphere fits into it while the cap is a ninth of the sphere or more.
#[derive(Clone, Copy, Debug)]
struct Room {
    low: DVec3,
    high: DVec3,
}

impl Room {
    fn around(mesh: &Mesh, rims: &HoleRims, support: &[FaceId]) -> Self {
        let faces = support.iter().flat_map(|&f| mesh.topology.face_vertices(f));
        let points = faces.chain(rims.vertices.iter().copied());
        let nothing = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let (low, high) = points
            .map(|v| mesh.position(v))
            .fold(nothing, |(low, high), p| (low.min(p), high.max(p)));
        let (centre, reach) = (low.midpoint(high), low.distance(high));
        Self {
            low: centre - reach,
            high: centre + reach,
        }
    }

    fn contains(&self, p: DVec3) -> bool {
        self.low.cmple(p).all() && p.cmple(self.high).all()
    }
}

/// Places of the new vertices of `triangles` outside a room.
fn escaped(mesh: &Mesh, room: Room, triangles: &[[u32; 3]], positions: &[DVec3]) -> Vec<DVec3> {
    let first = mesh.vertex_count() as u32;
    let new: BTreeSet<u32> = triangles
        .iter()
        .flatten()
        .copied()
        .filter(|&v| v >= first)
        .collect();
    let places = new.into_iter().map(|v| place(mesh, positions, v));
    places.filter(|&p| !room.contains(p)).collect()
}

/// The patches of a group, each with a box around it.
struct Patches {
    triangles: Vec<[u32; 3]>,
    /// End of each patch in `triangles`.
    ends: Vec<usize>,
    boxes: Vec<(DVec3, DVec3)>,
}

/// What the box of a patch exceeds it by, relative to the coordinates: more than their rounding.
const ROOM: f64 = 1e-9;

impl Patches {
    fn new(context: FillContext<'_>, group: usize, (topology, positions): &Surface) -> Self {
        let counts = topology.holes.iter().map(|hole| hole.triangles.len());
        let mut end = 0;
        let ends = counts.map(|count| {
            end += count;
            end
        });
        let mut patches = Self {
            triangles: context.patch_triangles(group, topology),
            ends: ends.collect(),
            boxes: vec![(DVec3::ZERO, DVec3::ZERO); topology.holes.len()],
        };
        for k in 0..patches.boxes.len() {
            patches.boxes[k] = patches.around(context.mesh, k, positions);
        }
        patches
    }

    /// The triangles of a patch.
    fn of(&self, k: usize) -> &[[u32; 3]] {
        let begin = if k == 0 { 0 } else { self.ends[k - 1] };
        &self.triangles[begin..self.ends[k]]
    }

    /// The box around a patch with new vertices at `positions`.
    fn around(&self, mesh: &Mesh, k: usize, positions: &[DVec3]) -> (DVec3, DVec3) {
        let points = self.of(k).iter().flatten();
        let points = points.map(|&v| place(mesh, positions, v));
        let nothing = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let (low, high) = points.fold(nothing, |(low, high), p| (low.min(p), high.max(p)));
        let room = ROOM * low.abs().max(high.abs());
        (low - room, high + room)
    }

    /// The triangles of the other patches whose boxes overlap that of a patch with new vertices at
    /// `positions`.
    fn near(&self, mesh: &Mesh, k: usize, positions: &[DVec3]) -> Vec<[u32; 3]> {
        let (low, high) = self.around(mesh, k, positions);
        let is_near = |j: &usize| {
            let (other_low, other_high) = self.boxes[*j];
            *j != k && other_low.cmple(high).all() && other_high.cmpge(low).all()
        };
        let near = (0..self.boxes.len()).filter(is_near);
        near.flat_map(|j| self.of(j).iter().copied()).collect()
    }
}

/// The severity of the defects of a patch.
fn severity(defects: Option<Defects>) -> [usize; 3] {
    defects.map_or(SOUND, |defects| defects.severity())
}

/// The defects of a patch in `room` of the triangles `own` beside those of `others`, both
/// [appended](appended_triangles) to the mesh with new vertices at `positions`; `None` if it is
/// sound.
fn defects(
    mesh: &Mesh,
    obstacles: &Obstacles,
    rims: &HoleRims,
    room: Room,
    own: &[[u32; 3]],
    others: &[[u32; 3]],
    positions: &[DVec3],
) -> Option<Defects> {
    let counted = |places: Vec<DVec3>| places.first().map(|&at| (places.len(), at));
    let crossings = intersections(mesh, obstacles, own, others, positions, MAX_PAIRS);
    let found = Defects {
        crossings: counted(crossings),
        escaped: counted(escaped(mesh, room, own, positions)),
        folds: counted(folds(mesh, rims, own, positions)),
    };
    (found.severity() != SOUND).then_some(found)
}

/// Places of folded edges, those of the rims included, and of triangles without area.
fn folds(mesh: &Mesh, rims: &HoleRims, triangles: &[[u32; 3]], positions: &[DVec3]) -> Vec<DVec3> {
    let corners = |t: [u32; 3]| t.map(|v| place(mesh, positions, v));
    let normal = |[a, b, c]: [DVec3; 3]| (b - a).cross(c - a).normalize_or_zero();
    // unit normal of the face to the left of each directed edge
    let mut left: FxHashMap<[u32; 2], DVec3> = FxHashMap::default();
    let halfedges = rims.loops.iter().flat_map(|l| &l.halfedges);
    for h in halfedges.map(|h| h.twin()) {
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
    use crate::mesh::{boundary_loops, self_intersections};
    use crate::shapes;

    fn cap() -> Mesh {
        let (positions, triangles) = shapes::cut_where(&shapes::sphere(1000, 1), |p| p.z > 0.8);
        Mesh::from_triangles(positions, &triangles).expect("a manifold")
    }

    #[test]
    fn crossings_escapes_folds_and_triangles_without_area_are_found() {
        let mesh = cap();
        let loops = boundary_loops(&mesh);
        let plan = prepare(&mesh, &[vec![&loops[0]]], &FillOptions::default());
        let context = FillContext {
            mesh: &mesh,
            plan: &plan,
        };
        let topology = &plan.groups[0].topology;
        let start = plan.start_positions(&mesh, 0);
        let hole = HoleOfGroup {
            context,
            group: 0,
            number: 0,
            rims: &plan.holes()[0].rims,
        };
        let defects = |positions: &[DVec3]| {
            hole.defects(&(PatchTopology::clone(topology), positions.to_vec()))
        };
        assert_eq!(defects(&start), None);
        // a vertex pulled through the opposite side of the sphere
        let mut crossing = start.clone();
        crossing[0] = DVec3::new(0.1, 0.2, -2.0);
        let found = defects(&crossing).expect("defects");
        assert!(found.crossings.is_some());
        // a vertex pulled far out
        let mut far = start.clone();
        far[0] = DVec3::new(0.0, 0.0, 2.5);
        assert_eq!(defects(&far).and_then(|found| found.escaped), None);
        far[0] = DVec3::new(0.1, 0.0, 4.0);
        let found = defects(&far).expect("defects").escaped;
        assert_eq!(found, Some((1, far[0])));
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
}
