//! The document: the data that is edited, saved and undone.

use std::collections::BTreeSet;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::run::RunState;
use crate::fill::{Controls, LoopChoice, choose};
use crate::io::Opened;
use crate::mesh::{
    BoundaryLoop, DVec3, FaceData, LoadReport, LoopId, Mesh, Topology, boundary_loops,
};
use crate::ops::{Operation, Outcome};
use crate::render::Bounds;
use crate::warning::counted;

/// The name of a file without its folders.
pub fn file_name(path: &Path) -> String {
    let name = path.file_name().unwrap_or(path.as_os_str());
    name.to_string_lossy().into_owned()
}

/// A name of at most `most` characters: a longer one is elided in the middle, so that its beginning and
/// its extension stay.
pub fn elided(name: &str, most: usize) -> String {
    let count = name.chars().count();
    if count <= most {
        return name.to_owned();
    }
    let kept = most.saturating_sub(1);
    let start = name.chars().take(kept - kept / 2);
    let end = name.chars().skip(count - kept / 2);
    start.chain(['…']).chain(end).collect()
}

/// The origin of a document's mesh.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Source {
    /// A mesh file.
    File(PathBuf),
    /// A built-in sample, by its name on the command line.
    Sample(String),
    /// A mesh stored in a project or recovery file.
    Embedded,
}

/// The opened mesh's origin; all states of a document share it.
#[derive(Clone, Debug)]
pub struct Origin {
    /// The source of the mesh.
    pub source: Source,
    /// Counts and repairs.
    pub report: LoadReport,
    /// The bounding box of the opened mesh.
    pub bounds: Bounds,
}

impl Origin {
    /// Name for titles and messages.
    pub fn name(&self) -> String {
        match &self.source {
            Source::File(path) => file_name(path),
            Source::Sample(name) => format!("sample {name}"),
            Source::Embedded => "untitled".into(),
        }
    }
}

/// An accepted operation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AppliedOperation {
    /// The operation.
    #[serde(flatten)]
    pub operation: Operation,
    /// The faces that it added, as far as they still exist.
    #[serde(with = "face_range")]
    pub faces: Range<usize>,
}

/// A range of faces as its two bounds.
mod face_range {
    use std::ops::Range;

    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    pub fn serialize<S: Serializer>(range: &Range<usize>, to: S) -> Result<S::Ok, S::Error> {
        [range.start, range.end].serialize(to)
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Range<usize>, D::Error> {
        let [start, end] = <[usize; 2]>::deserialize(from)?;
        Ok(start..end)
    }
}

/// The state that is saved and undone. Cloning is cheap: meshes are shared.
#[derive(Clone, Debug)]
pub struct Document {
    /// The opened file or sample.
    pub origin: Arc<Origin>,
    /// The mesh after all operations. Vertices and faces of the opened mesh come first.
    pub mesh: Arc<Mesh>,
    /// The limit surface through its vertices, if the last operation was a refinement.
    pub surface: Option<RunState>,
    /// The first face that belongs to a patch.
    pub first_patch_face: usize,
    /// Its boundary loops.
    pub loops: Arc<Vec<BoundaryLoop>>,
    /// The selected loops.
    pub selection: BTreeSet<LoopId>,
    /// The selected faces, ascending.
    pub faces: Arc<Vec<u32>>,
    /// Controls of the next run.
    pub controls: Controls,
    /// The operations applied so far, oldest first.
    pub accepted: Vec<Arc<AppliedOperation>>,
}

impl Document {
    /// A document of an opened mesh. The runs of the window are flows in true time.
    pub fn new(opened: Opened, source: Source) -> Self {
        let mesh = Arc::new(opened.mesh);
        let loops = boundary_loops(&mesh);
        Self {
            origin: Arc::new(Origin {
                source,
                report: opened.report,
                bounds: bounds_of(&mesh),
            }),
            first_patch_face: mesh.face_count(),
            surface: None,
            mesh,
            loops: Arc::new(loops),
            selection: BTreeSet::new(),
            faces: Arc::default(),
            controls: window_controls(),
            accepted: Vec::new(),
        }
    }

    /// The empty document.
    pub fn blank() -> Self {
        let nothing = Opened {
            mesh: Mesh::new(Vec::new(), Topology::default()),
            report: LoadReport::default(),
        };
        Self::new(nothing, Source::Embedded)
    }

    /// Whether no mesh was opened yet.
    pub fn is_blank(&self) -> bool {
        self.mesh.vertex_count() == 0 && !self.is_changed()
    }

    /// Stores the result of an operation. If it erased faces, `kept` lists the old indices of the
    /// other faces, which come first in `mesh`.
    pub fn accept(&mut self, mesh: Mesh, kept: Option<&[u32]>, done: AppliedOperation) {
        if matches!(done.operation, Operation::Refine(_)) {
            // all faces are new and none belongs to a patch
            self.first_patch_face = mesh.face_count();
            for one in &mut self.accepted {
                Arc::make_mut(one).faces = 0..0;
            }
        } else if let Some(kept) = kept {
            self.first_patch_face = left_of(kept, self.first_patch_face);
            for one in &mut self.accepted {
                let faces = left_of(kept, one.faces.start)..left_of(kept, one.faces.end);
                if faces != one.faces {
                    Arc::make_mut(one).faces = faces;
                }
            }
        } else if matches!(done.operation, Operation::Stitch(_))
            && self.first_patch_face == self.mesh.face_count()
        {
            // the parts of divided faces belong to no patch
            self.first_patch_face = mesh.face_count();
        }
        self.mesh = Arc::new(mesh);
        self.surface = None;
        self.loops = Arc::new(boundary_loops(&self.mesh));
        self.selection.clear();
        self.faces = Arc::default();
        self.accepted.push(Arc::new(done));
    }

    /// [Stores](Self::accept) the result of an operation that has run as a whole.
    pub fn accept_outcome(&mut self, operation: Operation, outcome: Outcome) {
        let (mesh, kept) = match outcome {
            Outcome::Erased(erased) => (erased.mesh, Some(erased.old_face)),
            Outcome::Refilled(new) => (new.filled.mesh, Some(new.region.erased.old_face)),
            other => (other.into_mesh(), None),
        };
        let first = kept.as_ref().map_or(self.mesh.face_count(), Vec::len);
        let faces = first..mesh.face_count().max(first);
        self.accept(mesh, kept.as_deref(), AppliedOperation { operation, faces });
    }

    /// The faces of the newest patch of which some are left; none without patches.
    pub fn newest_patch(&self) -> Range<usize> {
        let mut faces = self.accepted.iter().rev().map(|one| one.faces.clone());
        faces.find(|faces| !faces.is_empty()).unwrap_or_default()
    }

    /// The number of loops, in words.
    pub fn loop_count(&self) -> String {
        counted(self.loops.len(), "loop", "loops")
    }

    /// The faces of the bridges, ascending, as far as no later operation has replaced them.
    pub fn bridge_faces(&self) -> Vec<u32> {
        let accepted = self.accepted.iter();
        let bridges = accepted.filter(|one| matches!(one.operation, Operation::Bridge(_)));
        let faces = bridges.flat_map(|one| one.faces.start as u32..one.faces.end as u32);
        faces.collect()
    }

    /// Whether the last operation was a bridge, beside which are holes to fill.
    pub fn ends_with_bridge(&self) -> bool {
        let last = self.accepted.last();
        last.is_some_and(|one| matches!(one.operation, Operation::Bridge(_)))
    }

    /// A loop, if it exists.
    pub fn loop_of(&self, id: LoopId) -> Option<&BoundaryLoop> {
        self.loops.get(id.index())
    }

    /// The selected loops.
    pub fn selected(&self) -> Vec<&BoundaryLoop> {
        self.selection
            .iter()
            .filter_map(|&id| self.loop_of(id))
            .collect()
    }

    /// The loops of a choice other than a list of numbers.
    pub fn chosen(&self, choice: &LoopChoice) -> BTreeSet<LoopId> {
        let chosen = choose(&self.loops, choice);
        chosen.into_iter().flatten().collect()
    }

    /// All loops that are not classified as outer boundaries.
    pub fn holes(&self) -> BTreeSet<LoopId> {
        self.chosen(&LoopChoice::Auto)
    }

    /// Whether an operation was applied to the opened mesh.
    pub fn is_changed(&self) -> bool {
        !self.accepted.is_empty()
    }

    /// The patches as a separate mesh, with their rims and with vertices in order; `None` if there
    /// are none.
    pub fn patches(&self) -> Option<Mesh> {
        let first = self.first_patch_face;
        let triangles: Vec<[u32; 3]> = self.mesh.topology.triangles().skip(first).collect();
        if triangles.is_empty() {
            return None;
        }
        let mut new_index = vec![u32::MAX; self.mesh.vertex_count()];
        for t in &triangles {
            for &v in t {
                new_index[v as usize] = 0;
            }
        }
        let mut positions = Vec::new();
        let mut vertices = Vec::new();
        for (v, slot) in new_index.iter_mut().enumerate() {
            if *slot == 0 {
                *slot = positions.len() as u32;
                positions.push(self.mesh.positions[v]);
                vertices.push(v as u32);
            }
        }
        let local: Vec<[u32; 3]> = triangles
            .iter()
            .map(|t| t.map(|v| new_index[v as usize]))
            .collect();
        let mut patches = Mesh::from_triangles(positions, &local).ok()?;
        let faces: Vec<u32> = (first as u32..self.mesh.face_count() as u32).collect();
        patches.attributes = self.mesh.attributes.picked(&vertices, &faces);
        patches.attributes.non_orientable = FaceData::default();
        Some(patches)
    }
}

/// The number of kept faces before a face.
pub fn left_of(kept: &[u32], face: usize) -> usize {
    kept.partition_point(|&f| (f as usize) < face)
}

/// The bounding box of a mesh; a box of size 1 for an empty mesh.
pub fn bounds_of(mesh: &Mesh) -> Bounds {
    let unit = DVec3::splat(0.5);
    Bounds::of(mesh.positions.iter().copied()).unwrap_or(Bounds::new(-unit, unit))
}

/// The defaults of the window: flows in true time.
pub fn window_controls() -> Controls {
    Controls {
        mode: crate::solver::Mode::Flow,
        ..Controls::default()
    }
}

#[cfg(test)]
mod tests {
    use super::elided;

    #[test]
    fn long_names_keep_their_ends() {
        assert_eq!(elided("scan.obj", 8), "scan.obj");
        assert_eq!(elided("a long name of a scan.obj", 12), "a long…n.obj");
        assert_eq!(elided("größenänderung.ply", 9), "größ….ply");
        assert_eq!(elided("scan.obj", 1), "…");
    }
}
