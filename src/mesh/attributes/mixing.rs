//! Numbers of new rows from those of given rows.

use super::colors::{Colors, color_steps, to_light, to_signal};
use super::column::{Column, columns_named};

/// How the numbers of a column are interpolated.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Rule {
    /// Labels: the number of the nearest row.
    Copy,
    /// Measures: linearly.
    Linear,
    /// Colours: linearly in light. `full` is the number of full intensity; `steps` is the number of
    /// steps up to it if the colours are decimals that are all whole steps of an integer type.
    Light { full: f64, steps: Option<f64> },
}

impl Rule {
    fn of(columns: &[Column]) -> Vec<Self> {
        let colors = Colors::of(columns);
        let steps = colors.and_then(|c| decimal_steps(columns, &c));
        let rule = |(k, column): (usize, &Column)| match &colors {
            Some(colors) if colors.channels.contains(&k) => Self::Light {
                full: colors.full,
                steps,
            },
            Some(colors) if colors.alpha == Some(k) => Self::Linear,
            _ if column.numbers.kind().is_integer() => Self::Copy,
            _ => Self::Linear,
        };
        columns.iter().enumerate().map(rule).collect()
    }

    /// A number as a quantity that can be averaged.
    fn quantity(self, number: f64) -> f64 {
        match self {
            Self::Light { full, .. } => to_light(number / full),
            _ => number,
        }
    }

    fn append(self, column: &mut Column, quantity: f64) {
        let number = match self {
            Self::Light {
                full,
                steps: Some(steps),
            } => {
                let whole = (to_signal(quantity) * steps).round();
                // as the quotients in single precision that such colours are
                f64::from(whole as f32 / (steps / full) as f32)
            }
            Self::Light { full, .. } => to_signal(quantity) * full,
            Self::Copy | Self::Linear => quantity,
        };
        column.numbers.push(if column.numbers.kind().is_integer() {
            number.round()
        } else {
            number
        });
    }
}

/// The steps of the integer type whose whole steps all colours are, if they are decimals of a text file.
fn decimal_steps(columns: &[Column], colors: &Colors) -> Option<f64> {
    if columns[colors.channels[0]].is_typed {
        return None;
    }
    color_steps(&super::colors(columns)).map(f64::from)
}

/// Appends a row for each pair of rows `[a, b]` and `t` in 0..=1: their values at `t` of the way from
/// the first to the second. Labels are those of the nearer row; colours are mixed in linear light;
/// normals get length 1.
pub fn append_between(
    columns: &mut [Column],
    pairs: &(impl Iterator<Item = ([u32; 2], f64)> + Clone),
) {
    let first = super::row_count(columns);
    let rules = Rule::of(columns);
    for (column, rule) in columns.iter_mut().zip(rules) {
        for ([a, b], t) in pairs.clone() {
            let (a, b) = (a as usize, b as usize);
            if rule == Rule::Copy || column.numbers.are_same(a, b) {
                column.numbers.repeat(if t <= 0.5 { a } else { b });
                continue;
            }
            let [x, y] = [a, b].map(|i| rule.quantity(column.numbers.get(i)));
            rule.append(column, x + (y - x) * t);
        }
    }
    normalize(columns, first);
}

/// Appends rows that continue the rows `known`: `interpolate` maps the quantities of these, one each,
/// to those of the new rows. `nearest` is for each new row the row whose labels it gets. Colours are
/// mixed in linear light, normals get length 1.
pub fn append_interpolated(
    columns: &mut [Column],
    known: &[u32],
    nearest: &[u32],
    mut interpolate: impl FnMut(&[f64]) -> Vec<f64>,
) {
    let first = super::row_count(columns);
    let rules = Rule::of(columns);
    for (column, rule) in columns.iter_mut().zip(rules) {
        let first_known = known.first().map_or(0, |&row| row as usize);
        let is_same = |&row: &u32| column.numbers.are_same(row as usize, first_known);
        if rule == Rule::Copy || known.iter().all(is_same) {
            for &row in nearest {
                column.numbers.repeat(row as usize);
            }
            continue;
        }
        let number = |&row: &u32| rule.quantity(column.numbers.get(row as usize));
        let quantities: Vec<f64> = known.iter().map(number).collect();
        for quantity in interpolate(&quantities) {
            rule.append(column, quantity);
        }
    }
    normalize(columns, first);
}

/// Gives the normals `nx`, `ny`, `nz` from row `first` on length 1.
fn normalize(columns: &mut [Column], first: usize) {
    let Some(axes) = columns_named(columns, ["nx", "ny", "nz"]) else {
        return;
    };
    for row in first..super::row_count(columns) {
        let n = glam::DVec3::from(axes.map(|k| columns[k].numbers.get(row)));
        if let Some(n) = n.try_normalize() {
            for (k, x) in axes.into_iter().zip(n.to_array()) {
                columns[k].numbers.set(row, x);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::attributes::Numbers;

    fn column(name: &str, numbers: Numbers) -> Column {
        Column {
            name: name.to_owned(),
            numbers,
            is_typed: true,
        }
    }

    #[test]
    fn labels_measures_colours_and_normals() {
        let mut columns = vec![
            column("label", Numbers::I32(vec![4, 9])),
            column("quality", Numbers::F32(vec![1.0, 2.0])),
            column("red", Numbers::U8(vec![0, 255])),
            column("green", Numbers::U8(vec![7, 7])),
            column("blue", Numbers::U8(vec![255, 0])),
            column("alpha", Numbers::U8(vec![0, 255])),
            column("nx", Numbers::F32(vec![1.0, 0.0])),
            column("ny", Numbers::F32(vec![0.0, 1.0])),
            column("nz", Numbers::F32(vec![0.0, 0.0])),
        ];
        append_between(&mut columns, &[([0, 1], 0.5), ([0, 1], 0.75)].into_iter());
        append_interpolated(&mut columns, &[0, 1], &[1], |q| vec![0.5 * (q[0] + q[1])]);
        let row = |row: usize| -> Vec<f64> { columns.iter().map(|c| c.numbers.get(row)).collect() };
        let half = f64::from(0.5_f64.sqrt() as f32);
        // half of the light of 255 is 188
        let middle = [1.5, 188.0, 7.0, 188.0, 128.0, half, half, 0.0];
        assert_eq!(row(2)[0], 4.0);
        assert_eq!(row(2)[1..], middle);
        assert_eq!(row(3)[..2], [9.0, 1.75]);
        assert_eq!(row(4)[0], 9.0);
        assert_eq!(row(4)[1..], middle);
    }
}
