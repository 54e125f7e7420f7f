//! The header of a PLY file: the elements and their encoding.

use super::super::error::{ParseError, ParseErrorKind, at_line, excerpt, in_file};
use crate::mesh::NumberType;

/// The encoding of the elements.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    Ascii,
    LittleEndian,
    BigEndian,
}

/// The type with a PLY name.
fn type_of_name(name: &[u8]) -> Option<NumberType> {
    Some(match name {
        b"char" | b"int8" => NumberType::I8,
        b"uchar" | b"uint8" => NumberType::U8,
        b"short" | b"int16" => NumberType::I16,
        b"ushort" | b"uint16" => NumberType::U16,
        b"int" | b"int32" => NumberType::I32,
        b"uint" | b"uint32" => NumberType::U32,
        b"float" | b"float32" => NumberType::F32,
        b"double" | b"float64" => NumberType::F64,
        _ => return None,
    })
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Number(NumberType),
    List { count: NumberType, item: NumberType },
}

#[derive(Clone, Debug)]
pub(super) struct Property {
    pub name: String,
    pub kind: Kind,
}

#[derive(Clone, Debug)]
pub(super) struct Element {
    pub name: String,
    pub count: u64,
    pub properties: Vec<Property>,
}

impl Element {
    /// Minimum number of bytes of a row.
    pub fn least_bytes(&self, encoding: Encoding) -> u64 {
        let binary = |p: &Property| match p.kind {
            Kind::Number(scalar) | Kind::List { count: scalar, .. } => scalar.size() as u64,
        };
        match encoding {
            // A digit and a blank; the blank may be missing at the end of the file.
            Encoding::Ascii => 2 * self.properties.len() as u64,
            _ => self.properties.iter().map(binary).sum(),
        }
    }
}

#[derive(Debug)]
pub(super) struct Header {
    pub encoding: Encoding,
    pub elements: Vec<Element>,
    /// The lines `comment` and `obj_info`.
    pub comments: Vec<String>,
    /// The first line before the elements that begins with no word of the format.
    pub unknown: Option<(usize, String)>,
    /// First byte after the header.
    pub end: usize,
    /// Number of the line after the header.
    pub next_line: usize,
}

/// Reads the header.
pub(super) fn read(bytes: &[u8]) -> Result<Header, ParseError> {
    if bytes.is_empty() {
        return Err(in_file(ParseErrorKind::Empty));
    }
    // some programs end the lines of the header, also of a binary file, with a single carriage return
    let is_old = bytes.starts_with(b"ply\r") && !bytes.starts_with(b"ply\r\n");
    let line_end = if is_old { b'\r' } else { b'\n' };
    let mut at = 0;
    let mut number = 0;
    let mut encoding = None;
    let mut elements: Vec<Element> = Vec::new();
    let mut comments = Vec::new();
    let mut unknown = None;
    loop {
        number += 1;
        let Some(length) = bytes[at..].iter().position(|&b| b == line_end) else {
            if number == 1 {
                return Err(not_ply(bytes));
            }
            let what = "the header has no 'end_header'".to_owned();
            return Err(at_line(number, ParseErrorKind::Truncated { what }));
        };
        let line = bytes[at..at + length].trim_ascii();
        at += length + 1;
        if number == 1 {
            if line != b"ply" {
                return Err(not_ply(bytes));
            }
            continue;
        }
        let mut words = line
            .split(u8::is_ascii_whitespace)
            .filter(|w| !w.is_empty());
        let error = |what: &str| {
            let what = what.to_owned();
            at_line(
                number,
                ParseErrorKind::Syntax {
                    what,
                    found: excerpt(line),
                },
            )
        };
        match words.next() {
            None => {}
            Some(b"comment" | b"obj_info") => comments.push(text(line)),
            Some(b"format") => {
                encoding = match words.next() {
                    Some(b"ascii") => Some(Encoding::Ascii),
                    Some(b"binary_little_endian") => Some(Encoding::LittleEndian),
                    Some(b"binary_big_endian") => Some(Encoding::BigEndian),
                    _ => return Err(error("unknown PLY format")),
                };
            }
            Some(b"element") => {
                let element = element(&mut words).ok_or_else(|| error("broken element line"))?;
                elements.push(element);
            }
            Some(b"property") => {
                let property = property(&mut words)
                    .ok_or_else(|| error("a property needs a PLY type and a name"))?;
                let element = elements
                    .last_mut()
                    .ok_or_else(|| error("a property before any element"))?;
                element.properties.push(property);
            }
            Some(b"end_header") => break,
            // a comment without the word
            Some(_) if elements.is_empty() => {
                unknown.get_or_insert((number, excerpt(line)));
            }
            Some(_) => return Err(error("this line does not belong in a PLY header")),
        }
    }
    let missing = "the header has no format line".to_owned();
    let encoding = encoding.ok_or_else(|| {
        at_line(
            number,
            ParseErrorKind::Syntax {
                what: missing,
                found: "end_header".into(),
            },
        )
    })?;
    Ok(Header {
        encoding,
        elements,
        comments,
        unknown,
        end: at,
        next_line: number + 1,
    })
}

fn not_ply(bytes: &[u8]) -> ParseError {
    let first = bytes.split(|&b| b == b'\n').next().unwrap_or(bytes);
    let found = format!("'{}' instead of 'ply'", excerpt(first));
    at_line(
        1,
        ParseErrorKind::NotThisFormat {
            format: "PLY",
            found,
        },
    )
}

fn element<'a>(words: &mut impl Iterator<Item = &'a [u8]>) -> Option<Element> {
    let name = text(words.next()?);
    let count = str::from_utf8(words.next()?).ok()?.parse().ok()?;
    Some(Element {
        name,
        count,
        properties: Vec::new(),
    })
}

fn property<'a>(words: &mut impl Iterator<Item = &'a [u8]>) -> Option<Property> {
    let kind = match words.next()? {
        b"list" => {
            let count = type_of_name(words.next()?).filter(|c| c.is_integer())?;
            Kind::List {
                count,
                item: type_of_name(words.next()?)?,
            }
        }
        name => Kind::Number(type_of_name(name)?),
    };
    Some(Property {
        name: text(words.next()?),
        kind,
    })
}

fn text(word: &[u8]) -> String {
    String::from_utf8_lossy(word).into_owned()
}
