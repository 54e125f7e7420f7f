//! Colours among the columns of vertices and faces.

use super::column::{Column, NumberType, Numbers};

/// The columns of a colour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Colors {
    /// Indices of the columns of red, green and blue.
    pub channels: [usize; 3],
    /// Index of the column of the opacity. Whole numbers have the range of their type; others are in
    /// 0..=1, or 0..=255 if one is above 1.
    pub alpha: Option<usize>,
    /// The number that stands for full intensity.
    pub full: f64,
}

/// Which channel a name stands for: 0 to 2 for red, green and blue, 3 for the opacity.
fn channel(name: &str) -> Option<usize> {
    Some(match name {
        "red" | "r" | "diffuse_red" => 0,
        "green" | "g" | "diffuse_green" => 1,
        "blue" | "b" | "diffuse_blue" => 2,
        "alpha" | "a" => 3,
        _ => return None,
    })
}

/// The first column of a channel.
fn find(columns: &[Column], wanted: usize) -> Option<usize> {
    let is_wanted = |c: &Column| channel(&c.name) == Some(wanted);
    columns.iter().position(is_wanted)
}

/// Whether a type has a number of full intensity.
fn has_full(kind: NumberType) -> bool {
    use NumberType::{F32, F64, U8, U16};
    matches!(kind, U8 | U16 | F32 | F64)
}

impl Colors {
    /// The colour among these columns: red, green and blue of one type. Whole numbers have the range
    /// of their type; other numbers 0 to 1, or 0 to 255 if one of them is above 1.
    pub fn of(columns: &[Column]) -> Option<Self> {
        let channels = Self::channels(columns)?;
        let full = channels.iter().map(|&k| full(&columns[k].numbers));
        let full = full.reduce(|a, b| Some(a?.max(b?)))??;
        Some(Self {
            channels,
            alpha: find(columns, 3),
            full,
        })
    }

    /// The columns of red, green and blue among these, without a look at their numbers. `None` if one is missing
    /// or their types are not one that has a full intensity.
    pub fn channels(columns: &[Column]) -> Option<[usize; 3]> {
        let channels = [find(columns, 0)?, find(columns, 1)?, find(columns, 2)?];
        let kind = columns[channels[0]].numbers.kind();
        let is_alike = |&k: &usize| columns[k].numbers.kind() == kind;
        (has_full(kind) && channels.iter().all(is_alike)).then_some(channels)
    }
}

/// The number of full intensity; `None` for a type that has none.
fn full(numbers: &Numbers) -> Option<f64> {
    match numbers.kind() {
        NumberType::U8 => Some(255.0),
        NumberType::U16 => Some(65535.0),
        NumberType::F32 | NumberType::F64 => {
            let is_above = (0..numbers.len()).any(|row| numbers.get(row) > 1.0);
            Some(if is_above { 255.0 } else { 1.0 })
        }
        _ => None,
    }
}

/// Red, green, blue and opacity in 0..=1 for each row; empty if the columns have no colour, or a
/// colour that is not finite.
pub fn colors(columns: &[Column]) -> Vec<[f32; 4]> {
    let Some(Colors {
        channels,
        alpha,
        full,
    }) = Colors::of(columns)
    else {
        return Vec::new();
    };
    let alpha = alpha.and_then(|k| Some((k, self::full(&columns[k].numbers)?)));
    let part = |k: usize, row: usize, full: f64| columns[k].numbers.get(row) as f32 / full as f32;
    let color = |row| {
        let [r, g, b] = channels.map(|k| part(k, row, full));
        [r, g, b, alpha.map_or(1.0, |(k, full)| part(k, row, full))]
    };
    let mut all: Vec<[f32; 4]> = (0..super::row_count(columns)).map(color).collect();
    if !all.iter().flatten().all(|c| c.is_finite()) {
        return Vec::new();
    }
    for channel in all.iter_mut().flatten() {
        *channel = channel.max(0.0);
    }
    all
}

/// Colours of the faces of a binary STL file: five bits for each channel in the attribute of a face.
pub(super) struct StlColors<'a> {
    attributes: &'a [u16],
    /// The colour of faces without one of their own.
    default: Option<[f32; 3]>,
    /// Whether the highest bit marks faces without a colour of their own and red has the lowest bits, as
    /// Materialise writes them. In other files it marks faces with a colour, and blue has the lowest bits.
    is_materialise: bool,
}

impl<'a> StlColors<'a> {
    /// Those in the attributes among these columns of faces, in a file with this header. `None` if no face has
    /// one.
    pub fn of(columns: &'a [Column], header: Option<&[u8; 80]>) -> Option<Self> {
        const MARK: &[u8] = b"COLOR=";
        let header = header?;
        let attributes = columns.iter().find_map(|column| match &column.numbers {
            Numbers::U16(attributes) if column.name == "attribute" => Some(&attributes[..]),
            _ => None,
        })?;
        let at = header.windows(MARK.len()).position(|text| text == MARK);
        let default = at.and_then(|at| header.get(at + MARK.len()..)?.first_chunk());
        let default = default.map(|bytes: &[u8; 3]| bytes.map(|byte| f32::from(byte) / 255.0));
        let is_materialise = default.is_some();
        let has_some = is_materialise || attributes.iter().any(|bits| bits & 0x8000 != 0);
        has_some.then_some(Self {
            attributes,
            default,
            is_materialise,
        })
    }

    /// Red, green and blue in 0..=1 for each face.
    pub fn all(&self) -> Vec<Option<[f32; 3]>> {
        let color = |&bits: &u16| {
            let is_own = (bits & 0x8000 != 0) != self.is_materialise;
            let [low, middle, high] = [0, 5, 10].map(|k| f32::from(bits >> k & 31) / 31.0);
            match (is_own, self.is_materialise) {
                (false, _) => self.default,
                (true, true) => Some([low, middle, high]),
                (true, false) => Some([high, middle, low]),
            }
        };
        self.attributes.iter().map(color).collect()
    }
}

/// Columns of colours in 0..=1 without a declared type; with opacity only if one differs from 1.
pub fn color_columns(colors: &[[f32; 4]]) -> Vec<Column> {
    if colors.is_empty() {
        return Vec::new();
    }
    let count = if colors.iter().all(|c| c[3] == 1.0) {
        3
    } else {
        4
    };
    let column = |k: usize| colors.iter().map(|c| f64::from(c[k])).collect();
    let names = ["red", "green", "blue", "alpha"];
    (0..count)
        .map(|k| Column::decimals(names[k], column(k)))
        .collect()
}

/// The largest value of the integer type, 255 or 65535, in whose steps all colours are exact; `None`
/// if there is none. Channels are the quotients of these values in single precision.
pub fn color_steps(colors: &[[f32; 4]]) -> Option<u16> {
    let is_exact = |steps: u16| {
        let mut channels = colors.iter().flatten();
        channels.all(|&c| (0.0..=1.0).contains(&c) && rounded(c, steps) == c)
    };
    [u8::MAX.into(), u16::MAX]
        .into_iter()
        .find(|&s| is_exact(s))
}

fn rounded(channel: f32, steps: u16) -> f32 {
    let steps = f32::from(steps);
    (channel * steps).round() / steps
}

/// The light of a signal in 0..=1, by the transfer function of sRGB.
pub fn to_light(signal: f64) -> f64 {
    if signal <= 0.040_45 {
        signal / 12.92
    } else {
        ((signal + 0.055) / 1.055).powf(2.4)
    }
}

/// The signal of a light: the inverse of [`to_light`].
pub fn to_signal(light: f64) -> f64 {
    if light <= 0.040_45 / 12.92 {
        light * 12.92
    } else {
        1.055 * light.powf(1.0 / 2.4) - 0.055
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_of_integer_types_are_found() {
        let byte = |k: u8| f32::from(k) / 255.0;
        let word = |k: u16| f32::from(k) / 65535.0;
        let bytes: Vec<_> = (0..=255).map(|k| [byte(k), byte(3), 0.0, 1.0]).collect();
        assert_eq!(color_steps(&bytes), Some(255));
        let words: Vec<_> = (0..=65535).map(|k| [word(k), 0.0, 1.0, 1.0]).collect();
        assert_eq!(color_steps(&words), Some(65535));
        assert_eq!(color_steps(&[[0.1, 0.0, 0.0, 1.0]]), None);
        assert_eq!(colors(&color_columns(&bytes)), bytes);
    }

    #[test]
    fn scales_are_recognized() {
        let column = |name: &str, numbers| Column {
            name: name.into(),
            numbers,
            is_typed: true,
        };
        let shades = |names: [&str; 3], numbers: Numbers| {
            let all = names.map(|name| column(name, numbers.clone()));
            colors(&all)
        };
        let names = ["diffuse_red", "diffuse_green", "diffuse_blue"];
        assert_eq!(shades(names, Numbers::U8(vec![51])), [[0.2, 0.2, 0.2, 1.0]]);
        let floats = Numbers::F32(vec![51.0, 0.0]);
        assert_eq!(shades(["r", "g", "b"], floats)[0], [0.2, 0.2, 0.2, 1.0]);
        let unit = Numbers::F32(vec![0.5]);
        assert_eq!(shades(["r", "g", "b"], unit)[0], [0.5, 0.5, 0.5, 1.0]);
        assert!(shades(["r", "g", "b"], Numbers::F32(vec![f32::NAN])).is_empty());
        assert!(shades(["r", "g", "b"], Numbers::I32(vec![5])).is_empty());
        assert!(shades(["r", "g", "c"], Numbers::U8(vec![5])).is_empty());
    }

    #[test]
    fn attributes_of_stl_files_are_colours() {
        let columns = [Column {
            name: "attribute".into(),
            numbers: Numbers::U16(vec![0x8000 | 31, 31, 31 << 10, 0x8000]),
            is_typed: true,
        }];
        let colors = |header: &[u8]| {
            let mut all = [b' '; 80];
            all[..header.len()].copy_from_slice(header);
            StlColors::of(&columns, Some(&all)).expect("colours").all()
        };
        let [red, blue, black] = [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0; 3]].map(Some);
        assert_eq!(colors(b"some program"), [blue, None, None, black]);
        let orange = Some([1.0, 128.0 / 255.0, 0.0]);
        let magics = b"COLOR=\xff\x80\x00\xff,MATERIAL=";
        assert_eq!(colors(magics), [orange, red, blue, orange]);
        assert!(StlColors::of(&columns, None).is_none());
        let plain = [Column {
            numbers: Numbers::U16(vec![1, 2]),
            ..columns[0].clone()
        }];
        assert!(StlColors::of(&plain, Some(&[b' '; 80])).is_none());
    }

    #[test]
    fn light_and_signal_are_inverse() {
        for k in 0..=255 {
            let signal = f64::from(k) / 255.0;
            assert!((to_signal(to_light(signal)) - signal).abs() < 1e-14);
        }
        assert!((to_light(0.5) - 0.214_041_14).abs() < 1e-8);
    }
}
