//! Numbers as text: the shortest decimals that parse to the same bits.

use std::io::Write;

use crate::mesh::Numbers;

/// Appends `x` with the fewest digits that parse to the same `f64`. Very large and very small
/// magnitudes have an exponent instead of many zeros.
pub(super) fn push_f64(text: &mut Vec<u8>, x: f64) {
    let size = x.abs();
    let written = if size == 0.0 || (1e-5..1e16).contains(&size) {
        write!(text, "{x}")
    } else {
        write!(text, "{x:e}")
    };
    written.expect("writing to a Vec does not fail");
}

/// As [`push_f64`], for `f32`.
pub(super) fn push_f32(text: &mut Vec<u8>, x: f32) {
    write!(text, "{x}").expect("writing to a Vec does not fail");
}

/// Appends a number of a column with the fewest digits that parse to the same bits of its type.
pub(super) fn push_number(text: &mut Vec<u8>, numbers: &Numbers, row: usize) {
    match numbers {
        Numbers::F32(list) => push_f32(text, list[row]),
        _ => push_f64(text, numbers.get(row)),
    }
}

/// Appends a whole number.
#[inline]
pub(super) fn push_index(text: &mut Vec<u8>, mut n: u64) {
    let mut digits = [0_u8; 20];
    let mut at = digits.len();
    loop {
        at -= 1;
        digits[at] = b'0' + (n % 10) as u8;
        n /= 10;
        if n == 0 {
            break;
        }
    }
    text.extend_from_slice(&digits[at..]);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(x: f64) -> String {
        let mut out = Vec::new();
        push_f64(&mut out, x);
        String::from_utf8(out).expect("ascii")
    }

    #[test]
    fn shortest_and_exact() {
        assert_eq!(text(0.1), "0.1");
        assert_eq!(text(-0.0), "-0");
        assert_eq!(text(1e300), "1e300");
        assert_eq!(text(-2.5e-7), "-2.5e-7");
        for x in [
            5e-324,
            f64::MIN_POSITIVE,
            f64::MAX,
            1e16,
            123_456_789.123_456_78,
            1.0 / 3.0,
        ] {
            assert_eq!(text(x).parse::<f64>().map(f64::to_bits), Ok(x.to_bits()));
        }
    }

    #[test]
    fn whole_numbers() {
        let mut out = Vec::new();
        for n in [0, 7, 10, 4_294_967_296, u64::MAX] {
            push_index(&mut out, n);
            out.push(b' ');
        }
        assert_eq!(out, b"0 7 10 4294967296 18446744073709551615 ");
    }
}
