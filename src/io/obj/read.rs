//! The OBJ reader: the lists of the file, polygons, groups and materials.

use std::borrow::Cow;

use super::super::error::{ParseError, ParseErrorKind, at_line, excerpt, in_file};
use super::super::text_scanner::{Scanner, unix_lines, without_mark};
use super::corners::Corners;
use super::extras::Extras;
use super::ignored_statements::IgnoredStatements;
use super::tags::TagRuns;
use crate::mesh::{DVec3, Soup};

/// Statements of the format that do not describe the polygon mesh.
const OTHER_STATEMENTS: &str = "vp mg deg bmat step cstype curv curv2 surf parm trim hole scrv sp \
    end con bevel c_interp d_interp lod shadow_obj trace_obj maplib usemap call csh bsp bzp cdc \
    cdp res stech ctech";

/// Reads OBJ text.
pub(in super::super) fn read(bytes: &[u8]) -> Result<Soup, ParseError> {
    if bytes.is_empty() {
        return Err(in_file(ParseErrorKind::Empty));
    }
    if bytes.starts_with(b"\xff\xfe") || bytes.starts_with(b"\xfe\xff") {
        return Err(not_obj(
            1,
            "UTF-16 text; save it as plain text or UTF-8".to_owned(),
        ));
    }
    let bytes: Cow<'_, [u8]> = unix_lines(bytes);
    let mut reader = Reader::new(&bytes);
    while !reader.text.at_end() {
        reader.text.skip_blanks();
        if !reader.text.statement_over() {
            reader.statement()?;
        }
        reader.text.next_line();
    }
    reader.finish()
}

struct Reader<'a> {
    text: Scanner<'a>,
    soup: Soup,
    extras: Extras,
    corners: Corners,
    tags: TagRuns,
    ignored: IgnoredStatements,
    /// Increasing maxima of corners that refer to a later vertex: line, face, vertex.
    ahead: Vec<(usize, usize, u32)>,
    statements: usize,
}

impl<'a> Reader<'a> {
    fn new(bytes: &'a [u8]) -> Self {
        // Typical sizes of a triangle mesh; unused capacity costs nothing.
        let room = [bytes.len() / 80, bytes.len() / 14];
        let mut soup = Soup {
            positions: Vec::with_capacity(room[0]),
            corners: Vec::with_capacity(room[1]),
            offsets: Vec::with_capacity(bytes.len() / 40),
            ..Soup::default()
        };
        soup.offsets.push(0);
        Self {
            text: Scanner::new(bytes, without_mark(bytes), 1),
            soup,
            extras: Extras::default(),
            corners: Corners::new(room),
            tags: TagRuns::default(),
            ignored: IgnoredStatements::new(bytes),
            ahead: Vec::new(),
            statements: 0,
        }
    }

    #[inline]
    fn statement(&mut self) -> Result<(), ParseError> {
        self.statements += 1;
        let line = self.text.line();
        match self.text.token() {
            b"v" => return self.vertex(),
            b"f" | b"fo" => return self.face(),
            b"vt" => return self.value(false),
            b"vn" => return self.value(true),
            b"l" | b"p" => self.ignored.lines = true,
            b"s" => {
                let name = self.text.name();
                self.tags.change(|tag| tag.smoothing = name);
            }
            b"o" => {
                let name = self.text.name();
                self.tags.change(|tag| tag.object = name);
            }
            b"g" => {
                let name = self.text.name();
                self.tags.change(|tag| tag.group = name);
            }
            b"usemtl" => {
                let name = self.text.name();
                self.tags.change(|tag| tag.material = name);
            }
            b"mtllib" => {
                let library = self.text.name();
                let libraries = &mut self.soup.attributes.material_libraries;
                if !library.is_empty() && !libraries.contains(&library) {
                    libraries.push(library);
                }
            }
            word => return self.other(word, line),
        }
        Ok(())
    }

    /// A statement with an unknown word. A word of letters is an extension of some program;
    /// anything else is an error.
    fn other(&mut self, word: &[u8], line: usize) -> Result<(), ParseError> {
        if OTHER_STATEMENTS
            .split(' ')
            .any(|other| other.as_bytes() == word)
        {
            return Ok(());
        }
        let in_word = |b: &u8| b.is_ascii_alphabetic() || matches!(b, b'_' | b'-' | b':' | b'.');
        if !word.iter().all(in_word) {
            let text = word.iter().all(u8::is_ascii_graphic);
            let found = if text {
                format!("a line that starts with '{}'", excerpt(word))
            } else {
                "bytes that are not text".to_owned()
            };
            return Err(not_obj(line, found));
        }
        self.ignored.unknown(line, word);
        Ok(())
    }

    #[inline]
    fn vertex(&mut self) -> Result<(), ParseError> {
        let mut numbers = [0.0; 7];
        let mut count = 0;
        loop {
            self.text.skip_blanks();
            if self.text.statement_over() {
                break;
            }
            if count == numbers.len() {
                return Err(self.vertex_numbers(count + 1));
            }
            let start = self.text.at();
            let Some(value) = self.text.float() else {
                return Err(self.not_a_number(count));
            };
            if count < 3 && !value.is_finite() {
                return Err(self.not_finite(count, start));
            }
            numbers[count] = value;
            count += 1;
        }
        if count < 3 || count == 5 {
            return Err(self.vertex_numbers(count));
        }
        let extra = &numbers[3..count];
        if !self.extras.vertex(self.soup.positions.len(), extra) {
            return Err(self.vertex_numbers(count));
        }
        if extra.len() == 1 && extra[0] != 1.0 {
            self.ignored.weighted += 1;
        }
        self.soup.positions.push(DVec3::from_slice(&numbers));
        Ok(())
    }

    /// A texture coordinate or a normal.
    #[inline]
    fn value(&mut self, is_normal: bool) -> Result<(), ParseError> {
        let mut numbers = [0.0; 3];
        let mut count = 0;
        while count < 3 {
            self.text.skip_blanks();
            if self.text.statement_over() {
                break;
            }
            let Some(number) = self.text.float() else {
                return Err(self.no_value(is_normal));
            };
            numbers[count] = number;
            count += 1;
        }
        if count == 0 || (is_normal && count < 3) {
            return Err(self.no_value(is_normal));
        }
        self.corners.value(is_normal, numbers, count);
        Ok(())
    }

    #[inline]
    fn face(&mut self) -> Result<(), ParseError> {
        let first = self.soup.corners.len();
        let vertices = self.soup.positions.len();
        let line = self.text.line();
        loop {
            self.text.skip_blanks();
            if self.text.statement_over() {
                break;
            }
            let start = self.text.at();
            let Some((index, values)) = self.text.corner() else {
                return Err(self.bad_corner(start));
            };
            self.corners.corner(self.soup.corners.len(), values);
            let Some(vertex) = vertex_of(index, vertices) else {
                return Err(self.bad_index(index));
            };
            if vertex as usize >= vertices && self.ahead.last().is_none_or(|a| a.2 < vertex) {
                self.ahead
                    .push((self.text.line(), self.soup.offsets.len(), vertex));
            }
            self.soup.corners.push(vertex);
        }
        let found = self.soup.corners.len() - first;
        if found < 3 {
            let face = self.soup.offsets.len();
            let cut = self.ignored.cut && self.text.at_end();
            return Err(at_line(
                line,
                ParseErrorKind::FewCorners { face, found, cut },
            ));
        }
        let Ok(end) = u32::try_from(self.soup.corners.len()) else {
            return Err(in_file(ParseErrorKind::too_large("face corners")));
        };
        self.soup.offsets.push(end);
        self.tags.face(&mut self.soup);
        Ok(())
    }

    fn finish(mut self) -> Result<Soup, ParseError> {
        let vertices = self.soup.positions.len();
        if self.statements == 0 {
            return Err(in_file(ParseErrorKind::NothingButComments));
        }
        if vertices == 0
            && self.soup.face_count() == 0
            && let Some(at) = self.ignored.first_unknown
        {
            let (line, word) = at;
            return Err(not_obj(
                line,
                format!("no mesh, but a line that starts with '{word}'"),
            ));
        }
        if vertices == 0 {
            return Err(in_file(ParseErrorKind::NoVertices));
        }
        if u32::try_from(vertices).is_err() {
            return Err(in_file(ParseErrorKind::too_large("vertices")));
        }
        if let Some(&(line, face, vertex)) = self.ahead.iter().find(|a| a.2 as usize >= vertices) {
            let found = i64::from(vertex) + 1;
            return Err(at_line(
                line,
                ParseErrorKind::IndexRange {
                    face,
                    found,
                    vertices,
                    first: 1,
                },
            ));
        }
        if self.soup.face_count() == 0 {
            return Err(in_file(ParseErrorKind::NoFaces {
                vertices,
                cut: self.ignored.cut,
            }));
        }
        self.extras.settle(&mut self.soup);
        self.corners.settle(&mut self.soup);
        self.ignored.write(&mut self.soup.notes, self.text.line());
        Ok(self.soup)
    }

    fn here(&self, kind: ParseErrorKind) -> ParseError {
        at_line(self.text.line(), kind)
    }

    #[cold]
    fn vertex_numbers(&self, found: usize) -> ParseError {
        let vertex = self.soup.positions.len() + 1;
        self.here(ParseErrorKind::VertexNumbers {
            vertex,
            found,
            wanted: self.extras.wanted(),
        })
    }

    #[cold]
    fn no_value(&self, is_normal: bool) -> ParseError {
        let (what, wanted) = if is_normal {
            ("a normal", "three numbers")
        } else {
            ("a texture coordinate", "one to three numbers")
        };
        let found = excerpt(self.text.token_at(self.text.at()));
        self.here(ParseErrorKind::syntax(
            format!("{what} needs {wanted}"),
            found,
        ))
    }

    #[cold]
    fn not_a_number(&self, count: usize) -> ParseError {
        let vertex = self.soup.positions.len() + 1;
        let name = ["x", "y", "z"]
            .get(count)
            .map_or("an extra number", |name| name);
        let what = format!("{name} of vertex {vertex}");
        let found = excerpt(self.text.token_at(self.text.at()));
        self.here(ParseErrorKind::NotANumber { what, found })
    }

    #[cold]
    fn not_finite(&self, axis: usize, start: usize) -> ParseError {
        let vertex = self.soup.positions.len() + 1;
        let axis = ['x', 'y', 'z'][axis];
        let found = excerpt(self.text.token_at(start));
        self.here(ParseErrorKind::NotFinite {
            vertex,
            axis,
            found,
        })
    }

    #[cold]
    fn bad_corner(&self, start: usize) -> ParseError {
        let face = self.soup.offsets.len();
        self.here(ParseErrorKind::BadCorner {
            face,
            found: excerpt(self.text.token_at(start)),
        })
    }

    #[cold]
    fn bad_index(&self, found: i64) -> ParseError {
        let face = self.soup.offsets.len();
        let vertices = self.soup.positions.len();
        self.here(match found {
            0 => ParseErrorKind::IndexZero { face },
            _ => ParseErrorKind::IndexRange {
                face,
                found,
                vertices,
                first: 1,
            },
        })
    }
}

/// The vertex of a corner, counted from 0. The index in the file counts from 1, or backwards from
/// the last vertex read. The vertex may come later in the file.
#[inline]
fn vertex_of(index: i64, vertices: usize) -> Option<u32> {
    let vertex = match usize::try_from(index) {
        Ok(index) => index.checked_sub(1),
        Err(_) => vertices.checked_sub(usize::try_from(index.unsigned_abs()).ok()?),
    };
    u32::try_from(vertex?).ok()
}

fn not_obj(line: usize, found: String) -> ParseError {
    at_line(
        line,
        ParseErrorKind::NotThisFormat {
            format: "OBJ",
            found,
        },
    )
}
