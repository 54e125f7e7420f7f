//! Texture coordinates and normals, and the corners that refer to them.

use std::sync::Arc;

use crate::mesh::{Column, NO_VALUE, Soup};

/// A list of values and the references of the corners read so far.
struct List {
    names: [&'static str; 3],
    /// The numbers of the values, one list for each name.
    numbers: [Vec<f64>; 3],
    /// The most numbers that a value has.
    width: usize,
    /// The value of each corner; empty until a corner has one.
    of_corner: Vec<u32>,
    /// Values and corners that there is room for, once there is one.
    room: [usize; 2],
}

impl List {
    fn new(names: [&'static str; 3], room: [usize; 2]) -> Self {
        Self {
            names,
            room,
            numbers: Default::default(),
            width: 0,
            of_corner: Vec::new(),
        }
    }

    #[inline]
    fn corner(&mut self, before: usize, reference: Option<i64>) {
        let Some(index) = reference else {
            if !self.of_corner.is_empty() {
                self.of_corner.push(NO_VALUE);
            }
            return;
        };
        if self.of_corner.len() != before || before == 0 {
            // filled up here, because a list that is empty before the first corner stays so until then
            self.of_corner.reserve(self.room[1].saturating_sub(before));
            self.of_corner.resize(before, NO_VALUE);
        }
        let value = match usize::try_from(index) {
            // 0 wraps to an index that does not exist
            Ok(index) => index.wrapping_sub(1),
            Err(_) => self.numbers[0]
                .len()
                .wrapping_sub(index.unsigned_abs() as usize),
        };
        // what does not fit does not exist
        self.of_corner.push(u32::try_from(value).unwrap_or(MISSING));
    }

    /// The columns and the references of corners. References to values that do not exist are removed
    /// and counted.
    fn settle(self) -> (Vec<Column>, Vec<u32>, usize) {
        let mut of_corner = self.of_corner;
        let count = self.numbers[0].len() as u32;
        let mut missing = 0;
        for value in &mut of_corner {
            if *value >= count && *value != NO_VALUE {
                *value = NO_VALUE;
                missing += 1;
            }
        }
        if count == 0 {
            return (Vec::new(), Vec::new(), missing);
        }
        let named = self.names.into_iter().zip(self.numbers).take(self.width);
        let columns = named.map(|(name, numbers)| Column::decimals(name, numbers));
        (columns.collect(), of_corner, missing)
    }
}

/// A reference to a value that does not exist.
const MISSING: u32 = NO_VALUE - 1;

/// The values of corners of a file that is being read.
pub(super) struct Corners {
    lists: [List; 2],
}

impl Corners {
    /// No values, and room for those of a file in which `room` values and corners are typical.
    pub fn new(room: [usize; 2]) -> Self {
        let names = [["u", "v", "w"], ["nx", "ny", "nz"]];
        Self {
            lists: names.map(|names| List::new(names, room)),
        }
    }

    /// Adds a texture coordinate or a normal of `count` numbers; the others are 0.
    #[inline]
    pub fn value(&mut self, is_normal: bool, numbers: [f64; 3], count: usize) {
        let list = &mut self.lists[usize::from(is_normal)];
        if count > list.width {
            // earlier values had fewer numbers
            let before = list.numbers[0].len();
            for column in &mut list.numbers[list.width..count] {
                column.reserve(list.room[0]);
                column.resize(before, 0.0);
            }
            list.width = count;
        }
        for (column, number) in list.numbers[..list.width].iter_mut().zip(numbers) {
            column.push(number);
        }
    }

    /// Adds the references of a corner that follows `before` others, as they are in the file.
    #[inline]
    pub fn corner(&mut self, before: usize, references: [Option<i64>; 2]) {
        for (list, reference) in self.lists.iter_mut().zip(references) {
            list.corner(before, reference);
        }
    }

    /// Moves everything into `soup`.
    pub fn settle(self, soup: &mut Soup) {
        let [texture, normals] = self.lists.map(List::settle);
        let all = &mut soup.attributes;
        let mut note = |what: &str, missing: usize| {
            if missing > 0 {
                soup.notes.push(format!(
                    "{missing} corners refer to {what} that the file does not have"
                ));
            }
        };
        note("texture coordinates", texture.2);
        note("normals", normals.2);
        (all.texture, all.faces.texture) = (Arc::new(texture.0), texture.1);
        (all.normals, all.faces.normals) = (Arc::new(normals.0), normals.1);
    }
}
