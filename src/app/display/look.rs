//! Colours and texture images of the faces that are drawn.

use std::sync::Arc;

use super::{Continued, Request};
use crate::app::run::state_key;
use crate::mesh::{Mesh, Topology};
use crate::render::{FaceTextures, Textures};

/// The colours and texture images of a mesh, or of a state of a run.
#[derive(Default)]
pub(super) struct Look {
    /// Red, green, blue and opacity of the first vertices of the drawn mesh.
    pub colors: Vec<[f32; 4]>,
    /// Red, green and blue of its first faces, where they are known.
    pub face_colors: Arc<Vec<Option<[f32; 3]>>>,
    /// The images of its faces, until the surfaces are made.
    pub textures: Option<Arc<FaceTextures>>,
}

impl Look {
    /// That of a request, whose drawn mesh has this connectivity.
    pub fn new(request: &Request, topology: &Topology) -> Self {
        let Some(state) = &request.state else {
            return Self::of(&request.mesh, &request.textures);
        };
        if request.continued != Continued::No {
            let mesh = state.mesh();
            let own = &mesh.attributes.own_materials;
            let with_own = request.textures.with_own(own);
            let textures = with_own.as_ref().unwrap_or(&request.textures);
            let mut look = Self::of(&mesh, textures);
            look.colors = by_corners(&look.colors, &mesh, topology);
            return look;
        }
        if state.patch_faces().is_some() {
            return Self::of(&request.mesh, &request.textures);
        }
        // the faces of a refinement are others
        Self::default()
    }

    fn of(mesh: &Mesh, textures: &Textures) -> Self {
        Self {
            colors: mesh.colors(),
            face_colors: Arc::new(mesh.attributes.face_colors()),
            textures: (!textures.is_empty()).then(|| Arc::new(textures.of_faces(mesh))),
        }
    }
}

/// The colours of the vertices of a mesh for one with the same faces, which may be cut open.
fn by_corners(colors: &[[f32; 4]], mesh: &Mesh, topology: &Topology) -> Vec<[f32; 4]> {
    if colors.is_empty() || mesh.vertex_count() == topology.vertex_count() {
        return colors.to_vec();
    }
    let mut cut = vec![[0.0; 4]; topology.vertex_count()];
    for f in mesh.topology.faces() {
        let corners = mesh.topology.face_vertices(f);
        for (v, w) in topology.face_vertices(f).into_iter().zip(corners) {
            cut[v.index()] = colors[w.index()];
        }
    }
    cut
}

/// What a look depends on besides the drawn connectivity.
pub(super) struct LookKey(Request);

impl LookKey {
    pub fn of(request: &Request) -> Self {
        Self(request.clone())
    }

    /// Whether a request, whose drawn mesh has the same connectivity, has the same look.
    pub fn fits(&self, request: &Request) -> bool {
        let state = |r: &Request| state_key(r.state.as_ref());
        Arc::ptr_eq(&self.0.mesh, &request.mesh)
            && Arc::ptr_eq(&self.0.textures, &request.textures)
            && self.0.continued == request.continued
            && (request.continued != Continued::WithShape || state(&self.0) == state(request))
    }
}
