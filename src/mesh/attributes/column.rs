//! Named columns of numbers, such as the colours and qualities of vertices.

use serde::{Deserialize, Serialize};

/// The type of the numbers of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)] // named like the types of the language
pub enum NumberType {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl NumberType {
    /// Size of a number in bytes.
    pub fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    /// The name of the type in PLY files.
    pub fn ply_name(self) -> &'static str {
        match self {
            Self::I8 => "char",
            Self::U8 => "uchar",
            Self::I16 => "short",
            Self::U16 => "ushort",
            Self::I32 => "int",
            Self::U32 => "uint",
            Self::F32 => "float",
            Self::F64 => "double",
        }
    }

    /// Whether the numbers are whole.
    pub fn is_integer(self) -> bool {
        !matches!(self, Self::F32 | Self::F64)
    }
}

/// Numbers of one type.
#[derive(Clone, Debug, PartialEq)]
#[allow(missing_docs)] // named like the types of the language
pub enum Numbers {
    I8(Vec<i8>),
    U8(Vec<u8>),
    I16(Vec<i16>),
    U16(Vec<u16>),
    I32(Vec<i32>),
    U32(Vec<u32>),
    F32(Vec<f32>),
    F64(Vec<f64>),
}

/// Evaluates an expression for the list of numbers, of whatever type.
macro_rules! of_any_type {
    ($numbers:expr, $list:ident => $value:expr) => {
        match $numbers {
            Numbers::I8($list) => $value,
            Numbers::U8($list) => $value,
            Numbers::I16($list) => $value,
            Numbers::U16($list) => $value,
            Numbers::I32($list) => $value,
            Numbers::U32($list) => $value,
            Numbers::F32($list) => $value,
            Numbers::F64($list) => $value,
        }
    };
}

impl Numbers {
    /// An empty list of this type with room for `count` numbers.
    pub fn with_capacity(kind: NumberType, count: usize) -> Self {
        match kind {
            NumberType::I8 => Self::I8(Vec::with_capacity(count)),
            NumberType::U8 => Self::U8(Vec::with_capacity(count)),
            NumberType::I16 => Self::I16(Vec::with_capacity(count)),
            NumberType::U16 => Self::U16(Vec::with_capacity(count)),
            NumberType::I32 => Self::I32(Vec::with_capacity(count)),
            NumberType::U32 => Self::U32(Vec::with_capacity(count)),
            NumberType::F32 => Self::F32(Vec::with_capacity(count)),
            NumberType::F64 => Self::F64(Vec::with_capacity(count)),
        }
    }

    /// Their type.
    pub fn kind(&self) -> NumberType {
        match self {
            Self::I8(_) => NumberType::I8,
            Self::U8(_) => NumberType::U8,
            Self::I16(_) => NumberType::I16,
            Self::U16(_) => NumberType::U16,
            Self::I32(_) => NumberType::I32,
            Self::U32(_) => NumberType::U32,
            Self::F32(_) => NumberType::F32,
            Self::F64(_) => NumberType::F64,
        }
    }

    /// Their count.
    pub fn len(&self) -> usize {
        of_any_type!(self, list => list.len())
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The number at an index; exact.
    #[inline]
    #[allow(clippy::useless_conversion)] // of one of the types
    pub fn get(&self, index: usize) -> f64 {
        of_any_type!(self, list => list[index].into())
    }

    /// Appends a number, cast to the type: rounded to single precision, or cut to a whole number in
    /// the range of the type.
    #[inline]
    pub fn push(&mut self, number: f64) {
        of_any_type!(self, list => list.push(number as _));
    }

    /// Replaces a number; cast as by [`Self::push`].
    pub fn set(&mut self, index: usize, number: f64) {
        of_any_type!(self, list => list[index] = number as _);
    }

    /// Appends the number at an index once more.
    pub fn repeat(&mut self, index: usize) {
        of_any_type!(self, list => list.push(list[index]));
    }

    /// Appends zeros up to this count.
    pub fn pad(&mut self, count: usize) {
        of_any_type!(self, list => list.resize(count, Default::default()));
    }

    /// The numbers at these indices.
    #[must_use]
    pub fn picked(&self, indices: &[u32]) -> Self {
        macro_rules! picked {
            ($kind:ident, $list:expr) => {
                Self::$kind(indices.iter().map(|&i| $list[i as usize]).collect())
            };
        }
        match self {
            Self::I8(list) => picked!(I8, list),
            Self::U8(list) => picked!(U8, list),
            Self::I16(list) => picked!(I16, list),
            Self::U16(list) => picked!(U16, list),
            Self::I32(list) => picked!(I32, list),
            Self::U32(list) => picked!(U32, list),
            Self::F32(list) => picked!(F32, list),
            Self::F64(list) => picked!(F64, list),
        }
    }

    /// Whether the numbers at two indices have the same bits.
    pub fn are_same(&self, a: usize, b: usize) -> bool {
        match self {
            Self::F32(list) => list[a].to_bits() == list[b].to_bits(),
            Self::F64(list) => list[a].to_bits() == list[b].to_bits(),
            _ => self.get(a) == self.get(b),
        }
    }

    /// Appends the little-endian bytes of a number.
    #[inline]
    pub fn push_bytes(&self, index: usize, bytes: &mut Vec<u8>) {
        of_any_type!(self, list => bytes.extend_from_slice(&list[index].to_le_bytes()));
    }

    /// Size in bytes.
    pub fn bytes(&self) -> usize {
        self.len() * self.kind().size()
    }
}

/// A number for each vertex, each face or each value that corners refer to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Column {
    /// The name in the file, such as `quality`.
    pub name: String,
    /// The numbers.
    pub numbers: Numbers,
    /// Whether the file declares the type. A text format without types has `F64`.
    pub is_typed: bool,
}

impl Column {
    /// A column of decimals without a declared type.
    pub fn decimals(name: &str, numbers: Vec<f64>) -> Self {
        Self {
            name: name.to_owned(),
            numbers: Numbers::F64(numbers),
            is_typed: false,
        }
    }
}

/// The rows at these indices.
pub fn picked_rows(columns: &[Column], rows: &[u32]) -> Vec<Column> {
    let picked = |column: &Column| Column {
        name: column.name.clone(),
        numbers: column.numbers.picked(rows),
        is_typed: column.is_typed,
    };
    columns.iter().map(picked).collect()
}

/// Number of rows of columns, which all have as many; 0 without columns.
pub fn row_count(columns: &[Column]) -> usize {
    columns.first().map_or(0, |column| column.numbers.len())
}

/// The columns with these names.
pub fn columns_named<const N: usize>(columns: &[Column], names: [&str; N]) -> Option<[usize; N]> {
    let mut found = [0; N];
    for (slot, name) in found.iter_mut().zip(names) {
        *slot = columns.iter().position(|column| column.name == name)?;
    }
    Some(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_type_and_bits() {
        let kinds = [
            NumberType::I8,
            NumberType::U8,
            NumberType::I16,
            NumberType::U16,
            NumberType::I32,
            NumberType::U32,
            NumberType::F32,
            NumberType::F64,
        ];
        for kind in kinds {
            let mut numbers = Numbers::with_capacity(kind, 2);
            assert!(numbers.is_empty());
            for x in [3.0, 0.1, 7.0] {
                numbers.push(x);
            }
            numbers.repeat(0);
            numbers.pad(5);
            assert_eq!(numbers.kind(), kind);
            assert_eq!(numbers.bytes(), 5 * kind.size());
            assert_eq!(numbers.get(1) == 0.0, kind.is_integer());
            let picked = numbers.picked(&[2, 3, 4]);
            assert_eq!([0, 1, 2].map(|i| picked.get(i)), [7.0, 3.0, 0.0]);
            assert!(numbers.are_same(0, 3) && !numbers.are_same(0, 2));
            let mut bytes = Vec::new();
            numbers.push_bytes(2, &mut bytes);
            assert_eq!(bytes.len(), kind.size());
        }
        let zeros = Numbers::F64(vec![0.0, -0.0, f64::NAN, f64::NAN]);
        assert!(!zeros.are_same(0, 1) && zeros.are_same(2, 3));
    }
}
