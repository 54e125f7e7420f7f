//! The PLY reader: vertices, polygons and triangle strips. Other elements are skipped.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::super::error::{ParseError, ParseErrorKind, in_file};
use super::super::text_scanner::unix_lines;
use super::columns::{Target, Targets, list_length, skip_property};
use super::header::{self, Element, Encoding, Header, Kind, Property};
use super::source::{Binary, Source, Text};
use super::vertices;
use crate::mesh::{Column, FaceTag, NO_VALUE, NumberType, Numbers, Soup};

/// Reads PLY.
pub(in super::super) fn read(bytes: &[u8]) -> Result<Soup, ParseError> {
    let header = header::read(bytes)?;
    match header.encoding {
        Encoding::Ascii => {
            let text = unix_lines(bytes);
            body(&header, Text::new(&text, header.end, header.next_line))
        }
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
    soup.attributes.comments.clone_from(&header.comments);
    if let Some((line, found)) = &header.unknown {
        soup.notes.push(format!(
            "line {line} of the header, '{found}', is ignored: it begins with no word of the format"
        ));
    }
    let (mut faces, mut strips) = (false, false);
    let mut skipped: Vec<&str> = Vec::new();
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
            name => {
                skip(element, &mut source)?;
                skipped.push(name);
            }
        }
    }
    if !skipped.is_empty() {
        soup.notes
            .push(format!("elements not kept: {}", skipped.join(", ")));
    }
    pad_strips(&mut soup);
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

/// The list of the corners' vertices among what [`read_faces`] reads itself.
const CORNERS: usize = 0;
/// The list of the corners' texture coordinates.
const TEXTURE: usize = 1;

fn read_faces(
    element: &Element,
    source: &mut impl Source,
    soup: &mut Soup,
    vertices: usize,
) -> Result<(), ParseError> {
    let corners = corners_property(element)?;
    let texture = element.properties.iter().position(is_texture);
    let mut targets = Targets::new(element, |property| {
        let is = |k: usize| std::ptr::eq(property, &raw const element.properties[k]);
        match texture {
            _ if is(corners) => Some(CORNERS),
            Some(k) if is(k) => Some(TEXTURE),
            _ => None,
        }
    });
    // check_size has bounded the count by the size of the file.
    let count = element.count as usize;
    soup.offsets.reserve_exact(count);
    // Most faces are triangles, and there are never more corners than bytes.
    soup.corners.reserve((3 * count).min(source.remaining()));
    let kind = texture.map_or(NumberType::F32, |k| match element.properties[k].kind {
        Kind::List { item, .. } | Kind::Number(item) => item,
    });
    let mut coordinates = TextureLists {
        numbers: [(); 2].map(|()| Numbers::with_capacity(kind, 0)),
        of_corner: Vec::new(),
        wrong: 0,
    };
    let mut row = Vec::new();
    for face in 0..count {
        let what = || format!("face {} of {count}", face + 1);
        source.begin_row(&what)?;
        let first = soup.corners.len();
        row.clear();
        for (k, property) in element.properties.iter().enumerate() {
            match (targets.of_property[k], property.kind) {
                (Target::Own(CORNERS), Kind::List { count, item }) => {
                    read_corners(count, item, source, soup, vertices)?;
                }
                (Target::Own(TEXTURE), Kind::List { count, item }) => {
                    for _ in 0..list_length(count, source, &what)? {
                        row.push(source.number(item, &what)?);
                    }
                }
                (target, _) => targets.read(target, property, source, &what)?,
            }
        }
        source.end_row();
        if texture.is_some() {
            coordinates.face(&row, soup.corners.len() - first);
        }
    }
    targets.note_lost(element, "face", &mut soup.notes);
    soup.attributes.faces.columns = targets.columns;
    coordinates.settle(soup);
    tag_patches(soup, count);
    Ok(())
}

/// Texture coordinates of corners, as many programs write them: for each face a list of u and v
/// of each corner.
struct TextureLists {
    numbers: [Numbers; 2],
    of_corner: Vec<u32>,
    /// Faces with another number of coordinates than twice their corners.
    wrong: usize,
}

impl TextureLists {
    fn face(&mut self, row: &[f64], corners: usize) {
        // programs write zeros for faces without coordinates
        let is_empty = row.iter().all(|x| x.to_bits() == 0);
        if row.len() == 2 * corners && !is_empty {
            for pair in row.chunks_exact(2) {
                self.of_corner.push(self.numbers[0].len() as u32);
                for (list, number) in self.numbers.iter_mut().zip(pair) {
                    list.push(*number);
                }
            }
        } else {
            self.wrong += usize::from(row.len() != 2 * corners && !row.is_empty());
            self.of_corner
                .resize(self.of_corner.len() + corners, NO_VALUE);
        }
    }

    fn settle(self, soup: &mut Soup) {
        if self.wrong > 0 {
            soup.notes.push(format!(
                "{} faces have texture coordinates that do not fit their corners: not kept",
                self.wrong
            ));
        }
        if self.numbers[0].is_empty() {
            return;
        }
        let column = |(name, numbers): (&str, Numbers)| Column {
            name: name.to_owned(),
            numbers,
            is_typed: true,
        };
        let columns = ["u", "v"].into_iter().zip(self.numbers).map(column);
        soup.attributes.texture = Arc::new(columns.collect());
        let before = soup.corners.len() - self.of_corner.len();
        let list = &mut soup.attributes.faces.texture;
        list.resize(before, NO_VALUE);
        list.extend(self.of_corner);
    }
}

/// Whether a property is the list of the texture coordinates of corners.
fn is_texture(property: &Property) -> bool {
    property.name == "texcoord"
        && matches!(property.kind, Kind::List { item, .. } if !item.is_integer())
}

/// Gives triangles of strips the data that other faces have: zeros, and no texture coordinates.
fn pad_strips(soup: &mut Soup) {
    let (faces, corners) = (soup.face_count(), soup.corners.len());
    let data = &mut soup.attributes.faces;
    if !data.tags.is_empty() {
        data.tags.resize(faces, 0);
    }
    if !data.texture.is_empty() {
        data.texture.resize(corners, NO_VALUE);
    }
    for column in &mut data.columns {
        column.numbers.pad(faces);
    }
}

/// Tags the last `count` faces by the numbers of their patches in the column `patch`, as this program
/// writes it; 0 is no patch.
fn tag_patches(soup: &mut Soup, count: usize) {
    let data = &mut soup.attributes.faces;
    let is_patch = |column: &Column| column.name == "patch";
    let Some(k) = data.columns.iter().position(is_patch) else {
        return;
    };
    let Numbers::I32(labels) = &data.columns[k].numbers else {
        return;
    };
    if labels.iter().any(|&label| label < 0) || labels.iter().all(|&label| label == 0) {
        return;
    }
    let mut tag_of = BTreeMap::from([(0, 0)]);
    let tags = &mut soup.attributes.tags;
    tags.push(FaceTag::default());
    data.tags.resize(soup.offsets.len() - 1 - count, 0);
    for &label in labels {
        let tag = *tag_of.entry(label).or_insert_with(|| {
            tags.push(FaceTag::default().in_patch(label.unsigned_abs()));
            tags.len() as u32 - 1
        });
        data.tags.push(tag);
    }
    data.columns.remove(k);
}

fn read_corners(
    count: NumberType,
    item: NumberType,
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
