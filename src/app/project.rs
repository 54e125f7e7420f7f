//! The project file: mesh, operations, options and view.
//!
//! It consists of a TOML head and, unless the mesh is an unchanged file or sample, the line
//! [`ATTRIBUTES`] and the attributes as JSON, the line [`MESH`] and positions and triangles as OBJ. The head contains the path of the mesh relative to the project
//! file.

use std::io::Read as _;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::document::{AppliedOperation, Document, Source, file_name};
use super::report::ReportView;
use super::view_state::ViewState;
use crate::fill::Controls;
use crate::io::{self, Format, Opened, OutputMesh};
use crate::mesh::{
    Attributes, Column, DVec3, NO_VALUE, Soup, parse_ranges, ranges_text, row_count,
};
use crate::options::Choice;
use crate::render::{Bounds, Camera, ViewMode, ViewStyle};
use crate::shapes::Sample;

/// Extension of project files.
pub const EXTENSION: &str = "meniscus";
/// The line between head and attributes; a file without it has those that OBJ stores.
const ATTRIBUTES: &str = "#--- attributes (JSON) ---";
/// The line before the mesh.
const MESH: &str = "#--- mesh (OBJ) ---";
const VERSION: u32 = 1;

/// The head.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Project {
    version: u32,
    /// Mesh file, relative to the project file.
    #[serde(skip_serializing_if = "Option::is_none")]
    mesh: Option<PathBuf>,
    /// Built-in sample.
    #[serde(skip_serializing_if = "Option::is_none")]
    sample: Option<String>,
    /// Counts of the mesh, `[vertices, faces]`, as a check. Patches begin after them if
    /// `first_patch_face` is missing.
    opened: [usize; 2],
    /// The first face of a patch.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    first_patch_face: Option<usize>,
    /// Indices of the selected loops.
    selection: Vec<usize>,
    /// The selected faces, as a list of ranges.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    selected_faces: String,
    /// The view.
    pub view: ViewPart,
    controls: Controls,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    fills: Vec<AppliedOperation>,
}

/// The stored part of the view.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ViewPart {
    camera: String,
    mode: String,
    stripes: u32,
    light: [f64; 3],
    #[serde(default)]
    light_follows_view: bool,
    #[serde(default)]
    zebra_turn: f64,
    /// Ends of the colour map, if they were set.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    range: Option<[f32; 2]>,
    wireframe: bool,
    tint: bool,
    limit_surface: bool,
    rims: bool,
    #[serde(default)]
    report: ReportView,
}

/// The text of a project file in `folder`. It refers to the mesh by name if that is an unchanged
/// file or sample, and contains the mesh otherwise. It also contains the mesh if the path is not
/// Unicode, because TOML cannot store such a path.
pub fn write(document: &Document, view: &ViewState, folder: &Path) -> String {
    let origin = &document.origin;
    let named = |path: &Path| Some(relative(path, folder)).filter(|p| p.to_str().is_some());
    let (mut mesh, mut sample) = (None, None);
    match &origin.source {
        Source::File(path) => mesh = named(path),
        Source::Sample(name) => sample = Some(name.clone()),
        Source::Embedded => {}
    }
    let embed = document.is_changed() || (mesh.is_none() && sample.is_none());
    let style = &view.style;
    let head = Project {
        version: VERSION,
        mesh,
        sample,
        opened: [document.mesh.vertex_count(), document.mesh.face_count()],
        first_patch_face: document.is_changed().then_some(document.first_patch_face),
        selected_faces: ranges_text(&document.faces),
        selection: document.selection.iter().map(|id| id.index()).collect(),
        view: ViewPart {
            camera: view.camera.to_text(),
            mode: style.mode.name().into(),
            stripes: style.stripes,
            light: style.light.to_array(),
            light_follows_view: style.light_follows_view,
            zebra_turn: style.zebra_turn,
            range: style.range,
            wireframe: style.wireframe,
            tint: style.tint_patch,
            limit_surface: view.limit_surface,
            rims: view.show_rims,
            report: ReportView {
                reference: view.report.reference.as_deref().and_then(named),
                ..view.report.clone()
            },
        },
        controls: document.controls.clone(),
        fills: document
            .accepted
            .iter()
            .map(|one| (**one).clone())
            .collect(),
    };
    let mut text = String::from("# Meniscus project\n");
    // TOML can represent every value
    text += &toml::to_string(&head).expect("a project is plain data");
    if embed {
        let mut bytes = Vec::new();
        io::with_output(&document.mesh, |output| {
            let attributes = serde_json::to_string(output.attributes);
            let attributes = attributes.expect("attributes are plain data");
            text.extend([ATTRIBUTES, "\n", &attributes, "\n", MESH, "\n"]);
            let bare = OutputMesh {
                positions: output.positions,
                triangles: output.triangles,
                ..OutputMesh::default()
            };
            // writing to a vector cannot fail
            io::write(Format::Obj, &bare, &mut bytes).ok();
        });
        text += &String::from_utf8_lossy(&bytes);
    }
    text
}

/// Reads a project file.
///
/// # Errors
/// A message for the user: the file, or the mesh that it refers to, is invalid.
pub fn read(path: &Path) -> Result<(Document, Project), String> {
    let text = std::fs::read_to_string(path)
        .map_err(|e| format!("{}: {e}; check the path", path.display()))?;
    parse(&text, path)
}

/// Reads the text of a project file at `path`.
///
/// # Errors
/// As [`read`].
fn parse(text: &str, path: &Path) -> Result<(Document, Project), String> {
    let name = path.display();
    let separator = format!("\n{MESH}\n");
    // use the last such line: a value of the head may contain it, a mesh cannot
    let (head, body) = match text.rsplit_once(&separator) {
        Some((head, body)) => (head, Some(body)),
        None => (text, None),
    };
    let (head, attributes) = match head.rsplit_once(&format!("\n{ATTRIBUTES}\n")) {
        Some((head, attributes)) => (head, Some(attributes)),
        None => (head, None),
    };
    let mut project: Project =
        toml::from_str(head).map_err(|e| format!("{name} is not a valid project file: {e}"))?;
    if project.version > VERSION {
        return Err(format!(
            "{name} has the newer format version {}; this program reads versions up to {VERSION}",
            project.version
        ));
    }
    let folder = path.parent().unwrap_or(Path::new("."));
    if let Some(reference) = &mut project.view.report.reference {
        *reference = folder.join(&*reference);
    }
    let mesh_path = project.mesh.as_ref().map(|p| folder.join(p));
    let (opened, source) = if let Some(body) = body {
        let mut soup = io::read(Format::Obj, body.as_bytes(), path).map_err(|e| e.to_string())?;
        if let Some(text) = attributes {
            let all = serde_json::from_str(text).map_err(|e| e.to_string());
            let all = all.and_then(|all| checked(all, &soup));
            soup.attributes =
                all.map_err(|e| format!("{name} has attributes that do not fit its mesh: {e}"))?;
        }
        // material libraries and images are beside the mesh file
        let beside = mesh_path.as_deref().and_then(Path::parent);
        soup.attributes.folder = beside.map(Path::to_owned);
        let opened = io::from_soup(&soup, path).map_err(|e| e.to_string())?;
        let source = match (&mesh_path, &project.sample) {
            // the mesh was stored although nothing has changed it
            _ if project.fills.is_empty() => Source::Embedded,
            (Some(path), _) => Source::File(path.clone()),
            (None, Some(sample)) => Source::Sample(sample.clone()),
            (None, None) => Source::Embedded,
        };
        (opened, source)
    } else if let Some(mesh_path) = mesh_path {
        let opened = io::open(&mesh_path).map_err(|e| {
            format!(
                "{name}: the mesh cannot be opened: \
                                                               {e}"
            )
        })?;
        (opened, Source::File(mesh_path))
    } else if let Some(sample) = &project.sample {
        (sample_of(sample)?, Source::Sample(sample.clone()))
    } else {
        return Err(format!("{name} contains no mesh and no reference to one"));
    };
    let document = restore(opened, source, &project).map_err(|e| format!("{name}: {e}"))?;
    Ok((document, project))
}

/// Attributes that fit the triangles of a soup.
fn checked(all: Attributes, soup: &Soup) -> Result<Attributes, String> {
    if soup.corners.len() != 3 * soup.face_count() {
        return Err("its faces are no triangles".to_owned());
    }
    let mesh = OutputMesh {
        positions: &soup.positions,
        triangles: soup.corners.as_chunks().0,
        attributes: &all,
    };
    io::check(Format::Ply, &mesh).map_err(|e| e.to_string())?;
    let has = |corners: &[u32], columns: &[Column], counts: &[usize]| {
        let mut lengths = columns.iter().map(|column| column.numbers.len());
        lengths.all(|length| length == row_count(columns))
            && (corners.is_empty() || counts.contains(&columns.len()))
    };
    let fits = has(&all.faces.texture, &all.texture, &[2, 3])
        && has(&all.faces.normals, &all.normals, &[3])
        && !all.faces.tags.contains(&NO_VALUE);
    if fits {
        Ok(all)
    } else {
        Err("a list has an unexpected length".to_owned())
    }
}

/// Reads the text of a project file and writes it again, for tests of round trips.
///
/// # Errors
/// As for opening the file.
pub fn rewrite_project(text: &str) -> Result<String, String> {
    let folder = Path::new("/");
    let (document, project) = parse(text, &folder.join("project.meniscus"))?;
    let bounds = Bounds::of(document.mesh.positions.iter().copied()).unwrap_or_default();
    let mut view = ViewState::new(&bounds, ViewStyle::default());
    project.view.restore(&mut view, &bounds);
    Ok(write(&document, &view, folder))
}

/// The name of the mesh of a project file, for lists; the name of the file if it has none.
pub fn title(path: &Path) -> String {
    let own = || file_name(path);
    let mut head = String::new();
    let Ok(file) = std::fs::File::open(path) else {
        return own();
    };
    // enough for the head; the mesh may be large
    if file.take(1 << 16).read_to_string(&mut head).is_err() {
        return own();
    }
    let value = |line: &str| line.split('"').nth(1).map(str::to_owned);
    head.lines()
        .find_map(|line| {
            if line.starts_with("mesh = ") {
                Some(file_name(Path::new(&value(line)?)))
            } else if line.starts_with("sample = ") {
                Some(format!("sample {}", value(line)?))
            } else {
                None
            }
        })
        .unwrap_or_else(own)
}

/// Opens a sample.
///
/// # Errors
/// No sample has this name.
pub fn sample_of(name: &str) -> Result<Opened, String> {
    let sample = Sample::named(name).ok_or_else(|| format!("unknown sample `{name}`"))?;
    io::from_soup(&sample.soup(), Path::new(name)).map_err(|e| e.to_string())
}

fn restore(opened: Opened, source: Source, project: &Project) -> Result<Document, String> {
    let mut document = Document::new(opened, source);
    let (mesh, [vertices, faces]) = (&document.mesh, project.opened);
    if mesh.vertex_count() < vertices || mesh.face_count() < faces {
        return Err(format!(
            "the mesh has {} vertices and {} faces now, but had {vertices} and {faces} when the \
             project was saved; open the mesh itself",
            mesh.vertex_count(),
            mesh.face_count()
        ));
    }
    document.faces = Arc::new(parse_ranges(&project.selected_faces, mesh.face_count())?);
    if !project.fills.is_empty() {
        let first = project.first_patch_face.unwrap_or(faces);
        document.first_patch_face = first.min(document.mesh.face_count());
        document.accepted = project.fills.iter().cloned().map(Arc::new).collect();
    }
    let loops = document.loops.iter().map(|l| l.id);
    document.selection = loops
        .filter(|id| project.selection.contains(&id.index()))
        .collect();
    document.controls = project.controls.clone();
    Ok(document)
}

/// `path` relative to `folder` if it is inside, else absolute.
fn relative(path: &Path, folder: &Path) -> PathBuf {
    let absolute = |p: &Path| std::path::absolute(p).unwrap_or_else(|_| p.to_owned());
    let (path, folder) = (absolute(path), absolute(folder));
    path.strip_prefix(&folder)
        .map_or_else(|_| path.clone(), Path::to_owned)
}

impl ViewPart {
    /// Restores the stored view.
    pub fn restore(&self, view: &mut ViewState, bounds: &Bounds) {
        if let Ok(camera) = Camera::parse(&self.camera, bounds) {
            view.camera = camera;
            view.fit = false;
        }
        if let Some(mode) = ViewMode::named(&self.mode) {
            view.style.mode = mode;
        }
        view.style.stripes = self.stripes.clamp(1, 100);
        let light = DVec3::from_array(self.light);
        if light.is_finite() && light != DVec3::ZERO {
            view.style.light = light;
        }
        view.style.light_follows_view = self.light_follows_view;
        if self.zebra_turn.is_finite() {
            view.style.zebra_turn = self.zebra_turn;
        }
        view.style.range = self.range.filter(|[low, high]| low < high);
        view.style.wireframe = self.wireframe;
        view.style.tint_patch = self.tint;
        view.limit_surface = self.limit_surface;
        view.show_rims = self.rims;
        view.report = self.report.clone().checked();
    }
}
