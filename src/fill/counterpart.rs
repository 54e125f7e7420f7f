//! Fills by symmetry: what is missing at a hole may exist elsewhere.
//!
//! The *counterpart* of a hole is the part of the mesh to which an approximate
//! [symmetry](crate::symmetry) takes the surroundings of the hole. Its shape, taken back to the hole, is
//! the [`Reference`] of the patch: the flow of `g2` keeps its variation of curvature and bends it
//! smoothly to fit the rim. The *share* of a counterpart scales the reference: 0 gives the fill without
//! it, 1 the whole counterpart. The share is the one of least error on the pseudo-holes of the hole.

use std::cell::Cell;
use std::sync::Arc;

use rayon::prelude::*;
use rustc_hash::FxHashMap;

use crate::fill::context::FillContext;
use crate::fill::patch_topology::PatchTopology;
use crate::fill::pseudo_hole::{Disc, Surroundings};
use crate::fill::surface_choice::Counterpart;
use crate::mesh::{
    ClosestPoint, DVec3, FaceId, Neighbourhood, Topology, VertexId, closest_point_from,
    vertex_normal, vertex_normals,
};
use crate::solver::{Flow, FlowProblem, G2_RINGS, Reference};
use crate::symmetry::{Isometry, Sample, alike, inside, smooth, symmetries};

/// The share of the vertices around a hole that counts in the fit of a symmetry.
const SHARE: f64 = 0.7;
/// Maximum number of vertices to which a symmetry is fitted around a hole, and of rounds.
const FITTED: [usize; 2] = [100, 8];
/// Those around a pseudo-hole, where the fit to the hole is a good start.
const FITTED_DISC: [usize; 2] = [30, 3];

/// A vertex of the mesh near a hole, and the face with the point nearest to its image under the symmetry
/// of the hole.
#[derive(Clone, Copy, Debug)]
pub(super) struct Image {
    sample: Sample,
    face: FaceId,
}

impl FillContext<'_> {
    /// The point of the mesh nearest to a point.
    fn closest(&self, to: DVec3) -> Option<ClosestPoint> {
        self.plan.obstacles.bvh(self.mesh).closest_point(to)
    }

    /// The point of the mesh nearest to a sample. A walk from a face nearby finds it; where that ends on a boundary,
    /// which it cannot cross, or on the other side of the surface, the whole mesh is searched.
    fn closest_from(&self, face: Option<FaceId>, to: &Sample) -> Option<ClosestPoint> {
        let walked = face.map(|face| closest_point_from(self.mesh, face, to.point));
        let walked = walked.filter(|found| alike(self.mesh, found, to).is_some());
        walked.or_else(|| self.closest(to.point))
    }

    /// The symmetries of the mesh.
    pub fn symmetries(&self) -> &[Isometry] {
        let all = &self.plan.symmetries;
        all.get_or_init(|| Arc::new(symmetries(self.mesh)))
    }

    /// Unit normals at the vertices of the mesh; 0 for none.
    fn normals(&self) -> &[DVec3] {
        let all = &self.plan.normals;
        all.get_or_init(|| {
            Arc::new(vertex_normals(
                &self.mesh.positions,
                self.mesh.topology.triangles(),
            ))
        })
    }

    /// A vertex of the mesh. `None` if it has no normal.
    fn sample(&self, v: VertexId) -> Option<Sample> {
        let normal = self.normals()[v.index()];
        let point = self.mesh.position(v);
        (normal != DVec3::ZERO).then_some(Sample { point, normal })
    }

    /// A symmetry fitted to at most [`FITTED`] of the surroundings of a hole, `vertices` of the mesh, and the median
    /// distance of their counterparts from them along the normals. `None` if fewer than half have a
    /// counterpart.
    pub fn fitted(&self, symmetry: &Isometry, vertices: &[VertexId]) -> Option<(Isometry, f64)> {
        let [most, rounds] = FITTED;
        let step = vertices.len().div_ceil(most).max(1);
        let vertices = vertices.iter().step_by(step);
        let samples: Vec<Sample> = vertices.filter_map(|&v| self.sample(v)).collect();
        // the faces found in the round before
        let faces = vec![Cell::new(None); samples.len()];
        let nearest = |i: usize, image: &Sample| {
            let found = self.closest_from(faces[i].get(), image)?;
            faces[i].set(Some(FaceId(found.face)));
            alike(self.mesh, &found, image)
        };
        let fit = symmetry.fitted(&samples, SHARE, rounds, nearest)?;
        let distance = fit.median(&samples, nearest)?;
        Some((fit, distance))
    }

    /// The share of points that have a counterpart.
    pub fn covered(&self, isometry: &Isometry, points: &[DVec3]) -> f64 {
        let closest = |&p: &DVec3| self.closest(isometry.apply(p));
        let found = points.iter().filter_map(closest);
        let found = found.filter(|found| inside(self.mesh, found).is_some());
        found.count() as f64 / points.len().max(1) as f64
    }

    /// The images of the vertices of some pseudo-holes under the symmetry of their hole, by the numbers of its
    /// surroundings.
    pub fn images(
        &self,
        isometry: &Isometry,
        surroundings: &Surroundings,
        discs: &[Disc],
    ) -> Vec<Option<Image>> {
        let mut is_used = vec![false; surroundings.vertices.len()];
        for &v in discs.iter().flat_map(|disc| &disc.vertices) {
            is_used[v as usize] = true;
        }
        let image = |(&v, is_used): (&VertexId, bool)| {
            let sample = is_used.then(|| self.sample(v)).flatten()?;
            let face = FaceId(self.closest(isometry.apply(sample.point))?.face);
            Some(Image { sample, face })
        };
        let vertices = surroundings.vertices.par_iter().with_min_len(64);
        vertices.zip(is_used).map(image).collect()
    }

    /// A symmetry fitted to at most [`FITTED_DISC`] of the vertices around a pseudo-hole. `None` if fewer than half
    /// have a counterpart.
    pub fn fitted_to_disc(
        &self,
        symmetry: &Isometry,
        images: &[Option<Image>],
    ) -> Option<Isometry> {
        let [most, rounds] = FITTED_DISC;
        let step = images.len().div_ceil(most).max(1);
        let images: Vec<&Image> = images.iter().step_by(step).flatten().collect();
        let samples: Vec<Sample> = images.iter().map(|image| image.sample).collect();
        symmetry.fitted(&samples, SHARE, rounds, |i, image| {
            let found = self.closest_from(Some(images[i].face), image)?;
            alike(self.mesh, &found, image)
        })
    }

    /// Where a sample would lie on its counterpart, taken back to it; `None` if the mesh has none. A walk finds
    /// it from a face near to it, which becomes the face on which it lies.
    fn counterpart(
        &self,
        isometry: &Isometry,
        of: &Sample,
        face: &mut Option<FaceId>,
    ) -> Option<DVec3> {
        let image = isometry.image(of);
        let found = self.closest_from(*face, &image)?;
        *face = Some(FaceId(found.face));
        Some(isometry.invert(smooth(self.mesh, self.normals(), &found, &image)?))
    }

    /// Where the vertex of an image would lie on its counterpart under a symmetry that is near to the one of the
    /// hole. `None` if the mesh has none.
    pub fn counterpart_of(&self, isometry: &Isometry, of: &Image) -> Option<DVec3> {
        self.counterpart(isometry, &of.sample, &mut Some(of.face))
    }

    /// The references of the patches of `topology` that have a counterpart, with the region at
    /// `positions` (relative to the centre of the problem). `faces` are those on which the counterparts of
    /// vertices lay before.
    pub fn references(
        &self,
        problem: &FlowProblem,
        topology: &PatchTopology,
        positions: &[DVec3],
        counterparts: &[Option<Counterpart>],
        faces: &mut Faces,
    ) -> Vec<Reference> {
        let all: Vec<u32> = (0..topology.new_vertices() as u32).collect();
        let own = topology.split(&all).map(|part| part.1);
        let pairs = own.zip(counterparts);
        let pairs = pairs.filter_map(|(own, counterpart)| Some((own, counterpart.as_ref()?)));
        pairs
            .enumerate()
            .map(|(number, (own, counterpart))| {
                self.reference(problem, positions, own, counterpart, number, faces)
            })
            .collect()
    }

    /// The reference of the patch whose new vertices are `own`, the one of this number with a counterpart, with
    /// the region at `positions` (relative to the centre of the problem).
    fn reference(
        &self,
        problem: &FlowProblem,
        positions: &[DVec3],
        own: &[u32],
        counterpart: &Counterpart,
        number: usize,
        faces: &mut Faces,
    ) -> Reference {
        let topology = problem.topology();
        let seeds = own.iter().map(|&v| VertexId(v));
        let near = Neighbourhood::small(topology, seeds, G2_RINGS);
        let mut at = |v: VertexId| {
            let normal = vertex_normal(topology, v, |v| positions[v.index()])?;
            let point = positions[v.index()] + problem.centre();
            let sample = Sample { point, normal };
            let face = faces.entry((number, v.0)).or_default();
            let there = self.counterpart(&counterpart.isometry, &sample, face)?;
            Some(there - problem.centre())
        };
        Reference {
            positions: near.vertices().iter().map(|&v| (v.0, at(v))).collect(),
            share: counterpart.share,
        }
    }
}

/// The faces of the mesh on which the counterparts of vertices of a region lie, if they were looked for, by the
/// number of the patch with a counterpart and that of the vertex.
pub(super) type Faces = FxHashMap<(usize, u32), Option<FaceId>>;

/// Movement of a vertex, relative to the hole radius, below which the references are not updated again,
/// and how often they are updated at most.
const SETTLED: f64 = 1e-3;
const UPDATES: usize = 5;

/// Updates of the references while a flow follows the counterparts of its holes.
#[derive(Clone, Debug, Default)]
pub(super) struct Following {
    /// The positions at the last update.
    before: Vec<DVec3>,
    updates: usize,
    /// The counterparts of the vertices at the last update, in the numbers of this region.
    faces: Faces,
    region: Option<Arc<Topology>>,
}

impl Following {
    /// Whether a flow has references.
    pub fn has_begun(&self) -> bool {
        self.updates > 0
    }

    /// Lets a flow that has converged continue with references for its present shape. Returns false
    /// without counterparts, and if the references would be practically the same as before.
    pub fn update(
        &mut self,
        context: FillContext<'_>,
        flow: &mut Flow,
        topology: &PatchTopology,
        counterparts: &[Option<Counterpart>],
    ) -> bool {
        let positions = flow.positions();
        let pairs = positions.iter().zip(&self.before);
        let moved = pairs.map(|(a, b)| a.distance(*b)).fold(0.0, f64::max);
        let is_settled =
            positions.len() == self.before.len() && moved < SETTLED * flow.problem().radius();
        let follows = counterparts.iter().any(Option::is_some);
        if !follows || is_settled || self.updates == UPDATES {
            return false;
        }
        self.before = positions.to_vec();
        self.updates += 1;
        let problem = flow.problem();
        let region = problem.topology();
        if self
            .region
            .as_ref()
            .is_none_or(|of| !Arc::ptr_eq(of, region))
        {
            self.region = Some(Arc::clone(region));
            self.faces.clear();
        }
        let faces = &mut self.faces;
        let references = context.references(problem, topology, positions, counterparts, faces);
        flow.set_references(references);
        true
    }
}

#[cfg(test)]
mod tests {
    use rayon::prelude::*;

    use super::*;
    use crate::fill::group_flow::GroupFlow;
    use crate::fill::prepare::prepare;
    use crate::fill::{FillOptions, Filled, RimSet, Symmetry, fill_rim_sets};
    use crate::mesh::{Mesh, TriangleBvh, boundary_loops};
    use crate::shapes;

    /// A body with bumps, symmetric to the plane x = 0, with and without a hole on one side.
    fn bodies() -> (Mesh, Mesh) {
        let (mut positions, triangles) = shapes::sphere(4000, 3);
        let is_missing = |p: DVec3| p.distance(DVec3::new(0.8, 0.4, 0.4).normalize()) < 0.35;
        let missing: Vec<bool> = positions.iter().map(|&p| is_missing(p)).collect();
        for p in &mut positions {
            let x = p.x.abs();
            let bumps =
                0.1 * (9.0 * p.y + 2.0 * x).sin() * (8.0 * x).cos() + 0.06 * (7.0 * p.z).sin();
            *p *= DVec3::new(1.0, 1.2, 1.5) * (1.0 + bumps);
        }
        let whole = Mesh::from_triangles(positions.clone(), &triangles).expect("a closed mesh");
        let keeps = |t: &&[u32; 3]| t.iter().all(|&v| !missing[v as usize]);
        let kept: Vec<[u32; 3]> = triangles.iter().filter(keeps).copied().collect();
        (
            whole,
            Mesh::from_triangles(positions, &kept).expect("a manifold"),
        )
    }

    fn filled(mesh: &Mesh, symmetry: Symmetry) -> Filled {
        let loops = boundary_loops(mesh);
        let chosen: Vec<RimSet<'_>> = loops.iter().map(|l| vec![l]).collect();
        let options = FillOptions {
            symmetry,
            ..FillOptions::default()
        };
        fill_rim_sets(mesh, &chosen, &options, &|_, _| true).expect("filled")
    }

    /// RMS distance of new vertices from the whole body.
    fn error(whole: &Mesh, new: &[DVec3]) -> f64 {
        let triangles: Vec<[u32; 3]> = whole.topology.triangles().collect();
        let truth = TriangleBvh::new(&whole.positions, &triangles);
        let distances = new.iter().filter_map(|&p| truth.closest_point(p));
        (distances.map(|c| c.distance.powi(2)).sum::<f64>() / new.len() as f64).sqrt()
    }

    #[test]
    fn a_flow_leaves_the_counterpart_when_symmetry_is_turned_off() {
        let (whole, broken) = bodies();
        let loops = boundary_loops(&broken);
        let options = FillOptions::default();
        let plan = prepare(&broken, &[vec![&loops[0]]], &[], &options).plan;
        let (mesh, plan) = (&broken, &plan);
        let context = FillContext { mesh, plan };
        let mut group = GroupFlow::start(context, 0, &options);
        let mut errors = Vec::new();
        for symmetry in [Symmetry::Auto, Symmetry::Off, Symmetry::Auto] {
            let options = FillOptions {
                symmetry,
                ..options.clone()
            };
            group.change(context, &options).expect("accepted");
            while group.attempt(context).is_some() {}
            assert_eq!(group.surface().model.symmetric, symmetry == Symmetry::Auto);
            errors.push(error(&whole, &group.positions()));
        }
        let [with, without, again] = errors[..] else {
            unreachable!("three runs")
        };
        assert!(with < 0.2 * without && again < 0.2 * without, "{errors:?}");
    }

    #[test]
    fn tasks_that_need_the_symmetries_at_once_do_not_wait_for_each_other() {
        let (_, broken) = bodies();
        let loops = boundary_loops(&broken);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(8).build();
        let pool = pool.expect("a thread pool");
        for _ in 0..20 {
            let plan = prepare(&broken, &[vec![&loops[0]]], &[], &FillOptions::default()).plan;
            let (mesh, plan) = (&broken, &plan);
            let context = FillContext { mesh, plan };
            // idle threads would take over parts of the search, and the thread that searches would wait for them
            let task = |i: usize| {
                if i.is_multiple_of(2) {
                    assert_eq!(context.symmetries().len(), 1);
                }
            };
            pool.install(|| (0..32).into_par_iter().for_each(task));
        }
    }

    #[test]
    fn what_is_missing_is_taken_from_the_other_side() {
        let (whole, broken) = bodies();
        let error = |result: &Filled| {
            let new = &result.mesh.positions[broken.vertex_count()..];
            error(&whole, new)
        };
        let [with, without] = [Symmetry::Auto, Symmetry::Off].map(|s| filled(&broken, s));
        let surface = |result: &Filled| {
            let group = result.groups[0].as_ref().expect("a flow");
            group.surface.clone()
        };
        assert!(surface(&with).model.symmetric);
        assert!(!surface(&without).model.symmetric);
        assert!(surface(&with).expected_error() < surface(&without).expected_error());
        let [with, without] = [&with, &without].map(error);
        assert!(with < 0.2 * without, "{with} {without}");
    }
}
