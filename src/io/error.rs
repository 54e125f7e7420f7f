//! What can go wrong with a file, with the place, what was found there and what to do about it.

use std::fmt;
use std::path::{Path, PathBuf};

/// Why a mesh file could not be read.
#[derive(Debug, thiserror::Error)]
#[error("{}: {kind}", .path.display())]
#[non_exhaustive]
pub struct LoadError {
    /// The path given.
    pub path: PathBuf,
    /// What is wrong with the file.
    pub kind: LoadErrorKind,
}

/// What keeps a file from being read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LoadErrorKind {
    /// Nothing has that name.
    #[error("no such file; check the path")]
    NotFound,
    /// The operating system refused to open the file.
    #[error("no permission to read the file; check its owner and mode")]
    PermissionDenied,
    /// The path names a directory.
    #[error("is a directory; give the path of a mesh file in it")]
    IsDirectory,
    /// The path names a device, a pipe or a socket, whose end may never come.
    #[error("is not a regular file; copy the data into one first")]
    NotAFile,
    /// The extension names no supported format.
    #[error(transparent)]
    UnknownFormat(UnknownFormat),
    /// Reading failed half-way.
    #[error("reading failed: {0}")]
    Read(std::io::Error),
    /// The file was read, but it is not a sound mesh file.
    #[error("{0}")]
    Content(ParseError),
}

/// Why a mesh could not be written. Whatever stood at the path before is untouched.
#[derive(Debug, thiserror::Error)]
#[error("{}: {kind}", .path.display())]
#[non_exhaustive]
pub struct SaveError {
    /// The path given.
    pub path: PathBuf,
    /// What is in the way.
    pub kind: SaveErrorKind,
}

/// What keeps a file from being written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SaveErrorKind {
    /// The extension names no supported format.
    #[error(transparent)]
    UnknownFormat(UnknownFormat),
    /// The directory to write to does not exist.
    #[error("there is no directory {}; create it first", .0.display())]
    DirectoryMissing(PathBuf),
    /// The path names a directory.
    #[error("is a directory; give the name of a file in it")]
    IsDirectory,
    /// The file exists and is write-protected.
    #[error("is read-only and was left as it is; choose another name or make it writable")]
    ReadOnly,
    /// The operating system refused to write there.
    #[error("no permission to write in that directory; nothing was changed")]
    PermissionDenied,
    /// No space, or the quota is used up.
    #[error("the disk is full; nothing was changed, free some space or choose another disk")]
    DiskFull,
    /// Any other failure of the operating system.
    #[error("writing failed: {0}; nothing was changed")]
    Write(std::io::Error),
    /// The mesh cannot be represented in that file.
    #[error("not written: {0}")]
    Mesh(MeshFault),
}

/// An extension that names no supported format; `None` without extension.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}; supported are {}", extension_words(.0.as_deref()), super::supported_extensions())]
pub struct UnknownFormat(pub Option<String>);

impl LoadErrorKind {
    /// The error for the file at `path`.
    pub(super) fn of(self, path: &Path) -> LoadError {
        LoadError {
            path: path.to_owned(),
            kind: self,
        }
    }
}

impl SaveErrorKind {
    /// The error for the file at `path`.
    pub(super) fn of(self, path: &Path) -> SaveError {
        SaveError {
            path: path.to_owned(),
            kind: self,
        }
    }
}

/// What keeps a mesh from being written.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MeshFault {
    /// A coordinate is NaN or infinite.
    #[error("vertex {vertex} (counted from 0) has the coordinate {value}, which is not finite")]
    NotFinite {
        /// The vertex, counted from 0.
        vertex: usize,
        /// The coordinate.
        value: f64,
    },
    /// STL stores `f32`, whose range is exceeded.
    #[error(
        "vertex {vertex} (counted from 0) has the coordinate {value:e}, beyond the single-precision range of STL; write OBJ or PLY"
    )]
    BeyondSingle {
        /// The vertex, counted from 0.
        vertex: usize,
        /// The coordinate.
        value: f64,
    },
    /// A corner names a vertex that is not there.
    #[error(
        "triangle {triangle} (counted from 0) uses vertex {index}, but there are only {vertices}"
    )]
    IndexRange {
        /// The triangle, counted from 0.
        triangle: usize,
        /// The index it uses.
        index: u32,
        /// Number of vertices.
        vertices: usize,
    },
    /// An attribute array has the wrong length or an index out of range.
    #[error("{what}: {found} entries where {wanted} belong")]
    Attribute {
        /// Which attribute.
        what: &'static str,
        /// Its length, or the tag index.
        found: usize,
        /// The length it must have, or the number of tags.
        wanted: usize,
    },
    /// More elements than the format can count.
    #[error("{count} {what} are more than the format can count")]
    TooMany {
        /// What there is too much of.
        what: &'static str,
        /// How many.
        count: usize,
    },
}

/// What is wrong with the contents of a file, and where.
#[derive(Clone, Debug, PartialEq)]
pub struct ParseError {
    /// Where in the file.
    pub place: Place,
    /// What is wrong there.
    pub kind: ParseErrorKind,
}

impl fmt::Display for ParseError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.place {
            Place::File => write!(f, "{}", self.kind),
            Place::Line(line) => write!(f, "line {line}: {}", self.kind),
            Place::Byte(byte) => write!(f, "byte {byte}: {}", self.kind),
        }
    }
}

/// A place in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// The file as a whole.
    File,
    /// A line of a text file, counted from 1.
    Line(usize),
    /// A byte of a binary file, counted from 0.
    Byte(usize),
}

/// What is wrong with the contents of a file. Vertices and faces are counted from 1 here.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ParseErrorKind {
    /// Zero bytes.
    #[error("the file is empty (0 bytes); export the mesh again")]
    Empty,
    /// Text without a single statement.
    #[error("the file holds comments or blank lines only, no mesh; export the mesh again")]
    NothingButComments,
    /// Something else than the format.
    #[error(
        "this does not look like {format}: found {found}; check that the extension fits the contents"
    )]
    NotThisFormat {
        /// The format that was expected.
        format: &'static str,
        /// What is there instead.
        found: String,
    },
    /// Faces or nothing at all, but no vertices.
    #[error("no vertices in the file; export the mesh again")]
    NoVertices,
    /// Vertices but no faces.
    #[error("{vertices} vertices but no faces, so there is no surface{}; export the mesh with its faces", cut_words(*.cut))]
    NoFaces {
        /// How many vertices there are.
        vertices: usize,
        /// Whether the file ends in the middle of a line.
        cut: bool,
    },
    /// Something that should be a number is none.
    #[error("{what} is not a number: '{found}'{}", comma_words(.found))]
    NotANumber {
        /// What the number would have been.
        what: String,
        /// What is there instead.
        found: String,
    },
    /// A coordinate is NaN or infinite (or too large for a double).
    #[error(
        "vertex {vertex} has the coordinate {axis} = '{found}', which is not a finite number; repair or remove this vertex"
    )]
    NotFinite {
        /// The vertex, counted from 1.
        vertex: usize,
        /// `x`, `y` or `z`.
        axis: char,
        /// The text or value found.
        found: String,
    },
    /// A vertex line with too few or too many numbers.
    #[error("vertex {vertex} has {found} numbers; {wanted} are expected")]
    VertexNumbers {
        /// The vertex, counted from 1.
        vertex: usize,
        /// How many numbers there are.
        found: usize,
        /// How many there may be.
        wanted: &'static str,
    },
    /// A face with fewer than three corners.
    #[error(
        "face {face} has {found} corners, but a face needs 3{}; remove it or export the mesh again",
        cut_words(*.cut)
    )]
    FewCorners {
        /// The face, counted from 1.
        face: usize,
        /// How many corners it has.
        found: usize,
        /// Whether the file ends in the middle of this line.
        cut: bool,
    },
    /// An index 0 where counting starts at 1.
    #[error("face {face} uses vertex 0, but OBJ counts from 1; a face of this file is broken")]
    IndexZero {
        /// The face, counted from 1.
        face: usize,
    },
    /// An index beyond the vertices.
    #[error(
        "face {face} uses vertex {found}, but there are {vertices} vertices, counted from {first}; a face of this file is broken, or vertices are missing"
    )]
    IndexRange {
        /// The face, counted from 1.
        face: usize,
        /// The index as the file writes it.
        found: i64,
        /// Number of vertices (for a negative index, of those above the face).
        vertices: usize,
        /// What the format counts from.
        first: u8,
    },
    /// A corner that cannot be read.
    #[error(
        "face {face} has the corner '{found}'; a corner is v, v/vt, v//vn or v/vt/vn in integers"
    )]
    BadCorner {
        /// The face, counted from 1.
        face: usize,
        /// What is there instead.
        found: String,
    },
    /// The file ends too early.
    #[error("the file is cut off: {what}; copy or export it again")]
    Truncated {
        /// What was expected and what is there.
        what: String,
    },
    /// A statement that cannot be understood.
    #[error("{what}: '{found}'")]
    Syntax {
        /// What is wrong.
        what: String,
        /// What is there.
        found: String,
    },
    /// A legal feature that is not read.
    #[error("{what} cannot be read; {remedy}")]
    Unsupported {
        /// The feature.
        what: String,
        /// What to do instead.
        remedy: &'static str,
    },
    /// More elements than 32-bit indices can name.
    #[error("{what}: more than {limit}; split the mesh")]
    TooLarge {
        /// What there is too much of.
        what: &'static str,
        /// The most there can be.
        limit: u64,
    },
}

impl ParseErrorKind {
    pub(super) fn syntax(what: impl Into<String>, found: impl Into<String>) -> Self {
        Self::Syntax {
            what: what.into(),
            found: found.into(),
        }
    }

    pub(super) fn truncated(what: impl Into<String>) -> Self {
        Self::Truncated { what: what.into() }
    }

    /// Too many elements for 32-bit indices.
    pub(super) fn too_large(what: &'static str) -> Self {
        Self::TooLarge {
            what,
            limit: u64::from(u32::MAX),
        }
    }
}

fn extension_words(extension: Option<&str>) -> String {
    match extension {
        Some(ext) => format!("unknown file type '.{ext}'"),
        None => "no file extension".to_owned(),
    }
}

fn cut_words(cut: bool) -> &'static str {
    if cut {
        " (the file ends in the middle of a line, it may be cut off)"
    } else {
        ""
    }
}

fn comma_words(found: &str) -> &'static str {
    let decimal = |c: char| c.is_ascii_digit() || matches!(c, ',' | '-' | '+' | 'e' | 'E');
    if found.contains(',') && found.chars().all(decimal) {
        " (numbers need a decimal point, not a comma)"
    } else {
        ""
    }
}

impl Place {
    pub(super) fn error(self, kind: ParseErrorKind) -> ParseError {
        ParseError { place: self, kind }
    }
}

pub(super) fn at_line(line: usize, kind: ParseErrorKind) -> ParseError {
    Place::Line(line).error(kind)
}

pub(super) fn at_byte(byte: usize, kind: ParseErrorKind) -> ParseError {
    Place::Byte(byte).error(kind)
}

pub(super) fn in_file(kind: ParseErrorKind) -> ParseError {
    Place::File.error(kind)
}

/// A piece of the file for a message: short, and printable whatever the bytes are.
pub(super) fn excerpt(bytes: &[u8]) -> String {
    const LONGEST: usize = 40;
    let cut = &bytes[..bytes.len().min(LONGEST)];
    let mut text: String = String::from_utf8_lossy(cut).escape_debug().collect();
    if bytes.len() > LONGEST {
        text.push_str("...");
    }
    text
}
