//! Fonts, colours and spacing of the window.

use std::sync::Arc;

use eframe::egui::{
    self, Color32, CornerRadius, FontData, FontDefinitions, FontFamily, FontId, Shadow, Stroke,
    Style, TextStyle, Theme, Visuals,
    style::{Selection, WidgetVisuals},
};

const REGULAR: &[u8] = include_bytes!("../../../assets/fonts/Inter-Regular.otf");
const STRONG: &[u8] = include_bytes!("../../../assets/fonts/Inter-SemiBold.otf");
/// The icon of the program.
pub(crate) const ICON: &[u8] = include_bytes!("../../../assets/meniscus.png");

/// The family of headings and primary buttons.
pub(crate) fn strong() -> FontFamily {
    FontFamily::Name("strong".into())
}

/// The colours of a theme.
struct Palette {
    panel: Color32,
    field: Color32,
    /// Background of buttons: idle, hovered, pressed.
    button: [Color32; 3],
    line: Color32,
    text: Color32,
    title: Color32,
    accent: Color32,
    selection: Color32,
    warning: Color32,
    error: Color32,
    success: Color32,
}

const DARK: Palette = Palette {
    panel: Color32::from_rgb(31, 36, 43),
    field: Color32::from_rgb(20, 24, 29),
    button: [
        Color32::from_rgb(47, 54, 63),
        Color32::from_rgb(59, 68, 79),
        Color32::from_rgb(71, 82, 95),
    ],
    line: Color32::from_rgb(54, 62, 72),
    text: Color32::from_rgb(199, 207, 217),
    title: Color32::from_rgb(240, 243, 247),
    accent: Color32::from_rgb(38, 128, 190),
    selection: Color32::from_rgb(30, 84, 122),
    warning: Color32::from_rgb(240, 172, 66),
    error: Color32::from_rgb(255, 120, 110),
    success: Color32::from_rgb(95, 190, 115),
};

const LIGHT: Palette = Palette {
    panel: Color32::from_rgb(244, 246, 248),
    field: Color32::from_rgb(255, 255, 255),
    button: [
        Color32::from_rgb(226, 231, 236),
        Color32::from_rgb(212, 219, 226),
        Color32::from_rgb(194, 203, 212),
    ],
    line: Color32::from_rgb(204, 211, 218),
    text: Color32::from_rgb(52, 61, 71),
    title: Color32::from_rgb(15, 21, 28),
    accent: Color32::from_rgb(24, 112, 176),
    selection: Color32::from_rgb(188, 221, 243),
    warning: Color32::from_rgb(158, 92, 0),
    error: Color32::from_rgb(185, 25, 25),
    success: Color32::from_rgb(25, 120, 50),
};

/// Colours of curves. Neighbours differ in lightness, for users who cannot distinguish the hues.
const SERIES_DARK: [Color32; 6] = [
    Color32::from_rgb(86, 180, 233),
    Color32::from_rgb(230, 159, 0),
    Color32::from_rgb(120, 215, 130),
    Color32::from_rgb(214, 120, 180),
    Color32::from_rgb(240, 228, 90),
    Color32::from_rgb(160, 140, 235),
];
const SERIES_LIGHT: [Color32; 6] = [
    Color32::from_rgb(0, 100, 170),
    Color32::from_rgb(200, 95, 0),
    Color32::from_rgb(0, 120, 75),
    Color32::from_rgb(165, 50, 125),
    Color32::from_rgb(120, 100, 0),
    Color32::from_rgb(95, 65, 190),
];

fn palette(dark: bool) -> &'static Palette {
    if dark { &DARK } else { &LIGHT }
}

/// Background of the primary button of a panel.
pub(crate) fn accent(ui: &egui::Ui) -> Color32 {
    palette(ui.visuals().dark_mode).accent
}

/// The colour of a curve or of a compared side, by its number.
pub(crate) fn series(ui: &egui::Ui, number: usize) -> Color32 {
    let all = if ui.visuals().dark_mode {
        &SERIES_DARK
    } else {
        &SERIES_LIGHT
    };
    all[number % all.len()]
}

/// Whether a curve is dashed, because a curve before it has the same colour.
pub(crate) fn is_dashed(number: usize) -> bool {
    (number / SERIES_DARK.len()) % 2 == 1
}

/// Colour of success, readable on the theme's background.
pub(crate) fn success(ui: &egui::Ui) -> Color32 {
    palette(ui.visuals().dark_mode).success
}

/// The ground of text over the view, on which it is legible whatever the surface.
pub(crate) fn ground(ui: &egui::Ui) -> Color32 {
    ui.visuals().extreme_bg_color.gamma_multiply(0.72)
}

/// Sets fonts, and colours and spacing of both themes.
pub(crate) fn install(ctx: &egui::Context) {
    ctx.set_fonts(fonts());
    for theme in [Theme::Dark, Theme::Light] {
        ctx.style_mut_of(theme, |style| restyle(style, theme == Theme::Dark));
    }
}

/// Inter, with the fonts of egui for other characters.
fn fonts() -> FontDefinitions {
    let mut fonts = FontDefinitions::default();
    let fallback = fonts.families.get(&FontFamily::Proportional).cloned();
    for (name, bytes, family) in [
        ("inter", REGULAR, FontFamily::Proportional),
        ("inter-strong", STRONG, strong()),
    ] {
        let data = Arc::new(FontData::from_static(bytes));
        fonts.font_data.insert(name.into(), data);
        let mut list = vec![name.to_owned()];
        list.extend(fallback.iter().flatten().cloned());
        fonts.families.insert(family, list);
    }
    fonts
}

fn restyle(style: &mut Style, dark: bool) {
    style.text_styles = [
        (TextStyle::Small, FontId::proportional(11.0)),
        (TextStyle::Body, FontId::proportional(13.0)),
        (TextStyle::Button, FontId::proportional(13.0)),
        (TextStyle::Heading, FontId::new(14.0, strong())),
        (TextStyle::Monospace, FontId::monospace(12.5)),
    ]
    .into();
    let spacing = &mut style.spacing;
    spacing.item_spacing = egui::vec2(6.0, 5.0);
    spacing.button_padding = egui::vec2(8.0, 3.0);
    spacing.interact_size.y = 22.0;
    spacing.slider_rail_height = 5.0;
    spacing.menu_margin = egui::Margin::same(6);
    spacing.tooltip_width = 320.0;
    // in the margin of a panel, not over its content
    spacing.scroll.bar_outer_margin = -6.0;
    style.visuals = visuals(dark);
}

fn visuals(dark: bool) -> Visuals {
    let p = palette(dark);
    let base = if dark {
        Visuals::dark()
    } else {
        Visuals::light()
    };
    let line = Stroke::new(1.0, p.line);
    let widget = |fill: Color32, edge: Stroke, ink: Color32| WidgetVisuals {
        bg_fill: fill,
        weak_bg_fill: fill,
        bg_stroke: edge,
        fg_stroke: Stroke::new(1.0, ink),
        corner_radius: CornerRadius::same(5),
        expansion: 0.0,
    };
    let mut widgets = base.widgets.clone();
    widgets.noninteractive = widget(p.panel, line, p.text);
    widgets.inactive = widget(p.button[0], Stroke::NONE, p.text);
    widgets.hovered = widget(p.button[1], line, p.title);
    widgets.active = widget(p.button[2], Stroke::new(1.0, p.accent), p.title);
    widgets.open = widget(p.button[1], line, p.title);
    let shadow = |alpha| Shadow {
        offset: [0, 6],
        blur: 18,
        spread: 0,
        color: Color32::from_black_alpha(alpha),
    };
    let shadow = shadow(if dark { 110 } else { 45 });
    Visuals {
        widgets,
        selection: Selection {
            bg_fill: p.selection,
            stroke: Stroke::new(1.0, p.title),
        },
        weak_text_color: Some(p.text.gamma_multiply(0.72)),
        hyperlink_color: if dark {
            Color32::from_rgb(104, 178, 235)
        } else {
            p.accent
        },
        faint_bg_color: if dark {
            Color32::from_white_alpha(5)
        } else {
            Color32::from_black_alpha(8)
        },
        extreme_bg_color: p.field,
        code_bg_color: p.field,
        warn_fg_color: p.warning,
        error_fg_color: p.error,
        panel_fill: p.panel,
        window_fill: p.panel,
        window_stroke: line,
        window_shadow: shadow,
        popup_shadow: shadow,
        slider_trailing_fill: true,
        // a blinking cursor would keep the window from sleeping
        text_cursor: egui::style::TextCursorStyle {
            blink: false,
            ..base.text_cursor.clone()
        },
        ..base
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_of_one_colour_differ_in_their_lines() {
        let dashed: Vec<bool> = (0..14).map(is_dashed).collect();
        let count = SERIES_LIGHT.len();
        for k in 0..count {
            assert!(!dashed[k] && dashed[k + count]);
        }
        assert!(!dashed[2 * count]);
    }

    /// Relative luminance of WCAG.
    fn luminance(c: Color32) -> f32 {
        let linear = egui::Rgba::from(c);
        0.2126 * linear.r() + 0.7152 * linear.g() + 0.0722 * linear.b()
    }

    fn contrast(a: Color32, b: Color32) -> f32 {
        let (a, b) = (luminance(a) + 0.05, luminance(b) + 0.05);
        a.max(b) / a.min(b)
    }

    /// Contrast of at least 4.5, as WCAG requires for text.
    #[test]
    fn all_text_is_legible() {
        for p in [&DARK, &LIGHT] {
            for ground in [p.panel, p.field] {
                for ink in [p.text, p.title, p.warning, p.error, p.success] {
                    let found = contrast(ink, ground);
                    assert!(found >= 4.5, "{ink:?} on {ground:?}: {found}");
                }
            }
            assert!(contrast(p.title, p.selection) >= 4.5);
            assert!(contrast(p.title, p.button[2]) >= 4.5);
            assert!(contrast(Color32::WHITE, p.accent) >= 4.0);
        }
    }
}
