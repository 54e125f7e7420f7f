//! What is edited, saved and undone.

use std::collections::BTreeSet;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::view_state::Task;
use crate::fill::{Controls, Schedule};
use crate::io::Opened;
use crate::mesh::{BoundaryLoop, DVec3, LoadReport, Mesh, Topology, boundary_loops};
use crate::render::Bounds;

/// Where a document came from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Source {
    /// A mesh file.
    File(PathBuf),
    /// A built-in sample, by its name on the command line.
    Sample(String),
    /// The mesh held by a project or recovery file that names no other.
    Embedded,
}

/// What was opened; shared by all states of a document.
#[derive(Clone, Debug)]
pub struct Origin {
    /// Where it came from.
    pub source: Source,
    /// Counts and repairs.
    pub report: LoadReport,
    /// Material libraries to be named again when it is saved.
    pub material_libraries: Vec<String>,
    /// The mesh as it was opened.
    pub mesh: Arc<Mesh>,
    /// Its box.
    pub bounds: Bounds,
}

impl Origin {
    /// Name for titles and messages.
    pub fn name(&self) -> String {
        let file_name = |p: &Path| {
            p.file_name()
                .map_or_else(|| p.display().to_string(), |n| n.to_string_lossy().into())
        };
        match &self.source {
            Source::File(path) => file_name(path),
            Source::Sample(name) => format!("sample {name}"),
            Source::Embedded => "untitled".into(),
        }
    }
}

/// A fill that was accepted, with all that is needed to repeat it.
#[derive(Clone, Debug, PartialEq)]
pub struct AcceptedFill {
    /// Whether each loop has a patch of its own, or one joins them all.
    pub task: Task,
    /// Numbers of the loops, in the mesh it was run on.
    pub loops: Vec<usize>,
    /// Controls at its start.
    pub controls: Controls,
    /// What was changed on the way.
    pub schedule: Schedule,
    /// The faces it added.
    pub faces: Range<usize>,
}

/// The saved and undone state. Cloning is cheap: meshes are shared.
#[derive(Clone, Debug)]
pub struct Document {
    /// What was opened.
    pub origin: Arc<Origin>,
    /// The mesh with all accepted fills; the opened one's vertices and faces come first.
    pub mesh: Arc<Mesh>,
    /// Its boundary loops.
    pub loops: Arc<Vec<BoundaryLoop>>,
    /// Indices of the selected ones.
    pub selection: BTreeSet<usize>,
    /// What the next run is to use.
    pub controls: Controls,
    /// Accepted fills, oldest first.
    pub fills: Vec<Arc<AcceptedFill>>,
}

impl Document {
    /// A document of an opened mesh. The window's runs are flows in true time.
    pub fn new(opened: Opened, source: Source) -> Self {
        let mesh = Arc::new(opened.mesh);
        let loops = boundary_loops(&mesh);
        Self {
            origin: Arc::new(Origin {
                source,
                report: opened.report,
                material_libraries: opened.material_libraries,
                bounds: bounds_of(&mesh),
                mesh: Arc::clone(&mesh),
            }),
            mesh,
            loops: Arc::new(loops),
            selection: BTreeSet::new(),
            controls: window_controls(),
            fills: Vec::new(),
        }
    }

    /// Nothing, until something is opened.
    pub fn blank() -> Self {
        let nothing = Opened {
            mesh: Mesh::new(Vec::new(), Topology::default()),
            report: LoadReport::default(),
            material_libraries: Vec::new(),
        };
        Self::new(nothing, Source::Embedded)
    }

    /// Whether nothing was opened yet.
    pub fn is_blank(&self) -> bool {
        self.origin.mesh.vertex_count() == 0
    }

    /// Takes in a fill: the mesh is `filled`, the remaining loops are numbered anew.
    pub fn accept(&mut self, filled: Mesh, fill: AcceptedFill) {
        self.mesh = Arc::new(filled);
        self.loops = Arc::new(boundary_loops(&self.mesh));
        self.selection.clear();
        self.fills.push(Arc::new(fill));
    }

    /// Faces from here on belong to patches.
    pub fn first_patch_face(&self) -> usize {
        self.origin.mesh.face_count()
    }

    /// The selected loops.
    pub fn selected(&self) -> Vec<&BoundaryLoop> {
        self.selection
            .iter()
            .filter_map(|&i| self.loops.get(i))
            .collect()
    }

    /// Indices of all loops that are not guessed outer rims.
    pub fn holes(&self) -> BTreeSet<usize> {
        (0..self.loops.len())
            .filter(|&i| !self.loops[i].outer_rim)
            .collect()
    }

    /// Indices of all loops but the one with the largest perimeter.
    pub fn all_but_largest(&self) -> BTreeSet<usize> {
        let largest = (0..self.loops.len())
            .max_by(|&a, &b| self.loops[a].perimeter.total_cmp(&self.loops[b].perimeter));
        (0..self.loops.len())
            .filter(|&i| Some(i) != largest)
            .collect()
    }

    /// Whether something was accepted since the mesh was opened.
    pub fn is_filled(&self) -> bool {
        !self.fills.is_empty()
    }

    /// The patches alone, as a mesh of their own (used vertices in order, rims included);
    /// `None` if there are none.
    pub fn patches(&self) -> Option<Mesh> {
        let first = self.first_patch_face();
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
        let mut colors = Vec::new();
        for (v, slot) in new_index.iter_mut().enumerate() {
            if *slot == 0 {
                *slot = positions.len() as u32;
                positions.push(self.mesh.positions[v]);
                if let Some(&c) = self.mesh.colors.get(v) {
                    colors.push(c);
                }
            }
        }
        let local: Vec<[u32; 3]> = triangles
            .iter()
            .map(|t| t.map(|v| new_index[v as usize]))
            .collect();
        let topology = Topology::from_triangles(positions.len(), &local).ok()?;
        let mut patches = Mesh::new(positions, topology);
        patches.colors = colors;
        Some(patches)
    }
}

/// The box around a mesh; one of size 1 around nothing.
pub fn bounds_of(mesh: &Mesh) -> Bounds {
    let unit = DVec3::splat(0.5);
    Bounds::of(mesh.positions.iter().copied()).unwrap_or(Bounds::new(-unit, unit))
}

/// The window's defaults: the flow in true time, so that there is something to watch.
pub fn window_controls() -> Controls {
    Controls {
        mode: crate::solver::Mode::Flow,
        ..Controls::default()
    }
}
