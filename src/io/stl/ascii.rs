//! ASCII STL: one statement per line, in upper or lower case. A file may contain several solids.

use super::super::error::{ParseError, ParseErrorKind, at_line, excerpt, in_file};
use super::super::text_scanner::{Scanner, unix_lines, without_mark};
use super::{close_face, with_room};
use crate::mesh::{DVec3, FaceTag, Soup};

/// Whether the file starts with "solid" and continues as text.
pub(super) fn looks_like(bytes: &[u8]) -> bool {
    let text = bytes[without_mark(bytes)..].trim_ascii_start();
    let head = &text[..text.len().min(1024)];
    head.len() >= 5 && head[..5].eq_ignore_ascii_case(b"solid") && !head.contains(&0)
}

/// Reads ASCII STL.
pub(super) fn read(bytes: &[u8]) -> Result<Soup, ParseError> {
    let bytes = unix_lines(bytes);
    let mut reader = Reader {
        text: Scanner::new(&bytes, without_mark(&bytes), 1),
        // A face usually has at least 200 bytes.
        soup: with_room(bytes.len() / 200),
        in_solid: false,
    };
    while !reader.text.at_end() {
        reader.text.skip_blanks();
        if !reader.text.line_over() {
            reader.statement()?;
        }
        reader.text.next_line();
    }
    reader.finish()
}

struct Reader<'a> {
    text: Scanner<'a>,
    soup: Soup,
    in_solid: bool,
}

impl Reader<'_> {
    fn statement(&mut self) -> Result<(), ParseError> {
        let word = self.text.token();
        let mut lower = [0_u8; 8];
        let length = word.len().min(lower.len());
        lower[..length].copy_from_slice(&word[..length]);
        lower.make_ascii_lowercase();
        match &lower[..length] {
            b"vertex" => self.vertex(),
            b"facet" => self.expect_corners(0, word),
            b"outer" | b"color" => Ok(()),
            b"endloop" => self.expect_corners(3, word),
            b"endfacet" if word.len() == 8 => {
                self.expect_corners(3, word)?;
                close_face(&mut self.soup)?;
                let all = &mut self.soup.attributes;
                if let Some(last) = all.tags.len().checked_sub(1) {
                    all.faces.tags.push(last as u32);
                }
                Ok(())
            }
            b"solid" => {
                self.in_solid = true;
                self.expect_corners(0, word)?;
                self.start_solid();
                Ok(())
            }
            b"endsolid" if word.len() == 8 => {
                self.in_solid = false;
                self.expect_corners(0, word)
            }
            _ => {
                let found = excerpt(word);
                Err(self.here(ParseErrorKind::syntax(
                    "this is not an ASCII STL statement",
                    found,
                )))
            }
        }
    }

    /// Number of corners of the current face.
    fn open_corners(&self) -> usize {
        self.soup.positions.len() - self.soup.corners.len()
    }

    fn expect_corners(&self, wanted: usize, word: &[u8]) -> Result<(), ParseError> {
        let found = self.open_corners();
        if found == wanted {
            return Ok(());
        }
        let face = self.soup.face_count() + 1;
        let what = format!("face {face} has {found} corners instead of {wanted}");
        Err(self.here(ParseErrorKind::syntax(what, excerpt(word))))
    }

    fn vertex(&mut self) -> Result<(), ParseError> {
        if self.open_corners() == 3 {
            let what = format!("face {} has a fourth corner", self.soup.face_count() + 1);
            return Err(self.here(ParseErrorKind::syntax(what, "vertex")));
        }
        let vertex = self.soup.positions.len() + 1;
        let wanted = "3 (x y z)";
        let mut position = [0.0; 3];
        for (count, axis) in ['x', 'y', 'z'].into_iter().enumerate() {
            self.text.skip_blanks();
            if self.text.line_over() {
                return Err(self.here(ParseErrorKind::VertexNumbers {
                    vertex,
                    found: count,
                    wanted,
                }));
            }
            let start = self.text.at();
            let value = self.text.float();
            let found = || excerpt(self.text.token_at(start));
            match value {
                Some(value) if value.is_finite() => position[count] = value,
                Some(_) => {
                    let found = found();
                    return Err(self.here(ParseErrorKind::NotFinite {
                        vertex,
                        axis,
                        found,
                    }));
                }
                None => {
                    let what = format!("{axis} of vertex {vertex}");
                    return Err(self.here(ParseErrorKind::NotANumber {
                        what,
                        found: found(),
                    }));
                }
            }
        }
        self.text.skip_blanks();
        if !self.text.line_over() {
            return Err(self.here(ParseErrorKind::VertexNumbers {
                vertex,
                found: 4,
                wanted,
            }));
        }
        self.soup.positions.push(DVec3::from_array(position));
        Ok(())
    }

    /// A solid with a name becomes an object.
    fn start_solid(&mut self) {
        let object = self.text.name();
        let faces = self.soup.face_count();
        let all = &mut self.soup.attributes;
        if all.tags.is_empty() {
            if object.is_empty() {
                return;
            }
            if faces > 0 {
                all.tags.push(FaceTag::default());
                all.faces.tags.resize(faces, 0);
            }
        }
        if all.tags.last().is_none_or(|tag| tag.object != object) {
            all.tags.push(FaceTag {
                object,
                ..FaceTag::default()
            });
        }
    }

    fn finish(mut self) -> Result<Soup, ParseError> {
        let open = self.open_corners();
        if open > 0 {
            let what = format!("the last face ends after {open} corners");
            return Err(self.here(ParseErrorKind::truncated(what)));
        }
        if self.soup.face_count() == 0 {
            return Err(in_file(ParseErrorKind::NoVertices));
        }
        if self.in_solid {
            self.soup
                .notes
                .push("the file has no 'endsolid' and may be cut off".into());
        }
        Ok(self.soup)
    }

    fn here(&self, kind: ParseErrorKind) -> ParseError {
        at_line(self.text.line(), kind)
    }
}
