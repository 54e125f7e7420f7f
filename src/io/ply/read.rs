//! PLY in: positions, colours and polygons; everything else is skipped.

use super::super::error::{Fault, Place, Problem, in_file};
use super::header::{self, Element, Encoding, Header, Kind, Property, Scalar};
use super::source::{Binary, Source, Text};
use crate::mesh::{DVec3, Soup};

/// Reads PLY.
pub(in super::super) fn read(bytes: &[u8]) -> Result<Soup, Fault> {
    let header = header::read(bytes)?;
    match header.encoding {
        Encoding::Ascii => body(&header, Text::new(bytes, header.end, header.next_line)),
        Encoding::LittleEndian => body(&header, Binary::<false>::new(bytes, header.end)),
        Encoding::BigEndian => body(&header, Binary::<true>::new(bytes, header.end)),
    }
}

fn body(header: &Header, mut source: impl Source) -> Result<Soup, Fault> {
    let named = |name: &str| {
        header
            .elements
            .iter()
            .find(|e| e.name == name && e.count > 0)
    };
    let vertices = named("vertex")
        .ok_or_else(|| in_file(Problem::NoVertices))?
        .count;
    if vertices > u64::from(u32::MAX) {
        return Err(in_file(Problem::TooLarge {
            what: "vertices",
            limit: u64::from(u32::MAX),
        }));
    }
    if named("face").is_none() {
        if named("tristrips").is_some() {
            let what = "a PLY file with triangle strips instead of faces".to_owned();
            let remedy = "export it with faces";
            return Err(in_file(Problem::Unsupported { what, remedy }));
        }
        let vertices = vertices as usize;
        return Err(in_file(Problem::NoFaces {
            vertices,
            cut: false,
        }));
    }
    let mut soup = Soup::default();
    let mut done = [false; 2];
    for element in &header.elements {
        check_size(element, header.encoding, &source)?;
        match element.name.as_str() {
            "vertex" if !done[0] => {
                done[0] = element.count > 0;
                read_vertices(element, &mut source, &mut soup)?;
            }
            "face" if !done[1] => {
                done[1] = element.count > 0;
                read_faces(element, &mut source, &mut soup, vertices)?;
            }
            _ => skip(element, &mut source)?,
        }
    }
    if source.has_rest() {
        let rest = source.remaining();
        soup.notes.push(format!(
            "{rest} bytes after the last element of the header: ignored"
        ));
    }
    Ok(soup)
}

/// Refuses counts that the rest of the file cannot hold, before anything is allocated for them.
fn check_size(element: &Element, encoding: Encoding, source: &impl Source) -> Result<(), Fault> {
    let least = u128::from(element.count) * u128::from(element.least_bytes(encoding));
    // The last line of a text may lack its line end.
    let have = source.remaining() as u128 + u128::from(encoding == Encoding::Ascii);
    if least > have {
        let what = format!(
            "the header declares {} '{}' elements, which take at least {least} bytes, but {} are left",
            element.count,
            element.name,
            source.remaining()
        );
        return Err(Fault {
            place: source.place(),
            problem: Problem::Truncated { what },
        });
    }
    Ok(())
}

/// What a vertex property is.
#[derive(Clone, Copy, PartialEq)]
enum Role {
    Coordinate(usize),
    Color(usize, f32),
    Other,
}

fn role(property: &Property) -> Role {
    let Kind::Number(scalar) = property.kind else {
        return Role::Other;
    };
    // Integer channels fill the range of their type; floating ones are 0..=1.
    let scale = match scalar {
        Scalar::U8 => 255.0,
        Scalar::U16 => 65535.0,
        Scalar::F32 | Scalar::F64 => 1.0,
        _ => 0.0,
    };
    match property.name.as_str() {
        "x" => Role::Coordinate(0),
        "y" => Role::Coordinate(1),
        "z" => Role::Coordinate(2),
        "red" | "r" | "diffuse_red" if scale > 0.0 => Role::Color(0, scale),
        "green" | "g" | "diffuse_green" if scale > 0.0 => Role::Color(1, scale),
        "blue" | "b" | "diffuse_blue" if scale > 0.0 => Role::Color(2, scale),
        "alpha" | "a" if scale > 0.0 => Role::Color(3, scale),
        _ => Role::Other,
    }
}

fn read_vertices(
    element: &Element,
    source: &mut impl Source,
    soup: &mut Soup,
) -> Result<(), Fault> {
    let roles: Vec<Role> = element.properties.iter().map(role).collect();
    for (axis, name) in ["x", "y", "z"].iter().enumerate() {
        if !roles.contains(&Role::Coordinate(axis)) {
            let what = "the vertices have no coordinate".to_owned();
            return Err(in_file(Problem::Syntax {
                what,
                found: (*name).to_owned(),
            }));
        }
    }
    let has = |channel| {
        roles
            .iter()
            .any(|r| matches!(r, Role::Color(c, _) if *c == channel))
    };
    let colored = has(0) && has(1) && has(2);
    // check_size has bounded the count by the size of the file.
    let count = element.count as usize;
    soup.positions.reserve_exact(count);
    if colored {
        soup.colors.reserve_exact(count);
    }
    for vertex in 0..count {
        let what = || format!("vertex {} of {count}", vertex + 1);
        let mut point = [0.0; 3];
        let mut color = [1.0_f32; 4];
        source.begin_row(&what)?;
        for (property, role) in element.properties.iter().zip(&roles) {
            let Kind::Number(scalar) = property.kind else {
                skip_list(property, source, &what)?;
                continue;
            };
            let value = source.number(scalar, &what)?;
            match *role {
                Role::Coordinate(axis) => {
                    if !value.is_finite() {
                        return Err(not_finite(source.place(), vertex, axis, value));
                    }
                    point[axis] = value;
                }
                Role::Color(channel, scale) => color[channel] = value as f32 / scale,
                Role::Other => {}
            }
        }
        source.end_row(&what)?;
        soup.positions.push(DVec3::from_array(point));
        if colored {
            soup.colors.push(color);
        }
    }
    let lost: Vec<&str> = element
        .properties
        .iter()
        .zip(&roles)
        .filter(|(_, role)| {
            matches!(role, Role::Other) || (matches!(role, Role::Color(..)) && !colored)
        })
        .map(|(property, _)| property.name.as_str())
        .collect();
    if !lost.is_empty() {
        soup.notes
            .push(format!("vertex properties not kept: {}", lost.join(", ")));
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
    Ok(())
}

fn not_finite(place: Place, vertex: usize, axis: usize, value: f64) -> Fault {
    let axis = ['x', 'y', 'z'][axis];
    let problem = Problem::NotFinite {
        vertex: vertex + 1,
        axis,
        found: value.to_string(),
    };
    Fault { place, problem }
}

fn read_faces(
    element: &Element,
    source: &mut impl Source,
    soup: &mut Soup,
    vertices: u64,
) -> Result<(), Fault> {
    let is_corners = |p: &Property| {
        let list = matches!(p.kind, Kind::List { item, .. } if item.is_integer());
        list && (p.name == "vertex_indices" || p.name == "vertex_index")
    };
    let Some(corners) = element.properties.iter().position(is_corners) else {
        let what = "a PLY file whose faces have no integer list 'vertex_indices'".to_owned();
        let remedy = "export it with vertex indices";
        return Err(in_file(Problem::Unsupported { what, remedy }));
    };
    let count = element.count as usize;
    soup.offsets.reserve_exact(count + 1);
    soup.offsets.push(0);
    // Triangles most of the time, and never more corners than bytes.
    soup.corners.reserve((3 * count).min(source.remaining()));
    for face in 0..count {
        let what = || format!("face {} of {count}", face + 1);
        source.begin_row(&what)?;
        for (k, property) in element.properties.iter().enumerate() {
            match property.kind {
                Kind::List { count, item } if k == corners => {
                    read_corners(count, item, source, soup, vertices)?;
                }
                Kind::List { .. } => skip_list(property, source, &what)?,
                Kind::Number(scalar) => {
                    source.number(scalar, &what)?;
                }
            }
        }
        source.end_row(&what)?;
    }
    if element.properties.len() > 1 {
        soup.notes
            .push("face properties other than the corners: not kept".into());
    }
    Ok(())
}

fn read_corners(
    count: Scalar,
    item: Scalar,
    source: &mut impl Source,
    soup: &mut Soup,
    vertices: u64,
) -> Result<(), Fault> {
    let face = soup.offsets.len();
    let what = || format!("face {face}");
    let found = list_length(count, source, &what)?;
    if found < 3 {
        let problem = Problem::FewCorners {
            face,
            found,
            cut: false,
        };
        return Err(Fault {
            place: source.place(),
            problem,
        });
    }
    for _ in 0..found {
        let index = source.number(item, &what)?;
        if !(0.0..vertices as f64).contains(&index) {
            let found = index as i64;
            let last = vertices as i64 - 1;
            let problem = Problem::IndexRange {
                face,
                found,
                first: 0,
                last,
            };
            return Err(Fault {
                place: source.place(),
                problem,
            });
        }
        soup.corners.push(index as u32);
    }
    let Ok(end) = u32::try_from(soup.corners.len()) else {
        let limit = u64::from(u32::MAX);
        let problem = Problem::TooLarge {
            what: "face corners",
            limit,
        };
        return Err(Fault {
            place: source.place(),
            problem,
        });
    };
    soup.offsets.push(end);
    Ok(())
}

fn list_length(
    count: Scalar,
    source: &mut impl Source,
    what: &dyn Fn() -> String,
) -> Result<usize, Fault> {
    let length = source.number(count, what)?;
    if length < 0.0 || length > source.remaining() as f64 {
        let what = format!(
            "{} has a list of {length} items, but the file is not that long",
            what()
        );
        return Err(Fault {
            place: source.place(),
            problem: Problem::Truncated { what },
        });
    }
    Ok(length as usize)
}

fn skip_list(
    property: &Property,
    source: &mut impl Source,
    what: &dyn Fn() -> String,
) -> Result<(), Fault> {
    if let Kind::List { count, item } = property.kind {
        for _ in 0..list_length(count, source, what)? {
            source.number(item, what)?;
        }
    }
    Ok(())
}

/// Passes over an element that means nothing here.
fn skip(element: &Element, source: &mut impl Source) -> Result<(), Fault> {
    if element.properties.is_empty() {
        // Rows without numbers take no room, whatever their count says.
        return Ok(());
    }
    for row in 0..element.count {
        let what = || format!("'{}' element {}", element.name, row + 1);
        source.begin_row(&what)?;
        for property in &element.properties {
            match property.kind {
                Kind::List { .. } => skip_list(property, source, &what)?,
                Kind::Number(scalar) => {
                    source.number(scalar, &what)?;
                }
            }
        }
        source.end_row(&what)?;
    }
    Ok(())
}
