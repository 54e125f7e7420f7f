//! Rows of numbers, from text or from bytes of either order.

use super::super::error::{Fault, Place, Problem, excerpt};
use super::super::scan::Scanner;
use super::header::Scalar;

/// Where the next number comes from.
pub(super) trait Source {
    /// Goes to the start of a row; `what` names it for the message if there is none.
    fn begin_row(&mut self, what: &dyn Fn() -> String) -> Result<(), Fault>;
    /// The next number of the row.
    fn number(&mut self, scalar: Scalar, what: &dyn Fn() -> String) -> Result<f64, Fault>;
    /// Leaves the row.
    fn end_row(&mut self, what: &dyn Fn() -> String) -> Result<(), Fault>;
    /// Bytes not read yet.
    fn remaining(&self) -> usize;
    /// Where the number read last stands, for messages.
    fn place(&self) -> Place;
    /// Whether something but blanks is left.
    fn has_rest(&mut self) -> bool;
}

/// Numbers in text, one row a line.
pub(super) struct Text<'a> {
    scanner: Scanner<'a>,
    total: usize,
}

impl<'a> Text<'a> {
    pub fn new(bytes: &'a [u8], start: usize, line: usize) -> Self {
        Self {
            scanner: Scanner::new(bytes, start, line),
            total: bytes.len(),
        }
    }

    fn skip_empty_lines(&mut self) {
        self.scanner.skip_blanks();
        while self.scanner.line_over() && !self.scanner.at_end() {
            self.scanner.next_line();
            self.scanner.skip_blanks();
        }
    }
}

impl Source for Text<'_> {
    fn begin_row(&mut self, what: &dyn Fn() -> String) -> Result<(), Fault> {
        self.skip_empty_lines();
        if self.scanner.at_end() {
            let what = format!("it ends before {}", what());
            return Err(Fault {
                place: self.place(),
                problem: Problem::Truncated { what },
            });
        }
        Ok(())
    }

    fn number(&mut self, scalar: Scalar, what: &dyn Fn() -> String) -> Result<f64, Fault> {
        self.scanner.skip_blanks();
        let place = self.place();
        if self.scanner.line_over() {
            let what = format!("{} has too few numbers on its line", what());
            return Err(Fault {
                place,
                problem: Problem::Truncated { what },
            });
        }
        match self.scanner.float() {
            Some(value) if !scalar.is_integer() || value == value.trunc() => Ok(value),
            Some(value) => {
                let what = format!("{} needs a whole number", what());
                let found = value.to_string();
                Err(Fault {
                    place,
                    problem: Problem::Syntax { what, found },
                })
            }
            None => {
                let found = excerpt(self.scanner.peek_token());
                let what = format!("a value of {}", what());
                Err(Fault {
                    place,
                    problem: Problem::NotANumber { what, found },
                })
            }
        }
    }

    fn end_row(&mut self, what: &dyn Fn() -> String) -> Result<(), Fault> {
        self.scanner.skip_blanks();
        if !self.scanner.line_over() {
            let what = format!("{} has more on its line than the header says", what());
            let found = excerpt(self.scanner.peek_token());
            return Err(Fault {
                place: self.place(),
                problem: Problem::Syntax { what, found },
            });
        }
        self.scanner.next_line();
        Ok(())
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
    fn take<const N: usize>(&mut self) -> Option<[u8; N]> {
        let mut raw: [u8; N] = self.bytes.get(self.at..self.at + N)?.try_into().ok()?;
        self.last = self.at;
        self.at += N;
        if BIG {
            raw.reverse();
        }
        Some(raw)
    }
}

impl<const BIG: bool> Source for Binary<'_, BIG> {
    #[inline]
    fn begin_row(&mut self, _: &dyn Fn() -> String) -> Result<(), Fault> {
        Ok(())
    }

    #[inline]
    fn number(&mut self, scalar: Scalar, what: &dyn Fn() -> String) -> Result<f64, Fault> {
        let value = match scalar {
            Scalar::I8 => self.take().map(|b| f64::from(i8::from_le_bytes(b))),
            Scalar::U8 => self.take().map(|b| f64::from(u8::from_le_bytes(b))),
            Scalar::I16 => self.take().map(|b| f64::from(i16::from_le_bytes(b))),
            Scalar::U16 => self.take().map(|b| f64::from(u16::from_le_bytes(b))),
            Scalar::I32 => self.take().map(|b| f64::from(i32::from_le_bytes(b))),
            Scalar::U32 => self.take().map(|b| f64::from(u32::from_le_bytes(b))),
            Scalar::F32 => self.take().map(|b| f64::from(f32::from_le_bytes(b))),
            Scalar::F64 => self.take().map(f64::from_le_bytes),
        };
        value.ok_or_else(|| {
            let what = format!("it ends in {}", what());
            Fault {
                place: Place::Byte(self.bytes.len()),
                problem: Problem::Truncated { what },
            }
        })
    }

    #[inline]
    fn end_row(&mut self, _: &dyn Fn() -> String) -> Result<(), Fault> {
        Ok(())
    }

    fn remaining(&self) -> usize {
        self.bytes.len() - self.at
    }

    fn place(&self) -> Place {
        Place::Byte(self.last)
    }

    fn has_rest(&mut self) -> bool {
        self.at < self.bytes.len()
    }
}
