//! Colours in whole steps of an integer type.

/// The largest value of the integer type, 255 or 65535, in whose steps all colours are exact; `None`
/// if there is none. Channels are the quotients of these values in single precision.
pub fn color_steps(colors: &[[f32; 4]]) -> Option<u16> {
    let is_exact = |steps: u16| {
        let mut channels = colors.iter().flatten();
        channels.all(|&c| (0.0..=1.0).contains(&c) && rounded(c, steps) == c)
    };
    [u8::MAX.into(), u16::MAX]
        .into_iter()
        .find(|&s| is_exact(s))
}

/// A colour in the steps of [`color_steps`], as new vertices get it beside given ones.
pub fn round_color(color: [f32; 4], steps: Option<u16>) -> [f32; 4] {
    steps.map_or(color, |steps| color.map(|c| rounded(c, steps)))
}

fn rounded(channel: f32, steps: u16) -> f32 {
    let steps = f32::from(steps);
    (channel * steps).round() / steps
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colors_stay_in_their_type() {
        let byte = |k: u8| f32::from(k) / 255.0;
        let word = |k: u16| f32::from(k) / 65535.0;
        let of = |k: u8| [byte(k), byte(3), 0.0, 1.0];
        let bytes: Vec<_> = (0..=255).map(of).collect();
        assert_eq!(color_steps(&bytes), Some(255));
        let words: Vec<_> = (0..=65535).map(|k| [word(k), 0.0, 1.0, 1.0]).collect();
        assert_eq!(color_steps(&words), Some(65535));
        assert_eq!(color_steps(&[[0.1, 0.0, 0.0, 1.0]]), None);
        let mixed = [0.5 * (byte(10) + byte(11)), 0.2, 0.0, 1.0];
        assert_eq!(color_steps(&[round_color(mixed, Some(255))]), Some(255));
        assert_eq!(round_color(mixed, None), mixed);
    }
}
