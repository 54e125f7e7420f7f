//! Converts text to tokens with positions.

use super::error::SyntaxError;

/// The kind of a token.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind<'a> {
    /// A number.
    Number(f64),
    /// A name: variable, parameter or function.
    Name(&'a str),
    /// One of `+ - * / ^ ( ) ,`.
    Symbol(char),
    /// The end of the text.
    End,
}

/// A token and its byte range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Token<'a> {
    /// Its kind.
    pub kind: Kind<'a>,
    /// First byte.
    pub start: usize,
    /// One past its last byte.
    pub end: usize,
}

impl Token<'_> {
    /// Its name in error messages.
    pub fn describe(&self) -> String {
        match self.kind {
            Kind::Number(x) => format!("the number {x}"),
            Kind::Name(name) => format!("'{name}'"),
            Kind::Symbol(c) => format!("'{c}'"),
            Kind::End => "the end".to_owned(),
        }
    }
}

/// Splits `text` into tokens; the last one is [`Kind::End`].
pub fn tokens(text: &str) -> Result<Vec<Token<'_>>, SyntaxError> {
    let mut out = Vec::new();
    let mut at = 0;
    while let Some(c) = text[at..].chars().next() {
        let end = at + c.len_utf8();
        if c.is_whitespace() {
            at = end;
            continue;
        }
        let (kind, end) = match c {
            '0'..='9' | '.' => number(text, at)?,
            _ if c.is_alphabetic() || c == '_' => {
                let rest = &text[at..];
                let length = rest
                    .find(|c: char| !(c.is_alphabetic() || c.is_ascii_digit() || c == '_'))
                    .unwrap_or(rest.len());
                (Kind::Name(&rest[..length]), at + length)
            }
            '*' if text[end..].starts_with('*') => {
                let message = "expected a single operator; powers are written ^, e.g. H^2";
                return Err(SyntaxError::new(text, at, end + 1, message));
            }
            '+' | '-' | '*' | '/' | '^' | '(' | ')' | ',' => (Kind::Symbol(c), end),
            _ => return Err(SyntaxError::new(text, at, end, unexpected(c))),
        };
        out.push(Token {
            kind,
            start: at,
            end,
        });
        at = end;
    }
    out.push(Token {
        kind: Kind::End,
        start: at,
        end: at,
    });
    Ok(out)
}

/// The number that starts at byte `at`: `2`, `2.`, `.5`, `1e-3`.
fn number(text: &str, at: usize) -> Result<(Kind<'_>, usize), SyntaxError> {
    let bytes = text.as_bytes();
    let digits = |mut i: usize| {
        while bytes.get(i).is_some_and(u8::is_ascii_digit) {
            i += 1;
        }
        i
    };
    let mut end = digits(at);
    let mut mantissa = end - at;
    if bytes.get(end) == Some(&b'.') {
        let fraction = digits(end + 1);
        mantissa += fraction - end - 1;
        end = fraction;
    }
    if mantissa == 0 {
        let message = "expected digits before or after the decimal point, e.g. 0.5";
        return Err(SyntaxError::new(text, at, end, message));
    }
    if matches!(bytes.get(end), Some(b'e' | b'E')) {
        let sign = usize::from(matches!(bytes.get(end + 1), Some(b'+' | b'-')));
        let exponent = digits(end + 1 + sign);
        if exponent > end + 1 + sign {
            end = exponent;
        } else if !bytes.get(end + 1).is_some_and(u8::is_ascii_alphabetic) {
            let message = "expected digits after the exponent mark, e.g. 1e-3";
            return Err(SyntaxError::new(text, end, end + 1 + sign, message));
        }
    }
    match text[at..end].parse::<f64>() {
        Ok(x) if x.is_finite() => Ok((Kind::Number(x), end)),
        _ => Err(SyntaxError::new(
            text,
            at,
            end,
            "expected a number below 1.8e308",
        )),
    }
}

fn unexpected(c: char) -> String {
    let hint = match c {
        '²' | '³' | '⁴' | '⁵' | '⁶' | '⁷' | '⁸' | '⁹' | '⁰' | '¹' | '⁻' => {
            "powers are written ^, e.g. H^2"
        }
        '₁' | '₂' => "the principal curvatures are written k1 and k2",
        '−' | '–' | '—' => "the minus sign is the ASCII hyphen -",
        '·' | '×' | '∙' | '⋅' => "a product is written *",
        '÷' => "a quotient is written /",
        '√' => "the square root is written sqrt(...)",
        '|' => "the absolute value is written abs(...)",
        '[' | ']' | '{' | '}' => "only round parentheses group",
        ';' => "arguments are separated by a comma, decimals written with a point",
        '=' => "give the right-hand side only, e.g. H^2",
        _ => "expected a number, H, K, k1, k2, a parameter, a function or an operator",
    };
    format!("unexpected character '{}': {hint}", c.escape_debug())
}
