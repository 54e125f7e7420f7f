//! Evaluates the drawn surfaces on a separate thread, so that the window does not wait. A new
//! request replaces older ones.

mod builder;
mod look;

use std::ops::Range;
use std::sync::{Arc, Condvar, Mutex, PoisonError};

use super::jobs::Wake;
use super::report::Reference;
use super::run::{RunState, state_key};
use super::seam::Seam;
use crate::energy::{Energy, WellPosedScan};
use crate::mesh::{DVec3, Mesh, VertexId};
use crate::render::{Bounds, Geometry, Textures};
use builder::DisplayBuilder;

/// A request for a display.
#[derive(Clone)]
pub struct Request {
    /// The mesh of the run, or that of the document.
    pub mesh: Arc<Mesh>,
    /// The state of the run, if there is one.
    pub state: Option<RunState>,
    /// The first state with the same vertices, which the deviation refers to.
    pub start: Option<RunState>,
    /// The first face that belongs to a patch.
    pub first_patch_face: usize,
    /// The faces of the newest patch.
    pub newest: Range<usize>,
    /// Other faces that the flow moves, in ascending order.
    pub faired: Arc<Vec<u32>>,
    /// Selected faces in ascending order.
    pub highlight: Arc<Vec<u32>>,
    /// Rims joined with a crease, as vertices in order.
    pub creases: Arc<Vec<[VertexId; 2]>>,
    /// Limit surface or control mesh.
    pub limit: bool,
    /// Whether the opened mesh is drawn.
    pub original: bool,
    /// The origin of drawn positions.
    pub centre: DVec3,
    /// The bounding box to use if the mesh has no vertices.
    pub bounds: Bounds,
    /// The energy whose well-posedness is shown, and the hole radius.
    pub energy: Option<(Energy, f64)>,
    /// The reference for distances.
    pub reference: Option<Arc<Reference>>,
    /// The texture images of the materials.
    pub textures: Arc<Textures>,
    /// Which state new faces have their colours and textures from.
    pub continued: Continued,
}

/// Which state of a run its faces have their colours and textures from. They depend on the triangulation, and
/// hardly on the shape.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Continued {
    /// None: patches have no colours.
    No,
    /// The first one that was drawn of those with the same triangulation.
    WithTriangulation,
    /// The drawn one.
    WithShape,
}

impl Request {
    /// Whether both have the same display.
    fn same(&self, other: &Self) -> bool {
        self.same_surfaces(other) && same_list(&self.highlight, &other.highlight)
    }

    /// Whether both have the same display except for the selected faces.
    fn same_surfaces(&self, other: &Self) -> bool {
        let states = |r: &Self| [&r.state, &r.start].map(|s| state_key(s.as_ref()));
        let reference = |r: &Self| r.reference.as_ref().map(Arc::as_ptr);
        Arc::ptr_eq(&self.mesh, &other.mesh)
            && reference(self) == reference(other)
            && states(self) == states(other)
            && Arc::ptr_eq(&self.creases, &other.creases)
            && self.first_patch_face == other.first_patch_face
            && self.newest == other.newest
            && same_list(&self.faired, &other.faired)
            && self.limit == other.limit
            && self.original == other.original
            && self.centre == other.centre
            && self.energy == other.energy
            && Arc::ptr_eq(&self.textures, &other.textures)
            && self.continued == other.continued
    }
}

/// Whether both are the same list or both are empty.
fn same_list(a: &Arc<Vec<u32>>, b: &Arc<Vec<u32>>) -> bool {
    Arc::ptr_eq(a, b) || (a.is_empty() && b.is_empty())
}

/// The display of a request.
#[derive(Clone)]
pub struct Display {
    /// Surfaces. The static part comes first.
    pub surfaces: Vec<Arc<Geometry>>,
    /// The selected faces, drawn over the surfaces.
    pub highlights: Vec<Arc<Geometry>>,
    /// The bounding box of the surfaces.
    pub bounds: Bounds,
    /// Whether the flow is well posed on the patch and its support region.
    pub posed: Option<WellPosedScan>,
    /// Continuity of the patch of the run and the mesh.
    pub seam: Option<Seam>,
}

#[derive(Default)]
struct Slot {
    wanted: Option<Request>,
    /// Whether the thread builds a display.
    building: bool,
    ready: Option<Display>,
    /// Number of calls of [`DisplayWorker::clear`]. Results of earlier requests are discarded.
    epoch: u64,
    quit: bool,
}

type Shared = (Mutex<Slot>, Condvar);

/// The thread and its newest result.
pub struct DisplayWorker {
    shared: Arc<Shared>,
    requested: Option<Request>,
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
    /// Starts the thread, which calls `wake` after every result.
    pub fn new(wake: &Wake) -> Self {
        let shared: Arc<Shared> = Arc::default();
        let (inner, wake) = (Arc::clone(&shared), Arc::clone(wake));
        std::thread::Builder::new()
            .name("meniscus-display".into())
            .spawn(move || work(&inner, &wake))
            .ok();
        Self {
            shared,
            requested: None,
            latest: None,
        }
    }

    /// Requests a display, unless the last request was the same.
    pub fn request(&mut self, request: Request) {
        if self
            .requested
            .as_ref()
            .is_some_and(|asked| asked.same(&request))
        {
            return;
        }
        self.requested = Some(request.clone());
        lock(&self.shared.0).wanted = Some(request);
        self.shared.1.notify_all();
    }

    /// Receives a new result. Returns whether there was one.
    pub fn poll(&mut self) -> bool {
        let ready = lock(&self.shared.0).ready.take();
        let new = ready.is_some();
        if new {
            self.latest = ready;
        }
        new
    }

    /// Discards all requests and results.
    pub fn clear(&mut self) {
        let mut slot = lock(&self.shared.0);
        slot.epoch += 1;
        (slot.wanted, slot.ready) = (None, None);
        (self.requested, self.latest) = (None, None);
    }

    /// The last request.
    pub fn requested(&self) -> Option<&Request> {
        self.requested.as_ref()
    }

    /// Builds displays on the calling thread, for pictures of many states.
    pub fn builder() -> impl FnMut(&Request) -> Display {
        let mut builder = DisplayBuilder::default();
        move |request| builder.build(request)
    }

    /// The newest result.
    pub fn latest(&self) -> Option<&Display> {
        self.latest.as_ref()
    }

    /// Whether the newest result is that of the last request.
    pub fn is_settled(&self) -> bool {
        let slot = lock(&self.shared.0);
        let is_idle = slot.wanted.is_none() && !slot.building && slot.ready.is_none();
        is_idle && self.requested.is_some()
    }
}

fn work(shared: &Shared, wake: &Wake) {
    let mut builder = DisplayBuilder::default();
    loop {
        let (request, epoch) = {
            let mut slot = lock(&shared.0);
            loop {
                if slot.quit {
                    return;
                }
                if let Some(request) = slot.wanted.take() {
                    slot.building = true;
                    break (request, slot.epoch);
                }
                slot = shared.1.wait(slot).unwrap_or_else(PoisonError::into_inner);
            }
        };
        let publish = |display: Display, is_last: bool| {
            {
                let mut slot = lock(&shared.0);
                slot.building &= !is_last;
                if slot.epoch != epoch {
                    return;
                }
                slot.ready = Some(display);
            }
            wake();
        };
        if builder.waits_for_images(&request) {
            let plain = Request {
                continued: Continued::No,
                ..request.clone()
            };
            publish(builder.build(&plain), false);
        }
        publish(builder.build(&request), true);
    }
}
