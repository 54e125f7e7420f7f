//! Vertex colours, an extension with several dialects: `v x y z r g b`, the same with a weight
//! before or an alpha after, in 0..1 or 0..255.

use crate::mesh::Soup;

/// The number of values after the coordinates of coloured vertices.
#[derive(Clone, Copy, Default, PartialEq)]
enum Layout {
    #[default]
    None,
    Three,
    /// `w r g b` or `r g b a`, decided after all vertices are read.
    Four,
}

/// The mark of a vertex without a colour while the file is read.
const UNCOLORED: [f32; 4] = [-1.0; 4];

/// The colours of a file that is being read.
#[derive(Default)]
pub(super) struct Colors {
    layout: Layout,
    uncolored: usize,
}

impl Colors {
    /// Stores the numbers after the coordinates of the vertex that is added to `soup` next. Returns
    /// `false` if earlier vertices had a different number of them.
    pub fn vertex(&mut self, soup: &mut Soup, extra: &[f64]) -> bool {
        let layout = match extra.len() {
            3 => Layout::Three,
            4 => Layout::Four,
            _ => {
                if self.layout != Layout::None {
                    soup.colors.push(UNCOLORED);
                    self.uncolored += 1;
                }
                return true;
            }
        };
        if self.layout == Layout::None {
            self.layout = layout;
            self.uncolored = soup.positions.len();
            soup.colors.resize(self.uncolored, UNCOLORED);
        }
        let mut color = [1.0; 4];
        for (c, x) in color.iter_mut().zip(extra) {
            *c = *x as f32;
        }
        soup.colors.push(color);
        self.layout == layout
    }

    /// The accepted numbers of values on a vertex line, given the lines before.
    pub fn wanted(&self) -> &'static str {
        match self.layout {
            Layout::None => "3 (x y z), 4 with a weight, 6 or 7 with a colour",
            Layout::Three => "3, 4, or as before 6 (x y z r g b)",
            Layout::Four => "3, 4, or as before 7",
        }
    }

    /// Decides the meaning of four numbers, scales 0..255 to 0..1, and makes uncoloured vertices
    /// white.
    pub fn settle(&self, soup: &mut Soup) {
        if soup.colors.is_empty() {
            return;
        }
        let given = || soup.colors.iter().filter(|&&c| c != UNCOLORED);
        // If every first number is 1, it is the weight w, because a red channel would vary.
        let weighted = self.layout == Layout::Four && given().all(|c| c[0] == 1.0);
        let numbers = if weighted { 1..4 } else { 0..3 };
        let bytes = given().any(|c| c[numbers.clone()].iter().any(|&x| x > 1.0));
        if given().flatten().any(|c| !c.is_finite() || *c < 0.0) {
            soup.colors.clear();
            soup.notes
                .push("vertex colours are ignored because some are negative or not finite".into());
            return;
        }
        let scale = if bytes { 255.0 } else { 1.0 };
        for c in &mut soup.colors {
            if *c == UNCOLORED {
                *c = [1.0; 4];
                continue;
            }
            let alpha = if weighted { 1.0 } else { c[3] };
            let rgb = &c[numbers.clone()];
            *c = [rgb[0] / scale, rgb[1] / scale, rgb[2] / scale, alpha];
            if c[3] > 1.0 {
                c[3] /= 255.0;
            }
        }
        if bytes {
            soup.notes
                .push("vertex colours exceed 1 and are read as 0 to 255".into());
        }
        if self.uncolored > 0 {
            soup.notes.push(format!(
                "{} vertices without a colour are white",
                self.uncolored
            ));
        }
    }
}
