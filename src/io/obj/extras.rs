//! Numbers after the coordinates of vertices: a weight, or a colour, which is an extension with several
//! dialects: `v x y z r g b`, the same with a weight before or an opacity after, in 0..1 or 0..255.

use crate::mesh::{Column, Soup};

/// The number of values after the coordinates of coloured vertices.
#[derive(Clone, Copy, Default, PartialEq)]
enum Layout {
    #[default]
    None,
    Three,
    /// `w r g b` or `r g b a`, decided after all vertices are read.
    Four,
}

/// The numbers of a file that is being read.
#[derive(Default)]
pub(super) struct Extras {
    layout: Layout,
    /// The numbers of colours; 0 for a vertex without one.
    colors: [Vec<f64>; 4],
    uncolored: Vec<u32>,
    /// The weights, if a vertex without a colour has one.
    weights: Vec<f64>,
}

impl Extras {
    /// Stores the numbers after the coordinates of vertex `vertex`. Returns `false` if earlier vertices
    /// had a different number of them.
    #[inline]
    pub fn vertex(&mut self, vertex: usize, extra: &[f64]) -> bool {
        match extra {
            [] | [_] => {
                if let [weight] = extra {
                    self.weights.resize(vertex, 1.0);
                    self.weights.push(*weight);
                }
                if self.layout != Layout::None {
                    self.color(&[0.0; 4]);
                    self.uncolored.push(vertex as u32);
                }
                true
            }
            _ => {
                let layout = if extra.len() == 3 {
                    Layout::Three
                } else {
                    Layout::Four
                };
                if self.layout == Layout::None {
                    self.layout = layout;
                    self.uncolored = (0..vertex as u32).collect();
                    for column in &mut self.colors[..extra.len()] {
                        column.resize(vertex, 0.0);
                    }
                }
                self.color(extra);
                self.layout == layout
            }
        }
    }

    fn color(&mut self, numbers: &[f64]) {
        let count = if self.layout == Layout::Four { 4 } else { 3 };
        for (column, number) in self.colors[..count].iter_mut().zip(numbers) {
            column.push(*number);
        }
    }

    /// The accepted numbers of values on a vertex line, given the lines before.
    pub fn wanted(&self) -> &'static str {
        match self.layout {
            Layout::None => "3 (x y z), 4 with a weight, 6 or 7 with a colour",
            Layout::Three => "3, 4, or as before 6 (x y z r g b)",
            Layout::Four => "3, 4, or as before 7",
        }
    }

    /// Decides the meaning of four numbers, makes vertices without a colour white, and moves everything
    /// into `soup`.
    pub fn settle(mut self, soup: &mut Soup) {
        let columns = &mut soup.attributes.vertices;
        if !self.weights.is_empty() {
            self.weights.resize(soup.positions.len(), 1.0);
            columns.push(Column::decimals("w", self.weights));
        }
        if self.layout == Layout::None {
            return;
        }
        let mut is_colored = vec![true; soup.positions.len()];
        for &vertex in &self.uncolored {
            is_colored[vertex as usize] = false;
        }
        let given = |column: &[f64], wanted: &dyn Fn(f64) -> bool| {
            let mut pairs = column.iter().zip(&is_colored);
            pairs.any(|(&x, &is)| is && wanted(x))
        };
        // if every first number is 1, it is the weight w, because a red channel would vary
        let is_four = self.layout == Layout::Four;
        let weighted = is_four && !given(&self.colors[0], &|x| x != 1.0);
        let names = match self.layout {
            Layout::Four if weighted => ["w", "red", "green", "blue"],
            _ => ["red", "green", "blue", "alpha"],
        };
        let all = self.colors.iter().take(if is_four { 4 } else { 3 });
        let channels = names.iter().zip(all);
        let above = |what: &[&str]| {
            let mut some = channels.clone().filter(|(name, _)| what.contains(name));
            some.any(|(_, column)| given(column, &|x| x > 1.0))
        };
        let in_bytes = above(&["red", "green", "blue"]);
        let full = [in_bytes, above(&["alpha"])].map(|is| if is { 255.0 } else { 1.0 });
        let mut other = channels.clone().map(|(_, column)| column);
        if other.any(|column| given(column, &|x| !(x.is_finite() && x >= 0.0))) {
            let note = "vertex colours that are negative or not finite: kept, but not shown";
            soup.notes.push(note.into());
        }
        for (name, mut numbers) in names.into_iter().zip(self.colors) {
            if numbers.is_empty() {
                continue;
            }
            let white = match name {
                "w" => 1.0,
                "alpha" => full[1],
                _ => full[0],
            };
            for &vertex in &self.uncolored {
                numbers[vertex as usize] = white;
            }
            columns.push(Column::decimals(name, numbers));
        }
        if in_bytes {
            soup.notes
                .push("vertex colours exceed 1 and are read as 0 to 255".into());
        }
        if !self.uncolored.is_empty() {
            soup.notes.push(format!(
                "{} vertices without a colour are white",
                self.uncolored.len()
            ));
        }
    }
}
