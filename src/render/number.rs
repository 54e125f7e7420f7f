//! Numbers in words.

/// A number with four digits.
pub fn format_number(x: f64) -> String {
    with_digits(x, 3)
}

/// A number with three digits, at most seven characters if it is positive.
pub fn short_number(x: f64) -> String {
    with_digits(x, 2)
}

/// A number with four digits, or with as many as a narrow field has room for: six characters besides the
/// sign.
pub fn field_number(x: f64) -> String {
    let room = 6 + usize::from(x < 0.0);
    let mut texts = (0..=3).rev().map(|more| with_digits(x, more));
    let fitting = texts.find(|text| text.len() <= room);
    fitting.unwrap_or_else(|| with_digits(x, 0))
}

/// A number with six digits, for values that are compared, such as energies.
pub fn long_number(x: f64) -> String {
    with_digits(x, 5)
}

/// A count whose digits are in groups of three if there are more than four, as in `3,343,872`.
pub fn grouped(count: usize) -> String {
    let digits = count.to_string();
    if digits.len() < 5 {
        return digits;
    }
    let mut text = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// A number with some digits after the first one.
fn with_digits(x: f64, more: i32) -> String {
    let size = x.abs();
    if x == 0.0 {
        "0".into()
    } else if (1e-3..1e5).contains(&size) {
        let digits = (more - size.log10().floor() as i32).max(0) as usize;
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
    use super::{field_number, format_number, grouped, long_number, short_number, trimmed};

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
    fn counts_and_energies_are_legible() {
        for (count, text) in [
            (0, "0"),
            (1125, "1125"),
            (16_990, "16,990"),
            (343_872, "343,872"),
            (3_343_872, "3,343,872"),
        ] {
            assert_eq!(grouped(count), text);
        }
        for (x, text) in [
            (3_500.695_501, "3500.70"),
            (91.221_99, "91.2220"),
            (0.061_534_4, "0.0615344"),
            (-0.001_234_567, "-0.00123457"),
        ] {
            assert_eq!(long_number(x), text);
        }
    }

    #[test]
    fn round_numbers_have_no_trailing_zeros() {
        for (x, text) in [(0.0, "0"), (0.5, "0.5"), (20.0, "20"), (-1e-5, "-1e-5")] {
            assert_eq!(trimmed(x), text);
        }
    }

    #[test]
    fn numbers_of_a_field_have_six_characters_and_a_sign() {
        for (x, text) in [
            (0.0, "0"),
            (1.0, "1.000"),
            (0.01, "0.0100"),
            (-0.012_345, "-0.0123"),
            (1.2345e-7, "1.2e-7"),
            (123_456.0, "1.23e5"),
        ] {
            assert_eq!(field_number(x), text);
        }
        for k in -1200..1200 {
            let x = -1.2345 * 1.8f64.powi(k);
            assert!(field_number(x).len() <= 7, "{x}");
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
