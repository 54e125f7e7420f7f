//! Ignored statements of an OBJ file: notes for the load report.

use super::super::error::excerpt;

/// Counts collected while a file is read.
#[derive(Default)]
pub(super) struct IgnoredStatements {
    pub lines: bool,
    /// Vertices with a weight other than 1.
    pub weighted: usize,
    /// Line and first word of the first unknown statement.
    pub first_unknown: Option<(usize, String)>,
    unknown: usize,
    /// Whether the last line has no line end.
    pub cut: bool,
}

impl IgnoredStatements {
    pub fn new(bytes: &[u8]) -> Self {
        Self {
            cut: bytes.last().is_some_and(|&b| b != b'\n'),
            ..Self::default()
        }
    }

    pub fn unknown(&mut self, line: usize, word: &[u8]) {
        self.unknown += 1;
        self.first_unknown
            .get_or_insert_with(|| (line, excerpt(word)));
    }

    /// Writes the notes; `last_line` is the number of the last line.
    pub fn write(&self, notes: &mut Vec<String>, last_line: usize) {
        if self.lines {
            notes.push("not kept: lines and points".to_owned());
        }
        if self.weighted > 0 {
            notes.push(format!(
                "{} vertices have a weight w other than 1, which is ignored",
                self.weighted
            ));
        }
        if let Some((line, word)) = &self.first_unknown {
            let count = self.unknown;
            notes.push(format!(
                "{count} unknown statements ignored, first '{word}' on line {line}"
            ));
        }
        if self.cut {
            notes.push(format!(
                "the last line has no line end: line {last_line} may be incomplete if the file was \
                 cut off"
            ));
        }
    }
}
