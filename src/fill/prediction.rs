//! Choice of a surface model by prediction: how well would each model restore parts of the mesh
//! around a hole that are known?
//!
//! A *pseudo-hole* is a disc of vertices of the mesh near the hole. Each candidate computes the
//! disc from its surroundings, on the existing triangles and in their metric. The error of a
//! candidate is the RMS of the distances along the normals, relative to the radius of the disc. The
//! candidate with the least error over all discs is chosen. The error to expect of the fill, relative to
//! the hole radius, is that error, scaled by how much more the rim of the hole turns than those of the
//! discs.

use std::ops::RangeInclusive;

use rayon::prelude::*;
use rustc_hash::FxHashMap;

use crate::cancel::is_cancelled;
use crate::energy::Order;
use crate::fill::context::FillContext;
use crate::fill::hole::PlannedHole;
use crate::fill::options::Symmetry;
use crate::fill::pseudo_hole::{Disc, FAILED, Surroundings};
use crate::fill::restored::Restored;
use crate::fill::surface_choice::{
    CANDIDATES, Candidate, ENERGIES, OwnErrors, Prediction, SMOOTH, TENSIONS, candidates,
};
use crate::fill::symmetric_errors::SymmetricErrors;
use crate::mesh::{DVec3, HalfedgeId, Mesh, Neighbourhood, VertexId};
use crate::solver::{
    FlowOptions, FlowProblem, Mode, SUPPORT_RINGS, StepRequest, SurfaceModel, scheme_stepper,
};

/// Number of pseudo-holes on which the energies, the most expensive candidates, are tried first of all. If
/// they are not chosen, their errors on all are estimated by the ratio to the best other candidate on
/// these.
const ENERGY_DISCS: usize = 2;
/// Error of the best other candidate on the first pseudo-holes above which `energy` is not tried. Where
/// `energy` is chosen, the others have errors below a third of [`SMOOTH`] (measured on `analytic/`).
const HOPELESS: f64 = 2.0 * SMOOTH;
/// Error of `energy` up to which no symmetry is looked for, and error to expect of it up to which no
/// other energy is tried.
const EXACT: f64 = 1e-3;
/// New vertices of a hole for which the second is tried. In smaller ones the errors are those of the triangles. It
/// takes three times the memory of the first.
const VARIED: RangeInclusive<usize> = 40..=4000;
/// Maximum turning of the rim of such a hole: as on a cap of 60° of a sphere. At the end of a tube, whose rim turns
/// by 1, the surface of least variation is far from that of the pseudo-holes.
const MAX_TURNING: f64 = 0.5;
/// Variation of the mean curvature over the pseudo-holes up to which it counts as constant: `H²` is then the
/// better energy, which is exact on spheres.
const CONSTANT: f64 = 0.05;
impl Prediction {
    /// Predicts for the holes of a group. `flow` has the energy of the candidate `Energy`. Without
    /// candidates if there is no room for a pseudo-hole around any of the holes.
    pub(super) fn new(
        context: FillContext<'_>,
        group: usize,
        flow: &FlowOptions,
        symmetry: Symmetry,
    ) -> Self {
        let alone = context.plan.groups[group].holes.len() == 1;
        let holes: Vec<&PlannedHole> = context.plan.holes_of(group).collect();
        let predicted = holes
            .par_iter()
            .map(|hole| HolePrediction::new(context, hole, flow, symmetry, alone));
        let predicted: Vec<Option<HolePrediction>> = predicted.collect();
        // squared errors in the unit of the mesh, weighted by the new vertices of the holes
        let mut sums = [0.0; CANDIDATES];
        let mut symmetric_sums = [0.0; TENSIONS.len()];
        let (mut extent, mut turning, mut count) = (0.0, 0.0, 0);
        for (hole, one) in holes.iter().zip(&predicted) {
            let Some(one) = one else { continue };
            count += one.discs;
            let radius = hole.rims.radius();
            let weight = hole.patch.new_points().len() as f64 * radius * radius;
            extent += weight;
            turning += weight * one.turning_ratio;
            for (sum, error) in sums.iter_mut().zip(one.errors) {
                *sum += weight * error;
            }
            for (k, sum) in symmetric_sums.iter_mut().enumerate() {
                let symmetric = one.symmetric.as_ref();
                *sum += weight * one.errors[k] * symmetric.map_or(1.0, |s| s.ratio(k));
            }
        }
        let root = |sum: f64| (sum / extent).sqrt();
        let errors = candidates().zip(sums.map(root));
        let mut errors: Vec<_> = errors.filter(|e| e.1.is_finite()).collect();
        // the tension is that of the fill without symmetry: holes of the group may have no counterpart
        let best = |&i: &usize, &j: &usize| sums[i].total_cmp(&sums[j]);
        let best = (0..TENSIONS.len()).min_by(best).unwrap_or(0);
        let counterpart =
            |one: &Option<HolePrediction>| one.as_ref()?.symmetric.as_ref()?.counterpart(best);
        let counterparts: Vec<_> = predicted.iter().map(counterpart).collect();
        if counterparts.iter().any(Option::is_some) {
            let candidate = Candidate {
                symmetric: true,
                ..Candidate::new(SurfaceModel::G2, TENSIONS[best])
            };
            errors.push((candidate, root(symmetric_sums[best])));
        }
        let own = |(hole, one): (&&PlannedHole, &Option<HolePrediction>)| {
            let one = one.as_ref()?;
            let plain = one.errors.map(|error| (error * one.turning_ratio).sqrt());
            let ratio = one.symmetric.as_ref().map_or(1.0, |s| s.ratio(best));
            let errors = OwnErrors {
                plain,
                symmetric: plain[best] * ratio.sqrt(),
            };
            Some((hole.rims.id(), errors))
        };
        Self {
            of_holes: holes.iter().zip(&predicted).filter_map(own).collect(),
            errors,
            discs: count,
            scale: if extent > 0.0 { root(turning) } else { 1.0 },
            varies: predicted.iter().flatten().all(|one| one.varies),
            counterparts,
        }
    }
}

/// Height of a face over the length of its rim edge above which it is a needle.
const NEEDLE: f64 = 6.0;
/// The model beside needles.
const BESIDE_NEEDLES: Candidate = Candidate::new(SurfaceModel::G2, 30.0);

/// The model of a group without a prediction, if most faces at its rims are needles: long strips as CAD programs
/// write them. Their limit surfaces do not determine the curvatures across the rim. With an energy of these the
/// patch grows without bound.
pub(super) fn beside_needles(context: FillContext<'_>, group: usize) -> Option<Candidate> {
    let (mesh, topology) = (context.mesh, &context.mesh.topology);
    let rims = context
        .plan
        .holes_of(group)
        .flat_map(|hole| &hole.rims.loops);
    let is_needle = |h: &HalfedgeId| {
        let [a, b, apex] = mesh.corners(topology.face(h.twin()));
        let along = mesh.position(topology.target(*h)) - mesh.position(topology.origin(*h));
        (b - a).cross(apex - a).length() > NEEDLE * along.length_squared()
    };
    let (mut needles, mut all) = (0, 0);
    for h in rims.flat_map(|rim| &rim.halfedges) {
        needles += usize::from(is_needle(h));
        all += 1;
    }
    (2 * needles > all).then_some(BESIDE_NEEDLES)
}

/// What was predicted for one hole.
struct HolePrediction {
    /// Squared errors of the candidates, relative to the radius of the pseudo-holes.
    errors: [f64; CANDIDATES],
    symmetric: Option<SymmetricErrors>,
    discs: usize,
    turning_ratio: f64,
    varies: bool,
}

impl HolePrediction {
    /// `None` if there is no room for a pseudo-hole, or if the run was cancelled.
    fn new(
        context: FillContext<'_>,
        hole: &PlannedHole,
        flow: &FlowOptions,
        symmetry: Symmetry,
        alone: bool,
    ) -> Option<Self> {
        if is_cancelled() {
            return None;
        }
        let surroundings = Surroundings::new(context.mesh, &hole.rims);
        if surroundings.discs.is_empty() {
            return None;
        }
        let new = hole.patch.new_points().len();
        let is_varied = VARIED.contains(&new) && surroundings.turning <= MAX_TURNING;
        let count = 1 + usize::from(is_varied);
        let energies = &ENERGIES[..count];
        let (errors, restored) = mean_squares(context.mesh, &surroundings, flow, energies, alone);
        let discs = restored.len();
        let is_exact = errors[TENSIONS.len()] <= EXACT * EXACT;
        let symmetric = (symmetry == Symmetry::Auto && !is_exact)
            .then(|| {
                let errors = &errors[..TENSIONS.len()];
                SymmetricErrors::least(context, hole, &surroundings, restored, errors)
            })
            .flatten();
        Some(Self {
            errors,
            symmetric,
            discs,
            turning_ratio: surroundings.turning_ratio(),
            varies: surroundings.curvature_variation() > CONSTANT,
        })
    }
}

/// Mean over the discs, at least one, of the squared error of each candidate, and the discs that were
/// computed: if one of the `energies`, the first of [`ENERGIES`], is good on the first ones and the hole is
/// `alone` in its group, no others are needed. The error of a candidate that was not tried is infinite.
pub fn mean_squares(
    mesh: &Mesh,
    surroundings: &Surroundings,
    flow: &FlowOptions,
    energies: &[Candidate],
    alone: bool,
) -> ([f64; CANDIDATES], Vec<Restored>) {
    let discs = &surroundings.discs;
    let (first, others) = discs.split_at(discs.len().min(ENERGY_DISCS));
    let best_of =
        |means: &[f64]| (0..TENSIONS.len()).min_by(|&i, &j| means[i].total_cmp(&means[j]));
    let mut means = [f64::INFINITY; CANDIDATES];
    let average = |means: &mut [f64], restored: &[Restored]| {
        for (k, mean) in means[..TENSIONS.len()].iter_mut().enumerate() {
            let errors = restored
                .iter()
                .zip(discs)
                .map(|(one, disc)| one.error(disc, k));
            *mean = errors.sum::<f64>() / restored.len() as f64;
        }
    };
    let mut restored = Restored::all(surroundings, first);
    average(&mut means, &restored);
    if best_of(&means).is_some_and(|k| means[k] <= HOPELESS * HOPELESS) {
        for (mean, &candidate) in means[TENSIONS.len()..].iter_mut().zip(energies) {
            let error = |disc: &Disc| disc.energy_error(mesh, surroundings, flow, candidate);
            let errors: Vec<f64> = first.par_iter().map(error).collect();
            *mean = errors.iter().sum::<f64>() / first.len() as f64;
            // the next candidate cannot be chosen
            let expected = *mean * surroundings.turning_ratio();
            if *mean > SMOOTH * SMOOTH || expected <= EXACT * EXACT {
                break;
            }
        }
        let is_good = means[TENSIONS.len()..]
            .iter()
            .any(|mean| *mean <= SMOOTH * SMOOTH);
        if alone && is_good {
            return (means, restored);
        }
    }
    restored.extend(Restored::all(surroundings, others));
    let of_first = means;
    average(&mut means, &restored);
    if let Some(k) = best_of(&means) {
        let growth = means[k] / of_first[k];
        let energies = means[TENSIONS.len()..].iter_mut();
        for energy in energies.filter(|mean| **mean > SMOOTH * SMOOTH) {
            *energy *= growth;
        }
    }
    (means, restored)
}

impl Disc {
    /// Squared error of one of [`ENERGIES`], relative to the radius: that of one long step from the true
    /// positions.
    fn energy_error(
        &self,
        mesh: &Mesh,
        surroundings: &Surroundings,
        flow: &FlowOptions,
        candidate: Candidate,
    ) -> f64 {
        let mut options = flow.clone();
        candidate.apply(&mut options);
        options.mode = Mode::Fast;
        let energy = options.energy_at(self.radius);
        let problem = (!is_cancelled()).then(|| self.problem(mesh, surroundings));
        let Some(problem) = problem.flatten() else {
            return FAILED;
        };
        let Ok(mut stepper) = scheme_stepper(&problem, &options, &energy) else {
            return FAILED;
        };
        let natural_time = match options.order() {
            Order::Sixth => SurfaceModel::G2.natural_time(self.radius),
            _ => SurfaceModel::Energy.natural_time(self.radius),
        };
        let tau = LONG * natural_time;
        let attempt = stepper.attempt(&StepRequest {
            tau,
            next_tau: tau,
            may_freeze: true,
        });
        if !attempt.is_accepted() {
            return FAILED;
        }
        let pairs = stepper.state().positions.iter().zip(problem.positions());
        let distances = pairs
            .zip(&self.normals)
            .map(|((reached, given), n)| (*reached - *given).dot(*n));
        self.mean_square(distances)
    }

    /// The disc as a problem whose starting positions are the true ones.
    fn problem(&self, mesh: &Mesh, surroundings: &Surroundings) -> Option<FlowProblem> {
        let moving = self.vertices[..self.ends[0]]
            .iter()
            .map(|&v| surroundings.vertices[v as usize]);
        let rings = usize::from(SUPPORT_RINGS);
        let region = Neighbourhood::small(&mesh.topology, moving, rings);
        let numbered = region.vertices().iter().copied().zip(0..);
        let local: FxHashMap<VertexId, u32> = numbered.collect();
        let positions = region.vertices().iter().map(|&v| mesh.position(v));
        let positions: Vec<DVec3> = positions.collect();
        let faces = region.faces.iter().map(|&f| mesh.topology.face_vertices(f));
        let triangles: Vec<[u32; 3]> = faces.map(|t| t.map(|v| local[&v])).collect();
        let interior: Vec<u32> = (0..self.normals.len() as u32).collect();
        FlowProblem::new(&positions, &triangles, &interior, self.radius).ok()
    }
}

/// Time step of a prediction over the natural time: practically stationary.
const LONG: f64 = 1e9;

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    use crate::fill::{FillOptions, GroupSurface, RimSet, fill_rim_sets};
    use crate::mesh::boundary_loops;
    use crate::shapes;

    /// Fills the loops but outer boundaries.
    fn filled(mesh: &Mesh, options: &FillOptions) -> (GroupSurface, Mesh) {
        let loops = boundary_loops(mesh);
        let holes = loops.iter().filter(|l| !l.is_outer_boundary);
        let chosen: Vec<RimSet<'_>> = holes.map(|l| vec![l]).collect();
        let filled = fill_rim_sets(mesh, &chosen, options, &|_, _| true).expect("filled");
        let group = filled.groups[0].as_ref().expect("a flow");
        (group.surface.clone(), filled.mesh)
    }

    fn mesh(parts: (Vec<DVec3>, Vec<[u32; 3]>)) -> Mesh {
        Mesh::from_triangles(parts.0, &parts.1).expect("a manifold")
    }

    #[test]
    fn a_sphere_is_filled_by_the_energy_and_the_expected_error_is_met() {
        let sphere = mesh(shapes::cut_where(&shapes::icosphere(24), |p| p.z > 0.7));
        let (surface, result) = filled(&sphere, &FillOptions::default());
        assert_eq!(surface.model, Candidate::new(SurfaceModel::Energy, 0.0));
        let expected = surface.expected_error().expect("a prediction");
        let prediction = surface.prediction.as_deref();
        assert_eq!(prediction.map(|p| p.discs), Some(ENERGY_DISCS));
        let radius = (1.0f64 - 0.7 * 0.7).sqrt();
        let new = &result.positions[sphere.vertex_count()..];
        let squares = new.iter().map(|p| (p.length() - 1.0).powi(2));
        let error = (squares.sum::<f64>() / new.len() as f64).sqrt() / radius;
        // measured: 2.0e-4, expected 3.9e-5
        assert!(
            error < 10.0 * expected && expected < 10.0 * error,
            "{error:e} {expected:e}"
        );
        // the positions are bit-identical to those of the energy alone
        let options = FillOptions {
            predicts_surface: false,
            ..FillOptions::default()
        };
        assert_eq!(filled(&sphere, &options).1.positions, result.positions);
    }

    /// Two holes of one group, one of them with noise on its other side.
    #[test]
    fn each_hole_has_the_error_of_its_own_surroundings() {
        let is_hole = |p: DVec3| (p.x.abs() - 0.5).hypot(p.y) < 0.4;
        let (mut positions, triangles) = shapes::cut_where(&shapes::plane(4.0, 60, 1), is_hole);
        for (i, p) in positions.iter_mut().enumerate().filter(|(_, p)| p.x > 0.95) {
            p.z += 0.02 * (1e3 * i as f64).sin();
        }
        let plane = mesh((positions, triangles));
        let loops = boundary_loops(&plane);
        let (surface, _) = filled(&plane, &FillOptions::default());
        let holes = loops.iter().filter(|l| !l.is_outer_boundary);
        let errors: Vec<(f64, f64)> = holes
            .map(|hole| {
                let error = surface.expected_error_of(hole.id);
                (hole.centroid.x, error.expect("a prediction"))
            })
            .collect();
        let of = |side: f64| errors.iter().find(|e| e.0 * side > 0.0).expect("a hole").1;
        let of_holes = surface.prediction.as_ref().map(|p| p.of_holes.len());
        assert_eq!(of_holes, Some(2));
        // one is flat, and the other not
        assert!(of(-1.0) < 1e-9 && of(1.0) > 1e-3, "{errors:?}");
    }

    #[test]
    fn noise_makes_a_vector_flow_the_better_model() {
        let (mut positions, triangles) = shapes::cut_where(&shapes::sphere(2000, 1), |p| p.z > 0.9);
        for (i, p) in positions.iter_mut().enumerate() {
            *p *= 1.0 + 0.02 * (1e3 * i as f64).sin();
        }
        let sphere = mesh((positions, triangles));
        let (surface, _) = filled(&sphere, &FillOptions::default());
        assert_ne!(surface.model.surface, SurfaceModel::Energy);
        let prediction = surface.prediction.as_deref().expect("a prediction");
        assert!(prediction.discs >= 5);
        // the others are so bad that the energy is not tried
        let is_energy = |e: &(Candidate, f64)| e.0.surface == SurfaceModel::Energy;
        assert!(!prediction.errors.iter().any(is_energy));
        let least = prediction
            .errors
            .iter()
            .map(|e| e.1)
            .fold(f64::INFINITY, f64::min);
        let expected = prediction.scale * least;
        assert_eq!(surface.expected_error(), Some(expected));
        // the group is one hole
        let hole = boundary_loops(&sphere)[0].id;
        let own = surface.expected_error_of(hole).expect("a prediction");
        assert!(
            (own - expected).abs() < 1e-12 * expected,
            "{own} {expected}"
        );
    }

    #[test]
    fn a_saddle_is_filled_by_the_variation_of_the_mean_curvature() {
        let saddle = shapes::graph(2.0, 46, |x, y| x * x - y * y, 1);
        let (positions, triangles) = shapes::cut_where(&saddle, |p| p.x.hypot(p.y) < 0.54);
        let options = FillOptions {
            symmetry: Symmetry::Off,
            ..FillOptions::default()
        };
        let of = |scale: f64| {
            let positions = positions.iter().map(|&p| scale * p).collect();
            filled(&mesh((positions, triangles.clone())), &options)
        };
        let (surface, result) = of(1.0);
        assert_eq!(surface.model, ENERGIES[1]);
        assert_eq!(surface.model.words(), "energy gradH2");
        assert!(!surface.model.uses_energy());
        let new = &result.positions[positions.len()..];
        let squares = new.iter().map(|p| (p.z - p.x * p.x + p.y * p.y).powi(2));
        let error = (squares.sum::<f64>() / new.len() as f64).sqrt() / 0.54;
        let expected = surface.expected_error().expect("a prediction");
        assert!(
            error < 2.0 * expected && expected < 4.0 * error,
            "{error:e} {expected:e}"
        );
        // with another unit of length
        let (scaled, _) = of(1e6);
        let errors =
            |surface: &GroupSurface| surface.prediction.as_ref().expect("there").errors.clone();
        for (one, other) in errors(&surface).iter().zip(errors(&scaled)) {
            assert_eq!(one.0, other.0);
            assert!((one.1 - other.1).abs() < 1e-3 * one.1, "{one:?} {other:?}");
        }
    }

    #[test]
    fn without_surroundings_the_energy_is_used_without_a_prediction() {
        // a band of two rings of triangles around the hole
        let band = shapes::cut_where(&shapes::sphere(500, 1), |p| p.z > 0.8 || p.z < 0.5);
        let band = mesh(band);
        let (surface, _) = filled(&band, &FillOptions::default());
        assert_eq!(surface.model, Candidate::new(SurfaceModel::Energy, 0.0));
        assert_eq!(surface.expected_error(), None);
    }

    #[test]
    fn beside_long_strips_a_vector_flow_is_used() {
        // a closed tube of two rows of strips, open at the lower end
        let tube = |sectors: u32| {
            let mut positions: Vec<DVec3> = (0..3 * sectors)
                .map(|i| {
                    let angle = std::f64::consts::TAU * f64::from(i % sectors) / f64::from(sectors);
                    DVec3::new(angle.cos(), angle.sin(), -f64::from(i / sectors))
                })
                .collect();
            positions.push(DVec3::ZERO);
            let rows = (0..2 * sectors).flat_map(|a| {
                let b = a - a % sectors + (a + 1) % sectors;
                [[a, a + sectors, b], [b, a + sectors, b + sectors]]
            });
            let cap = (0..sectors).map(|i| [3 * sectors, i, (i + 1) % sectors]);
            mesh((positions, rows.chain(cap).collect()))
        };
        let (surface, _) = filled(&tube(32), &FillOptions::default());
        assert_eq!(surface.model, Candidate::new(SurfaceModel::Energy, 0.0));
        for sectors in [64, 128] {
            let tube = tube(sectors);
            let (surface, result) = filled(&tube, &FillOptions::default());
            assert_eq!(
                (surface.model, surface.expected_error()),
                (BESIDE_NEEDLES, None)
            );
            let new = &result.positions[tube.positions.len()..];
            let is_near = |p: &DVec3| (-3.0..-1.9).contains(&p.z) && p.x.hypot(p.y) < 1.1;
            assert!(new.len() > 500 && new.iter().all(is_near));
        }
    }

    #[test]
    fn energy_is_chosen_on_smooth_surfaces() {
        let chosen = |g2: f64, energy: f64| {
            let errors = vec![
                (Candidate::new(SurfaceModel::G2, 0.0), g2),
                (Candidate::new(SurfaceModel::Energy, 0.0), energy),
            ];
            let prediction = Prediction {
                of_holes: BTreeMap::new(),
                errors,
                discs: 9,
                scale: 1.0,
                varies: true,
                counterparts: Vec::new(),
            };
            prediction.chosen().map(|c| c.0.surface)
        };
        assert_eq!(chosen(1e-4, 9e-3), Some(SurfaceModel::Energy));
        assert_eq!(chosen(0.02, 0.015), Some(SurfaceModel::G2));
        assert_eq!(chosen(0.04, 0.019), Some(SurfaceModel::G2));
    }
}
