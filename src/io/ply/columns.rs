//! Columns of the numbers of an element.

use super::super::error::{ParseError, ParseErrorKind};
use super::header::{Element, Kind, Property};
use super::source::{Source, What};
use crate::mesh::{Column, NumberType, Numbers};

/// Where the value of a property goes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Target {
    /// To the reader of the element, which has a number for it.
    Own(usize),
    /// To a column.
    Column(usize),
    /// Nowhere: a list.
    Lost,
}

/// The columns of an element.
pub(super) struct Targets {
    /// Where each property goes.
    pub of_property: Vec<Target>,
    pub columns: Vec<Column>,
}

impl Targets {
    /// Columns for the numbers of an element that it does not own. The size of the file bounds the count
    /// of its rows.
    pub fn new(element: &Element, own: impl Fn(&Property) -> Option<usize>) -> Self {
        let mut columns = Vec::new();
        let mut of_property: Vec<Target> = Vec::new();
        for property in &element.properties {
            let target = match (own(property), property.kind) {
                // of two properties with one name, the last one counts, as in other programs
                (Some(number), _) => Target::Own(number),
                (None, Kind::Number(kind)) => {
                    columns.push(Column {
                        name: property.name.clone(),
                        numbers: Numbers::with_capacity(kind, element.count as usize),
                        is_typed: true,
                    });
                    Target::Column(columns.len() - 1)
                }
                (None, Kind::List { .. }) => Target::Lost,
            };
            of_property.push(target);
        }
        Self {
            of_property,
            columns,
        }
    }

    /// Reads the value of a property that is not owned.
    #[inline]
    pub fn read(
        &mut self,
        target: Target,
        property: &Property,
        source: &mut impl Source,
        what: What<'_>,
    ) -> Result<(), ParseError> {
        match (target, property.kind) {
            (Target::Column(k), Kind::Number(kind)) => {
                let number = source.number(kind, what)?;
                self.columns[k].numbers.push(number);
                Ok(())
            }
            _ => skip_property(property, source, what),
        }
    }

    /// Adds a note about the lists that are not kept.
    pub fn note_lost(&self, element: &Element, of: &str, notes: &mut Vec<String>) {
        let pairs = element.properties.iter().zip(&self.of_property);
        let lost = pairs.filter(|(_, target)| **target == Target::Lost);
        let names: Vec<&str> = lost.map(|(property, _)| property.name.as_str()).collect();
        if !names.is_empty() {
            notes.push(format!("{of} lists not kept: {}", names.join(", ")));
        }
    }
}

/// Skips one property of a row.
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

pub(super) fn list_length(
    count: NumberType,
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
