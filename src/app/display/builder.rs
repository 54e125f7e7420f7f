//! Builds the display of a mesh and a state. Unchanged parts are reused.

use std::ops::Range;
use std::sync::Arc;

use super::look::{Look, LookKey};
use super::{Continued, Display, Request, same_list};
use crate::app::cached::Cached;
use crate::app::report::Reference;
use crate::app::run::RunState;
use crate::app::seam::seam;
use crate::energy::{WellPosed, scan_well_posedness};
use crate::mesh::{DVec3, FaceId, Mesh, Neighbourhood, Topology, VertexId};
use crate::render::{Bounds, DynamicSurface, Evaluation, Geometry, SurfaceOptions, Vertex};

/// Rings of faces around a patch that are drawn as limit surface, like the patch.
const LIMIT_RINGS: usize = 3;
/// A closed mesh with at most this many faces is drawn entirely as limit surface.
const SMALL: usize = 20_000;
/// Symbols below this, relative to their scale, count as zero, because drawn curvatures have single
/// precision.
const SINGLE: f64 = 1e-5;

/// Data that is reused from one request to the next.
#[derive(Default)]
pub(super) struct DisplayBuilder {
    split: Option<Split>,
    still: Cached<StillKey, Arc<Geometry>>,
    /// The mesh that the distances in `still` refer to.
    reference: Option<Arc<Reference>>,
    /// The last display and its request.
    last: Option<(Request, Display)>,
}

/// The faces of a mesh, split into those drawn as limit surface and the others.
struct Split {
    topology: TopologyKey,
    creases: Arc<Vec<[VertexId; 2]>>,
    first_patch_face: usize,
    newest: Range<usize>,
    faired: Arc<Vec<u32>>,
    original: bool,
    look_key: LookKey,
    look: Look,
    moving: DynamicSurface,
    moving_faces: Vec<FaceId>,
    still: Vec<FaceId>,
}

/// Keeps the value alive, so that its address is not reused.
enum TopologyKey {
    Mesh(Arc<Mesh>),
    State(Arc<Topology>),
}

impl TopologyKey {
    fn of(request: &Request) -> Self {
        request.state.as_ref().map_or_else(
            || Self::Mesh(Arc::clone(&request.mesh)),
            |state| Self::State(Arc::clone(state.topology())),
        )
    }

    fn same(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Mesh(a), Self::Mesh(b)) => Arc::ptr_eq(a, b),
            (Self::State(a), Self::State(b)) => Arc::ptr_eq(a, b),
            _ => false,
        }
    }

    fn topology(&self) -> &Topology {
        match self {
            Self::Mesh(mesh) => &mesh.topology,
            Self::State(topology) => topology,
        }
    }
}

/// The key of the static part of a surface, for one split.
#[derive(Clone, Copy, PartialEq)]
struct StillKey {
    faces: usize,
    vertices: usize,
    limit: bool,
    centre: DVec3,
}

impl DisplayBuilder {
    /// Builds the display of a request.
    pub(super) fn build(&mut self, request: &Request) -> Display {
        let mut display = match self.last.take() {
            Some((asked, display)) if asked.same_surfaces(request) => display,
            _ => self.surfaces(request),
        };
        display.highlights = match &self.split {
            Some(split) if !request.highlight.is_empty() => {
                split.highlights(&display.surfaces, &request.highlight)
            }
            _ => Vec::new(),
        };
        self.last = Some((request.clone(), display.clone()));
        display
    }

    /// Whether the first patches of a run would be drawn only when images are read, which may take seconds.
    pub(super) fn waits_for_images(&self, request: &Request) -> bool {
        let drawn = self.last.as_ref().map(|(asked, _)| asked);
        let is_drawn = |r: &Request| r.state.is_some() && Arc::ptr_eq(&r.mesh, &request.mesh);
        let has_patches = request
            .state
            .as_ref()
            .is_some_and(|s| s.patch_faces().is_some());
        let is_wanted = request.continued != Continued::No && !request.textures.is_empty();
        has_patches && is_wanted && !drawn.is_some_and(is_drawn)
    }

    fn surfaces(&mut self, request: &Request) -> Display {
        let key = TopologyKey::of(request);
        let fits = self.split.as_ref().is_some_and(|s| {
            s.topology.same(&key)
                && Arc::ptr_eq(&s.creases, &request.creases)
                && s.first_patch_face == request.first_patch_face
                && s.newest == request.newest
                && same_list(&s.faired, &request.faired)
                && s.original == request.original
                && s.look_key.fits(request)
        });
        if !fits {
            self.split = Some(Split::new(key, request));
            self.still = Cached::default();
        }
        let reference = request.reference.as_ref();
        if self.reference.as_ref().map(Arc::as_ptr) != reference.map(Arc::as_ptr) {
            self.reference = reference.cloned();
            self.still = Cached::default();
        }
        let distance = reference.map(|r| |p: DVec3| r.signed_distance(p));
        let distance = distance
            .as_ref()
            .map(|f| f as &(dyn Fn(DVec3) -> f64 + Sync));
        let Some(split) = &mut self.split else {
            unreachable!("made above");
        };
        let topology = split.topology.topology();
        let limit = request.limit && request.state.as_ref().is_none_or(|s| s.has_limit());
        let place = |state: &RunState| state.positions(!limit);
        let state = request.state.as_ref();
        let positions = state.map_or_else(|| request.mesh.positions.clone(), place);
        let start = request
            .start
            .as_ref()
            .map(place)
            .filter(|p| p.len() == positions.len());

        let mut surfaces = Vec::new();
        if !split.still.is_empty() {
            let key = StillKey {
                faces: split.still.len(),
                vertices: positions.len(),
                limit,
                centre: request.centre,
            };
            let look = &mut split.look;
            let has_textures = !request.textures.is_empty();
            surfaces.push(self.still.get(key, || {
                // they are large and not kept beside what is made of them
                let textures = look.textures.take();
                let again = || Look::new(request, topology).textures;
                let options = SurfaceOptions {
                    samples_per_edge: Some(1),
                    textures: textures.or_else(|| has_textures.then(again).flatten()),
                    face_colors: Arc::clone(&look.face_colors),
                    ..SurfaceOptions::default()
                };
                let still = DynamicSurface::new(topology, &split.still, &options);
                drop(options);
                let evaluation = Evaluation {
                    centre: request.centre,
                    limit,
                    distance,
                    colors: &look.colors,
                    ..Evaluation::default()
                };
                Arc::new(still.evaluate_with(&positions, &evaluation))
            }));
        }
        let posed_at = request.energy.as_ref().map(|(energy, radius)| {
            let radius = *radius;
            move |h: f64, k: f64| {
                let scan = scan_well_posedness(energy, &[[h, k]], radius, SINGLE);
                scan.worst.is_some_and(|w| w.class >= WellPosed::IllPosed)
            }
        });
        let ill_posed = posed_at
            .as_ref()
            .map(|f| f as &(dyn Fn(f64, f64) -> bool + Sync));
        if !split.moving_faces.is_empty() {
            let moving = split.moving.evaluate_with(
                &positions,
                &Evaluation {
                    centre: request.centre,
                    limit,
                    start: start.as_deref(),
                    distance,
                    colors: &split.look.colors,
                    ill_posed,
                },
            );
            surfaces.push(Arc::new(moving));
        }
        let posed = request.energy.as_ref().map(|(energy, radius)| {
            scan_well_posedness(energy, &curvatures(surfaces.last()), *radius, SINGLE)
        });
        let bounds = Bounds::of(positions.iter().copied()).unwrap_or(request.bounds);
        let first = request.mesh.face_count();
        let seam = state
            .is_some_and(|state| state.patch_faces().is_some())
            .then(|| {
                seam(
                    topology,
                    &positions,
                    first,
                    &request.faired,
                    &request.creases,
                )
            });
        Display {
            surfaces,
            highlights: Vec::new(),
            bounds,
            posed,
            seam,
        }
    }
}

/// Mean and Gaussian curvatures at a limited number of vertices of a geometry.
fn curvatures(geometry: Option<&Arc<Geometry>>) -> Vec<[f64; 2]> {
    let Some(geometry) = geometry else {
        return Vec::new();
    };
    let known = |v: &&Vertex| v.flags & Vertex::CURVATURE != 0;
    let stride = geometry.vertices.len().div_ceil(4096).max(1);
    geometry
        .vertices
        .iter()
        .step_by(stride)
        .filter(known)
        .map(|v| [f64::from(v.mean), f64::from(v.gauss)])
        .collect()
}

impl Split {
    fn new(key: TopologyKey, request: &Request) -> Self {
        let topology = key.topology();
        let first = request.first_patch_face;
        let count = topology.face_count();
        let is_faired = |f: FaceId| request.faired.binary_search(&f.0).is_ok();
        let flows = |f: FaceId| f.index() >= first || is_faired(f);
        let all = topology.faces();
        let whole = request
            .state
            .as_ref()
            .is_some_and(|s| s.patch_faces().is_none());
        let (moving, still): (Vec<FaceId>, Vec<FaceId>) = if !request.original && !whole {
            (all.filter(|&f| flows(f)).collect(), Vec::new())
        } else if count <= SMALL || whole {
            (all.collect(), Vec::new())
        } else {
            around(topology, &flows, LIMIT_RINGS)
        };
        let flag = |&f: &FaceId| {
            if whole || !flows(f) {
                0
            } else if request.newest.contains(&f.index()) || is_faired(f) {
                Vertex::PATCH | Vertex::NEWEST
            } else {
                Vertex::PATCH
            }
        };
        let mut look = Look::new(request, topology);
        let options = SurfaceOptions {
            samples_per_edge: None,
            creases: request.creases.to_vec(),
            is_cut: request.state.as_ref().is_some_and(|s| s.is_cut()),
            flags: moving.iter().map(flag).collect(),
            textures: look.textures.clone(),
            face_colors: Arc::clone(&look.face_colors),
        };
        if still.is_empty() {
            look.textures = None;
        }
        Self {
            moving: DynamicSurface::new(topology, &moving, &options),
            moving_faces: moving,
            still,
            creases: Arc::clone(&request.creases),
            first_patch_face: first,
            newest: request.newest.clone(),
            faired: Arc::clone(&request.faired),
            original: request.original,
            look_key: LookKey::of(request),
            look,
            topology: key,
        }
    }

    /// The listed faces of the surfaces, flagged as selected.
    fn highlights(&self, surfaces: &[Arc<Geometry>], listed: &[u32]) -> Vec<Arc<Geometry>> {
        let parts = [&self.still, &self.moving_faces];
        let drawn = parts.into_iter().filter(|faces| !faces.is_empty());
        surfaces
            .iter()
            .zip(drawn)
            .filter_map(|(surface, faces)| {
                let places = listed
                    .iter()
                    .filter_map(|&f| faces.binary_search(&FaceId(f)).ok());
                let places: Vec<usize> = places.collect();
                (!places.is_empty())
                    .then(|| Arc::new(surface.part(&places, faces.len(), Vertex::SELECTED)))
            })
            .collect()
    }
}

/// The flowing faces with `rings` rings around them, and the other faces.
fn around(
    topology: &Topology,
    flows: &dyn Fn(FaceId) -> bool,
    rings: usize,
) -> (Vec<FaceId>, Vec<FaceId>) {
    let faces = topology.faces();
    let mut inside: Vec<bool> = faces.clone().map(flows).collect();
    let corners = faces.clone().filter(|&f| flows(f));
    let corners = corners.flat_map(|f| topology.face_vertices(f));
    for f in Neighbourhood::new(topology, corners, rings).faces {
        inside[f.index()] = true;
    }
    faces.partition(|f| inside[f.index()])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes::icosphere;

    #[test]
    fn rings_around_a_face() {
        let (positions, triangles) = icosphere(8);
        let topology = Topology::from_triangles(positions.len(), &triangles).expect("sphere");
        let last = topology.face_count() - 1;
        let (none, all) = around(&topology, &|_| false, 3);
        assert_eq!((none.len(), all.len()), (0, topology.face_count()));
        let (just, _) = around(&topology, &|f| f.index() == last, 0);
        assert_eq!(just, [FaceId::from(last)]);
        let (one, rest) = around(&topology, &|f| f.index() == last, 1);
        let corners = topology.face_vertices(FaceId::from(last));
        for f in &one {
            assert!(
                topology
                    .face_vertices(*f)
                    .iter()
                    .any(|v| corners.contains(v))
            );
        }
        for f in &rest {
            assert!(
                !topology
                    .face_vertices(*f)
                    .iter()
                    .any(|v| corners.contains(v))
            );
        }
    }
}
