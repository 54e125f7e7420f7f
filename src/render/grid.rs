//! The scale of a view: the length of its scale bar, and a grid with cells of that length on the ground
//! below the model.

use super::{Bounds, Camera, LineStyle, Overlay, Polyline};
use crate::mesh::DVec3;

/// Maximum number of cells from the middle of the grid to each side.
const MAX_CELLS: f64 = 40.0;
/// Reach of the grid beyond the pivot, in radii of the model.
const REACH: f64 = 2.0;
/// Distance of the ground below the model, in its radii, so that flat undersides do not touch it.
const BELOW: f64 = 2e-3;
const COLOR: [f32; 4] = [0.50, 0.53, 0.57, 0.55];
const WIDTH: f32 = 0.8;
/// Length of the scale bar at a scale of 1, at most, in pixels and relative to the width of the view.
const BAR: [f64; 2] = [120.0, 0.3];

/// Length of the scale bar of a view of `size` pixels, and of the cells of the grid: a round number of
/// units of the file. Lengths on the screen are multiplied by `scale`. `None` in a view without size.
pub fn bar_length(camera: &Camera, [width, height]: [f64; 2], scale: f64) -> Option<f64> {
    let pixel = 2.0 * camera.half_height() / height.max(1.0);
    let most = pixel * (BAR[0] * scale).min(BAR[1] * width);
    (most.is_finite() && most > 0.0 && height >= scale).then(|| round_length(most))
}

/// The largest of 1, 2 and 5 times a power of ten that is not above a length.
fn round_length(most: f64) -> f64 {
    let power = 10f64.powf(most.log10().floor());
    let steps = [5.0, 2.0, 1.0];
    let step = steps.into_iter().find(|s| s * power <= most);
    step.unwrap_or(1.0) * power
}

/// A square grid whose lines are at multiples of the step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    /// Length of a cell in units of the file.
    step: f64,
    /// The middle, at a corner of a cell.
    middle: DVec3,
    /// Number of cells to each side.
    cells: i32,
    /// Directions of the lines.
    axes: [DVec3; 2],
}

impl Grid {
    /// The grid below a model, with cells of a given length. `None` for numbers that are not finite.
    pub fn new(bounds: &Bounds, camera: &Camera, step: f64) -> Option<Self> {
        let radius = bounds.radius();
        let up = camera.vertical();
        let axes = [DVec3::X, DVec3::Y + DVec3::Z - up];
        let snapped = |axis: DVec3| (camera.pivot.dot(axis) / step).round() * step * axis;
        let ground = bounds.low.dot(up) - BELOW * radius;
        let grid = Self {
            step,
            middle: snapped(axes[0]) + snapped(axes[1]) + ground * up,
            cells: (REACH * radius / step).ceil().clamp(1.0, MAX_CELLS) as i32,
            axes,
        };
        grid.middle.is_finite().then_some(grid)
    }

    /// Half the length of its lines.
    fn reach(&self) -> f64 {
        f64::from(self.cells) * self.step
    }

    /// The box around the grid and another one.
    pub fn around(&self, bounds: Bounds) -> Bounds {
        let reach = self.reach() * (self.axes[0] + self.axes[1]);
        let (low, high) = (self.middle - reach, self.middle + reach);
        Bounds::new(bounds.low.min(low), bounds.high.max(high))
    }

    /// Its lines relative to a centre.
    pub fn overlay(&self, centre: DVec3) -> Overlay {
        let lines = (-self.cells..=self.cells).flat_map(|i| {
            let shift = f64::from(i) * self.step;
            [[0, 1], [1, 0]].map(|[along, across]| {
                let at = self.middle + shift * self.axes[across];
                let half = self.reach() * self.axes[along];
                Polyline {
                    points: [at - half, at + half]
                        .map(|p| (p - centre).to_array().map(|x| x as f32))
                        .into(),
                    closed: false,
                    color: COLOR,
                    width_px: WIDTH,
                    style: LineStyle::Thin,
                }
            })
        });
        Overlay::new(lines.collect(), Vec::new())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_have_the_length_of_the_scale_bar_and_lie_below_the_model() {
        let bounds = Bounds::new(DVec3::splat(-1.0), DVec3::ONE);
        let mut camera = Camera::fit(&bounds);
        for z_up in [false, true] {
            camera.z_up = z_up;
            camera.pivot = DVec3::new(0.37, -0.1, 0.81);
            let step = bar_length(&camera, [1280.0, 800.0], 1.0).expect("a length");
            let grid = Grid::new(&bounds, &camera, step).expect("a grid");
            let up = camera.vertical();
            let overlay = grid.overlay(DVec3::ZERO);
            assert_eq!(overlay.lines.len(), 2 * (2 * grid.cells as usize + 1));
            for p in overlay.lines.iter().flat_map(|l| &l.points) {
                let p = DVec3::from_array(p.map(f64::from));
                assert!(p.dot(up) < -1.0 && p.dot(up) > -1.1, "{p}");
                for axis in grid.axes {
                    let cells = p.dot(axis) / step;
                    assert!((cells - cells.round()).abs() < 1e-4, "{p}");
                }
            }
            // at any zoom the number of lines is limited
            let grid = Grid::new(&bounds, &camera, 1e-3 * step);
            assert_eq!(grid.expect("a grid").cells, MAX_CELLS as i32);
        }
        assert_eq!(bar_length(&camera, [0.0, 0.0], 1.0), None);
    }

    #[test]
    fn round_lengths_are_the_largest_below_the_limit() {
        for (most, length) in [
            (1.0, 1.0),
            (0.99, 0.5),
            (7.3, 5.0),
            (4.9, 2.0),
            (1999.0, 1000.0),
            (0.0031, 0.002),
        ] {
            assert!(
                (round_length(most) - length).abs() < 1e-12 * length,
                "{most}"
            );
        }
    }
}
