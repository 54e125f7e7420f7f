//! The grid on the ground below the model.

use crate::app::model::Model;
use crate::mesh::DVec3;
use crate::render::{Bounds, LineStyle, Overlay, Polyline};

/// Maximum number of cells from the middle of the grid to each side.
const MOST: f64 = 40.0;
/// Reach of the grid beyond the pivot, in radii of the model.
const REACH: f64 = 2.0;
/// Distance of the ground below the model, in its radii, so that flat undersides do not touch it.
const BELOW: f64 = 2e-3;
const COLOR: [f32; 4] = [0.50, 0.53, 0.57, 0.55];
const WIDTH: f32 = 0.8;

/// A square grid whose lines are at multiples of the step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Grid {
    /// Length of a cell in units of the file: that of the scale bar.
    step: f64,
    /// The middle, at a corner of a cell.
    middle: DVec3,
    /// Number of cells to each side.
    cells: i32,
    /// Directions of the lines.
    axes: [DVec3; 2],
}

impl Grid {
    /// The grid of the view, if it is switched on.
    pub(super) fn of(model: &Model) -> Option<Self> {
        let view = &model.view;
        let step = view.bar_length().filter(|_| model.settings.grid)?;
        let bounds = &model.document.origin.bounds;
        let radius = bounds.radius();
        let up = view.camera.vertical();
        let axes = [DVec3::X, DVec3::Y + DVec3::Z - up];
        let snapped = |axis: DVec3| (view.camera.pivot.dot(axis) / step).round() * step * axis;
        let ground = bounds.low.dot(up) - BELOW * radius;
        let grid = Self {
            step,
            middle: snapped(axes[0]) + snapped(axes[1]) + ground * up,
            cells: (REACH * radius / step).ceil().clamp(1.0, MOST) as i32,
            axes,
        };
        grid.middle.is_finite().then_some(grid)
    }

    /// Half the length of its lines.
    fn reach(&self) -> f64 {
        f64::from(self.cells) * self.step
    }

    /// The bounding box of the grid and another one.
    pub(super) fn around(&self, bounds: Bounds) -> Bounds {
        let reach = self.reach() * (self.axes[0] + self.axes[1]);
        let (low, high) = (self.middle - reach, self.middle + reach);
        Bounds::new(bounds.low.min(low), bounds.high.max(high))
    }

    /// Its lines relative to a centre.
    pub(super) fn overlay(&self, centre: DVec3) -> Overlay {
        let lines = (-self.cells..=self.cells).flat_map(|i| {
            let shift = f64::from(i) * self.step;
            [[0, 1], [1, 0]].map(|[along, across]| {
                let at = self.middle + shift * self.axes[across];
                let half = self.reach() * self.axes[along];
                Polyline {
                    points: [at - half, at + half]
                        .map(|p| super::narrow(p - centre))
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
    use crate::app::action::{Switch, ViewAction};
    use crate::app::tests::model;
    use crate::app::update::act;

    #[test]
    fn cells_have_the_length_of_the_scale_bar_and_lie_below_the_model() {
        let mut m = model();
        assert_eq!(Grid::of(&m), None);
        act(&mut m, ViewAction::Toggle(Switch::Grid));
        for z_up in [false, true] {
            m.view.camera.z_up = z_up;
            m.view.camera.pivot = DVec3::new(0.37, -0.1, 0.81);
            let grid = Grid::of(&m).expect("a grid");
            assert_eq!(Some(grid.step), m.view.bar_length());
            let up = m.view.camera.vertical();
            let overlay = grid.overlay(DVec3::ZERO);
            assert_eq!(overlay.lines.len(), 2 * (2 * grid.cells as usize + 1));
            for p in overlay.lines.iter().flat_map(|l| &l.points) {
                let p = DVec3::from_array(p.map(f64::from));
                assert!(p.dot(up) < -1.0 && p.dot(up) > -1.1, "{p}");
                for axis in grid.axes {
                    let cells = p.dot(axis) / grid.step;
                    assert!((cells - cells.round()).abs() < 1e-4, "{p}");
                }
            }
            // at any zoom the number of lines is limited
            m.view.camera.distance = 1e-3;
            assert_eq!(Grid::of(&m).expect("a grid").cells, MOST as i32);
            m.view.camera.distance = 4.0;
        }
    }
}
