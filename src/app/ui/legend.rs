//! The legend of a colour map, and the range it shows.

use eframe::egui::{self, Align2, Color32, FontId, Pos2, Rect, Ui};

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

/// Colours, ticks and name of a map.
pub(crate) fn legend(ui: &Ui, rect: Rect, mode: ViewMode, range: [f32; 2]) {
    let height = (rect.height() * 0.4).clamp(80.0, 260.0);
    let bar = Rect::from_min_size(
        Pos2::new(rect.right() - 104.0, rect.bottom() - height - 40.0),
        egui::vec2(16.0, height),
    );
    let ground = ui.visuals().extreme_bg_color.gamma_multiply(0.72);
    let around = Rect::from_min_max(
        bar.min - egui::vec2(10.0, 30.0),
        Pos2::new(rect.right() - 8.0, bar.max.y + 12.0),
    );
    let painter = ui.painter();
    painter.rect_filled(around, 6.0, ground);
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
