//! The OFF reader.

use super::super::error::{ParseError, ParseErrorKind, at_line, excerpt, in_file};
use super::super::text_scanner::{Scanner, unix_lines, without_mark};
use super::{COLOR, NORMAL, TEXTURE};
use crate::mesh::{Column, DVec3, Soup};

/// Reads OFF text.
pub(in super::super) fn read(bytes: &[u8]) -> Result<Soup, ParseError> {
    if bytes.is_empty() {
        return Err(in_file(ParseErrorKind::Empty));
    }
    let bytes = unix_lines(bytes);
    let mut reader = Reader {
        text: Scanner::new(&bytes, without_mark(&bytes), 1),
        bytes: bytes.len(),
        soup: Soup::default(),
    };
    let parts = reader.header()?;
    let [vertices, faces] = reader.counts()?;
    reader.vertices(vertices, parts)?;
    reader.faces(faces, vertices)?;
    if reader.next_line_with_numbers() {
        let note = format!(
            "what follows the faces, from line {}, is ignored",
            reader.text.line()
        );
        reader.soup.notes.push(note);
    }
    Ok(reader.soup)
}

/// What a vertex has besides its coordinates, in this order.
#[derive(Clone, Copy)]
struct Parts {
    normal: bool,
    texture: bool,
}

struct Reader<'a> {
    text: Scanner<'a>,
    bytes: usize,
    soup: Soup,
}

impl Reader<'_> {
    fn here(&self, kind: ParseErrorKind) -> ParseError {
        at_line(self.text.line(), kind)
    }

    /// Moves over empty lines and comments; `false` at the end of the file.
    fn next_line_with_numbers(&mut self) -> bool {
        self.text.skip_blanks();
        while self.text.statement_over() && !self.text.at_end() {
            self.text.next_line();
            self.text.skip_blanks();
        }
        !self.text.at_end()
    }

    /// The keyword: `OFF` with the letters of what vertices have before it.
    fn header(&mut self) -> Result<Parts, ParseError> {
        self.next_line_with_numbers();
        let word = self.text.token();
        let wrong = |found: String| {
            let format = "OFF";
            in_file(ParseErrorKind::NotThisFormat { format, found })
        };
        let Some(mut letters) = word.strip_suffix(b"OFF") else {
            return Err(wrong(format!("'{}' instead of 'OFF'", excerpt(word))));
        };
        let mut parts = Parts {
            normal: false,
            texture: false,
        };
        if let Some(rest) = letters.strip_prefix(b"ST") {
            (parts.texture, letters) = (true, rest);
        }
        if let Some(rest) = letters.strip_prefix(b"C") {
            // the number of values of a vertex says whether it has a colour
            letters = rest;
        }
        if let Some(rest) = letters.strip_prefix(b"N") {
            (parts.normal, letters) = (true, rest);
        }
        if !letters.is_empty() {
            let what = format!(
                "an OFF file of points in four or more dimensions ('{}')",
                excerpt(word)
            );
            let remedy = "export it with three coordinates for each vertex";
            return Err(self.here(ParseErrorKind::Unsupported { what, remedy }));
        }
        self.text.skip_blanks();
        if self.text.token_at(self.text.at()) == b"BINARY" {
            let what = "a binary OFF file".to_owned();
            let remedy = "export it as text, or as PLY";
            return Err(self.here(ParseErrorKind::Unsupported { what, remedy }));
        }
        Ok(parts)
    }

    /// The numbers of vertices and faces. The number of edges, which follows, may be missing.
    fn counts(&mut self) -> Result<[usize; 2], ParseError> {
        let mut counts = [0; 2];
        self.next_line_with_numbers();
        for (count, what) in counts.iter_mut().zip(["vertices", "faces"]) {
            self.text.skip_blanks();
            let start = self.text.at();
            let number = self.text.integer().and_then(|n| usize::try_from(n).ok());
            *count = number.ok_or_else(|| {
                let what = format!("the number of {what}");
                let found = excerpt(self.text.token_at(start));
                self.here(ParseErrorKind::NotANumber { what, found })
            })?;
        }
        let [vertices, faces] = counts;
        // a vertex has at least three digits and three separators, a face four of each
        let least = vertices
            .saturating_mul(6)
            .saturating_add(faces.saturating_mul(8));
        let left = self.bytes - self.text.at();
        if least > left.saturating_add(1) {
            let what = format!(
                "it declares {vertices} vertices and {faces} faces, at least {least} bytes, but {left} \
                 are left"
            );
            return Err(self.here(ParseErrorKind::truncated(what)));
        }
        if u32::try_from(vertices).is_err() {
            return Err(in_file(ParseErrorKind::too_large("vertices")));
        }
        if vertices == 0 {
            return Err(in_file(ParseErrorKind::NoVertices));
        }
        if faces == 0 {
            let cut = false;
            return Err(in_file(ParseErrorKind::NoFaces { vertices, cut }));
        }
        self.text.next_line();
        Ok(counts)
    }

    /// Reads numbers up to the end of the line, at most as many as there is room for.
    fn numbers(
        &mut self,
        numbers: &mut [f64],
        what: &dyn Fn() -> String,
    ) -> Result<usize, ParseError> {
        let mut count = 0;
        loop {
            self.text.skip_blanks();
            if self.text.statement_over() {
                return Ok(count);
            }
            if count == numbers.len() {
                let what = format!("{} has more than {count} numbers", what());
                let found = excerpt(self.text.token_at(self.text.at()));
                return Err(self.here(ParseErrorKind::syntax(what, found)));
            }
            let Some(number) = self.text.float() else {
                let what = format!("a value of {}", what());
                let found = excerpt(self.text.token_at(self.text.at()));
                return Err(self.here(ParseErrorKind::NotANumber { what, found }));
            };
            numbers[count] = number;
            count += 1;
        }
    }

    fn vertices(&mut self, count: usize, parts: Parts) -> Result<(), ParseError> {
        self.soup.positions.reserve_exact(count);
        let fixed = 3 + 3 * usize::from(parts.normal) + 2 * usize::from(parts.texture);
        let mut width = 0;
        let mut columns: Vec<Column> = Vec::new();
        for vertex in 1..=count {
            let what = || format!("vertex {vertex} of {count}");
            if !self.next_line_with_numbers() {
                let kind = ParseErrorKind::truncated(format!("it ends before {}", what()));
                return Err(self.here(kind));
            }
            let mut numbers = [0.0; 12];
            let found = self.numbers(&mut numbers, &what)?;
            if vertex == 1 {
                width = found;
                columns = vertex_columns(parts, found.wrapping_sub(fixed), count);
            }
            if found != width || ![0, 3, 4].contains(&found.wrapping_sub(fixed)) {
                let what = format!(
                    "{} needs {fixed} numbers, or {} or {} with a colour, as many as all others",
                    what(),
                    fixed + 3,
                    fixed + 4
                );
                return Err(self.here(ParseErrorKind::syntax(what, format!("{found} numbers"))));
            }
            for (value, axis) in numbers.iter().zip(['x', 'y', 'z']) {
                if !value.is_finite() {
                    let found = value.to_string();
                    let kind = ParseErrorKind::NotFinite {
                        vertex,
                        axis,
                        found,
                    };
                    return Err(self.here(kind));
                }
            }
            self.soup.positions.push(DVec3::from_slice(&numbers));
            for (column, number) in columns.iter_mut().zip(&numbers[3..]) {
                column.numbers.push(*number);
            }
            self.text.next_line();
        }
        self.soup.attributes.vertices = columns;
        Ok(())
    }

    fn faces(&mut self, count: usize, vertices: usize) -> Result<(), ParseError> {
        self.soup.offsets.reserve_exact(count + 1);
        self.soup.offsets.push(0);
        let mut colors = FaceColors::default();
        for face in 1..=count {
            let what = || format!("face {face} of {count}");
            if !self.next_line_with_numbers() {
                let kind = ParseErrorKind::truncated(format!("it ends before {}", what()));
                return Err(self.here(kind));
            }
            let corners = self.text.integer().unwrap_or(0);
            if corners < 3 {
                let found = usize::try_from(corners).unwrap_or(0);
                let cut = false;
                return Err(self.here(ParseErrorKind::FewCorners { face, found, cut }));
            }
            for _ in 0..corners {
                self.text.skip_blanks();
                let Some(found) = self.text.integer() else {
                    let what = format!("a vertex of {}", what());
                    let found = excerpt(self.text.token_at(self.text.at()));
                    return Err(self.here(ParseErrorKind::NotANumber { what, found }));
                };
                match u32::try_from(found) {
                    Ok(vertex) if (vertex as usize) < vertices => self.soup.corners.push(vertex),
                    _ => {
                        let first = 0;
                        let kind = ParseErrorKind::IndexRange {
                            face,
                            found,
                            vertices,
                            first,
                        };
                        return Err(self.here(kind));
                    }
                }
            }
            let end = u32::try_from(self.soup.corners.len());
            let end = end.map_err(|_| in_file(ParseErrorKind::too_large("face corners")))?;
            self.soup.offsets.push(end);
            let mut numbers = [0.0; 4];
            let found = self.numbers(&mut numbers, &what)?;
            colors.face(face - 1, &numbers[..found]);
            self.text.next_line();
        }
        colors.settle(&mut self.soup);
        Ok(())
    }
}

/// Columns for `count` vertices with these parts and a colour of `color` numbers.
fn vertex_columns(parts: Parts, color: usize, count: usize) -> Vec<Column> {
    let normal = NORMAL.iter().filter(|_| parts.normal);
    let color = COLOR.iter().take(if color <= 4 { color } else { 0 });
    let texture = TEXTURE.iter().filter(|_| parts.texture);
    let names = normal.chain(color).chain(texture);
    names
        .map(|name| Column::decimals(name, Vec::with_capacity(count)))
        .collect()
}

/// The colours of faces.
#[derive(Default)]
struct FaceColors {
    columns: Vec<Vec<f64>>,
    /// Whether some face has another number of values than the first.
    is_mixed: bool,
}

impl FaceColors {
    fn face(&mut self, before: usize, numbers: &[f64]) {
        if before == 0 {
            self.columns = vec![Vec::new(); numbers.len()];
        }
        self.is_mixed |= numbers.len() != self.columns.len();
        for (column, number) in self.columns.iter_mut().zip(numbers) {
            column.push(*number);
        }
    }

    fn settle(self, soup: &mut Soup) {
        if self.is_mixed || self.columns.len() == 2 {
            let note = "face colours are not kept, because faces have different numbers of values";
            soup.notes.push(note.to_owned());
            return;
        }
        // one number is an index of a table of colours
        let names = if self.columns.len() == 1 {
            &["color"][..]
        } else {
            &COLOR[..]
        };
        let columns = names.iter().zip(self.columns);
        let columns = columns.map(|(name, numbers)| Column::decimals(name, numbers));
        soup.attributes.faces.columns = columns.collect();
    }
}
