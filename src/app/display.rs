//! Makes what is drawn of a mesh on a thread of its own, so that the window never waits: the
//! newest request wins, results come when they are ready.

use std::sync::{Arc, Condvar, Mutex, PoisonError};

use super::jobs::Wake;
use super::seam::{Seam, seam};
use crate::fill::State;
use crate::mesh::{DVec3, FaceId, Mesh, Topology, VertexId};
use crate::render::{
    Bounds, DynamicSurface, Evaluation, Geometry, SurfaceOptions, Vertex, static_surface,
};
use crate::solver::energy::{Energy, WellPosed, WellPosedScan, scan_well_posedness};

/// Rings of faces around a patch that are drawn as the limit surface, as the patch is.
const COLLAR: usize = 3;
/// A closed mesh with at most so many faces is drawn as a limit surface all over.
const SMALL: usize = 20_000;
/// Symbols smaller than this, relative to their scale, count as zero: the curvatures that are drawn
/// are of single precision.
const SINGLE: f64 = 1e-5;

/// What is to be drawn.
#[derive(Clone)]
pub struct Request {
    /// The mesh the run works on, or the document's.
    pub mesh: Arc<Mesh>,
    /// The state of the run, if there is one.
    pub state: Option<Arc<State>>,
    /// The first state, to measure the deviation from.
    pub start: Option<Arc<State>>,
    /// Faces of the mesh from here on are patches.
    pub first_patch_face: usize,
    /// Rims joined with a crease: their vertices in order.
    pub creases: Arc<Vec<[VertexId; 2]>>,
    /// Limit surface or control mesh.
    pub limit: bool,
    /// Whether the opened mesh is drawn.
    pub original: bool,
    /// What positions are relative to.
    pub centre: DVec3,
    /// The box of a mesh without vertices.
    pub bounds: Bounds,
    /// Energy whose well-posedness is shown, and the hole radius.
    pub energy: Option<(Energy, f64)>,
}

impl Request {
    /// Whether both give the same picture.
    fn same(&self, other: &Self) -> bool {
        let same = |a: &Option<Arc<State>>, b: &Option<Arc<State>>| match (a, b) {
            (Some(a), Some(b)) => Arc::ptr_eq(a, b),
            (None, None) => true,
            _ => false,
        };
        let energy = |r: &Self| {
            r.energy
                .as_ref()
                .map(|(e, l)| (e.text().to_owned(), e.params().clone(), *l))
        };
        Arc::ptr_eq(&self.mesh, &other.mesh)
            && same(&self.state, &other.state)
            && same(&self.start, &other.start)
            && Arc::ptr_eq(&self.creases, &other.creases)
            && self.first_patch_face == other.first_patch_face
            && self.limit == other.limit
            && self.original == other.original
            && self.centre == other.centre
            && energy(self) == energy(other)
    }
}

/// What came of a request.
#[derive(Clone)]
pub struct Display {
    /// Surfaces, the still part first.
    pub surfaces: Vec<Arc<Geometry>>,
    /// Their box.
    pub bounds: Bounds,
    /// How the flow is posed on the patch and its collar.
    pub posed: Option<WellPosedScan>,
    /// How the patch of the run meets the mesh.
    pub seam: Option<Seam>,
}

#[derive(Default)]
struct Slot {
    wanted: Option<Request>,
    ready: Option<Display>,
    quit: bool,
}

type Shared = (Mutex<Slot>, Condvar);

/// The thread and the newest result.
pub struct DisplayWorker {
    shared: Arc<Shared>,
    asked: Option<Request>,
    latest: Option<Display>,
}

impl Drop for DisplayWorker {
    fn drop(&mut self) {
        lock(&self.shared.0).quit = true;
        self.shared.1.notify_all();
    }
}

fn lock(slot: &Mutex<Slot>) -> std::sync::MutexGuard<'_, Slot> {
    slot.lock().unwrap_or_else(PoisonError::into_inner)
}

impl DisplayWorker {
    /// Starts the thread; `wake` is called after every result.
    pub fn new(wake: &Wake) -> Self {
        let shared: Arc<Shared> = Arc::default();
        let (inner, wake) = (Arc::clone(&shared), Arc::clone(wake));
        std::thread::Builder::new()
            .name("meniscus-display".into())
            .spawn(move || work(&inner, &wake))
            .ok();
        Self {
            shared,
            asked: None,
            latest: None,
        }
    }

    /// Asks for a picture; nothing happens if it was asked for last.
    pub fn ask(&mut self, request: Request) {
        if self
            .asked
            .as_ref()
            .is_some_and(|asked| asked.same(&request))
        {
            return;
        }
        self.asked = Some(request.clone());
        lock(&self.shared.0).wanted = Some(request);
        self.shared.1.notify_all();
    }

    /// Takes in a new result. Returns whether there was one.
    pub fn poll(&mut self) -> bool {
        let ready = lock(&self.shared.0).ready.take();
        let new = ready.is_some();
        if new {
            self.latest = ready;
        }
        new
    }

    /// What was asked for last.
    pub fn asked(&self) -> Option<&Request> {
        self.asked.as_ref()
    }

    /// Answers requests at once, on the calling thread, for pictures of many states.
    pub fn maker() -> impl FnMut(&Request) -> Display {
        let mut cache = Cache::default();
        move |request| cache.make(request)
    }

    /// The newest result.
    pub fn latest(&self) -> Option<&Display> {
        self.latest.as_ref()
    }
}

fn work(shared: &Shared, wake: &Wake) {
    let mut cache = Cache::default();
    loop {
        let request = {
            let mut slot = lock(&shared.0);
            loop {
                if slot.quit {
                    return;
                }
                if let Some(request) = slot.wanted.take() {
                    break request;
                }
                slot = shared.1.wait(slot).unwrap_or_else(PoisonError::into_inner);
            }
        };
        let display = cache.make(&request);
        lock(&shared.0).ready = Some(display);
        wake();
    }
}

/// What stays from one request to the next.
#[derive(Default)]
struct Cache {
    split: Option<Split>,
    still: Option<(StillKey, Arc<Geometry>)>,
}

/// The faces of a mesh: those drawn as limit surface, and the others.
struct Split {
    topology: TopologyKey,
    creases: Arc<Vec<[VertexId; 2]>>,
    first_patch_face: usize,
    original: bool,
    moving: DynamicSurface,
    moving_faces: Vec<FaceId>,
    still: Vec<FaceId>,
}

/// Keeps what it identifies alive, so that no address is taken for another's.
enum TopologyKey {
    Mesh(Arc<Mesh>),
    State(Arc<Topology>),
}

impl TopologyKey {
    fn of(request: &Request) -> Self {
        request.state.as_ref().map_or_else(
            || Self::Mesh(Arc::clone(&request.mesh)),
            |state| Self::State(Arc::clone(&state.topology)),
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

type StillKey = (usize, usize, bool, [u64; 3]);

impl Cache {
    fn make(&mut self, request: &Request) -> Display {
        let key = TopologyKey::of(request);
        let fits = self.split.as_ref().is_some_and(|s| {
            s.topology.same(&key)
                && Arc::ptr_eq(&s.creases, &request.creases)
                && s.first_patch_face == request.first_patch_face
                && s.original == request.original
        });
        if !fits {
            self.split = Some(Split::new(key, request));
            self.still = None;
        }
        let Some(split) = &self.split else {
            unreachable!("made above");
        };
        let topology = split.topology.topology();
        let positions = positions_of(&request.mesh, request.state.as_deref());
        let start = request
            .start
            .as_deref()
            .map(|state| positions_of(&request.mesh, Some(state)))
            .filter(|p| p.len() == positions.len());

        let mut surfaces = Vec::new();
        if !split.still.is_empty() {
            let key = (
                split.still.len(),
                positions.len(),
                request.limit,
                request.centre.to_array().map(f64::to_bits),
            );
            let still = match &self.still {
                Some((k, geometry)) if *k == key => Arc::clone(geometry),
                _ => Arc::new(static_surface(
                    topology,
                    &positions,
                    &split.still,
                    request.centre,
                    request.limit,
                    0,
                )),
            };
            self.still = Some((key, Arc::clone(&still)));
            surfaces.push(still);
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
                    limit: request.limit,
                    start: start.as_deref(),
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
        let seam = request
            .state
            .is_some()
            .then(|| seam(topology, &positions, first, &request.creases));
        Display {
            surfaces,
            bounds,
            posed,
            seam,
        }
    }
}

/// Mean and Gaussian curvatures of at most some thousand vertices of a geometry.
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

/// Positions of all vertices: the mesh's, then the state's.
fn positions_of(mesh: &Mesh, state: Option<&State>) -> Vec<DVec3> {
    let mut positions = mesh.positions.clone();
    if let Some(state) = state {
        positions.extend(state.new_positions());
    }
    positions
}

impl Split {
    fn new(key: TopologyKey, request: &Request) -> Self {
        let topology = key.topology();
        let first = request.first_patch_face;
        let count = topology.face_count();
        let (moving, still) = if !request.original {
            ((first..count).map(FaceId::from).collect(), Vec::new())
        } else if count <= SMALL {
            ((0..count).map(FaceId::from).collect(), Vec::new())
        } else {
            around(topology, first, COLLAR)
        };
        let moving: Vec<FaceId> = moving;
        let flag = |f: &FaceId| if f.index() >= first { Vertex::PATCH } else { 0 };
        let options = SurfaceOptions {
            samples_per_edge: None,
            creases: request.creases.to_vec(),
            flags: moving.iter().map(flag).collect(),
        };
        Self {
            moving: DynamicSurface::new(topology, &moving, &options),
            moving_faces: moving,
            still,
            creases: Arc::clone(&request.creases),
            first_patch_face: first,
            original: request.original,
            topology: key,
        }
    }
}

/// The faces from `first` on with `rings` rings around them, and the others.
fn around(topology: &Topology, first: usize, rings: usize) -> (Vec<FaceId>, Vec<FaceId>) {
    let mut inside = vec![false; topology.face_count()];
    inside[first..].fill(true);
    let mut reached = vec![false; topology.vertex_count()];
    let mut front: Vec<VertexId> = Vec::new();
    let mut claim = |v: VertexId, next: &mut Vec<VertexId>| {
        if !std::mem::replace(&mut reached[v.index()], true) {
            next.push(v);
        }
    };
    for f in (first..topology.face_count()).map(FaceId::from) {
        for v in topology.face_vertices(f) {
            claim(v, &mut front);
        }
    }
    for _ in 0..rings {
        let mut next = Vec::new();
        for &v in &front {
            for h in topology.outgoing(v) {
                let f = topology.face(h);
                if f.is_some() && !std::mem::replace(&mut inside[f.index()], true) {
                    for w in topology.face_vertices(f) {
                        claim(w, &mut next);
                    }
                }
            }
        }
        front = next;
    }
    (0..inside.len())
        .map(FaceId::from)
        .partition(|f| inside[f.index()])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes::icosphere;

    #[test]
    fn rings_around_a_face() {
        let (positions, triangles) = icosphere(8);
        let topology = Topology::from_triangles(positions.len(), &triangles).expect("sphere");
        let last = topology.face_count() - 1;
        let (none, all) = around(&topology, topology.face_count(), 3);
        assert_eq!((none.len(), all.len()), (0, topology.face_count()));
        let (just, _) = around(&topology, last, 0);
        assert_eq!(just, [FaceId::from(last)]);
        let (one, rest) = around(&topology, last, 1);
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
