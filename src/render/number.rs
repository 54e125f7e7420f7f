//! Numbers in words.

/// A number with four digits.
pub fn format_number(x: f64) -> String {
    with_digits(x, 3)
}

/// A number with three digits, at most seven characters if it is positive.
pub fn short_number(x: f64) -> String {
    with_digits(x, 2)
}

/// A number with some digits after the first one.
fn with_digits(x: f64, more: i32) -> String {
    let size = x.abs();
    if x == 0.0 {
        "0".into()
    } else if (1e-3..1e5).contains(&size) {
        let digits = (more - size.log10().floor() as i32).clamp(0, 6) as usize;
        format!("{x:.digits$}")
    } else {
        format!("{x:.more$e}", more = more as usize)
    }
}

/// A round number without trailing zeros.
pub fn trimmed(x: f64) -> String {
    let text = format_number(x);
    let (digits, exponent) = text.split_at(text.find('e').unwrap_or(text.len()));
    if digits.contains('.') {
        let digits = digits.trim_end_matches('0').trim_end_matches('.');
        format!("{digits}{exponent}")
    } else {
        text
    }
}

#[cfg(test)]
mod tests {
    use super::{format_number, short_number, trimmed};

    #[test]
    fn short_numbers_have_seven_characters_at_most() {
        for (x, text) in [
            (0.0, "0"),
            (0.009_758, "0.00976"),
            (0.000_999_6, "1.00e-3"),
            (43.903, "43.9"),
            (99_999.0, "99999"),
            (1.2345e8, "1.23e8"),
        ] {
            assert_eq!(short_number(x), text);
        }
        for k in -120..300 {
            let x = 1.2345 * 1.1f64.powi(k);
            assert!(short_number(x).len() <= 7, "{x}");
        }
    }

    #[test]
    fn round_numbers_have_no_trailing_zeros() {
        for (x, text) in [(0.0, "0"), (0.5, "0.5"), (20.0, "20"), (-1e-5, "-1e-5")] {
            assert_eq!(trimmed(x), text);
        }
    }

    #[test]
    fn numbers_in_four_digits() {
        for (x, text) in [
            (0.0, "0"),
            (1.0, "1.000"),
            (12.345_67, "12.35"),
            (-0.012_345, "-0.01235"),
            (12_345.6, "12346"),
            (1.5e-7, "1.500e-7"),
            (2.5e9, "2.500e9"),
        ] {
            assert_eq!(format_number(x), text);
        }
    }
}
