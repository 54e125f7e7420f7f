//! OBJ in: the file's own vertex list, polygons, vertex colours, groups and materials.

use std::collections::HashMap;

use super::super::error::{Fault, Problem, at_line, excerpt, in_file};
use super::super::scan::Scanner;
use crate::mesh::{DVec3, FaceTag, Soup};

/// Statements of the format that say nothing about the polygon mesh.
const OTHER_STATEMENTS: [&[u8]; 33] = [
    b"vp",
    b"mg",
    b"deg",
    b"bmat",
    b"step",
    b"cstype",
    b"curv",
    b"curv2",
    b"surf",
    b"parm",
    b"trim",
    b"hole",
    b"scrv",
    b"sp",
    b"end",
    b"con",
    b"bevel",
    b"c_interp",
    b"d_interp",
    b"lod",
    b"shadow_obj",
    b"trace_obj",
    b"maplib",
    b"usemap",
    b"call",
    b"csh",
    b"bsp",
    b"bzp",
    b"cdc",
    b"cdp",
    b"res",
    b"stech",
    b"ctech",
];

/// Reads OBJ text.
pub(in super::super) fn read(bytes: &[u8]) -> Result<Soup, Fault> {
    if bytes.is_empty() {
        return Err(in_file(Problem::Empty));
    }
    if !bytes.contains(&b'\n') && bytes.contains(&b'\r') {
        // Line ends of the old Macintosh.
        let unix: Vec<u8> = bytes
            .iter()
            .map(|&b| if b == b'\r' { b'\n' } else { b })
            .collect();
        return Reader::new(&unix).run(&unix);
    }
    Reader::new(bytes).run(bytes)
}

/// How many colour numbers the coloured vertices of this file have.
#[derive(Clone, Copy, PartialEq)]
enum ColorLayout {
    None,
    Rgb,
    /// Four numbers: `w r g b` or `r g b a`, decided when all are read.
    Four,
}

struct Reader<'a> {
    text: Scanner<'a>,
    soup: Soup,
    layout: ColorLayout,
    uncolored: usize,
    weighted: usize,
    tag: FaceTag,
    tag_index: u32,
    tag_changed: bool,
    tagged: bool,
    known: HashMap<FaceTag, u32>,
    /// Growing maxima of corners that name a vertex further down: line, face, index.
    ahead: Vec<(usize, usize, u32)>,
    statements: usize,
    skipped: [usize; 4],
    unknown: Option<(usize, String)>,
    unknown_count: usize,
    cut: bool,
}

impl<'a> Reader<'a> {
    fn new(bytes: &'a [u8]) -> Self {
        let start = if bytes.starts_with(b"\xef\xbb\xbf") {
            3
        } else {
            0
        };
        // Typical shares of a triangle mesh; untouched reserve costs nothing.
        let soup = Soup {
            positions: Vec::with_capacity(bytes.len() / 80),
            corners: Vec::with_capacity(bytes.len() / 14),
            offsets: Vec::with_capacity(bytes.len() / 40),
            ..Soup::default()
        };
        Self {
            text: Scanner::new(bytes, start, 1),
            soup,
            layout: ColorLayout::None,
            uncolored: 0,
            weighted: 0,
            tag: FaceTag::default(),
            tag_index: 0,
            tag_changed: false,
            tagged: false,
            known: HashMap::new(),
            ahead: Vec::new(),
            statements: 0,
            skipped: [0; 4],
            unknown: None,
            unknown_count: 0,
            cut: bytes.last().is_some_and(|&b| b != b'\n'),
        }
    }

    fn run(mut self, bytes: &[u8]) -> Result<Soup, Fault> {
        if bytes.starts_with(b"\xff\xfe") || bytes.starts_with(b"\xfe\xff") {
            let found = "UTF-16 text (save it as plain text or UTF-8)".to_owned();
            return Err(at_line(
                1,
                Problem::NotThisFormat {
                    format: "OBJ",
                    found,
                },
            ));
        }
        self.soup.offsets.push(0);
        while !self.text.at_end() {
            self.text.skip_blanks();
            if !self.text.statement_over() {
                self.statement()?;
            }
            self.text.next_line();
        }
        self.finish()
    }

    #[inline]
    fn statement(&mut self) -> Result<(), Fault> {
        self.statements += 1;
        let line = self.text.line();
        match self.text.token() {
            b"v" => self.vertex(),
            b"f" | b"fo" => self.face(),
            b"vt" => self.skip(0),
            b"vn" => self.skip(1),
            b"l" | b"p" => self.skip(2),
            b"s" => self.skip(3),
            b"o" => {
                self.tag.object = self.name();
                self.retag()
            }
            b"g" => {
                self.tag.group = self.name();
                self.retag()
            }
            b"usemtl" => {
                self.tag.material = self.name();
                self.retag()
            }
            b"mtllib" => {
                let library = self.name();
                if !library.is_empty() && !self.soup.material_libraries.contains(&library) {
                    self.soup.material_libraries.push(library);
                }
                Ok(())
            }
            word if OTHER_STATEMENTS.contains(&word) => Ok(()),
            word => self.unknown_statement(word, line),
        }
    }

    #[allow(clippy::unnecessary_wraps)] // one shape for all statements
    fn skip(&mut self, kind: usize) -> Result<(), Fault> {
        self.skipped[kind] += 1;
        Ok(())
    }

    fn unknown_statement(&mut self, word: &[u8], line: usize) -> Result<(), Fault> {
        // A word of letters is an extension of some program; anything else is a broken line.
        if !word
            .iter()
            .all(|&b| b.is_ascii_alphabetic() || matches!(b, b'_' | b'-' | b':' | b'.'))
        {
            let format = "OBJ";
            let found = format!("a line that starts with '{}'", excerpt(word));
            return Err(at_line(line, Problem::NotThisFormat { format, found }));
        }
        self.unknown_count += 1;
        self.unknown.get_or_insert_with(|| (line, excerpt(word)));
        Ok(())
    }

    fn name(&mut self) -> String {
        self.text.skip_blanks();
        String::from_utf8_lossy(self.text.rest_of_line()).into_owned()
    }

    #[allow(clippy::unnecessary_wraps)]
    fn retag(&mut self) -> Result<(), Fault> {
        self.tag_changed = true;
        Ok(())
    }

    #[inline]
    fn vertex(&mut self) -> Result<(), Fault> {
        let mut numbers = [0.0; 7];
        let mut count = 0;
        loop {
            self.text.skip_blanks();
            if self.text.statement_over() {
                break;
            }
            if count == 7 {
                return Err(self.vertex_numbers(8));
            }
            let start = self.text.clone();
            let Some(value) = self.text.float() else {
                return Err(self.bad_number(count));
            };
            if count < 3 && !value.is_finite() {
                let vertex = self.soup.positions.len() + 1;
                let axis = ['x', 'y', 'z'][count];
                let found = excerpt(start.peek_token());
                return Err(self.here(Problem::NotFinite {
                    vertex,
                    axis,
                    found,
                }));
            }
            numbers[count] = value;
            count += 1;
        }
        let [x, y, z, rest @ ..] = numbers;
        match count {
            3 => {}
            4 => self.weighted += usize::from(rest[0] != 1.0),
            6 => self.color([rest[0], rest[1], rest[2], 1.0], ColorLayout::Rgb, count)?,
            7 => self.color(rest, ColorLayout::Four, count)?,
            _ => return Err(self.vertex_numbers(count)),
        }
        if count < 6 && self.layout != ColorLayout::None {
            self.soup.colors.push([1.0; 4]);
            self.uncolored += 1;
        }
        self.soup.positions.push(DVec3::new(x, y, z));
        Ok(())
    }

    fn color(&mut self, rgba: [f64; 4], layout: ColorLayout, count: usize) -> Result<(), Fault> {
        if self.layout == ColorLayout::None {
            self.layout = layout;
            self.uncolored = self.soup.positions.len();
            self.soup.colors.resize(self.uncolored, [1.0; 4]);
        } else if self.layout != layout {
            return Err(self.vertex_numbers(count));
        }
        self.soup.colors.push(rgba.map(|c| c as f32));
        Ok(())
    }

    #[inline]
    fn face(&mut self) -> Result<(), Fault> {
        let first = self.soup.corners.len();
        let vertices = self.soup.positions.len();
        let line = self.text.line();
        loop {
            self.text.skip_blanks();
            if self.text.statement_over() {
                break;
            }
            let start = self.text.clone();
            let index = self.text.integer();
            let (Some(index), true) = (index, self.text.skip_corner_rest()) else {
                return Err(self.bad_corner(&start));
            };
            let vertex = if index > 0 {
                index - 1
            } else {
                vertices as i64 + index
            };
            if index == 0 || vertex < 0 || vertex >= i64::from(u32::MAX) {
                return Err(self.bad_index(index));
            }
            let vertex = vertex as u32;
            if vertex as usize >= vertices && self.ahead.last().is_none_or(|a| a.2 < vertex) {
                self.ahead
                    .push((self.text.line(), self.soup.offsets.len(), vertex));
            }
            self.soup.corners.push(vertex);
        }
        let found = self.soup.corners.len() - first;
        if found < 3 {
            let face = self.soup.offsets.len();
            let cut = self.cut && self.text.at_end();
            return Err(at_line(line, Problem::FewCorners { face, found, cut }));
        }
        let end = u32::try_from(self.soup.corners.len()).map_err(|_| {
            self.here(Problem::TooLarge {
                what: "face corners",
                limit: u64::from(u32::MAX),
            })
        })?;
        self.soup.offsets.push(end);
        if self.tag_changed {
            self.switch_tag();
        }
        if self.tagged {
            self.soup.face_tags.push(self.tag_index);
        }
        Ok(())
    }

    /// Looks up the tag in force; called once a run of faces, after the face was stored.
    fn switch_tag(&mut self) {
        self.tag_changed = false;
        let before = self.soup.face_count() - 1;
        if !self.tagged && before > 0 {
            self.known.insert(FaceTag::default(), 0);
            self.soup.tags.push(FaceTag::default());
            self.soup.face_tags.resize(before, 0);
        }
        self.tagged = true;
        self.tag_index = match self.known.get(&self.tag) {
            Some(&index) => index,
            None => {
                let index = self.soup.tags.len() as u32;
                self.soup.tags.push(self.tag.clone());
                self.known.insert(self.tag.clone(), index);
                index
            }
        };
    }

    fn finish(mut self) -> Result<Soup, Fault> {
        let vertices = self.soup.positions.len();
        if self.statements == 0 {
            return Err(in_file(Problem::NothingButComments));
        }
        if vertices == 0 && self.soup.face_count() == 0 && self.unknown.is_some() {
            let (line, word) = self.unknown.unwrap_or_default();
            let found = format!("no vertices or faces, and a line that starts with '{word}'");
            return Err(at_line(
                line,
                Problem::NotThisFormat {
                    format: "OBJ",
                    found,
                },
            ));
        }
        if vertices == 0 {
            return Err(in_file(Problem::NoVertices));
        }
        if u32::try_from(vertices).is_err() {
            let limit = u64::from(u32::MAX);
            return Err(in_file(Problem::TooLarge {
                what: "vertices",
                limit,
            }));
        }
        if let Some(&(line, face, vertex)) = self.ahead.iter().find(|a| a.2 as usize >= vertices) {
            let found = i64::from(vertex) + 1;
            let problem = Problem::IndexRange {
                face,
                found,
                first: 1,
                last: vertices as i64,
            };
            return Err(at_line(line, problem));
        }
        if self.soup.face_count() == 0 {
            return Err(in_file(Problem::NoFaces {
                vertices,
                cut: self.cut,
            }));
        }
        self.settle_colors();
        self.write_notes();
        Ok(self.soup)
    }

    /// Decides what four colour numbers mean, and brings 0..255 to 0..1.
    fn settle_colors(&mut self) {
        let soup = &mut self.soup;
        if self.layout == ColorLayout::Four {
            // With every first number 1 it is the weight w; a red channel would vary.
            let weighted = soup.colors.iter().all(|c| c[0] == 1.0);
            if weighted {
                for c in &mut soup.colors {
                    *c = [c[1], c[2], c[3], 1.0];
                }
            }
        }
        if soup
            .colors
            .iter()
            .flatten()
            .any(|c| !c.is_finite() || *c < 0.0)
        {
            soup.colors.clear();
            soup.notes
                .push("vertex colours that are negative or not finite: all dropped".into());
        }
        if soup.colors.iter().any(|c| c[..3].iter().any(|&x| x > 1.0)) {
            let opaque = self.layout == ColorLayout::Rgb;
            for c in &mut soup.colors {
                let alpha = if opaque { 1.0 } else { c[3] / 255.0 };
                *c = [c[0] / 255.0, c[1] / 255.0, c[2] / 255.0, alpha];
            }
            soup.notes
                .push("vertex colours above 1: taken as 0 to 255".into());
        }
    }

    fn write_notes(&mut self) {
        let notes = &mut self.soup.notes;
        let kinds = [
            "texture coordinates",
            "normals",
            "lines and points",
            "smoothing groups",
        ];
        let lost: Vec<&str> = kinds
            .iter()
            .zip(self.skipped)
            .filter(|(_, n)| *n > 0)
            .map(|(k, _)| *k)
            .collect();
        if !lost.is_empty() {
            notes.push(format!("not kept: {}", lost.join(", ")));
        }
        if self.weighted > 0 {
            notes.push(format!(
                "{} vertices have a weight w other than 1: ignored",
                self.weighted
            ));
        }
        if self.uncolored > 0 && !self.soup.colors.is_empty() {
            notes.push(format!(
                "{} vertices without a colour: white",
                self.uncolored
            ));
        }
        if let Some((line, word)) = &self.unknown {
            let count = self.unknown_count;
            notes.push(format!(
                "{count} unknown statements skipped, the first '{word}' on line {line}"
            ));
        }
        if self.cut {
            let line = self.text.line();
            notes.push(format!(
                "the file ends without a line end: if it was cut off, line {line} may be incomplete"
            ));
        }
    }

    fn here(&self, problem: Problem) -> Fault {
        at_line(self.text.line(), problem)
    }

    #[cold]
    fn vertex_numbers(&self, found: usize) -> Fault {
        let vertex = self.soup.positions.len() + 1;
        let wanted = match self.layout {
            ColorLayout::None => "3 (x y z), 4 with a weight, 6 or 7 with a colour",
            ColorLayout::Rgb => "3, 4, or as before 6 (x y z r g b)",
            ColorLayout::Four => "3, 4, or as before 7",
        };
        self.here(Problem::VertexNumbers {
            vertex,
            found,
            wanted,
        })
    }

    #[cold]
    fn bad_number(&self, count: usize) -> Fault {
        let vertex = self.soup.positions.len() + 1;
        let names = ["x", "y", "z"];
        let name = names.get(count).map_or("an extra number", |n| n);
        let found = excerpt(self.text.peek_token());
        self.here(Problem::NotANumber {
            what: format!("{name} of vertex {vertex}"),
            found,
        })
    }

    #[cold]
    fn bad_corner(&self, start: &Scanner) -> Fault {
        let face = self.soup.offsets.len();
        self.here(Problem::BadCorner {
            face,
            found: excerpt(start.peek_token()),
        })
    }

    #[cold]
    fn bad_index(&self, found: i64) -> Fault {
        let face = self.soup.offsets.len();
        if found == 0 {
            return self.here(Problem::IndexZero { face });
        }
        let last = self.soup.positions.len() as i64;
        let first = if found < 0 { -last } else { 1 };
        self.here(Problem::IndexRange {
            face,
            found,
            first,
            last,
        })
    }
}
