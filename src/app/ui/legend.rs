//! The legend of a colour map, and the range it shows.

use eframe::egui::{self, Align2, Color32, FontId, Pos2, Rect, Ui};

use super::theme;
use crate::app::cached::Cached;
use crate::app::model::Model;
use crate::render::{ViewMode, colormap, legend_labels, robust_range};

/// The range of a colour map.
pub(crate) type MapRange = Cached<RangeKey, [f32; 2]>;

/// The key of the range of a colour map: the mode and the serial numbers of the surfaces.
#[derive(Clone, PartialEq)]
pub(crate) struct RangeKey {
    mode: ViewMode,
    surfaces: Vec<u64>,
}

/// The common range of all sides of a comparison.
pub(crate) fn shared_range(model: &Model, mode: ViewMode, known: &mut MapRange) -> [f32; 2] {
    let sides = model.sides();
    let shown = model.displays[..sides].iter().filter_map(|d| d.latest());
    let surfaces: Vec<_> = shown.flat_map(|d| d.surfaces.iter().cloned()).collect();
    let key = RangeKey {
        mode,
        surfaces: surfaces.iter().map(|s| s.id).collect(),
    };
    known.get(key, || robust_range(&surfaces, mode))
}

/// Width of the legend with its margin, at the right end of a view.
pub(crate) const WIDTH: f32 = 116.0;
/// Room above the colours of the legend, for its title, and below them.
const ABOVE: f32 = 30.0;
const BELOW: f32 = 12.0;

/// The place of the legend at the right end of a view, above what is at the bottom of the view. `None`
/// in a view that is too low for it.
pub(crate) fn legend_place(view: Rect, below: Option<Rect>) -> Option<Rect> {
    let column = view.right() - WIDTH;
    let floor = below
        .filter(|below| below.right() > column)
        .map_or(view.bottom() - 28.0, |below| below.top() - 8.0);
    let room = floor - view.top() - ABOVE - BELOW - 4.0;
    let height = (view.height() * 0.4).clamp(80.0, 260.0).min(room);
    (height >= 40.0).then(|| {
        Rect::from_min_max(
            Pos2::new(column + 2.0, floor - BELOW - height - ABOVE),
            Pos2::new(view.right() - 8.0, floor),
        )
    })
}

/// Colours, ticks and name of a map at its [place](legend_place).
pub(crate) fn legend(ui: &Ui, place: Rect, mode: ViewMode, range: [f32; 2]) {
    let left = place.left() + 10.0;
    let bar = Rect::from_min_max(
        Pos2::new(left, place.top() + ABOVE),
        Pos2::new(left + 16.0, place.bottom() - BELOW),
    );
    let painter = ui.painter();
    painter.rect_filled(place, 6.0, theme::ground(ui));
    let font = FontId::proportional(13.0);
    let ink = ui.visuals().strong_text_color();
    painter.text(
        Pos2::new(bar.left(), bar.top() - 8.0),
        Align2::LEFT_BOTTOM,
        mode.legend_title(),
        font.clone(),
        ink,
    );
    let mut mesh = egui::Mesh::default();
    let steps = 48;
    for i in 0..=steps {
        let t = i as f32 / steps as f32;
        let [r, g, b] = colormap(t).map(|c| (c * 255.0).round() as u8);
        let y = bar.bottom() - t * bar.height();
        let color = Color32::from_rgb(r, g, b);
        mesh.colored_vertex(Pos2::new(bar.left(), y), color);
        mesh.colored_vertex(Pos2::new(bar.right(), y), color);
        if i > 0 {
            let k = 2 * i;
            mesh.add_triangle(k - 2, k - 1, k);
            mesh.add_triangle(k - 1, k + 1, k);
        }
    }
    painter.add(mesh);
    for (place, words) in legend_labels(range, 15.0 / bar.height()) {
        let y = bar.bottom() - place * bar.height();
        painter.hline(
            bar.right()..=bar.right() + 4.0,
            y,
            egui::Stroke::new(1.0, ink),
        );
        painter.text(
            Pos2::new(bar.right() + 7.0, y),
            Align2::LEFT_CENTER,
            words,
            font.clone(),
            ink,
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The legend leaves the buttons at the bottom of a narrow view free, and is not drawn beyond a low one.
    #[test]
    fn the_legend_has_room_of_its_own() {
        let buttons = Rect::from_min_max(Pos2::new(33.0, 340.0), Pos2::new(165.0, 386.0));
        for height in [60.0, 130.0, 200.0, 400.0, 1000.0] {
            let view =
                Rect::from_min_size(Pos2::new(0.0, 400.0 - height), egui::vec2(198.0, height));
            for below in [None, Some(buttons)] {
                let place = legend_place(view, below);
                assert!(place.is_none_or(|place| view.contains_rect(place)));
                assert!(place.is_none_or(|place| below.is_none_or(|b| !b.intersects(place))));
                assert_eq!(
                    place.is_some(),
                    height > if below.is_some() { 150.0 } else { 114.0 }
                );
            }
        }
        // beside buttons in a wide view it stays where it is
        let view = Rect::from_min_size(Pos2::ZERO, egui::vec2(900.0, 400.0));
        assert_eq!(legend_place(view, Some(buttons)), legend_place(view, None));
    }
}
