//! The repair of a mesh: a sequence of operations, each chosen for the mesh that the one before gave.

use serde::Serialize;

use super::{CleanSpec, Faces, FacesSpec, FillSpec, FlowSpec, Operation, Outcome, StitchSpec};
use crate::fill::{LoopChoice, choose};
use crate::mesh::{
    DVec3, FOLD_DEGREES, Mesh, boundary_loops, components, face_flags, face_list, folded_edges,
    grow, self_intersections,
};
use crate::options::options;
use crate::warning::counted;

options! {
    /// The damaged faces that a repair erases: those that intersect others of their component.
    pub struct DamageSpec {
        /// Erase N rings of faces around damaged ones.
        grow("N"): usize = 1,
        /// Count faces folded onto a neighbour as damaged (their normals differ by 150 degrees or
        /// more). Knife edges are folded too.
        folds: bool = false,
    }
}

impl DamageSpec {
    /// The faces to erase with some `more` rings around them, ascending. Components that cross each other
    /// are not damaged by that: solids of an assembly do.
    fn faces(&self, mesh: &Mesh, more: usize) -> Vec<u32> {
        let triangles: Vec<[u32; 3]> = mesh.topology.triangles().collect();
        let mut pairs = self_intersections(&mesh.positions, &triangles, None, usize::MAX);
        let parts = components(&mesh.topology);
        pairs.retain(|&pair| parts.are_joined(pair));
        if self.folds {
            let angle = FOLD_DEGREES.to_radians();
            pairs.extend(folded_edges(&mesh.positions, &mesh.topology, angle));
        }
        let mut flags = face_flags(pairs.as_flattened(), triangles.len());
        if !pairs.is_empty() {
            for _ in 0..self.grow + more {
                grow(&mesh.topology, &mut flags);
            }
        }
        face_list(&flags)
    }
}

/// Share of the faces above which damaged faces are not erased: most of such a mesh would be patches.
const MAX_DAMAGED: f64 = 0.1;

/// Maximum number of times that damaged faces are erased and the holes filled, each time with one more ring of faces.
const MAX_REFILLS: usize = 4;

/// The next stage of a repair.
#[derive(Clone, Copy, Debug)]
enum Stage {
    Slits,
    LooseParts,
    /// Damaged faces after some refills.
    Damage(usize),
    Holes,
    End,
}

/// A repair: slits are stitched, loose parts are removed, damaged faces are erased and their holes filled, then all
/// other holes are filled.
#[derive(Clone, Debug)]
pub struct Repair {
    clean: CleanSpec,
    damage: DamageSpec,
    flow: FlowSpec,
    stage: Stage,
}

impl Repair {
    /// A repair whose patches are made by `flow`.
    pub fn new(clean: CleanSpec, damage: DamageSpec, flow: FlowSpec) -> Self {
        Self {
            clean,
            damage,
            flow,
            stage: Stage::Slits,
        }
    }

    /// Runs the next operation, by `run`, on the mesh that the ones before gave, the given mesh at first. Where
    /// damaged faces cannot be replaced, they stay, and `left` gets the reason. `None` if nothing is left to
    /// repair.
    ///
    /// # Errors
    /// Of another operation.
    pub fn step<E>(
        &mut self,
        mesh: &Mesh,
        run: impl Fn(&Operation) -> Result<Outcome, E>,
        mut left: impl FnMut(E),
    ) -> Result<Option<RepairStep>, E> {
        while let Some(operation) = self.next_for(mesh) {
            match run(&operation) {
                Ok(outcome) => {
                    let step = RepairStep::new(operation, mesh, outcome);
                    let [before, after] = step.boundary_edges;
                    // without slits nothing is stitched
                    if !matches!(step.operation, Operation::Stitch(_)) || before != after {
                        return Ok(Some(step));
                    }
                }
                Err(error) if matches!(operation, Operation::Refill(_)) => {
                    left(error);
                    self.stage = Stage::Holes;
                }
                Err(error) => return Err(error),
            }
        }
        Ok(None)
    }

    /// The next operation.
    fn next_for(&mut self, mesh: &Mesh) -> Option<Operation> {
        loop {
            match self.stage {
                Stage::Slits => {
                    self.stage = Stage::LooseParts;
                    if mesh.topology.boundary_edge_count() > 0 {
                        return Some(Operation::Stitch(StitchSpec::default()));
                    }
                }
                Stage::LooseParts => {
                    self.stage = Stage::Damage(0);
                    if self.clean.parts(mesh).faces.contains(&true) {
                        return Some(Operation::Clean(self.clean.clone()));
                    }
                }
                Stage::Damage(MAX_REFILLS) => self.stage = Stage::Holes,
                Stage::Damage(refills) => {
                    let faces = self.damage.faces(mesh, refills);
                    let is_much = faces.len() as f64 > MAX_DAMAGED * mesh.face_count() as f64;
                    if faces.is_empty() || is_much {
                        self.stage = Stage::Holes;
                        continue;
                    }
                    self.stage = Stage::Damage(refills + 1);
                    return Some(Operation::Refill(FacesSpec {
                        faces: Faces::new(faces),
                        flow: self.flow.clone(),
                    }));
                }
                Stage::Holes => {
                    self.stage = Stage::End;
                    let loops = choose(&boundary_loops(mesh), &LoopChoice::Auto);
                    let loops = loops.ok().filter(|loops| !loops.is_empty())?;
                    return Some(Operation::Fill(FillSpec {
                        loops,
                        islands: true,
                        bridges: Faces::default(),
                        flow: self.flow.clone(),
                    }));
                }
                Stage::End => return None,
            }
        }
    }
}

/// What a mesh has, before and after a repair.
#[derive(Clone, Debug, Serialize)]
pub struct Condition {
    /// Vertices.
    pub vertices: usize,
    /// Faces.
    pub faces: usize,
    /// Connected components.
    pub components: usize,
    /// Boundary loops.
    pub loops: usize,
    /// Pairs of faces of one component that intersect.
    pub self_intersections: usize,
    /// Pairs of faces of two components that intersect.
    pub intersections_of_components: usize,
    /// Edges where the normals of the faces differ by 150° or more.
    pub folded_edges: usize,
    /// The place of one self-intersection.
    #[serde(skip)]
    pub place: Option<DVec3>,
}

impl Condition {
    /// That of a mesh.
    pub fn of(mesh: &Mesh) -> Self {
        let triangles: Vec<[u32; 3]> = mesh.topology.triangles().collect();
        let parts = components(&mesh.topology);
        let all = self_intersections(&mesh.positions, &triangles, None, usize::MAX);
        let (of_one, of_two): (Vec<_>, Vec<_>) =
            all.into_iter().partition(|&pair| parts.are_joined(pair));
        let middle = |&[f, _]: &[u32; 2]| {
            let corners = triangles[f as usize].map(|v| mesh.positions[v as usize]);
            corners.iter().sum::<DVec3>() / 3.0
        };
        Self {
            vertices: mesh.vertex_count(),
            faces: mesh.face_count(),
            components: parts.count,
            loops: mesh.topology.boundary_loops().len(),
            self_intersections: of_one.len(),
            intersections_of_components: of_two.len(),
            folded_edges: folded_edges(&mesh.positions, &mesh.topology, FOLD_DEGREES.to_radians())
                .len(),
            place: of_one.first().map(middle),
        }
    }

    /// The counts in words.
    pub fn words(&self) -> String {
        let of_two = match self.intersections_of_components {
            0 => String::new(),
            count => format!(" and {count} between components"),
        };
        format!(
            "{}, {}, {}{of_two}, {}",
            counted(self.components, "component", "components"),
            counted(self.loops, "boundary loop", "boundary loops"),
            self.pairs(),
            counted(self.folded_edges, "folded edge", "folded edges"),
        )
    }

    /// The number of self-intersections in words.
    pub fn pairs(&self) -> String {
        counted(
            self.self_intersections,
            "pair of intersecting triangles",
            "pairs of intersecting triangles",
        )
    }
}

/// An operation of a repair and its result.
#[derive(Debug)]
pub struct RepairStep {
    /// The operation.
    pub operation: Operation,
    /// Its result.
    pub outcome: Outcome,
    /// Faces of the mesh before it that it erased.
    pub faces_erased: usize,
    /// New faces.
    pub faces_added: usize,
    /// Boundary edges before and after it.
    pub boundary_edges: [usize; 2],
}

impl RepairStep {
    /// That of an operation on a mesh.
    fn new(operation: Operation, mesh: &Mesh, outcome: Outcome) -> Self {
        let (before, after) = (mesh.face_count(), outcome.mesh().face_count());
        let faces_added = match outcome.filled() {
            Some(filled) => filled.faces_added(),
            None => after.saturating_sub(before),
        };
        Self {
            faces_erased: before + faces_added - after,
            faces_added,
            boundary_edges: [mesh, outcome.mesh()].map(|mesh| mesh.topology.boundary_edge_count()),
            operation,
            outcome,
        }
    }

    /// What was done, in words.
    pub fn words(&self) -> String {
        let erased = counted(self.faces_erased, "face", "faces");
        let holes = self.outcome.filled().map_or(0, |filled| filled.holes.len());
        let holes = counted(holes, "hole", "holes");
        let added = counted(self.faces_added, "face", "faces");
        match self.operation {
            Operation::Stitch(_) => {
                let [before, after] = self.boundary_edges;
                let closed = before.saturating_sub(after);
                let closed = counted(closed, "boundary edge", "boundary edges");
                format!("slits with {closed} stitched")
            }
            Operation::Clean(_) => format!("loose parts with {erased} removed"),
            Operation::Refill(_) => {
                format!("{erased} erased at damaged places; {holes} filled with {added}")
            }
            _ => format!("{holes} filled with {added}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes;

    fn mesh(parts: (Vec<DVec3>, Vec<[u32; 3]>)) -> Mesh {
        Mesh::from_triangles(parts.0, &parts.1).expect("a manifold")
    }

    /// Runs a repair. Returns the names of its operations and the mesh.
    fn repaired(mut mesh: Mesh, damage: DamageSpec) -> (Vec<&'static str>, Mesh) {
        let mut repair = Repair::new(CleanSpec::default(), damage, FlowSpec::default());
        let mut names = Vec::new();
        let mut step = |mesh: &Mesh| {
            let run = |operation: &Operation| operation.run(mesh, &|_, _| true);
            let step = repair.step(mesh, run, |error| panic!("{error}"));
            step.expect("repaired")
        };
        while let Some(step) = step(&mesh) {
            names.push(step.operation.command_name());
            mesh = step.outcome.into_mesh();
        }
        (names, mesh)
    }

    fn crossings(mesh: &Mesh) -> usize {
        let triangles: Vec<[u32; 3]> = mesh.topology.triangles().collect();
        self_intersections(&mesh.positions, &triangles, None, usize::MAX).len()
    }

    #[test]
    fn a_sphere_with_all_kinds_of_damage_becomes_a_sphere() {
        let ball = shapes::sphere(2000, 1);
        let (mut positions, mut triangles) = shapes::cut_where(&ball, |p| p.z > 0.9);
        // a vertex on the far side, and a loose triangle
        let spike = positions.iter().position(|p| p.x > 0.99).expect("a vertex");
        positions[spike] = DVec3::new(-1.2, 0.0, 0.0);
        let first = positions.len() as u32;
        positions.extend([2.0, 2.1, 2.2].map(|x| DVec3::new(x, 0.1 * x * x, 0.0)));
        triangles.push([first, first + 1, first + 2]);
        let given = mesh((positions, triangles));
        assert!(crossings(&given) > 0);
        let (names, after) = repaired(given.clone(), DamageSpec::default());
        assert_eq!(names, ["clean", "refill", "fill"]);
        assert_eq!(crossings(&after), 0);
        assert!(boundary_loops(&after).is_empty());
        assert!(
            after
                .positions
                .iter()
                .all(|p| (p.length() - 1.0).abs() < 0.01)
        );
        // what is left of the given vertices comes first and has its bits
        let mut kept = given.positions.iter();
        let own = after.positions.iter().take_while(|p| kept.any(|q| q == *p));
        assert!(own.count() > 1500);
        // nothing is left to repair
        assert!(repaired(after, DamageSpec::default()).0.is_empty());
    }

    #[test]
    fn components_that_cross_each_other_stay() {
        let (mut positions, mut triangles) = shapes::icosphere(6);
        let first = positions.len() as u32;
        let others: Vec<[u32; 3]> = triangles.iter().map(|t| t.map(|v| v + first)).collect();
        triangles.extend(others);
        let moved: Vec<DVec3> = positions.iter().map(|&p| p + 0.7 * DVec3::X).collect();
        positions.extend(moved);
        let both = mesh((positions, triangles));
        assert!(crossings(&both) > 0);
        assert!(repaired(both, DamageSpec::default()).0.is_empty());
    }

    #[test]
    fn folds_are_damage_if_wanted() {
        let (mut positions, triangles) = shapes::icosphere(12);
        let at = positions.iter().position(|p| p.x > 0.99).expect("a vertex");
        positions[at] = DVec3::new(0.97, 0.24, 0.0);
        let folded = mesh((positions, triangles));
        assert!(repaired(folded.clone(), DamageSpec::default()).0.len() <= 4);
        let spec = DamageSpec {
            folds: true,
            ..DamageSpec::default()
        };
        let (names, after) = repaired(folded, spec);
        assert_eq!(names.first(), Some(&"refill"));
        let folds = folded_edges(&after.positions, &after.topology, FOLD_DEGREES.to_radians());
        assert_eq!((folds.len(), crossings(&after)), (0, 0));
    }
}
