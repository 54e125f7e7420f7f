//! Colours for numbers: the map, the range it spans, and the ticks of its legend.

use super::scene::{Scene, Vertex, ViewMode};

/// Part of the values left out at either end of a robust range.
const OUTLIERS: f64 = 0.02;
/// Values looked at, at most; evenly chosen from more.
const SAMPLES: usize = 100_000;

/// Number of colours of the map, evenly spaced in value.
pub const STOPS: usize = 9;

/// The map, linear sRGB in between: blue to white to red with the lightness of CIELAB falling evenly
/// by 12.5 a stop from the middle to either end, so that equal steps look equal, also to people who
/// do not tell red from green.
pub const MAP: [[f32; 3]; STOPS] = [
    [0.031, 0.251, 0.506],
    [0.129, 0.400, 0.675],
    [0.365, 0.565, 0.780],
    [0.655, 0.753, 0.871],
    [0.949, 0.949, 0.949],
    [0.933, 0.686, 0.596],
    [0.827, 0.459, 0.380],
    [0.698, 0.212, 0.231],
    [0.486, 0.020, 0.125],
];

/// The colour at `t`, 0 at the lower and 1 at the upper end of the range, sRGB.
pub fn colormap(t: f32) -> [f32; 3] {
    let at = t.clamp(0.0, 1.0) * (STOPS - 1) as f32;
    let i = (at as usize).min(STOPS - 2);
    let s = at - i as f32;
    [0, 1, 2].map(|k| MAP[i][k] + s * (MAP[i + 1][k] - MAP[i][k]))
}

/// A range for the colours that a few wild values do not spoil: from −m to m, with m the 98th
/// percentile of the magnitude. The surfaces with a patch decide, if there is one.
pub fn robust_range(scene: &Scene, mode: ViewMode) -> [f32; 2] {
    let patched = |v: &[Vertex]| v.iter().any(|v| v.flags & Vertex::PATCH != 0);
    let any_patch = scene.surfaces.iter().any(|s| patched(&s.vertices));
    let chosen = || {
        let counts = |v: &&Vec<Vertex>| !any_patch || patched(v);
        scene.surfaces.iter().map(|s| &s.vertices).filter(counts)
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
    let place = ((sizes.len() - 1) as f64 * (1.0 - OUTLIERS)) as usize;
    let (_, &mut m, _) = sizes.select_nth_unstable_by(place, f32::total_cmp);
    if m > 0.0 { [-m, m] } else { [-1.0, 1.0] }
}

/// Three to nine round numbers within a range, ascending, for a legend.
pub fn legend_ticks(range: [f32; 2]) -> Vec<f32> {
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
        .filter(|&s| s <= raw * 1.0001)
        .next_back()
        .unwrap_or(power);
    let slack = 1e-6 * step;
    let first = ((low - slack) / step).ceil();
    (0..16)
        .map(|i| (first + f64::from(i)) * step)
        .take_while(|&x| x <= high + slack)
        .map(|x| x as f32)
        .collect()
}
