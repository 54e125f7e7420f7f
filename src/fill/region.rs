//! The region of a group: its patches and the faces around them as a separate mesh.
//!
//! ```text
//!        support region            the given faces within SUPPORT_RINGS rings of the rim, fixed
//!    . . . . . . . . . . .
//!    . . .-----------. . .         rim vertices, fixed: shared by patch and support region (G1),
//!    . . |           | . .         or copied (G0), so that the two are not joined
//!    . . |   patch   | . .         new vertices, which flow; they come first in the region
//!    . . |           | . .
//!    . . '-----------' . .
//!    . . . . . . . . . . .
//! ```
//!
//! The numbers of the region's vertices are, in this order: the new vertices of the group's
//! patches, then given vertices and copies of given vertices as triangles first use them.

use rustc_hash::{FxHashMap, FxHashSet};

use crate::fill::Continuity;
use crate::fill::context::FillContext;
use crate::fill::group::Group;
use crate::fill::hole::{HoleRims, PlannedHole};
use crate::fill::options::FillOptions;
use crate::fill::patch_topology::{HoleTopology, PatchTopology};
use crate::fill::plan::Domain;
use crate::fill::sheets;
use crate::mesh::union_find::{find, unite};
use crate::mesh::{DVec3, FaceId, Mesh, TopologyError, VertexId, Weld, sides};
use crate::solver::{FlowProblem, SolverError};

/// The flow of a group's vertices from `positions`, those of `topology` (or of a fairing).
pub(super) fn problem(
    context: FillContext<'_>,
    group: usize,
    topology: &PatchTopology,
    positions: &[DVec3],
    options: &FillOptions,
) -> Result<FlowProblem, SolverError> {
    let group = &context.plan.groups[group];
    let region = Region::new(context.mesh, positions);
    match &context.plan.domain {
        Domain::Holes(holes) => {
            let interior = topology.new_vertices() as u32;
            let loose = &context.plan.loose;
            region.of_patches(holes, loose, group, topology, interior, options)
        }
        Domain::Vertices(moved) => region.of_fairing(moved, group),
    }
}

/// The flow of the new vertices of one hole of a group, given by its place there, beside the patches
/// of the holes that its support region reaches. It costs as much as that hole by itself.
pub(super) fn problem_of_hole(
    context: FillContext<'_>,
    group: usize,
    number: usize,
    topology: &PatchTopology,
    positions: &[DVec3],
    options: &FillOptions,
) -> Result<FlowProblem, SolverError> {
    let (whole, holes) = (&context.plan.groups[group], context.plan.holes());
    let support = whole.support[number].iter();
    let near = support.flat_map(|&f| context.mesh.topology.face_vertices(f));
    let near: FxHashSet<VertexId> = near.collect();
    let is_reached = |k: &usize| {
        let rim = &holes[whole.holes[*k]].rims.vertices;
        *k != number && rim.iter().any(|v| near.contains(v))
    };
    let reached = (0..whole.holes.len()).filter(is_reached);
    let numbers: Vec<usize> = std::iter::once(number).chain(reached).collect();
    let parts: Vec<(&HoleTopology, &[DVec3])> = topology.split(positions).collect();
    let patches = PatchTopology {
        holes: numbers.iter().map(|&k| parts[k].0.clone()).collect(),
    };
    let positions: Vec<&[DVec3]> = numbers.iter().map(|&k| parts[k].1).collect();
    let mut support = vec![Vec::new(); numbers.len()];
    support[0].clone_from(&whole.support[number]);
    let part = Group {
        holes: numbers.iter().map(|&k| whole.holes[k]).collect(),
        support,
        ..whole.clone()
    };
    let interior = patches.holes[0].new_vertices as u32;
    let loose = &context.plan.loose;
    let region = Region::new(context.mesh, &positions.concat());
    region.of_patches(holes, loose, &part, &patches, interior, options)
}

/// Vertices and triangles of a region under construction: new vertices first.
struct Region<'a> {
    mesh: &'a Mesh,
    /// Number in the region of the vertices of the mesh that it contains.
    local: FxHashMap<VertexId, u32>,
    positions: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    creases: Vec<u32>,
    free_curvatures: Vec<u32>,
}

impl<'a> Region<'a> {
    fn new(mesh: &'a Mesh, new_positions: &[DVec3]) -> Self {
        Self {
            mesh,
            local: FxHashMap::default(),
            positions: new_positions.to_vec(),
            triangles: Vec::new(),
            creases: Vec::new(),
            free_curvatures: Vec::new(),
        }
    }

    /// The region of new vertices in patches, the first `interior` of which flow.
    ///
    /// A hole all of whose rims are creased has no support region. Where the support regions of
    /// other holes of the group reach such a hole, they end at its rim too.
    fn of_patches(
        mut self,
        holes: &[PlannedHole],
        loose: &[usize],
        group: &Group,
        topology: &PatchTopology,
        interior: u32,
        options: &FillOptions,
    ) -> Result<FlowProblem, SolverError> {
        let has_support = |hole: &PlannedHole| {
            let mut loops = hole.rims.loops.iter();
            loops.any(|l| options.continuity_at(l.id).is_smooth())
        };
        let mut first = 0;
        for (&h, patch) in group.holes.iter().zip(&topology.holes) {
            self.add_patch(&holes[h].rims, patch, first, options);
            first += patch.new_vertices as u32;
        }
        let support = group.holes.iter().zip(&group.support);
        let mut faces: Vec<FaceId> = support
            .filter(|(h, _)| has_support(&holes[**h]))
            .flat_map(|(_, faces)| faces.iter().copied())
            .collect();
        faces.sort_unstable();
        faces.dedup();
        let topology = &self.mesh.topology;
        let mut support: Vec<VertexId> = faces
            .iter()
            .flat_map(|&f| topology.face_vertices(f))
            .collect();
        support.sort_unstable();
        support.dedup();
        // patches without interior vertices close holes in the support region
        for hole in loose.iter().map(|&h| &holes[h]) {
            let rim = &hole.rims.vertices;
            let touches = |v: &VertexId| support.binary_search(v).is_ok();
            let is_split = !hole.rims.crease.is_empty();
            if has_support(hole) && !is_split && rim.iter().any(touches) {
                let triangles = hole.patch.triangles.iter();
                self.add(triangles.map(|t| t.map(|v| rim[v as usize])));
            }
        }
        self.add(faces.iter().map(|&f| topology.face_vertices(f)));
        self.into_problem(interior, group.radius)
    }

    /// The region of vertices of the mesh that flow.
    fn of_fairing(mut self, moved: &[VertexId], group: &Group) -> Result<FlowProblem, SolverError> {
        for (i, &v) in (0..).zip(moved) {
            self.local.insert(v, i);
        }
        let faces = group.support.iter().flatten();
        let topology = &self.mesh.topology;
        self.add(faces.map(|&f| topology.face_vertices(f)));
        self.into_problem(moved.len() as u32, group.radius)
    }

    /// The region number of an input vertex, which is added if it is missing.
    fn number(&mut self, v: VertexId) -> u32 {
        *self.local.entry(v).or_insert_with(|| {
            self.positions.push(self.mesh.position(v));
            self.positions.len() as u32 - 1
        })
    }

    /// Triangles over vertices of the mesh.
    fn add(&mut self, triangles: impl Iterator<Item = [VertexId; 3]>) {
        for t in triangles {
            let t = t.map(|v| self.number(v));
            self.triangles.push(t);
        }
    }

    /// A patch, which shares the vertices of its smooth rims with its surroundings and ends at
    /// copies of the others. `first` is the region's number of its first new vertex.
    fn add_patch(
        &mut self,
        rims: &HoleRims,
        topology: &HoleTopology,
        first: u32,
        options: &FillOptions,
    ) {
        let rim = rims.loops.iter();
        let mut at: Vec<Continuity> = rim
            .flat_map(|l| std::iter::repeat_n(options.continuity_at(l.id), l.vertices.len()))
            .collect();
        for &v in &rims.crease {
            at[v] = Continuity::G0;
        }
        let mut copies: Vec<Option<u32>> = vec![None; at.len()];
        for t in &topology.triangles {
            let t = t.map(|v| {
                let Some(&given) = rims.vertices.get(v as usize) else {
                    return first + (v - rims.vertices.len() as u32);
                };
                if at[v as usize].is_smooth() {
                    let own = self.number(given);
                    if at[v as usize] == Continuity::G1 {
                        self.free_curvatures.push(own);
                    }
                    return own;
                }
                *copies[v as usize].get_or_insert_with(|| {
                    let copy = self.positions.len() as u32;
                    self.positions.push(self.mesh.position(given));
                    self.creases.push(copy);
                    copy
                })
            });
            self.triangles.push(t);
        }
    }

    /// The triangles with one vertex for all fixed vertices that edges of no length join (the poles of
    /// spheres), and without those that end up with fewer than three. `None` without such edges.
    fn without_zero_edges(&self, interior: &[u32]) -> Option<Vec<[u32; 3]>> {
        let tolerance = Weld::Auto.tolerance(&self.positions, false);
        let first_fixed = interior.len() as u32;
        let mut link: Vec<u32> = (0..self.positions.len() as u32).collect();
        let mut any = false;
        for &t in &self.triangles {
            for [v, w] in sides(t) {
                let [p, q] = [v, w].map(|v| self.positions[v as usize]);
                if v.min(w) >= first_fixed && p.distance(q) <= tolerance {
                    unite(&mut link, v, w);
                    any = true;
                }
            }
        }
        let joined = self.triangles.iter().map(|t| t.map(|v| find(&mut link, v)));
        let mut joined: Vec<[u32; 3]> = if any { joined.collect() } else { return None };
        joined.retain(|[a, b, c]| a != b && b != c && c != a);
        Some(joined)
    }

    fn into_problem(mut self, interior: u32, radius: f64) -> Result<FlowProblem, SolverError> {
        let interior: Vec<u32> = (0..interior).collect();
        if let Some(triangles) = self.without_zero_edges(&interior)
            && let Ok(problem) = FlowProblem::new(&self.positions, &triangles, &interior, radius)
        {
            let problem = problem.with_free_curvatures(self.free_curvatures);
            return problem.with_creases(self.creases);
        }
        let problem = match FlowProblem::new(&self.positions, &self.triangles, &interior, radius) {
            Err(SolverError::Topology(TopologyError::NonManifoldVertex { .. })) => {
                sheets::separate(&mut self.positions, &mut self.triangles);
                FlowProblem::new(&self.positions, &self.triangles, &interior, radius)
            }
            problem => problem,
        };
        let problem = problem?.with_free_curvatures(self.free_curvatures);
        problem.with_creases(self.creases)
    }
}
