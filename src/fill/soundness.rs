//! Replacement of unsound patches by sound surfaces: by local repair, by other models, and on other
//! triangulations.

use crate::cancel::is_cancelled;
use crate::fill::assemble::appended_triangles;
use crate::fill::context::FillContext;
use crate::fill::counterpart::{Counterpart, Following};
use crate::fill::defects::{Defects, Patches, Room, SOUND, defects, severity};
use crate::fill::hole::HoleRims;
use crate::fill::options::FillOptions;
use crate::fill::patch_topology::{HoleTopology, PatchTopology};
use crate::fill::prediction::Candidate;
use crate::fill::region;
use crate::fill::repair::repaired;
use crate::fill::self_intersection::{CompactTriangles, Obstacles};
use crate::fill::warm_start::{warm_start, warm_start_of};
use crate::mesh::{DVec3, LoopId, Mesh, TriangleIntersections, VertexId, bending, bounds};
use crate::patch::{self, OtherPatches, Patch, PatchOptions};
use crate::solver::{End, Flow, FlowProblem, Mode, SurfaceModel, Tau};
use crate::warning::{MAX_PAIRS, Warning, Warnings};

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
    /// What was replaced, and which defects are left, by hole.
    pub warnings: Vec<(LoopId, Warning)>,
    /// The holes with patches by another surface model or on another triangulation.
    pub others: Vec<LoopId>,
}

/// Checks the patches of a group with new vertices at `positions`, filled with `options`. A wrinkled patch
/// by a predicted model is replaced by a [smoother](HoleOfGroup::smoother) one. An unsound
/// patch is [repaired] near its defects or else replaced by the first sound surface of
/// [other models](SAFER) or of [other triangulations](other_patches), or by the least unsound. The
/// other patches of its group are solved again beside one that was replaced.
pub(super) fn make_sound(
    context: FillContext<'_>,
    group: usize,
    topology: &PatchTopology,
    positions: Vec<DVec3>,
    counterparts: &[Option<Counterpart>],
    options: &FillOptions,
) -> Checked {
    let model = Candidate {
        symmetric: !counterparts.is_empty(),
        ..Candidate::of(&options.flow)
    };
    let first = positions.clone();
    let mut present = (topology.clone(), positions);
    let holes = context.plan.holes_of(group).enumerate();
    let holes: Vec<HoleOfGroup<'_>> = holes
        .map(|(number, hole)| HoleOfGroup {
            context,
            group,
            number,
            rims: &hole.rims,
        })
        .collect();
    let patches = Patches::new(context, group, &present.0, &present.1);
    let found = holes.iter();
    let found: Vec<Option<Defects>> = found
        .map(|hole| hole.defects_among(&patches, &present.1))
        .collect();
    // what each patch was replaced by
    let mut origins: Vec<Option<Origin>> = vec![None; holes.len()];
    for hole in holes.iter().filter(|_| options.predicts_surface) {
        if let Some(smoother) = hole.smoother(&present, options) {
            present = smoother.surface;
            origins[hole.number] = Some(smoother.origin);
        }
    }
    // a smoother patch stays when others of the group are filled again by the chosen model
    let (sound, unsound): (Vec<_>, Vec<_>) = holes
        .iter()
        .filter(|hole| origins[hole.number].is_none())
        .partition(|hole| found[hole.number].is_none());
    for hole in &unsound {
        if is_cancelled() {
            break;
        }
        let unsound = hole.replacement(present.clone(), None);
        let is_repaired = hole.rims.is_blend() || hole.has_local_defects(&unsound);
        if let Some(better) = is_repaired.then(|| hole.repaired(&unsound)).flatten() {
            present = better.surface;
            origins[hole.number] = Some(better.origin);
        }
    }
    let is_left =
        |hole: &&&HoleOfGroup<'_>| origins[hole.number].is_none() && !hole.rims.is_blend();
    let replaced: Vec<&HoleOfGroup<'_>> = unsound.iter().filter(is_left).copied().collect();
    if let Some((surface, by)) = filled_alike(&replaced, &present, model, options) {
        present = surface;
        for hole in &replaced {
            origins[hole.number] = Some(Origin {
                other: Some(by.clone()),
                ..Origin::default()
            });
        }
    }
    for hole in &replaced {
        if is_cancelled() {
            break;
        }
        let by = origins[hole.number].clone().and_then(|origin| origin.other);
        let unsound = hole.replacement(present.clone(), by);
        if unsound.is_sound() {
            continue;
        }
        let repaired = || hole.repaired(&unsound);
        let better = || hole.better(&unsound, model, options);
        let better = if hole.has_local_defects(&unsound) {
            repaired().or_else(better)
        } else {
            let better = better();
            let is_sound = better.as_ref().is_some_and(Replacement::is_sound);
            let repaired = (!is_sound).then(repaired).flatten();
            repaired.or(better)
        };
        if let Some(better) = better {
            present = better.surface;
            origins[hole.number] = Some(better.origin);
        }
    }
    let is_replaced = |hole: &&HoleOfGroup<'_>| origins[hole.number].is_some();
    let mut again: Vec<usize> = Vec::new();
    if holes.len() > 1 && replaced.iter().any(is_replaced) {
        let alone = replaced.into_iter().map(|hole| vec![hole]);
        for some in std::iter::once(sound).chain(alone) {
            if let Some(surface) = solved_again(&some, &present, counterparts, options) {
                present = surface;
                again.extend(some.iter().map(|hole| hole.number));
            }
        }
    }
    let (mut warnings, mut others) = (Vec::new(), Vec::new());
    if !unsound.is_empty() || origins.iter().any(Option::is_some) {
        let patches = Patches::new(context, group, &present.0, &present.1);
        for hole in &holes {
            let id = hole.rims.id();
            let left = hole.defects_among(&patches, &present.1);
            let by = origins[hole.number].take();
            let by = by.filter(|_| !again.contains(&hole.number));
            if let Some(by) = by {
                if by.other.is_some() {
                    others.push(id);
                }
                let [pairs, escaped, folds] = severity(found[hole.number]);
                let replaced = Warning::Replaced {
                    model: model.words(),
                    by: by.words(model),
                    pairs: pairs.min(MAX_PAIRS),
                    escaped,
                    folds,
                    bending: by.bending,
                };
                warnings.push((id, replaced));
            }
            let left = left.iter().flat_map(Defects::warnings);
            warnings.extend(left.map(|warning| (id, warning)));
        }
    }
    let is_changed = present.0 != *topology || present.1 != first;
    Checked {
        replaced: is_changed.then_some(present),
        warnings,
        others,
    }
}

/// Most holes that are filled alike. Rims side by side are two, seldom more; for the dozens of unsound holes of a
/// riddled mesh the trials take minutes.
const MOST_ALIKE: usize = 4;

/// Several unsound holes of a group, all filled by the first of the [safer models](SAFER) by which all
/// are sound, repaired if need be, and its words: the patches over two rims side by side cross each
/// other unless both are flat. `None` for fewer than two holes, for more than [`MOST_ALIKE`], or if some stay
/// unsound.
fn filled_alike(
    holes: &[&HoleOfGroup<'_>],
    present: &Surface,
    model: Candidate,
    options: &FillOptions,
) -> Option<(Surface, String)> {
    if !(2..=MOST_ALIKE).contains(&holes.len()) {
        return None;
    }
    let filled = |safer: Candidate| {
        let mut surface = present.clone();
        for hole in holes {
            surface = hole.by(&surface, safer, options)?;
        }
        for hole in holes {
            let next = hole.replacement(surface.clone(), None);
            if !next.is_sound() {
                surface = hole.repaired(&next)?.surface;
            }
        }
        Some((surface, safer.words()))
    };
    let mut safer = SAFER.into_iter().filter(|&safer| safer != model);
    safer.find_map(filled)
}

/// Some holes of a group, filled by the chosen model from their first patches with the other patches
/// fixed. `None` if that fails or one of them is not sound.
fn solved_again(
    holes: &[&HoleOfGroup<'_>],
    present: &Surface,
    counterparts: &[Option<Counterpart>],
    options: &FillOptions,
) -> Option<Surface> {
    let mut start = present.clone();
    for hole in holes {
        start = hole.at_first_patch(&start, options);
    }
    let numbers: Vec<usize> = holes.iter().map(|hole| hole.number).collect();
    let chosen = Candidate::of(&options.flow);
    let one = holes.first()?;
    let of_some = |(k, counterpart): (usize, &Option<Counterpart>)| {
        counterpart.filter(|_| numbers.contains(&k))
    };
    let counterparts: Vec<_> = counterparts.iter().enumerate().map(of_some).collect();
    let (context, group) = (one.context, one.group);
    let surface = solved(
        context,
        group,
        &numbers,
        &start,
        chosen,
        &counterparts,
        options,
    )?;
    let patches = Patches::new(one.context, one.group, &surface.0, &surface.1);
    let is_sound = |hole: &&HoleOfGroup<'_>| hole.defects_among(&patches, &surface.1).is_none();
    holes.iter().all(is_sound).then_some(surface)
}

/// A group with the holes of these numbers filled by a surface model from their warm start, the
/// others fixed. Holes with counterparts follow these. `None` if that fails.
fn solved(
    context: FillContext<'_>,
    group: usize,
    numbers: &[usize],
    (topology, positions): &Surface,
    model: Candidate,
    counterparts: &[Option<Counterpart>],
    options: &FillOptions,
) -> Option<Surface> {
    let problem = region::problem(context, group, topology, positions, options).ok()?;
    let parts: Vec<&[u32]> = topology
        .split(problem.interior())
        .map(|part| part.1)
        .collect();
    let own: Vec<u32> = numbers.iter().flat_map(|&k| parts[k]).copied().collect();
    let start = warm_start_of(problem.clone(), &own).ok()?;
    let mut flow = flow_by(start.moving_only(&own).ok()?, model, options)?;
    let mut following = Following::default();
    while flow.end() == Some(End::Converged)
        && following.update(context, &mut flow, topology, counterparts)
    {
        flow.run(|_, _| true).ok()?;
    }
    Some((topology.clone(), problem.to_world(flow.positions())))
}

/// Steps of a flow that is tried. Flows to sound surfaces rarely take more.
const MAX_STEPS: usize = 60;

/// The flow of a surface model from a problem to its end. `None` if that fails.
fn flow_by(problem: FlowProblem, model: Candidate, options: &FillOptions) -> Option<Flow> {
    let mut flow = options.flow.clone();
    model.apply(&mut flow);
    flow.mode = Mode::Fast;
    flow.tau = Tau::Auto;
    let mut flow = Flow::new(problem, flow).ok()?;
    flow.run(|_, record| record.step < MAX_STEPS).ok()?;
    Some(flow)
}

/// Replaces an unsound patch without new vertices, which no flow changes, by a sound or less unsound
/// one. `loose` are the patches of that kind before it. Returns the warnings about the defects that are left.
pub(super) fn make_patch_sound(
    mesh: &Mesh,
    obstacles: &Obstacles,
    rims: &HoleRims,
    patch: &mut Patch,
    loose: &[[u32; 3]],
    options: PatchOptions,
) -> Warnings {
    let defects = |patch: &Patch| {
        let new = patch.new_points();
        let part = (&rims.vertices[..], &patch.triangles[..], new.len());
        let own = appended_triangles(mesh.vertex_count(), [part]);
        let room = Room::around(mesh, rims, &[]);
        defects(mesh, obstacles, rims, room, &own, loose, new)
    };
    if !patch.new_points().is_empty() {
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
    if left.is_some()
        && let Some(sound) = repaired(mesh, obstacles, rims, patch, loose, &[])
    {
        *patch = sound;
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
    let (low, high) = bounds(rim.points.iter().copied());
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

/// Heights of domes, relative to the radius of the hole, that are tried on both sides of the rim.
const HEIGHTS: [f64; 3] = [0.1, 0.3, 1.0];

/// Edges of the shortest rim over which domes are tried. The patch of a shorter one is within reach of a
/// local repair.
const MIN_EDGES: usize = 12;

/// Slope of domes at the rim: 60°, which folds the rim of a flat sheet by 120°.
const SLOPE: f64 = 1.732;

/// Triangles of a patch for each pair of intersecting triangles and each folded edge, so that these count
/// as local. In `real/` the patch of igea under a wrong counterpart has four, those that are repaired well
/// have 25 and more.
const LOCAL: usize = 8;

/// Bending of a patch up to which it is not compared with another one: that of two spheres.
const WRINKLED: f64 = 8.0 * std::f64::consts::PI;

/// How much more than the first of [`SAFER`] a wrinkled patch bends at least. Of the patches in scans with known truth that
/// bend by more than [`WRINKLED`] none bends by more than 1.3 times as much.
const MUCH_MORE: f64 = 3.0;

/// Words for a surface on other triangles.
const OTHERWISE: &str = " on another triangulation";

/// What gave a surface.
#[derive(Clone, Default)]
struct Origin {
    /// Another model or triangulation, in words; `None` for the chosen model on the first triangles.
    other: Option<String>,
    is_repaired: bool,
    /// How many times as much the patch before bends, if that is why it was replaced.
    bending: Option<f64>,
}

impl Origin {
    /// In words, if `model` is the chosen one.
    fn words(&self, model: Candidate) -> String {
        let surface = self.other.clone().unwrap_or_else(|| model.words());
        let repair = if self.is_repaired {
            " changed near its defects"
        } else {
            ""
        };
        surface + repair
    }
}

/// A surface that may replace an unsound one.
struct Replacement {
    surface: Surface,
    origin: Origin,
    /// Those of the hole's patch; `None` if it is sound.
    defects: Option<Defects>,
}

impl Replacement {
    fn is_sound(&self) -> bool {
        self.defects.is_none()
    }
}

/// The least unsound surface of a search.
struct Best<'a> {
    hole: &'a HoleOfGroup<'a>,
    severity: [usize; 3],
    replacement: Option<Replacement>,
}

impl Best<'_> {
    /// Keeps a surface if it is less unsound than those before, repaired if possible. Returns whether
    /// it is sound.
    fn keep(&mut self, next: Option<Replacement>) -> bool {
        let Some(next) = next else { return false };
        if severity(next.defects) >= self.severity {
            return false;
        }
        let next = self.hole.repaired(&next).unwrap_or(next);
        self.severity = severity(next.defects);
        self.replacement = Some(next);
        self.severity == SOUND
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
    /// The least unsound of the other surfaces, the first of them if there are several. `None` if
    /// none is less unsound than the present one, by `model`.
    fn better(
        &self,
        unsound: &Replacement,
        model: Candidate,
        options: &FillOptions,
    ) -> Option<Replacement> {
        let mut best = Best {
            hole: self,
            severity: severity(unsound.defects),
            replacement: None,
        };
        if !self.search(&mut best, &unsound.surface, model, options) {
            self.search_domes(&mut best, &unsound.surface, options);
        }
        best.replacement
    }

    /// The surface by the first of the [safer models](SAFER), if the patch bends far more: a vector flow of
    /// sixth order gets wrinkles where the mesh at the rim leads away from the hole.
    fn smoother(&self, present: &Surface, options: &FillOptions) -> Option<Replacement> {
        if self.rims.is_blend() || Candidate::of(&options.flow) == SAFER[0] {
            return None;
        }
        let bends = self.bending(present).filter(|&bends| bends > WRINKLED)?;
        let smoother = self.by(present, SAFER[0], options)?;
        let mut smoother = self.replacement(smoother, Some(SAFER[0].words()));
        let ratio = bends / self.bending(&smoother.surface)?;
        smoother.origin.bending = Some(ratio);
        (ratio >= MUCH_MORE && smoother.is_sound()).then_some(smoother)
    }

    /// How much its patch bends.
    fn bending(&self, surface: &Surface) -> Option<f64> {
        let patch = self.patch(surface)?;
        Some(bending(&patch.points, &patch.triangles))
    }

    /// Searches surfaces by models, and triangulations of the rim. Returns whether the best is sound.
    fn search(
        &self,
        best: &mut Best<'_>,
        present: &Surface,
        model: Candidate,
        options: &FillOptions,
    ) -> bool {
        let chosen = Candidate::of(&options.flow);
        let all = || {
            let safer = SAFER.into_iter().filter(move |&safer| safer != chosen);
            std::iter::once(chosen).chain(safer)
        };
        let by = |start: &Surface, model: Candidate, on: &str| {
            let surface = self.by(start, model, options)?;
            Some(self.replacement(surface, Some(format!("{}{on}", model.words()))))
        };
        let mut others = all().filter(|&other| other != model);
        if others.any(|other| best.keep(by(present, other, ""))) {
            return true;
        }
        let (mesh, obstacles) = (self.context.mesh, &self.context.plan.obstacles);
        let patches = other_patches(mesh, obstacles, self.rims, options.patch);
        let Some(OtherPatches { relaxed, flat }) = patches else {
            return false;
        };
        let relaxed = self.with(present, &relaxed);
        if all().any(|model| best.keep(by(&relaxed, model, OTHERWISE))) {
            return true;
        }
        let Some(flat) = flat.map(|flat| self.with(present, &flat)) else {
            return false;
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
            Some(self.replacement(surface, Some(words)))
        });
        let unchanged = self.replacement(flat.clone(), Some("a triangulation of the rim".into()));
        if !mixed.chain([unchanged]).any(|next| best.keep(Some(next))) {
            return false;
        }
        // the same shape allows better triangles
        if let Some(sound) = &best.replacement {
            let even = self.remeshed(&sound.surface, options);
            let mut even = all().filter_map(|model| by(&even, model, OTHERWISE));
            best.replacement = even.find(Replacement::is_sound).or(best.replacement.take());
        }
        true
    }

    /// Searches sound domes over a rim that is the outer boundary of a sheet, on which a flat surface would
    /// lie, and over others if the best surface so far crosses the mesh nearly everywhere. Over the rim of a
    /// hole a surface with few defects is nearer to the truth than a dome.
    fn search_domes(&self, best: &mut Best<'_>, present: &Surface, options: &FillOptions) {
        let first = self.at_first_patch(present, options);
        let patch = self.patch(&first);
        let Some(patch) = patch.filter(|patch| patch.rim >= MIN_EDGES) else {
            return;
        };
        let [pairs, ..] = best.severity;
        let is_outer = self.rims.loops.iter().any(|rim| rim.is_outer_boundary);
        if !is_outer && 4 * pairs < patch.triangles.len() {
            return;
        }
        for height in HEIGHTS {
            let height = height * self.rims.radius();
            for height in [height, -height] {
                let dome = self.with(&first, &patch::domed(&patch, SLOPE, height));
                let dome = self.replacement(dome, Some("a dome over the rim".into()));
                let dome = self.repaired(&dome).unwrap_or(dome);
                // one that is not sound may cross far more than a flat surface
                if dome.is_sound() {
                    best.replacement = Some(dome);
                    return;
                }
            }
        }
    }

    /// A surface with the defects of the hole's patch. `other` is as in [`Origin`].
    fn replacement(&self, surface: Surface, other: Option<String>) -> Replacement {
        let defects = self.defects(&surface);
        Replacement {
            surface,
            origin: Origin {
                other,
                ..Origin::default()
            },
            defects,
        }
    }

    /// The group with the hole's patch remeshed.
    fn remeshed(&self, surface: &Surface, options: &FillOptions) -> Surface {
        let remesh = |patch| patch::reblend(&self.rims.geometry, &patch, options.patch);
        self.patch(surface).map_or_else(
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
    fn by(
        &self,
        (topology, positions): &Surface,
        model: Candidate,
        options: &FillOptions,
    ) -> Option<Surface> {
        if is_cancelled() {
            return None;
        }
        let (context, group, number) = (self.context, self.group, self.number);
        let problem =
            region::problem_of_hole(context, group, number, topology, positions, options).ok()?;
        let flow = flow_by(warm_start(problem).ok()?, model, options)?;
        let own = flow.problem().to_world(flow.positions());
        let mut parts: Vec<&[DVec3]> = topology.split(positions).map(|part| part.1).collect();
        parts[number] = &own;
        Some((topology.clone(), parts.concat()))
    }

    /// Whether the patch has few defects for its size: one with many has the wrong shape, which a local
    /// repair keeps.
    fn has_local_defects(&self, unsound: &Replacement) -> bool {
        let [pairs, _, folds] = severity(unsound.defects);
        let (topology, _) = &unsound.surface;
        LOCAL * (pairs + folds) <= topology.holes[self.number].triangles.len()
    }

    /// A surface with the defects of the hole's patch repaired. `None` if it has none, or if some would
    /// be left.
    fn repaired(&self, unsound: &Replacement) -> Option<Replacement> {
        let (mesh, obstacles) = (self.context.mesh, &self.context.plan.obstacles);
        if unsound.defects?.escaped.is_some() || is_cancelled() {
            return None;
        }
        let (topology, positions) = &unsound.surface;
        let patches = Patches::new(self.context, self.group, topology, positions);
        let others = patches.near(mesh, self.number, positions);
        let patch = self.patch(&unsound.surface)?;
        let patch = repaired(mesh, obstacles, self.rims, &patch, &others, positions)?;
        let surface = self.with(&unsound.surface, &patch);
        let mut repaired = self.replacement(surface, unsound.origin.other.clone());
        repaired.origin.is_repaired = true;
        Some(repaired).filter(Replacement::is_sound)
    }

    /// The patch of the hole.
    fn patch(&self, (topology, positions): &Surface) -> Option<Patch> {
        let (own, here) = topology.split(positions).nth(self.number)?;
        Some(self.rims.patch(own, here))
    }

    /// The defects of its patch; `None` if it is sound.
    fn defects(&self, (topology, positions): &Surface) -> Option<Defects> {
        let patches = Patches::new(self.context, self.group, topology, positions);
        self.defects_among(&patches, positions)
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::energy::Energy;
    use crate::fill::prepare::prepare;
    use crate::fill::{Filled, RimSet, fill_rim_sets};
    use crate::mesh::{boundary_loops, folded_edges, self_intersections};
    use crate::shapes;

    /// The lower of two parallel walls with a plate between them: a spherical cap over its hole would pass
    /// through the plate.
    fn below_plate() -> Mesh {
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
        assert_eq!(
            (&surface.others[..], &surface.prediction),
            (&[hole.id()][..], &None)
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
        let folds = folded_edges(&result.positions, &result.topology, 150f64.to_radians());
        (codes, pairs.len() + folds.len())
    }

    #[test]
    fn a_wrinkled_patch_becomes_smooth() {
        let (positions, triangles) = shapes::cut_where(&shapes::icosphere(24), |p| p.z > 0.7);
        let mesh = Mesh::from_triangles(positions, &triangles).expect("a manifold");
        let loops = boundary_loops(&mesh);
        let options = FillOptions::default();
        let plan = prepare(&mesh, &[vec![&loops[0]]], &[], &options).plan;
        let hole = HoleOfGroup {
            context: FillContext {
                mesh: &mesh,
                plan: &plan,
            },
            group: 0,
            number: 0,
            rims: &plan.holes()[0].rims,
        };
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
        let checked = make_sound(context, 0, topology, positions, &[], &options);
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
        let (mut positions, mut triangles) =
            shapes::cut_where(&shapes::sphere(800, 1), |p| p.z > 0.0);
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
}
