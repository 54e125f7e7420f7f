//! Rows of numbers, from text or from bytes in either byte order.

use super::super::error::{ParseError, ParseErrorKind, Place, excerpt};
use super::super::text_scanner::Scanner;
use crate::mesh::NumberType;

/// A function that describes a row or number for a message.
pub(super) type What<'a> = &'a dyn Fn() -> String;

/// A source of rows of numbers.
pub(super) trait Source {
    /// Moves to the start of a row.
    fn begin_row(&mut self, what: What<'_>) -> Result<(), ParseError>;
    /// The next number of the row.
    fn number(&mut self, scalar: NumberType, what: What<'_>) -> Result<f64, ParseError>;
    /// The next number of the row, of an integer type.
    fn integer(&mut self, scalar: NumberType, what: What<'_>) -> Result<i64, ParseError>;
    /// Ends the row. What it has beyond the properties is skipped and counted.
    fn end_row(&mut self);
    /// Number of remaining bytes.
    fn remaining(&self) -> usize;
    /// The place of the last number, for messages.
    fn place(&self) -> Place;
    /// Whether anything except blanks remains.
    fn has_rest(&mut self) -> bool;
    /// Rows with more values than properties so far, and the line of the first.
    fn longer_rows(&self) -> Option<(usize, usize)>;
}

/// Numbers in text, one row per line.
pub(super) struct Text<'a> {
    scanner: Scanner<'a>,
    total: usize,
    longer_rows: Option<(usize, usize)>,
}

impl<'a> Text<'a> {
    pub fn new(bytes: &'a [u8], start: usize, line: usize) -> Self {
        Self {
            scanner: Scanner::new(bytes, start, line),
            total: bytes.len(),
            longer_rows: None,
        }
    }

    fn skip_empty_lines(&mut self) {
        self.scanner.skip_blanks();
        while self.scanner.line_over() && !self.scanner.at_end() {
            self.scanner.next_line();
            self.scanner.skip_blanks();
        }
    }

    fn found(&self) -> String {
        excerpt(self.scanner.token_at(self.scanner.at()))
    }
}

impl Source for Text<'_> {
    fn begin_row(&mut self, what: What<'_>) -> Result<(), ParseError> {
        self.skip_empty_lines();
        if self.scanner.at_end() {
            let kind = ParseErrorKind::truncated(format!("it ends before {}", what()));
            return Err(self.place().error(kind));
        }
        Ok(())
    }

    fn number(&mut self, _: NumberType, what: What<'_>) -> Result<f64, ParseError> {
        self.scanner.skip_blanks();
        if self.scanner.line_over() {
            let kind = ParseErrorKind::truncated(format!("{} has too few numbers", what()));
            return Err(self.place().error(kind));
        }
        self.scanner.float().ok_or_else(|| {
            let what = format!("a value of {}", what());
            self.place().error(ParseErrorKind::NotANumber {
                what,
                found: self.found(),
            })
        })
    }

    fn integer(&mut self, scalar: NumberType, what: What<'_>) -> Result<i64, ParseError> {
        let value = self.number(scalar, what)?;
        if value == value.trunc() {
            return Ok(value as i64);
        }
        let kind = ParseErrorKind::syntax(
            format!("{} needs a whole number", what()),
            value.to_string(),
        );
        Err(self.place().error(kind))
    }

    fn end_row(&mut self) {
        self.scanner.skip_blanks();
        if !self.scanner.line_over() {
            let line = self.scanner.line();
            self.longer_rows.get_or_insert((0, line)).0 += 1;
        }
        self.scanner.next_line();
    }

    fn remaining(&self) -> usize {
        self.total - self.scanner.at()
    }

    fn place(&self) -> Place {
        Place::Line(self.scanner.line())
    }

    fn has_rest(&mut self) -> bool {
        self.skip_empty_lines();
        !self.scanner.at_end()
    }

    fn longer_rows(&self) -> Option<(usize, usize)> {
        self.longer_rows
    }
}

/// Numbers in binary, one row after the other.
pub(super) struct Binary<'a, const BIG: bool> {
    bytes: &'a [u8],
    at: usize,
    last: usize,
}

impl<'a, const BIG: bool> Binary<'a, BIG> {
    pub fn new(bytes: &'a [u8], start: usize) -> Self {
        Self {
            bytes,
            at: start,
            last: start,
        }
    }

    #[inline]
    fn take<const N: usize>(&mut self, what: What<'_>) -> Result<[u8; N], ParseError> {
        let Some(raw) = self.bytes[self.at..].first_chunk::<N>() else {
            let kind = ParseErrorKind::truncated(format!("it ends in {}", what()));
            return Err(Place::Byte(self.bytes.len()).error(kind));
        };
        self.last = self.at;
        self.at += N;
        let mut raw = *raw;
        if BIG {
            raw.reverse();
        }
        Ok(raw)
    }
}

impl<const BIG: bool> Source for Binary<'_, BIG> {
    #[inline]
    fn begin_row(&mut self, _: What<'_>) -> Result<(), ParseError> {
        Ok(())
    }

    #[inline]
    fn number(&mut self, scalar: NumberType, what: What<'_>) -> Result<f64, ParseError> {
        Ok(match scalar {
            NumberType::I8 => f64::from(i8::from_le_bytes(self.take(what)?)),
            NumberType::U8 => f64::from(u8::from_le_bytes(self.take(what)?)),
            NumberType::I16 => f64::from(i16::from_le_bytes(self.take(what)?)),
            NumberType::U16 => f64::from(u16::from_le_bytes(self.take(what)?)),
            NumberType::I32 => f64::from(i32::from_le_bytes(self.take(what)?)),
            NumberType::U32 => f64::from(u32::from_le_bytes(self.take(what)?)),
            NumberType::F32 => f64::from(f32::from_le_bytes(self.take(what)?)),
            NumberType::F64 => f64::from_le_bytes(self.take(what)?),
        })
    }

    #[inline]
    fn integer(&mut self, scalar: NumberType, what: What<'_>) -> Result<i64, ParseError> {
        // Exact: the integer types have 32 bits at most.
        self.number(scalar, what).map(|value| value as i64)
    }

    #[inline]
    fn end_row(&mut self) {}

    fn remaining(&self) -> usize {
        self.bytes.len() - self.at
    }

    fn place(&self) -> Place {
        Place::Byte(self.last)
    }

    fn has_rest(&mut self) -> bool {
        self.at < self.bytes.len()
    }

    fn longer_rows(&self) -> Option<(usize, usize)> {
        None
    }
}
