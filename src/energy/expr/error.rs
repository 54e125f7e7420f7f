//! Errors of typed energies, with the position of the error.

/// Why a typed energy is invalid.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ExprError {
    /// The text does not follow the grammar or names something unknown.
    #[error("energy: {0}")]
    Syntax(SyntaxError),
    /// `f(κ1, κ2) ≠ f(κ2, κ1)`.
    #[error(
        "energy: '{text}' is not symmetric in k1 and k2: f(k1={k1}, k2={k2}) = {f}, but \
         f(k1={k2}, k2={k1}) = {f_swapped}. The principal curvatures have no smooth labelling on a \
         surface, so only symmetric expressions have a flow; write it with H and K, or treat k1 \
         and k2 alike"
    )]
    NotSymmetric {
        /// The expression.
        text: String,
        /// κ1 of the counterexample.
        k1: f64,
        /// κ2 of the counterexample.
        k2: f64,
        /// `f(κ1, κ2)`.
        f: f64,
        /// `f(κ2, κ1)`.
        f_swapped: f64,
    },
    /// No sample gave a finite value.
    #[error(
        "energy: '{text}' has no finite value at any curvature tried (|k| from 1e-4 to 1e4, all \
         signs); look for a division by zero, or a sqrt or log of something negative"
    )]
    NowhereFinite {
        /// The expression.
        text: String,
    },
    /// An invalid parameter.
    #[error("energy: parameter '{name}' = {value}: {reason}")]
    Parameter {
        /// The parameter's name.
        name: String,
        /// The value given.
        value: f64,
        /// What is wrong and how to correct it.
        reason: String,
    },
}

impl ExprError {
    /// The message; for an error with a position also the text with a caret under it.
    pub fn render(&self) -> String {
        match self {
            Self::Syntax(error) => error.render(),
            _ => self.to_string(),
        }
    }

    /// The position of the error in the text, if it has one.
    pub fn syntax(&self) -> Option<&SyntaxError> {
        match self {
            Self::Syntax(error) => Some(error),
            _ => None,
        }
    }
}

impl From<SyntaxError> for ExprError {
    fn from(error: SyntaxError) -> Self {
        Self::Syntax(error)
    }
}

/// An error at one position of the text.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("at character {}: {message}", character + 1)]
pub struct SyntaxError {
    /// The whole text.
    pub text: String,
    /// Byte offset of the position (the text's length when something is missing at its end).
    pub byte: usize,
    /// Offset of the position in characters, from 0 (messages count from 1).
    pub character: usize,
    /// Number of characters of the erroneous part, at least 1.
    pub length: usize,
    /// What is wrong and what was expected.
    pub message: String,
    /// A name without a meaning yet; it is valid as a parameter with a value.
    pub unknown: Option<String>,
}

impl SyntaxError {
    /// An error at `text[start..end]` (byte offsets on character boundaries).
    pub(super) fn new(text: &str, start: usize, end: usize, message: impl Into<String>) -> Self {
        let count =
            |range: std::ops::Range<usize>| text.get(range).map_or(0, |part| part.chars().count());
        Self {
            text: text.to_owned(),
            byte: start,
            character: count(0..start),
            length: count(start..end.max(start)).max(1),
            message: message.into(),
            unknown: None,
        }
    }

    /// Three lines: the text around the error, carets under it, the message.
    pub fn render(&self) -> String {
        const BEFORE: usize = 50;
        const AFTER: usize = 30;
        // One column a character: control characters would move the caret away.
        let chars: Vec<char> = self
            .text
            .chars()
            .map(|c| if c.is_control() { ' ' } else { c })
            .collect();
        let from = self.character.saturating_sub(BEFORE);
        let to = (self.character + AFTER).min(chars.len());
        let shown: String = chars[from.min(to)..to].iter().collect();
        let (head, tail) = (
            if from > 0 { "..." } else { "" },
            if to < chars.len() { "..." } else { "" },
        );
        let indent = " ".repeat(head.len() + self.character - from);
        let carets = "^".repeat(self.length.min(AFTER));
        format!("  {head}{shown}{tail}\n  {indent}{carets}\n{self}")
    }
}
