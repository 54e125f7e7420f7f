//! Errors of files: the place, what was found there, and the remedy.

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

/// Why a file cannot be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LoadErrorKind {
    /// The file does not exist.
    #[error("the file does not exist; check the path")]
    NotFound,
    /// The operating system refused to open the file.
    #[error("no permission to read the file; check its owner and mode")]
    PermissionDenied,
    /// The path names a directory.
    #[error("this is a directory; give the path of a mesh file")]
    IsDirectory,
    /// The path is a device, a pipe or a socket, which may have no end.
    #[error("this is not a regular file; copy the data into a file first")]
    NotAFile,
    /// The file extension is unsupported.
    #[error(transparent)]
    UnknownFormat(UnknownFormat),
    /// Reading failed.
    #[error("reading failed: {0}")]
    Read(std::io::Error),
    /// The contents of the file are invalid.
    #[error("{0}")]
    Content(ParseError),
}

/// Why a mesh could not be written. An existing file at the path is unchanged.
#[derive(Debug, thiserror::Error)]
#[error("{}: {kind}", .path.display())]
#[non_exhaustive]
pub struct SaveError {
    /// The path given.
    pub path: PathBuf,
    /// Why the file cannot be written.
    pub kind: SaveErrorKind,
}

/// Why a file cannot be written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SaveErrorKind {
    /// The file extension is unsupported.
    #[error(transparent)]
    UnknownFormat(UnknownFormat),
    /// The directory to write to does not exist.
    #[error("the directory {} does not exist; create it first", .0.display())]
    DirectoryMissing(PathBuf),
    /// The path names a directory.
    #[error("this is a directory; add a file name")]
    IsDirectory,
    /// The file exists and is write-protected.
    #[error("the file is read-only and was not changed; choose another name or make it writable")]
    ReadOnly,
    /// The operating system refused to write there.
    #[error("no permission to write to this directory; nothing was changed")]
    PermissionDenied,
    /// The disk is full, or the quota is used up.
    #[error("the disk is full and nothing was changed; free some space or choose another disk")]
    DiskFull,
    /// Any other failure of the operating system.
    #[error("writing failed: {0}; nothing was changed")]
    Write(std::io::Error),
    /// The format cannot represent the mesh.
    #[error("not written: {0}")]
    Mesh(MeshFault),
}

/// An unsupported file extension; `None` if there is no extension.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "{}; supported extensions are {}",
    extension_words(.0.as_deref()),
    super::supported_extensions()
)]
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

/// Why a mesh cannot be written.
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
    /// The format stores `f32`, whose range is exceeded.
    #[error(
        "vertex {vertex} (counted from 0) has the coordinate {value:e}, which exceeds the \
         single-precision range of the format; write OBJ or PLY"
    )]
    BeyondSingle {
        /// The vertex, counted from 0.
        vertex: usize,
        /// The coordinate.
        value: f64,
    },
    /// A corner uses a vertex that does not exist.
    #[error(
        "triangle {triangle} (counted from 0) uses vertex {index}, but there are only {vertices} \
         vertices"
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
    #[error("{what}: {found} entries, expected {wanted}")]
    Attribute {
        /// Which attribute.
        what: &'static str,
        /// Its length, or the tag index.
        found: usize,
        /// The length it must have, or the number of tags.
        wanted: usize,
    },
    /// More elements than the format can count.
    #[error("{count} {what} exceed the limit of the format")]
    TooMany {
        /// The kind of element.
        what: &'static str,
        /// Number of the elements.
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
    /// Text without a statement.
    #[error("the file contains only comments or blank lines, no mesh; export the mesh again")]
    NothingButComments,
    /// The contents have a different format.
    #[error(
        "this is not valid {format}: found {found}; check that the extension matches the contents"
    )]
    NotThisFormat {
        /// The format that was expected.
        format: &'static str,
        /// The text found.
        found: String,
    },
    /// There are no vertices.
    #[error("the file contains no vertices; export the mesh again")]
    NoVertices,
    /// Vertices but no faces.
    #[error("the file contains {vertices} vertices but no faces{}; export the mesh with its \
             faces", cut_words(*.cut))]
    NoFaces {
        /// Number of vertices.
        vertices: usize,
        /// Whether the file ends in the middle of a line.
        cut: bool,
    },
    /// A text is not a number.
    #[error("{what} is not a number: '{found}'{}", comma_words(.found))]
    NotANumber {
        /// The meaning of the number.
        what: String,
        /// The text found.
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
        /// Number of numbers found.
        found: usize,
        /// The accepted numbers of numbers.
        wanted: &'static str,
    },
    /// A face with fewer than three corners.
    #[error(
        "face {face} has {found} corners, but a face needs at least 3{}; remove it or export the \
         mesh again",
        cut_words(*.cut)
    )]
    FewCorners {
        /// The face, counted from 1.
        face: usize,
        /// Number of its corners.
        found: usize,
        /// Whether the file ends in the middle of the line.
        cut: bool,
    },
    /// The index 0 in a format that counts from 1.
    #[error("face {face} uses vertex 0, but OBJ counts from 1; repair or remove this face")]
    IndexZero {
        /// The face, counted from 1.
        face: usize,
    },
    /// An index beyond the vertices.
    #[error(
        "face {face} uses vertex {found}, but there are {vertices} vertices, counted from {first}; \
         the index is wrong, or vertices are missing"
    )]
    IndexRange {
        /// The face, counted from 1.
        face: usize,
        /// The index as the file writes it.
        found: i64,
        /// Number of vertices (for a negative index, of those above the face).
        vertices: usize,
        /// The first index of the format.
        first: u8,
    },
    /// A corner that cannot be read.
    #[error(
        "face {face} has the corner '{found}'; a corner is v, v/vt, v//vn or v/vt/vn in integers"
    )]
    BadCorner {
        /// The face, counted from 1.
        face: usize,
        /// The text found.
        found: String,
    },
    /// The file ends too early.
    #[error("the file is cut off: {what}; copy or export it again")]
    Truncated {
        /// What was expected and what was found.
        what: String,
    },
    /// The bytes of the file are not those that were written.
    #[error("the file is damaged: {what}; copy or export it again")]
    Damaged {
        /// What cannot be read.
        what: String,
    },
    /// A statement that cannot be parsed.
    #[error("{what}: '{found}'")]
    Syntax {
        /// What is wrong.
        what: String,
        /// The text found.
        found: String,
    },
    /// Contents that contradict themselves or the format.
    #[error("{what}; export the mesh again")]
    Invalid {
        /// What is wrong, and where.
        what: String,
    },
    /// Another file that this one needs.
    #[error("{what}; {remedy}")]
    Unavailable {
        /// The file and the reason.
        what: String,
        /// The remedy.
        remedy: &'static str,
    },
    /// An error in a text inside the file.
    #[error("{part}, line {line}: {kind}")]
    InPart {
        /// The name of the part.
        part: String,
        /// Its line, counted from 1.
        line: usize,
        /// What is wrong there.
        kind: Box<Self>,
    },
    /// A valid but unsupported feature.
    #[error("{what} is not supported; {remedy}")]
    Unsupported {
        /// The feature.
        what: String,
        /// The remedy.
        remedy: &'static str,
    },
    /// More elements than 32-bit indices can name.
    #[error("{what}: more than {limit}; split the mesh")]
    TooLarge {
        /// The kind of element.
        what: &'static str,
        /// The maximum number.
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

    pub(super) fn damaged(what: impl Into<String>) -> Self {
        Self::Damaged { what: what.into() }
    }

    pub(super) fn invalid(what: impl Into<String>) -> Self {
        Self::Invalid { what: what.into() }
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
        " (the file ends in the middle of a line and may be cut off)"
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

/// The error for a part of a file that does not fit into the memory.
pub(super) fn no_memory(what: &str, error: &dyn fmt::Display) -> ParseError {
    in_file(ParseErrorKind::Unavailable {
        what: format!("{what}: {error}"),
        remedy: "split the mesh",
    })
}

/// A short excerpt of the file for a message, with unprintable bytes escaped.
pub(super) fn excerpt(bytes: &[u8]) -> String {
    const LONGEST: usize = 40;
    let cut = &bytes[..bytes.len().min(LONGEST)];
    let mut text: String = String::from_utf8_lossy(cut).escape_debug().collect();
    if bytes.len() > LONGEST {
        text.push_str("...");
    }
    text
}
