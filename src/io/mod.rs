//! Mesh files: OBJ, PLY, STL, OFF, glTF and 3MF, read and written. The extension determines the format.
//!
//! Reading takes one pass over the bytes. It returns the vertices of the file in the order of the
//! file, with coordinates rounded to the nearest `f64`. Writing is atomic and exact (OBJ, OFF and 3MF: the
//! shortest decimals that parse to the same bits; PLY: binary doubles), except for STL and glTF,
//! whose coordinates are `f32`. Errors contain the place in the file, what was found there, and the
//! remedy.
//!
//! ```no_run
//! use meniscus::io::{self, OutputMesh};
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let soup = io::load("scan.obj".as_ref())?;
//! let triangles: Vec<[u32; 3]> = (0..soup.face_count())
//!     .map(|f| [soup.face(f)[0], soup.face(f)[1], soup.face(f)[2]])
//!     .collect();
//! let mesh = OutputMesh {
//!     positions: &soup.positions,
//!     triangles: &triangles,
//!     attributes: &soup.attributes,
//!     ..OutputMesh::default()
//! };
//! io::save("copy.ply".as_ref(), &mesh)?;
//! # Ok(())
//! # }
//! ```

mod atomic;
mod check;
mod companions;
mod error;
mod gltf;
mod mesh_file;
mod number;
mod obj;
mod off;
mod own_materials;
mod ply;
mod stl;
#[cfg(test)]
mod tests;
mod text_scanner;
mod threemf;

use std::borrow::Cow;
use std::fs;
use std::io::{ErrorKind, Write};
use std::path::Path;
use std::sync::LazyLock;

pub use atomic::abandon_unfinished;
pub use check::{check, losses};
pub use companions::{Companions, copy_companions, materials};
pub use error::{
    LoadError, LoadErrorKind, MeshFault, ParseError, ParseErrorKind, Place, SaveError,
    SaveErrorKind, UnknownFormat,
};
pub use mesh_file::{
    OpenError, Opened, from_soup, open, open_joined, open_welded, save_mesh,
    save_mesh_keeping_files, with_output,
};

use crate::mesh::{Attributes, DVec3, ImageSource, Soup};
use own_materials::Beside;
use threemf::Sheet;

/// A mesh file format.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Format {
    /// Wavefront OBJ, text.
    Obj,
    /// Stanford PLY; text and both byte orders are read, binary little endian is written.
    Ply,
    /// STL; text and binary are read, binary is written.
    Stl,
    /// OFF, text.
    Off,
    /// Binary glTF 2.0.
    Glb,
    /// glTF 2.0 as JSON; buffers in data URIs and in files are read, data URIs are written.
    Gltf,
    /// 3MF.
    ThreeMf,
}

impl Format {
    /// All formats.
    pub const ALL: [Self; 7] = [
        Self::Obj,
        Self::Ply,
        Self::Stl,
        Self::Off,
        Self::Glb,
        Self::Gltf,
        Self::ThreeMf,
    ];

    /// The file extension, without the dot.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Obj => "obj",
            Self::Ply => "ply",
            Self::Stl => "stl",
            Self::Off => "off",
            Self::Glb => "glb",
            Self::Gltf => "gltf",
            Self::ThreeMf => "3mf",
        }
    }

    /// Whether coordinates are single precision numbers.
    fn is_single(self) -> bool {
        matches!(self, Self::Stl | Self::Glb | Self::Gltf)
    }

    /// Whether faces have materials with images. Faces of PLY files have numbers of images.
    fn has_materials(self) -> bool {
        matches!(self, Self::Obj | Self::Glb | Self::Gltf | Self::ThreeMf)
    }

    /// The format of the extension of `path`, in upper or lower case; `None` if it is unknown.
    pub fn from_path(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_str()?;
        Self::ALL
            .into_iter()
            .find(|f| f.extension().eq_ignore_ascii_case(extension))
    }
}

fn supported_extensions() -> String {
    Format::ALL
        .map(|f| format!(".{}", f.extension()))
        .join(", ")
}

fn unknown_target(path: &Path) -> SaveError {
    SaveErrorKind::UnknownFormat(unknown_format(path)).of(path)
}

fn unknown_format(path: &Path) -> UnknownFormat {
    UnknownFormat(path.extension().map(|e| e.to_string_lossy().into_owned()))
}

/// A triangle mesh to write, borrowed, in file order.
#[derive(Clone, Copy, Debug)]
pub struct OutputMesh<'a> {
    /// Vertex positions.
    pub positions: &'a [DVec3],
    /// Vertex indices of each triangle.
    pub triangles: &'a [[u32; 3]],
    /// Everything else. Rows of the vertex columns are vertices, and faces are the triangles. [`losses`]
    /// are the parts that a format cannot store.
    pub attributes: &'a Attributes,
}

impl Default for OutputMesh<'_> {
    fn default() -> Self {
        static NOTHING: LazyLock<Attributes> = LazyLock::new(Attributes::default);
        Self {
            positions: &[],
            triangles: &[],
            attributes: &NOTHING,
        }
    }
}

/// Reads the mesh file at `path`.
///
/// # Errors
/// [`LoadError`]: the file cannot be opened, its extension is unknown, or its contents are not a
/// valid mesh.
pub fn load(path: &Path) -> Result<Soup, LoadError> {
    let failed = |source: std::io::Error| {
        let kind = match source.kind() {
            ErrorKind::NotFound | ErrorKind::NotADirectory => LoadErrorKind::NotFound,
            ErrorKind::PermissionDenied => LoadErrorKind::PermissionDenied,
            _ => LoadErrorKind::Read(source),
        };
        kind.of(path)
    };
    // Check before opening, because opening a pipe would wait for its writer.
    let metadata = fs::metadata(path).map_err(failed)?;
    if metadata.is_dir() {
        return Err(LoadErrorKind::IsDirectory.of(path));
    }
    let Some(format) = Format::from_path(path) else {
        return Err(LoadErrorKind::UnknownFormat(unknown_format(path)).of(path));
    };
    if !metadata.is_file() {
        return Err(LoadErrorKind::NotAFile.of(path));
    }
    let bytes = fs::read(path).map_err(failed)?;
    let mut soup = read_in(format, &bytes, path, path.parent())?;
    soup.attributes.folder = path.parent().map(Path::to_owned);
    if format == Format::Obj {
        obj::look_up(path, &mut soup);
    }
    Ok(soup)
}

/// Reads a mesh from the bytes of a file. Messages contain `name`. A glTF file must contain its buffers.
///
/// # Errors
/// [`LoadErrorKind::Content`] with the place and the problem.
pub fn read(format: Format, bytes: &[u8], name: &Path) -> Result<Soup, LoadError> {
    read_in(format, bytes, name, None)
}

/// [`read`] of a file in a folder, which has the buffers of a glTF file.
fn read_in(
    format: Format,
    bytes: &[u8],
    name: &Path,
    folder: Option<&Path>,
) -> Result<Soup, LoadError> {
    let soup = match format {
        Format::Obj => obj::read(bytes),
        Format::Ply => ply::read(bytes),
        Format::Stl => stl::read(bytes),
        Format::Off => off::read(bytes),
        Format::Glb | Format::Gltf => gltf::read(bytes, folder),
        Format::ThreeMf => threemf::read(bytes),
    };
    soup.map_err(|error| LoadErrorKind::Content(error).of(name))
}

/// Writes `mesh` to `path` atomically, in the format of its extension.
///
/// It writes a temporary file in the same directory, syncs it to the disk and renames it. The images of
/// own materials are written before: beside an OBJ or PLY file, with names that begin with that of the file and
/// for OBJ with a material library of their own, and into a glTF or 3MF file.
///
/// # Errors
/// [`SaveError`]; an existing file is unchanged.
pub fn save(path: &Path, mesh: &OutputMesh<'_>) -> Result<(), SaveError> {
    save_named(path, mesh).map(drop)
}

/// [`save`], which returns the names of the files that were written beside the mesh file.
fn save_named(path: &Path, mesh: &OutputMesh<'_>) -> Result<Vec<String>, SaveError> {
    let format = Format::from_path(path).ok_or_else(|| unknown_target(path))?;
    check(format, mesh).map_err(|reason| SaveErrorKind::Mesh(reason).of(path))?;
    let Some(beside) = Beside::of(path, mesh.attributes) else {
        atomic::replace(path, |out| write(format, mesh, out))?;
        return Ok(Vec::new());
    };
    beside.write()?;
    let mesh = OutputMesh {
        attributes: beside.attributes(),
        ..*mesh
    };
    atomic::replace(path, |out| write(format, &mesh, out))?;
    Ok(beside.names())
}

/// Writes a text file atomically.
///
/// # Errors
/// [`SaveError`]; an existing file is unchanged.
pub fn save_text(path: &Path, text: &str) -> Result<(), SaveError> {
    atomic::replace(path, |out| out.write_all(text.as_bytes()))
}

/// Calls `fill` to write a file that then atomically replaces `path`.
///
/// # Errors
/// [`SaveError`], also for an error returned by `fill`; an existing file is unchanged.
pub fn save_with(
    path: &Path,
    fill: impl FnOnce(&mut dyn Write) -> std::io::Result<()>,
) -> Result<(), SaveError> {
    atomic::replace(path, fill)
}

/// Checks before a long computation that [`save`] can write to `path`: the extension is known, the
/// directory exists and is writable, and an existing file is not write-protected.
///
/// # Errors
/// The [`SaveError`] that [`save`] would return.
pub fn check_target(path: &Path) -> Result<Format, SaveError> {
    let format = Format::from_path(path).ok_or_else(|| unknown_target(path))?;
    atomic::probe(path)?;
    Ok(format)
}

/// Checks before a long computation that [`save_text`] or [`save_with`] can write to `path`.
///
/// # Errors
/// The [`SaveError`] that they would return.
pub fn check_text_target(path: &Path) -> Result<(), SaveError> {
    atomic::probe(path)
}

/// Writes `mesh`, which [`check()`] has accepted, to any writer.
///
/// # Errors
/// The error of the writer.
///
/// # Panics
/// May panic on a mesh that [`check()`] refuses.
pub fn write(format: Format, mesh: &OutputMesh<'_>, out: &mut dyn Write) -> std::io::Result<()> {
    let attributes = converted(format, mesh);
    let mesh = OutputMesh {
        attributes: &attributes,
        ..*mesh
    };
    match format {
        Format::Obj => obj::write(&mesh, out),
        Format::Ply => ply::write(&mesh, out),
        Format::Stl => stl::write(&mesh, out),
        Format::Off => off::write(&mesh, out),
        Format::Glb => gltf::write(&mesh, materials(&attributes), true, out),
        Format::Gltf => gltf::write(&mesh, materials(&attributes), false, out),
        Format::ThreeMf => threemf::write(&mesh, &Sheet::of(&mesh), out),
    }
}

/// The attributes as a format stores them.
fn converted<'a>(format: Format, mesh: &OutputMesh<'a>) -> Cow<'a, Attributes> {
    let is_down = matches!(format, Format::Glb | Format::Gltf);
    let stored = check::storable(format, mesh);
    if stored.texture_is_down != is_down && !stored.faces.texture.is_empty() {
        return Cow::Owned(stored.with_turned_texture());
    }
    stored
}

/// [`save`], which returns messages for the user: the [`losses`], and what was written beside it. Images are read
/// once.
fn save_with_messages(path: &Path, mesh: &OutputMesh<'_>) -> Result<Vec<String>, SaveError> {
    match Format::from_path(path) {
        Some(Format::ThreeMf) => {
            let attributes = converted(Format::ThreeMf, mesh);
            let mesh = OutputMesh {
                attributes: &attributes,
                ..*mesh
            };
            check(Format::ThreeMf, &mesh).map_err(|reason| SaveErrorKind::Mesh(reason).of(path))?;
            let sheet = Sheet::of(&mesh);
            atomic::replace(path, |out| threemf::write(&mesh, &sheet, out))?;
            Ok(check::other_losses(Format::ThreeMf, &mesh, Some(&sheet)))
        }
        format => {
            let beside = save_named(path, mesh)?;
            let mut messages = format.map_or_else(Vec::new, |format| losses(format, mesh));
            if !beside.is_empty() {
                messages.push(format!("written beside it: {}", beside.join(", ")));
            }
            Ok(messages)
        }
    }
}

/// The type of an image file that glTF and 3MF may contain: PNG or JPEG.
fn media_type(bytes: &[u8]) -> Option<&'static str> {
    if bytes.starts_with(b"\x89PNG") {
        Some("image/png")
    } else if bytes.starts_with(&[0xff, 0xd8, 0xff]) {
        Some("image/jpeg")
    } else {
        None
    }
}

/// The [`media_type`] of an image; of a file, only the beginning is read.
///
/// # Errors
/// Why glTF and 3MF cannot contain it.
fn stored_media(image: &ImageSource) -> Result<&'static str, String> {
    let start = image.start().map_err(|error| error.to_string())?;
    media_type(&start).ok_or_else(|| "it is no PNG or JPEG file; convert it".to_owned())
}

/// Whether both paths refer to the same file, also by links or different spellings. If one does not
/// exist, they are the same if directory and name are equal.
pub fn same_file(a: &Path, b: &Path) -> bool {
    #[cfg(unix)]
    if let (Ok(a), Ok(b)) = (fs::metadata(a), fs::metadata(b)) {
        use std::os::unix::fs::MetadataExt;
        return a.dev() == b.dev() && a.ino() == b.ino();
    }
    match (resolve(a), resolve(b)) {
        (Some(a), Some(b)) => a == b,
        _ => a == b,
    }
}

fn resolve(path: &Path) -> Option<std::path::PathBuf> {
    if let Ok(real) = fs::canonicalize(path) {
        return Some(real);
    }
    let parent = path
        .parent()
        .filter(|p| !p.as_os_str().is_empty())
        .unwrap_or(Path::new("."));
    Some(fs::canonicalize(parent).ok()?.join(path.file_name()?))
}
