//! The vertex element: coordinates, and the columns of all other numbers.

use super::super::error::{ParseError, ParseErrorKind, in_file};
use super::columns::{Target, Targets};
use super::header::{Element, Kind};
use super::source::Source;
use crate::mesh::{DVec3, Soup};

const AXES: [&str; 3] = ["x", "y", "z"];

/// Reads positions and columns.
pub(super) fn read(
    element: &Element,
    source: &mut impl Source,
    soup: &mut Soup,
) -> Result<(), ParseError> {
    // The caller has bounded the count by the size of the file.
    let count = element.count as usize;
    let mut targets = Targets::new(element, |property| {
        AXES.iter()
            .position(|axis| property.name == *axis)
            .filter(|_| matches!(property.kind, Kind::Number(_)))
    });
    for (axis, name) in AXES.into_iter().enumerate() {
        if !targets.of_property.contains(&Target::Own(axis)) {
            return Err(in_file(ParseErrorKind::syntax(
                "the vertices have no coordinate",
                name,
            )));
        }
    }
    soup.positions.reserve_exact(count);
    for vertex in 1..=count {
        let what = || format!("vertex {vertex} of {count}");
        let mut point = [0.0; 3];
        source.begin_row(&what)?;
        for (k, property) in element.properties.iter().enumerate() {
            match (targets.of_property[k], property.kind) {
                (Target::Own(axis), Kind::Number(kind)) => {
                    let value = source.number(kind, &what)?;
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
                (target, _) => targets.read(target, property, source, &what)?,
            }
        }
        source.end_row();
        soup.positions.push(DVec3::from_array(point));
    }
    targets.note_lost(element, "vertex", &mut soup.notes);
    soup.attributes.vertices = targets.columns;
    Ok(())
}
