//! The PLY reader: positions, colours, polygons and triangle strips. Other elements are skipped.

use std::collections::BTreeMap;

use super::super::error::{ParseError, ParseErrorKind, in_file};
use super::header::{self, Element, Encoding, Header, Kind, Property, Scalar};
use super::source::{Binary, Source, Text, What};
use super::vertices;
use crate::mesh::{FaceTag, Soup};

/// Reads PLY.
pub(in super::super) fn read(bytes: &[u8]) -> Result<Soup, ParseError> {
    let header = header::read(bytes)?;
    match header.encoding {
        Encoding::Ascii => body(&header, Text::new(bytes, header.end, header.next_line)),
        Encoding::LittleEndian => body(&header, Binary::<false>::new(bytes, header.end)),
        Encoding::BigEndian => body(&header, Binary::<true>::new(bytes, header.end)),
    }
}

fn body(header: &Header, mut source: impl Source) -> Result<Soup, ParseError> {
    let named = |name: &str| {
        header
            .elements
            .iter()
            .find(|e| e.name == name && e.count > 0)
    };
    let count = named("vertex")
        .ok_or_else(|| in_file(ParseErrorKind::NoVertices))?
        .count;
    if u32::try_from(count).is_err() {
        return Err(in_file(ParseErrorKind::too_large("vertices")));
    }
    let count = count as usize;
    if named("face").or(named("tristrips")).is_none() {
        return Err(in_file(ParseErrorKind::NoFaces {
            vertices: count,
            cut: false,
        }));
    }
    let mut soup = Soup {
        offsets: vec![0],
        ..Soup::default()
    };
    let (mut faces, mut strips) = (false, false);
    for element in header
        .elements
        .iter()
        .filter(|e| e.count > 0 && !e.properties.is_empty())
    {
        check_size(element, header.encoding, &source)?;
        match element.name.as_str() {
            "vertex" if soup.positions.is_empty() => {
                vertices::read(element, &mut source, &mut soup)?;
            }
            "face" if !std::mem::replace(&mut faces, true) => {
                read_faces(element, &mut source, &mut soup, count)?;
            }
            "tristrips" if !std::mem::replace(&mut strips, true) => {
                read_strips(element, &mut source, &mut soup, count)?;
            }
            _ => skip(element, &mut source)?,
        }
    }
    if !soup.face_tags.is_empty() {
        // triangle strips have no patches
        soup.face_tags.resize(soup.face_count(), 0);
    }
    if soup.positions.is_empty() {
        return Err(in_file(ParseErrorKind::NoVertices));
    }
    if soup.face_count() == 0 {
        return Err(in_file(ParseErrorKind::NoFaces {
            vertices: count,
            cut: false,
        }));
    }
    if let Some((rows, line)) = source.longer_rows() {
        soup.notes.push(format!(
            "{rows} lines with more values than the header declares, the first of them line {line}: \
             the additional values are ignored"
        ));
    }
    if source.has_rest() {
        let rest = source.remaining();
        soup.notes
            .push(format!("{rest} bytes after the last element are ignored"));
    }
    Ok(soup)
}

/// Refuses counts that exceed the remaining file, before memory is allocated for them.
fn check_size(
    element: &Element,
    encoding: Encoding,
    source: &impl Source,
) -> Result<(), ParseError> {
    let least = u128::from(element.count) * u128::from(element.least_bytes(encoding));
    // The last line of a text file may have no line end.
    let have = source.remaining() as u128 + u128::from(encoding == Encoding::Ascii);
    if least <= have {
        return Ok(());
    }
    let Element { count, name, .. } = element;
    let left = source.remaining();
    Err(source.place().error(ParseErrorKind::truncated(format!(
        "the header declares {count} '{name}' elements, at least {least} bytes, but {left} are left"
    ))))
}

/// Which property of an element is its list of vertices.
fn corners_property(element: &Element) -> Result<usize, ParseError> {
    let is_corners = |p: &Property| {
        let list = matches!(p.kind, Kind::List { item, .. } if item.is_integer());
        list && (p.name == "vertex_indices" || p.name == "vertex_index")
    };
    element
        .properties
        .iter()
        .position(is_corners)
        .ok_or_else(|| {
            let name = &element.name;
            let what = format!("a PLY file whose '{name}' has no integer list 'vertex_indices'");
            let remedy = "export it with vertex indices";
            in_file(ParseErrorKind::Unsupported { what, remedy })
        })
}

fn read_faces(
    element: &Element,
    source: &mut impl Source,
    soup: &mut Soup,
    vertices: usize,
) -> Result<(), ParseError> {
    let corners = corners_property(element)?;
    let patches = element.properties.iter().position(is_patch);
    // check_size has bounded the count by the size of the file.
    let count = element.count as usize;
    soup.offsets.reserve_exact(count);
    // Most faces are triangles, and there are never more corners than bytes.
    soup.corners.reserve((3 * count).min(source.remaining()));
    let mut labels = Vec::new();
    for face in 0..count {
        let what = || format!("face {} of {count}", face + 1);
        source.begin_row(&what)?;
        for (k, property) in element.properties.iter().enumerate() {
            match property.kind {
                Kind::List { count, item } if k == corners => {
                    read_corners(count, item, source, soup, vertices)?;
                }
                Kind::Number(scalar) if Some(k) == patches => {
                    labels.push(u32::try_from(source.integer(scalar, &what)?).unwrap_or(0));
                }
                _ => skip_property(property, source, &what)?,
            }
        }
        source.end_row();
    }
    tag_patches(soup, &labels);
    if element.properties.len() > 1 + usize::from(patches.is_some()) {
        soup.notes
            .push("face properties other than the corners are not kept".into());
    }
    Ok(())
}

/// Whether a property has the number of the patch of a face, as this program writes it.
fn is_patch(property: &Property) -> bool {
    property.name == "patch" && matches!(property.kind, Kind::Number(kind) if kind.is_integer())
}

/// Tags the last faces by the numbers of their patches; 0 is no patch.
fn tag_patches(soup: &mut Soup, labels: &[u32]) {
    if labels.iter().all(|&label| label == 0) {
        return;
    }
    let mut tag_of = BTreeMap::from([(0, 0)]);
    soup.tags.push(FaceTag::default());
    soup.face_tags.resize(soup.face_count() - labels.len(), 0);
    for &label in labels {
        let tag = *tag_of.entry(label).or_insert_with(|| {
            soup.tags.push(FaceTag::default().in_patch(label));
            soup.tags.len() as u32 - 1
        });
        soup.face_tags.push(tag);
    }
}

fn read_corners(
    count: Scalar,
    item: Scalar,
    source: &mut impl Source,
    soup: &mut Soup,
    vertices: usize,
) -> Result<(), ParseError> {
    let face = soup.offsets.len();
    let what = || format!("face {face}");
    let found = list_length(count, source, &what)?;
    if found < 3 {
        return Err(source.place().error(ParseErrorKind::FewCorners {
            face,
            found,
            cut: false,
        }));
    }
    for _ in 0..found {
        let found = source.integer(item, &what)?;
        match u32::try_from(found) {
            Ok(vertex) if (vertex as usize) < vertices => soup.corners.push(vertex),
            _ => {
                let kind = ParseErrorKind::IndexRange {
                    face,
                    found,
                    vertices,
                    first: 0,
                };
                return Err(source.place().error(kind));
            }
        }
    }
    push_offset(soup)
}

/// Reads triangle strips as triangles: each vertex of a strip makes one with the two before it, in
/// alternating orientation, and −1 starts another strip. Triangles that name a vertex twice only
/// join two parts of a strip and are left out.
fn read_strips(
    element: &Element,
    source: &mut impl Source,
    soup: &mut Soup,
    vertices: usize,
) -> Result<(), ParseError> {
    let corners = corners_property(element)?;
    for row in 1..=element.count {
        let what = || format!("triangle strip {row} of {}", element.count);
        source.begin_row(&what)?;
        for (k, property) in element.properties.iter().enumerate() {
            match property.kind {
                Kind::List { count, item } if k == corners => {
                    let mut strip: Vec<u32> = Vec::new();
                    for _ in 0..list_length(count, source, &what)? {
                        let found = source.integer(item, &what)?;
                        match u32::try_from(found) {
                            Ok(vertex) if (vertex as usize) < vertices => strip.push(vertex),
                            _ if found == -1 => strip.clear(),
                            _ => {
                                let kind = ParseErrorKind::IndexRange {
                                    face: soup.offsets.len(),
                                    found,
                                    vertices,
                                    first: 0,
                                };
                                return Err(source.place().error(kind));
                            }
                        }
                        if let [.., a, b, c] = strip[..]
                            && found != -1
                            && a != b
                            && b != c
                            && c != a
                        {
                            let is_odd = strip.len() % 2 == 1;
                            let corners = if is_odd { [a, b, c] } else { [b, a, c] };
                            soup.corners.extend(corners);
                            push_offset(soup)?;
                        }
                    }
                }
                _ => skip_property(property, source, &what)?,
            }
        }
        source.end_row();
    }
    Ok(())
}

/// Ends a face after the last corner.
fn push_offset(soup: &mut Soup) -> Result<(), ParseError> {
    let end = u32::try_from(soup.corners.len());
    soup.offsets
        .push(end.map_err(|_| in_file(ParseErrorKind::too_large("face corners")))?);
    Ok(())
}

fn list_length(
    count: Scalar,
    source: &mut impl Source,
    what: What<'_>,
) -> Result<usize, ParseError> {
    let length = source.integer(count, what)?;
    usize::try_from(length)
        .ok()
        .filter(|&n| n <= source.remaining())
        .ok_or_else(|| {
            let what = format!(
                "{} has a list of {length} items, which is not valid",
                what()
            );
            source.place().error(ParseErrorKind::truncated(what))
        })
}

pub(super) fn skip_property(
    property: &Property,
    source: &mut impl Source,
    what: What<'_>,
) -> Result<(), ParseError> {
    let (length, item) = match property.kind {
        Kind::Number(scalar) => (1, scalar),
        Kind::List { count, item } => (list_length(count, source, what)?, item),
    };
    for _ in 0..length {
        source.number(item, what)?;
    }
    Ok(())
}

/// Skips an unused element.
fn skip(element: &Element, source: &mut impl Source) -> Result<(), ParseError> {
    for row in 0..element.count {
        let what = || format!("'{}' element {}", element.name, row + 1);
        source.begin_row(&what)?;
        for property in &element.properties {
            skip_property(property, source, &what)?;
        }
        source.end_row();
    }
    Ok(())
}
