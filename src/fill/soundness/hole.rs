//! Other surfaces of one hole of a group: by other models, on other triangulations, domes, and local repairs.

use super::first_patch::other_patches;
use super::replacement::{Origin, Replacement, Surface, between};
use super::solve::{SAFER, flow_by};
use crate::cancel::is_cancelled;
use crate::energy::Preset;
use crate::fill::context::FillContext;
use crate::fill::defects::{Defects, Patches, Room, SOUND, defects, severity};
use crate::fill::hole::HoleRims;
use crate::fill::options::FillOptions;
use crate::fill::passing::passing_part;
use crate::fill::patch_topology::{HoleTopology, PatchTopology};
use crate::fill::region;
use crate::fill::repair::repaired;
use crate::fill::surface_choice::Candidate;
use crate::fill::warm_start::warm_start;
use crate::mesh::{DVec3, bending};
use crate::patch::{self, OtherPatches, Patch};
use crate::solver::SurfaceModel;

/// One hole of a group.
pub(super) struct HoleOfGroup<'a> {
    pub context: FillContext<'a>,
    pub group: usize,
    /// Its place among the holes of the group.
    pub number: usize,
    pub rims: &'a HoleRims,
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
pub(super) const MUCH_MORE: f64 = 3.0;

/// Part of the distance of a [far](HoleRims::far_reach) surface from the rim up to which the first of [`SAFER`] replaces
/// it.
const NEARER: f64 = 0.75;

/// Words for a surface on other triangles.
const OTHERWISE: &str = " on another triangulation";

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

impl HoleOfGroup<'_> {
    /// The least unsound of the other surfaces, the first of them if there are several. `None` if
    /// none is less unsound than the present one, by `model`.
    pub fn better(
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

    /// The surface by the first of the [safer models](SAFER), if the patch bends far more or goes farther from the rim:
    /// a vector flow of sixth order gets wrinkles where the mesh at the rim leads away from the hole, and goes on along
    /// the walls of an open end.
    pub fn smoother(&self, present: &Surface, options: &FillOptions) -> Option<Replacement> {
        if self.rims.is_blend() || Candidate::of(&options.flow) == SAFER[0] {
            return None;
        }
        let bends = self.bending(present).filter(|&bends| bends > WRINKLED);
        let far = match options.flow.surface {
            SurfaceModel::G2 => self.rims.far_reach(self.new_points(present)?),
            _ => None,
        };
        if bends.is_none() && far.is_none() {
            return None;
        }
        let smoother = self.by(present, SAFER[0], options)?;
        let mut smoother = self.replacement(smoother, Some(SAFER[0].words()));
        let ratio = bends.unwrap_or(0.0) / self.bending(&smoother.surface)?;
        let reach = self.rims.reach(self.new_points(&smoother.surface)?);
        smoother.origin.bending = Some(ratio).filter(|ratio| *ratio >= MUCH_MORE);
        smoother.origin.reach = far.filter(|far| reach <= NEARER * far);
        let is_better = smoother.origin.bending.is_some() || smoother.origin.reach.is_some();
        (is_better && smoother.is_sound()).then_some(smoother)
    }

    /// The new vertices of its patch.
    fn new_points<'s>(&self, (topology, positions): &'s Surface) -> Option<&'s [DVec3]> {
        topology
            .split(positions)
            .nth(self.number)
            .map(|part| part.1)
    }

    /// How much its patch bends.
    pub fn bending(&self, surface: &Surface) -> Option<f64> {
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
        // other surfaces follow no counterpart
        let chosen = Candidate {
            symmetric: false,
            ..model
        };
        // of the same kind, but of lower order
        let willmore = (chosen.energy == Some(Preset::MeanVariation)).then_some(Candidate {
            energy: Some(Preset::H2),
            ..chosen
        });
        let all = || {
            let safer = SAFER.into_iter().filter(move |&safer| safer != chosen);
            std::iter::once(chosen).chain(willmore).chain(safer)
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
    pub fn replacement(&self, surface: Surface, other: Option<String>) -> Replacement {
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
    pub fn at_first_patch(&self, present: &Surface, options: &FillOptions) -> Surface {
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
    pub fn by(
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
    pub fn has_local_defects(&self, unsound: &Replacement) -> bool {
        let [pairs, _, folds] = severity(unsound.defects);
        let (topology, _) = &unsound.surface;
        LOCAL * (pairs + folds) <= topology.holes[self.number].triangles.len()
    }

    /// A surface with the defects of the hole's patch repaired. `None` if it has none, or if some would
    /// be left.
    pub fn repaired(&self, unsound: &Replacement) -> Option<Replacement> {
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

    /// A place where a part of the mesh passes through its first patch.
    pub fn passing_part(&self) -> Option<DVec3> {
        let FillContext { mesh, plan } = self.context;
        let hole = plan.holes_of(self.group).nth(self.number)?;
        passing_part(mesh, &plan.obstacles, self.rims, &hole.patch)
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
    pub fn defects_among(&self, patches: &Patches, positions: &[DVec3]) -> Option<Defects> {
        let (mesh, obstacles) = (self.context.mesh, &self.context.plan.obstacles);
        let others = patches.near(mesh, self.number, positions);
        let own = patches.of(self.number);
        let support = &self.context.plan.groups[self.group].support[self.number];
        let room = Room::around(mesh, self.rims, support);
        defects(mesh, obstacles, self.rims, room, own, &others, positions)
    }
}
