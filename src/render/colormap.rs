//! The colour map, its range, and the ticks of its legend.

use std::sync::Arc;

use super::number::{format_number, trimmed};
use super::scene::{Geometry, ViewMode};

/// Percentage of the values inside a robust range.
const HELD: usize = 98;
/// Maximum number of sampled values. Larger sets are sampled evenly.
const SAMPLES: usize = 20_000;

/// Number of colours of the map, evenly spaced in value.
pub const STOPS: usize = 9;

/// The map, linear in sRGB between the stops: blue, white, red. The CIELAB lightness decreases by
/// 17 per stop, from 95 in the middle to 27 at both ends, so that equal steps look equal, also to
/// users who cannot distinguish red and green.
pub const MAP: [[f32; 3]; STOPS] = [
    [0.030, 0.246, 0.497],
    [0.135, 0.415, 0.699],
    [0.383, 0.592, 0.816],
    [0.666, 0.766, 0.886],
    [0.943, 0.943, 0.943],
    [0.950, 0.699, 0.607],
    [0.851, 0.473, 0.392],
    [0.733, 0.224, 0.244],
    [0.515, 0.023, 0.135],
];

/// The colour at `t`, 0 at the lower and 1 at the upper end of the range, sRGB.
#[expect(clippy::cast_sign_loss, reason = "clamped to 0..=1 before")]
pub fn colormap(t: f32) -> [f32; 3] {
    let at = t.clamp(0.0, 1.0) * (STOPS - 1) as f32;
    let i = (at as usize).min(STOPS - 2);
    let s = at - i as f32;
    [0, 1, 2].map(|k| MAP[i][k] + s * (MAP[i + 1][k] - MAP[i][k]))
}

/// A range that is robust against outliers: from −m to m, where m is the 98th percentile of the
/// magnitude. Only surfaces with a patch count, if there are any.
pub fn robust_range(surfaces: &[Arc<Geometry>], mode: ViewMode) -> [f32; 2] {
    let any_patch = surfaces.iter().any(|s| s.has_patch());
    let chosen = || {
        let counts = |s: &&Arc<Geometry>| !any_patch || s.has_patch();
        surfaces.iter().filter(counts).map(|s| &s.vertices)
    };
    let total: usize = chosen().map(Vec::len).sum();
    let stride = total.div_ceil(SAMPLES).max(1);
    let mut sizes: Vec<f32> = chosen()
        .flat_map(|v| v.iter().step_by(stride))
        .filter_map(|v| mode.value(v))
        .map(f32::abs)
        .filter(|x| x.is_finite())
        .collect();
    if sizes.is_empty() {
        return [-1.0, 1.0];
    }
    let place = (sizes.len() - 1) * HELD / 100;
    let (_, &mut m, _) = sizes.select_nth_unstable_by(place, f32::total_cmp);
    if m > 0.0 { [-m, m] } else { [-1.0, 1.0] }
}

/// The labels of a legend: the place of each from 0 at the lower end of the range to 1, and its number.
/// These are both ends, and round numbers that are at least `apart` from them.
pub fn legend_labels(range: [f32; 2], apart: f32) -> Vec<(f32, String)> {
    let [low, high] = range;
    let ends = [(0.0, low), (1.0, high)];
    let ends = ends.map(|(place, x)| (place, format_number(f64::from(x))));
    let place = |x: f32| (x - low) / (high - low);
    let between = legend_ticks(range)
        .into_iter()
        .filter(|&tick| (apart..=1.0 - apart).contains(&place(tick)));
    let between = between.map(|tick| (place(tick), trimmed(f64::from(tick))));
    ends.into_iter().chain(between).collect()
}

/// Three to nine round numbers inside a range in ascending order, for a legend.
fn legend_ticks(range: [f32; 2]) -> Vec<f32> {
    let [low, high] = range.map(f64::from);
    let width = high - low;
    if !(width.is_finite() && width > 0.0) {
        return vec![range[0]];
    }
    let raw = width / 4.0;
    let power = 10f64.powf(raw.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0]
        .map(|m| m * power)
        .into_iter()
        .rfind(|&s| s <= raw * 1.0001)
        .unwrap_or(power);
    let slack = 1e-6 * step;
    let first = ((low - slack) / step).ceil();
    (0..16)
        .map(|i| (first + f64::from(i)) * step)
        .take_while(|&x| x <= high + slack)
        .map(|x| x as f32)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::Vertex;

    /// CIELAB lightness of an sRGB colour.
    fn lightness([r, g, b]: [f32; 3]) -> f32 {
        let linear = |c: f32| {
            if c <= 0.04045 {
                c / 12.92
            } else {
                ((c + 0.055) / 1.055).powf(2.4)
            }
        };
        let y = 0.2126 * linear(r) + 0.7152 * linear(g) + 0.0722 * linear(b);
        116.0 * y.cbrt() - 16.0
    }

    #[test]
    fn lightness_falls_evenly_to_both_ends() {
        let middle = lightness(colormap(0.5));
        for i in 0..=20 {
            let t = i as f32 / 20.0;
            let expected = middle - (t - 0.5).abs() * 2.0 * (middle - 27.0);
            let found = lightness(colormap(t));
            assert!((found - expected).abs() < 0.5, "{t}: {found} {expected}");
        }
    }

    #[test]
    fn values_outside_have_the_colours_of_the_ends() {
        assert_eq!(colormap(-3.0), MAP[0]);
        assert_eq!(colormap(7.0), colormap(1.0));
        assert_eq!(colormap(0.5), MAP[STOPS / 2]);
    }

    fn surfaces(parts: &[(u32, &[f32])]) -> Vec<Arc<Geometry>> {
        let part = |&(flags, values): &(u32, &[f32])| {
            let vertex = |&mean: &f32| Vertex {
                mean,
                flags,
                ..Vertex::default()
            };
            let vertices = values.iter().map(vertex).collect();
            Arc::new(Geometry::new(vertices, Vec::new(), Vec::new()))
        };
        parts.iter().map(part).collect()
    }

    #[test]
    fn ranges_are_symmetric_robust_and_those_of_the_patch() {
        let known = Vertex::CURVATURE;
        let mut values: Vec<f32> = (0..100).map(|i| -0.01 * i as f32).collect();
        values[5] = 1e9;
        values[6] = f32::NAN;
        let one = surfaces(&[(known, &values)]);
        let [low, high] = robust_range(&one, ViewMode::Mean);
        assert_eq!(low, -high);
        assert!((0.95..1.0).contains(&high), "{high}");
        let both = surfaces(&[(known, &values), (known | Vertex::PATCH, &[0.25, -0.25])]);
        assert_eq!(robust_range(&both, ViewMode::Mean), [-0.25, 0.25]);
        let unknown = surfaces(&[(0, &values)]);
        assert_eq!(robust_range(&unknown, ViewMode::Mean), [-1.0, 1.0]);
        assert_eq!(robust_range(&one, ViewMode::Shaded), [-1.0, 1.0]);
    }

    #[test]
    fn legends_have_both_ends_and_round_numbers_that_leave_them_room() {
        let labels = legend_labels([-0.37, 0.31], 0.12);
        let words: Vec<&str> = labels.iter().map(|(_, words)| words.as_str()).collect();
        assert_eq!(
            words,
            ["-0.3700", "0.3100", "-0.2", "-0.1", "0", "0.1", "0.2"]
        );
        let places: Vec<f32> = labels.iter().map(|(place, _)| *place).collect();
        assert_eq!(places[..2], [0.0, 1.0]);
        assert!((places[4] - 0.37 / 0.68).abs() < 1e-6);
    }

    #[test]
    fn ticks_are_round_and_within() {
        for (range, expected) in [
            ([-1.0, 1.0], &[-1.0, -0.5, 0.0, 0.5, 1.0][..]),
            ([-0.37, 0.37], &[-0.3, -0.2, -0.1, 0.0, 0.1, 0.2, 0.3][..]),
            ([0.0, 5e6], &[0.0, 1e6, 2e6, 3e6, 4e6, 5e6][..]),
            ([3.0, 3.0], &[3.0][..]),
        ] {
            let ticks = legend_ticks(range);
            assert_eq!(ticks.len(), expected.len(), "{range:?}: {ticks:?}");
            for (t, e) in ticks.iter().zip(expected) {
                assert!((t - e).abs() <= 1e-6 * e.abs().max(1e-3), "{ticks:?}");
            }
        }
        for width in [1e-9f32, 0.7, 3.3, 9.99, 1e12] {
            let ticks = legend_ticks([-width, 2.0 * width]);
            assert!((3..=13).contains(&ticks.len()), "{width}: {ticks:?}");
        }
    }
}
