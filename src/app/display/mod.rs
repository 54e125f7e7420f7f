//! Evaluates the drawn surfaces on a thread, so that the window never waits. The newest request
//! replaces older ones; results arrive when they are ready.

mod builder;

use std::sync::{Arc, Condvar, Mutex, PoisonError};

use super::jobs::Wake;
use super::report::Reference;
use super::run::{RunState, state_key};
use super::seam::Seam;
use crate::energy::{Energy, WellPosedScan};
use crate::mesh::{DVec3, Mesh, VertexId};
use crate::render::{Bounds, Geometry};
use builder::DisplayBuilder;

/// What has to be drawn.
#[derive(Clone)]
pub struct Request {
    /// The mesh the run works on, or the document's.
    pub mesh: Arc<Mesh>,
    /// The state of the run, if there is one.
    pub state: Option<RunState>,
    /// The first state with the same vertices, to measure the deviation from.
    pub start: Option<RunState>,
    /// Faces of the mesh from here on are patches.
    pub first_patch_face: usize,
    /// Other faces that the flow moves, ascending.
    pub faired: Arc<Vec<u32>>,
    /// Selected faces, ascending.
    pub highlight: Arc<Vec<u32>>,
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
    /// What the distance of all that is drawn is shown to.
    pub reference: Option<Arc<Reference>>,
}

impl Request {
    /// Whether both give the same display.
    fn same(&self, other: &Self) -> bool {
        self.same_surfaces(other) && same_list(&self.highlight, &other.highlight)
    }

    /// Whether both give the same display except for the selected faces.
    fn same_surfaces(&self, other: &Self) -> bool {
        let states = |r: &Self| [&r.state, &r.start].map(|s| state_key(s.as_ref()));
        let reference = |r: &Self| r.reference.as_ref().map(Arc::as_ptr);
        Arc::ptr_eq(&self.mesh, &other.mesh)
            && reference(self) == reference(other)
            && states(self) == states(other)
            && Arc::ptr_eq(&self.creases, &other.creases)
            && self.first_patch_face == other.first_patch_face
            && same_list(&self.faired, &other.faired)
            && self.limit == other.limit
            && self.original == other.original
            && self.centre == other.centre
            && self.energy == other.energy
    }
}

/// Whether both are the same list, or both empty.
fn same_list(a: &Arc<Vec<u32>>, b: &Arc<Vec<u32>>) -> bool {
    Arc::ptr_eq(a, b) || (a.is_empty() && b.is_empty())
}

/// The answer to a request.
#[derive(Clone)]
pub struct Display {
    /// Surfaces, the still part first.
    pub surfaces: Vec<Arc<Geometry>>,
    /// The selected faces, drawn over the surfaces.
    pub highlights: Vec<Arc<Geometry>>,
    /// Their box.
    pub bounds: Bounds,
    /// Whether the flow is well posed on the patch and its support region.
    pub posed: Option<WellPosedScan>,
    /// How the patch of the run meets the mesh.
    pub seam: Option<Seam>,
}

#[derive(Default)]
struct Slot {
    wanted: Option<Request>,
    ready: Option<Display>,
    /// Results of requests before the last [`DisplayWorker::forget`] are dropped.
    epoch: u64,
    quit: bool,
}

type Shared = (Mutex<Slot>, Condvar);

/// The thread, and its newest result.
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

    /// Requests a display, unless it was requested last.
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

    /// Drops all requests and results.
    pub fn forget(&mut self) {
        let mut slot = lock(&self.shared.0);
        slot.epoch += 1;
        (slot.wanted, slot.ready) = (None, None);
        (self.asked, self.latest) = (None, None);
    }

    /// The last request.
    pub fn asked(&self) -> Option<&Request> {
        self.asked.as_ref()
    }

    /// Answers requests at once on the calling thread, for pictures of many states.
    pub fn builder() -> impl FnMut(&Request) -> Display {
        let mut builder = DisplayBuilder::default();
        move |request| builder.build(request)
    }

    /// The newest result.
    pub fn latest(&self) -> Option<&Display> {
        self.latest.as_ref()
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
                    break (request, slot.epoch);
                }
                slot = shared.1.wait(slot).unwrap_or_else(PoisonError::into_inner);
            }
        };
        let display = builder.build(&request);
        {
            let mut slot = lock(&shared.0);
            if slot.epoch != epoch {
                continue;
            }
            slot.ready = Some(display);
        }
        wake();
    }
}
