//! The vertex element: coordinates and colours.

use super::super::error::{ParseError, ParseErrorKind, in_file};
use super::header::{Element, Kind, Property, Scalar};
use super::read::skip_property;
use super::source::Source;
use crate::mesh::{DVec3, Soup};

/// The role of a vertex property.
#[derive(Clone, Copy, PartialEq)]
enum Role {
    Coordinate(usize),
    /// A colour channel and the value that corresponds to 1.
    Color(usize, f32),
    Other,
}

fn role(property: &Property) -> Role {
    // Integer channels use the range of their type; floating-point ones are 0..=1.
    let full = match property.kind {
        Kind::Number(Scalar::U8) => 255.0,
        Kind::Number(Scalar::U16) => 65535.0,
        Kind::Number(Scalar::F32 | Scalar::F64) => 1.0,
        Kind::Number(_) => 0.0,
        Kind::List { .. } => return Role::Other,
    };
    match property.name.as_str() {
        "x" => Role::Coordinate(0),
        "y" => Role::Coordinate(1),
        "z" => Role::Coordinate(2),
        "red" | "r" | "diffuse_red" if full > 0.0 => Role::Color(0, full),
        "green" | "g" | "diffuse_green" if full > 0.0 => Role::Color(1, full),
        "blue" | "b" | "diffuse_blue" if full > 0.0 => Role::Color(2, full),
        "alpha" | "a" if full > 0.0 => Role::Color(3, full),
        _ => Role::Other,
    }
}

/// Roles of all properties. Colours need red, green and blue.
fn roles(element: &Element) -> Result<Vec<Role>, ParseError> {
    let mut roles: Vec<Role> = element.properties.iter().map(role).collect();
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        if !roles.contains(&Role::Coordinate(axis)) {
            return Err(in_file(ParseErrorKind::syntax(
                "the vertices have no coordinate",
                name,
            )));
        }
    }
    let has = |channel| {
        roles
            .iter()
            .any(|r| matches!(r, Role::Color(c, _) if *c == channel))
    };
    if !(has(0) && has(1) && has(2)) {
        for role in roles.iter_mut().filter(|r| matches!(r, Role::Color(..))) {
            *role = Role::Other;
        }
    }
    Ok(roles)
}

/// Reads positions and colours.
pub(super) fn read(
    element: &Element,
    source: &mut impl Source,
    soup: &mut Soup,
) -> Result<(), ParseError> {
    let roles = roles(element)?;
    let colored = roles.iter().any(|r| matches!(r, Role::Color(..)));
    // The caller has bounded the count by the size of the file.
    let count = element.count as usize;
    soup.positions.reserve_exact(count);
    if colored {
        soup.colors.reserve_exact(count);
    }
    for vertex in 1..=count {
        let what = || format!("vertex {vertex} of {count}");
        let mut point = [0.0; 3];
        let mut color = [1.0_f32; 4];
        source.begin_row(&what)?;
        for (property, role) in element.properties.iter().zip(&roles) {
            match (*role, property.kind) {
                (Role::Coordinate(axis), Kind::Number(scalar)) => {
                    let value = source.number(scalar, &what)?;
                    if !value.is_finite() {
                        let axis = ['x', 'y', 'z'][axis];
                        let found = value.to_string();
                        let kind = ParseErrorKind::NotFinite {
                            vertex,
                            axis,
                            found,
                        };
                        return Err(source.place().error(kind));
                    }
                    point[axis] = value;
                }
                (Role::Color(channel, full), Kind::Number(scalar)) => {
                    color[channel] = source.number(scalar, &what)? as f32 / full;
                }
                _ => skip_property(property, source, &what)?,
            }
        }
        source.end_row();
        soup.positions.push(DVec3::from_array(point));
        if colored {
            soup.colors.push(color);
        }
    }
    let others = element
        .properties
        .iter()
        .zip(&roles)
        .filter(|(_, role)| **role == Role::Other);
    let lost: Vec<&str> = others.map(|(property, _)| property.name.as_str()).collect();
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
