//! The legend of a colour map, and the range it shows.

use eframe::egui::{self, Align2, Color32, FontId, Pos2, Rect, Ui};

use super::side::short;
use crate::app::model::Model;
use crate::render::{Scene, ViewMode, colormap, legend_ticks, robust_range};

/// The range of a map, and what it was found for: the mode and the numbers of the surfaces.
pub type KnownRange = Option<(ViewMode, Vec<u64>, [f32; 2])>;

/// One range for both sides of a comparison, found anew only for other surfaces or another mode.
pub fn shared_range(
    model: &Model,
    scene: &Scene,
    mode: ViewMode,
    known: &mut KnownRange,
) -> [f32; 2] {
    let sides = model.run.as_ref().map_or(1, |r| r.sides.len());
    let shown = model.displays[..sides].iter().filter_map(|d| d.latest());
    let surfaces: Vec<_> = shown.flat_map(|d| d.surfaces.iter().cloned()).collect();
    let numbers: Vec<u64> = surfaces.iter().map(|s| s.id).collect();
    if let Some((for_mode, for_numbers, range)) = known
        && *for_mode == mode
        && *for_numbers == numbers
    {
        return *range;
    }
    let all = Scene {
        surfaces,
        ..scene.clone()
    };
    let range = robust_range(&all, mode);
    *known = Some((mode, numbers, range));
    range
}

/// Colours, ticks and name of a map.
pub fn legend(ui: &Ui, rect: Rect, mode: ViewMode, range: [f32; 2]) {
    let height = (rect.height() * 0.4).clamp(80.0, 260.0);
    let bar = Rect::from_min_size(
        Pos2::new(rect.right() - 92.0, rect.bottom() - height - 40.0),
        egui::vec2(16.0, height),
    );
    let ground = ui.visuals().extreme_bg_color.gamma_multiply(0.72);
    let around = Rect::from_min_max(
        bar.min - egui::vec2(10.0, 30.0),
        Pos2::new(rect.right() - 8.0, bar.max.y + 12.0),
    );
    let painter = ui.painter();
    painter.rect_filled(around, 6.0, ground);
    let (name, _) = super::toolbar::mode_words(mode);
    let font = FontId::proportional(13.0);
    let ink = ui.visuals().strong_text_color();
    painter.text(
        Pos2::new(bar.left(), bar.top() - 8.0),
        Align2::LEFT_BOTTOM,
        name,
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
    for tick in legend_ticks(range) {
        let t = (tick - range[0]) / (range[1] - range[0]);
        let y = bar.bottom() - t * bar.height();
        painter.hline(
            bar.right()..=bar.right() + 4.0,
            y,
            egui::Stroke::new(1.0, ink),
        );
        let words = if tick == 0.0 {
            "0".into()
        } else {
            trimmed(f64::from(tick))
        };
        painter.text(
            Pos2::new(bar.right() + 7.0, y),
            Align2::LEFT_CENTER,
            words,
            font.clone(),
            ink,
        );
    }
}

/// A round number without the zeros at its end.
fn trimmed(x: f64) -> String {
    let text = short(x);
    if text.contains('.') && !text.contains('e') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}
