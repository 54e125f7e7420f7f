//! One pass over the bytes of a text format: blanks, tokens, numbers, line numbers.

use std::borrow::Cow;

/// The start of the text, after a UTF-8 byte order mark if there is one.
pub(super) fn without_mark(bytes: &[u8]) -> usize {
    if bytes.starts_with(b"\xef\xbb\xbf") {
        3
    } else {
        0
    }
}

/// The text with line ends of the old Macintosh (a single carriage return) replaced.
pub(super) fn unix_lines(bytes: &[u8]) -> Cow<'_, [u8]> {
    if bytes.contains(&b'\n') || !bytes.contains(&b'\r') {
        return Cow::Borrowed(bytes);
    }
    bytes
        .iter()
        .map(|&b| if b == b'\r' { b'\n' } else { b })
        .collect()
}

/// A position in a text file. It neither copies nor allocates.
#[derive(Clone)]
pub(super) struct Scanner<'a> {
    bytes: &'a [u8],
    at: usize,
    line: usize,
}

impl<'a> Scanner<'a> {
    /// Starts at byte `at` on line `line` (counted from 1).
    pub fn new(bytes: &'a [u8], at: usize, line: usize) -> Self {
        Self { bytes, at, line }
    }

    pub fn line(&self) -> usize {
        self.line
    }

    pub fn at(&self) -> usize {
        self.at
    }

    pub fn at_end(&self) -> bool {
        self.at >= self.bytes.len()
    }

    /// Skips blanks within the line; a backslash before a line end joins the lines (OBJ).
    #[inline]
    pub fn skip_blanks(&mut self) {
        while let Some(&byte) = self.bytes.get(self.at) {
            match byte {
                b' ' | b'\t' | b'\r' | 0x0b | 0x0c => self.at += 1,
                b'\\' => match &self.bytes[self.at + 1..] {
                    [b'\n', ..] => self.join(2),
                    [b'\r', b'\n', ..] => self.join(3),
                    _ => return,
                },
                _ => return,
            }
        }
    }

    fn join(&mut self, length: usize) {
        self.at += length;
        self.line += 1;
    }

    /// Whether the statement has ended: line end, file end or a comment.
    #[inline]
    pub fn statement_over(&self) -> bool {
        matches!(self.bytes.get(self.at), None | Some(b'\n' | b'#'))
    }

    /// Whether the line has ended.
    #[inline]
    pub fn line_over(&self) -> bool {
        matches!(self.bytes.get(self.at), None | Some(b'\n'))
    }

    /// Moves to the start of the next line.
    #[inline]
    pub fn next_line(&mut self) {
        match self.bytes[self.at..].iter().position(|&b| b == b'\n') {
            Some(length) => self.join(length + 1),
            None => self.at = self.bytes.len(),
        }
    }

    /// The bytes up to the next blank or line end.
    #[inline]
    pub fn token(&mut self) -> &'a [u8] {
        let start = self.at;
        self.at = token_end(self.bytes, start);
        &self.bytes[start..self.at]
    }

    /// The token at byte `at`, for messages.
    pub fn token_at(&self, at: usize) -> &'a [u8] {
        &self.bytes[at..token_end(self.bytes, at)]
    }

    /// The rest of the line as a name.
    pub fn name(&mut self) -> String {
        self.skip_blanks();
        String::from_utf8_lossy(self.rest_of_line()).into_owned()
    }

    /// The rest of the line without leading and trailing blanks. Moves to the line end.
    pub fn rest_of_line(&mut self) -> &'a [u8] {
        let rest = &self.bytes[self.at..];
        let length = rest.iter().position(|&b| b == b'\n').unwrap_or(rest.len());
        self.at += length;
        rest[..length].trim_ascii()
    }

    /// Reads a number; `None` (position unchanged) if the token is not one.
    #[inline]
    pub fn float(&mut self) -> Option<f64> {
        let (value, end) = float_at(self.bytes, self.at)?;
        self.at = end;
        Some(value)
    }

    /// Reads a signed integer that may be followed by `/...`; `None` (position unchanged) if there
    /// is none or it has more than 18 digits.
    #[inline]
    pub fn integer(&mut self) -> Option<i64> {
        let mut at = self.at;
        let sign = self.bytes.get(at);
        let negative = sign == Some(&b'-');
        at += usize::from(negative || sign == Some(&b'+'));
        let mut value = 0_i64;
        let mut digits = 0;
        for byte in self.bytes.get(at..)? {
            let digit = byte.wrapping_sub(b'0');
            if digit > 9 {
                break;
            }
            value = value.wrapping_mul(10).wrapping_add(i64::from(digit));
            digits += 1;
        }
        if digits == 0 || digits > 18 {
            return None;
        }
        self.at = at + digits;
        Some(if negative { -value } else { value })
    }

    /// Reads a corner of an OBJ face, `v`, `v/vt`, `v//vn` or `v/vt/vn`; `None` if it is none.
    #[inline]
    pub fn corner(&mut self) -> Option<(i64, [Option<i64>; 2])> {
        let vertex = self.integer()?;
        let mut values = [None; 2];
        for value in &mut values {
            if self.bytes.get(self.at) != Some(&b'/') {
                break;
            }
            self.at += 1;
            *value = self.integer();
        }
        let is_over = self.bytes.get(self.at).is_none_or(|&b| ends_token(b));
        is_over.then_some((vertex, values))
    }
}

#[inline]
fn ends_token(byte: u8) -> bool {
    byte <= b' ' || byte == b'\\'
}

#[inline]
fn token_end(bytes: &[u8], start: usize) -> usize {
    let rest = &bytes[start..];
    start
        + rest
            .iter()
            .position(|&b| ends_token(b))
            .unwrap_or(rest.len())
}

#[inline]
fn digit_at(bytes: &[u8], at: usize) -> Option<u8> {
    let digit = bytes.get(at)?.wrapping_sub(b'0');
    (digit < 10).then_some(digit)
}

/// Powers of ten that a double represents exactly.
const POWERS: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16,
    1e17, 1e18, 1e19, 1e20, 1e21, 1e22,
];

/// Reads the number at `start`, correctly rounded, and returns its end.
///
/// An integer up to 2^53 times or over a power of ten up to 10^22 needs one operation on exact
/// doubles, which is rounded once (Clinger 1990). The standard library parses all other numbers.
#[inline]
fn float_at(bytes: &[u8], start: usize) -> Option<(f64, usize)> {
    let sign = bytes.get(start);
    let negative = sign == Some(&b'-');
    let mut at = start + usize::from(negative || sign == Some(&b'+'));
    let mut mantissa = 0_u64;
    let whole = at;
    while let Some(digit) = digit_at(bytes, at) {
        mantissa = mantissa.wrapping_mul(10).wrapping_add(u64::from(digit));
        at += 1;
    }
    let mut digits = at - whole;
    let mut exponent = 0_i32;
    if bytes.get(at) == Some(&b'.') {
        at += 1;
        let fraction = at;
        while let Some(digit) = digit_at(bytes, at) {
            mantissa = mantissa.wrapping_mul(10).wrapping_add(u64::from(digit));
            at += 1;
        }
        digits += at - fraction;
        // Longer numbers have too many digits for the fast path.
        exponent = -i32::from(u8::try_from(at - fraction).unwrap_or(u8::MAX));
    }
    if matches!(bytes.get(at), Some(b'e' | b'E')) {
        let (written, end) = exponent_at(bytes, at + 1)?;
        exponent += written;
        at = end;
    }
    let over = bytes.get(at).is_none_or(|&b| ends_token(b));
    // 19 digits fit a u64, so the mantissa has not wrapped.
    if over && (1..=19).contains(&digits) && mantissa <= 1 << 53 && exponent.abs() <= 22 {
        let power = POWERS[exponent.unsigned_abs() as usize];
        let value = if exponent < 0 {
            mantissa as f64 / power
        } else {
            mantissa as f64 * power
        };
        return Some((if negative { -value } else { value }, at));
    }
    let token = &bytes[start..token_end(bytes, start)];
    // a comment may follow a digit; `1.#INF` is no number
    let comment = token
        .windows(2)
        .position(|pair| pair[0].is_ascii_digit() && pair[1] == b'#');
    let number = comment.map_or(token, |at| &token[..=at]);
    let value = str::from_utf8(number).ok()?.parse().ok()?;
    Some((value, start + number.len()))
}

fn exponent_at(bytes: &[u8], start: usize) -> Option<(i32, usize)> {
    let sign = bytes.get(start);
    let negative = sign == Some(&b'-');
    let mut at = start + usize::from(negative || sign == Some(&b'+'));
    let digits = at;
    let mut value = 0_i32;
    while let Some(digit) = digit_at(bytes, at) {
        // The exponent exceeds the fast path; the slow path reads the text again.
        value = (value * 10 + i32::from(digit)).min(100_000);
        at += 1;
    }
    (at > digits).then_some((if negative { -value } else { value }, at))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn read(text: &str) -> Option<f64> {
        Scanner::new(text.as_bytes(), 0, 1).float()
    }

    #[test]
    fn numbers_agree_with_the_standard_library() {
        for text in [
            "0",
            "-0",
            "+1",
            "1.",
            ".5",
            "-.5e1",
            "1e22",
            "1e23",
            "9007199254740993",
            "1e-22",
            "123456789012345678901234567890",
            "0.1",
            "5e-324",
            "2.2250738585072011e-308",
            "1e400",
            "1.7976931348623157e308",
            "0.000000000000000000000000000001",
            "1E5",
            "1e+5",
            "nan",
            "-inf",
            "9007199254740992e22",
            "00000000000000000000000000001.5",
        ] {
            let expected = text.parse::<f64>().ok().map(f64::to_bits);
            assert_eq!(read(text).map(f64::to_bits), expected, "{text}");
            if text.ends_with(|c: char| c.is_ascii_digit()) {
                let commented = format!("{text}#red");
                assert_eq!(read(&commented).map(f64::to_bits), expected, "{commented}");
            }
        }
        for text in [
            "", "-", ".", "e5", "1e", "1e+", "1.0x", "0x10", "1,5", "1.#QNAN", "--1", "1..2",
        ] {
            assert_eq!(read(text), None, "{text}");
        }
    }

    #[test]
    fn corners_have_up_to_three_integers() {
        let corner = |text: &str| Scanner::new(text.as_bytes(), 0, 1).corner();
        assert_eq!(corner("-12 7"), Some((-12, [None, None])));
        assert_eq!(corner("1/2"), Some((1, [Some(2), None])));
        assert_eq!(corner("1//-3\n"), Some((1, [None, Some(-3)])));
        assert_eq!(corner("1/2/3"), Some((1, [Some(2), Some(3)])));
        assert_eq!(corner("1/2/"), Some((1, [Some(2), None])));
        for text in ["-12/3//4 7", "1/2/3/4", "/2", "1/x", "1.5", ""] {
            assert_eq!(corner(text), None, "{text}");
        }
        assert_eq!(Scanner::new(b"9999999999999999999", 0, 1).integer(), None);
        assert_eq!(Scanner::new(b"-", 0, 1).integer(), None);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]
        #[test]
        fn decimals_are_rounded_correctly(m in any::<u64>(), point in 0_usize..20, e in -30_i32..30) {
            let digits = m.to_string();
            let point = point.min(digits.len());
            let text = format!("{}.{}e{e}", &digits[..point], &digits[point..]);
            prop_assert_eq!(read(&text).map(f64::to_bits), text.parse::<f64>().ok().map(f64::to_bits));
        }
    }
}
