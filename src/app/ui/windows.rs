//! Side windows: load report, log, keys, settings, frame times.

use std::time::{Duration, Instant};

use eframe::egui::{self, Context, Grid, RichText, ScrollArea, Ui, Window};

use super::UiState;
use super::format::grouped;
use super::repair::{REPAIR, repair_button};
use super::widgets::{ClickActions, named, row, slider};
use crate::app::action::{Action, EditAction, Switch, ViewAction};
use crate::app::log::Level;
use crate::app::model::Model;
use crate::app::report::ReportAction;
use crate::app::shortcuts::{GROUPS, SHORTCUTS};
use crate::memory::peak_memory;

/// Frame times without the time of the graphics card.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FrameStats {
    /// Start of the program.
    pub(crate) started: Instant,
    /// Time from the start to the end of the first frame.
    pub(crate) first: Option<Duration>,
    /// Number of frames.
    pub(crate) count: u64,
    /// Time of the last frame.
    pub(crate) last: Duration,
    /// The longest frame time since the start of the run or the last reset.
    pub(crate) longest: Duration,
    /// Sum of all frame times, for the mean.
    pub(crate) total: Duration,
}

impl Default for FrameStats {
    fn default() -> Self {
        Self {
            started: Instant::now(),
            first: None,
            count: 0,
            last: Duration::ZERO,
            longest: Duration::ZERO,
            total: Duration::ZERO,
        }
    }
}

impl FrameStats {
    /// Records a frame. The first frames, which include the initial layout, do not count as
    /// longest.
    pub(crate) fn record(&mut self, took: Duration) {
        if self.first.is_none() {
            self.first = Some(self.started.elapsed());
        }
        self.count += 1;
        self.last = took;
        self.total += took;
        if self.count > 3 {
            self.longest = self.longest.max(took);
        }
    }
}

/// All open side windows.
pub(crate) fn windows_ui(
    ctx: &Context,
    model: &Model,
    state: &mut UiState,
    actions: &mut Vec<Action>,
) {
    let windows = model.view.windows;
    let mut one = |title: &str,
                   open: bool,
                   switch: Switch,
                   body: &mut dyn FnMut(&mut Ui, &mut Vec<Action>)| {
        if !open {
            return;
        }
        let mut stays = true;
        let height = (ctx.content_rect().height() - 180.0).clamp(200.0, 560.0);
        Window::new(title)
            .open(&mut stays)
            .collapsible(false)
            // over the side panel, so that the middle of the view stays free
            .default_pos([8.0, 90.0])
            .default_size([360.0, height])
            .vscroll(false)
            .show(ctx, |ui| body(ui, actions));
        if !stays {
            actions.push(ViewAction::Toggle(switch).into());
        }
    };
    one(
        "Load report",
        windows.report,
        Switch::Report,
        &mut |ui, actions| {
            report_ui(ui, model, actions);
        },
    );
    one("Log", windows.log, Switch::Log, &mut |ui, _| {
        log_ui(ui, model);
    });
    one(
        "Keys and mouse",
        windows.help,
        Switch::Help,
        &mut |ui, _| help_ui(ui, model),
    );
    one(
        "Settings",
        windows.settings,
        Switch::Settings,
        &mut |ui, actions| {
            settings_ui(ui, model, actions);
        },
    );
    one(
        "Frame times and memory",
        windows.diagnostics,
        Switch::Diagnostics,
        &mut |ui, _| {
            diagnostics_ui(ui, model, state);
        },
    );
}

fn report_ui(ui: &mut Ui, model: &Model, actions: &mut Vec<Action>) {
    let document = &model.document;
    let r = &document.origin.report;
    let buttons = ui.spacing().interact_size.y + 2.0 * ui.spacing().item_spacing.y;
    let height = (ui.available_height() - buttons).max(80.0);
    ScrollArea::vertical().max_height(height).show(ui, |ui| {
        Grid::new("counts")
            .striped(true)
            .num_columns(2)
            .min_col_width(0.5 * ui.available_width() - ui.spacing().item_spacing.x)
            .show(ui, |ui| {
                for (name, count, always) in [
                    ("Vertices in the file", r.file_vertices, true),
                    ("Faces in the file", r.file_faces, true),
                    ("Vertices", r.vertices, true),
                    ("Triangles", r.faces, true),
                    ("Components", r.components.len(), true),
                    (
                        "Boundary loops",
                        r.components.iter().map(|part| part.loops).sum(),
                        true,
                    ),
                    ("Vertices merged", r.welded_vertices, false),
                    ("Polygons triangulated", r.polygons_triangulated, false),
                    ("Duplicate faces removed", r.duplicate_faces, false),
                    ("Degenerate faces removed", r.degenerate_faces, false),
                    ("Triangles of zero area", r.zero_area_faces, false),
                    ("Isolated vertices", r.isolated_vertices, false),
                    ("Faces flipped", r.flipped_faces, false),
                    (
                        "Edges with more than two faces, cut",
                        r.non_manifold_edges,
                        false,
                    ),
                    (
                        "Vertices with several sheets, split",
                        r.split_vertices,
                        false,
                    ),
                    (
                        "Vertices where a boundary touches itself",
                        r.pinched_vertices,
                        false,
                    ),
                    (
                        "Faces of non-orientable components",
                        r.non_orientable_faces,
                        false,
                    ),
                ] {
                    if always || count > 0 {
                        ui.label(name);
                        ui.label(grouped(count));
                        ui.end_row();
                    }
                }
                if !document.accepted.is_empty() {
                    let mesh = &document.mesh;
                    ui.label("After the changes");
                    ui.label(format!(
                        "{} vertices, {} triangles, {}",
                        grouped(mesh.vertex_count()),
                        grouped(mesh.face_count()),
                        document.loop_count()
                    ));
                    ui.end_row();
                }
            });
        for note in &r.notes {
            ui.label(RichText::new(note).weak());
        }
        if r.defects.is_empty() {
            ui.label("No defects.");
            return;
        }
        ui.add_space(4.0);
        let (listed, all) = (r.defects.len(), r.defect_count());
        ui.strong(if listed < all {
            format!("Defects of the file ({listed} of {all}; click one to show it)")
        } else {
            "Defects of the file (click one to show it)".to_owned()
        });
        for defect in &r.defects {
            let p = defect.position;
            let words = format!(
                "{}  at {:.4}, {:.4}, {:.4}",
                defect.kind.words(),
                p.x,
                p.y,
                p.z
            );
            ui.link(words).on_click(ReportAction::Inspect(p), actions);
        }
    });
    ui.horizontal_wrapped(|ui| {
        repair_button(ui, model, egui::Button::new(REPAIR), actions);
        for (name, tip, action) in [
            (
                "Remove loose parts",
                "erase small components, and flaps that stick into holes (meniscus clean)",
                EditAction::Clean,
            ),
            (
                "Stitch slits",
                "join boundary edges that coincide within 1 % of their mean length (meniscus \
                 stitch)",
                EditAction::Stitch,
            ),
        ] {
            let idle = model.run.is_none() && !document.is_blank();
            ui.add_enabled(idle, egui::Button::new(name))
                .on_hover_text(tip)
                .on_click(action, actions);
        }
    });
}

fn log_ui(ui: &mut Ui, model: &Model) {
    ScrollArea::vertical()
        .max_height(360.0)
        .stick_to_bottom(true)
        .show(ui, |ui| {
            for entry in model.log.entries() {
                let color = match entry.level {
                    Level::Info => ui.visuals().text_color(),
                    Level::Warning => ui.visuals().warn_fg_color,
                    Level::Error => ui.visuals().error_fg_color,
                };
                let ago = entry.at.elapsed().as_secs();
                ui.horizontal_wrapped(|ui| {
                    ui.weak(format!("{}:{:02} ago", ago / 60, ago % 60));
                    ui.label(RichText::new(&entry.text).color(color));
                });
            }
        });
}

fn help_ui(ui: &mut Ui, model: &Model) {
    let navigation = model.settings.navigation;
    let id = ui.scope_id().with("search");
    let mut sought = ui.data(|data| data.get_temp::<String>(id).unwrap_or_default());
    let field = egui::TextEdit::singleline(&mut sought)
        .hint_text("for example undo or Ctrl")
        .desired_width(f32::INFINITY);
    let changed = row(ui, "Search", "", |ui, label| {
        ui.add(field).labelled_by(label).changed()
    });
    if changed {
        ui.data_mut(|data| data.insert_temp(id, sought.clone()));
    }
    let sought = sought.trim().to_lowercase();
    let found = |about: &str, keys: &str| {
        let text = format!("{about} {keys}").to_lowercase();
        sought.split_whitespace().all(|word| text.contains(word))
    };
    let mouse = [
        (navigation.about(), navigation.title()),
        ("Select a hole", "Click"),
        ("Add a hole to the selection", "Shift+click"),
        ("Add or remove a hole", "Ctrl+click"),
        ("Set the pivot of rotations", "Double-click"),
        ("Open the menus; arrow keys move in them", "F10 or Alt"),
        ("Open the menu with this first letter", "Alt+letter"),
    ];
    ScrollArea::vertical().show(ui, |ui| {
        ui.set_min_width(ui.available_width());
        let rows = mouse.map(|(about, keys)| (about, keys.to_owned()));
        help_group(ui, "Mouse and menus", rows.into_iter(), &found);
        for group in GROUPS {
            let rows = SHORTCUTS.iter().filter(|s| s.group() == group);
            let ctx = ui.ctx().clone();
            let rows = rows.map(|s| (s.about, s.keys_text(&ctx)));
            help_group(ui, group, rows, &found);
        }
    });
}

/// The rows of a group that were found, under its heading.
fn help_group<'a>(
    ui: &mut Ui,
    title: &str,
    rows: impl Iterator<Item = (&'a str, String)>,
    found: &dyn Fn(&str, &str) -> bool,
) {
    let rows: Vec<_> = rows.filter(|(about, keys)| found(about, keys)).collect();
    if rows.is_empty() {
        return;
    }
    ui.add_space(4.0);
    ui.heading(title);
    for (about, keys) in rows {
        // no grid, which knows the heights of wrapped rows only in its second frame
        ui.horizontal_top(|ui| {
            let column = egui::vec2(KEYS, ui.spacing().interact_size.y);
            let layout = egui::Layout::top_down(egui::Align::Min);
            ui.allocate_ui_with_layout(column, layout, |ui| {
                ui.set_min_width(KEYS);
                ui.add(egui::Label::new(RichText::new(keys).strong()).wrap());
            });
            ui.add(egui::Label::new(about).wrap());
        });
    }
}

/// Width of the column of keys.
const KEYS: f32 = 150.0;

fn settings_ui(ui: &mut Ui, model: &Model, actions: &mut Vec<Action>) {
    let settings = &model.settings;
    ui.horizontal(|ui| {
        ui.label("Theme");
        for (dark, name) in [(true, "dark"), (false, "light")] {
            ui.selectable_label(settings.dark == dark, name)
                .on_click(ViewAction::Dark(dark), actions);
        }
    });
    ui.horizontal(|ui| {
        let mut scale = settings.ui_scale;
        let slider = slider(&mut scale, 0.5..=3.0).step_by(0.05);
        let slider = named(ui, "Scale of the interface", slider);
        // apply only after the drag, because the scale moves the slider under the cursor
        if slider.drag_stopped() || (slider.changed() && !slider.dragged()) {
            actions.push(ViewAction::UiScale(scale).into());
        }
    });
    ui.label("Mouse");
    super::menu::navigation_ui(ui, model, actions);
}

fn diagnostics_ui(ui: &mut Ui, model: &Model, state: &UiState) {
    let f = &state.frames;
    let ms = |d: Duration| format!("{:.2} ms", d.as_secs_f64() * 1e3);
    let mib = |bytes: usize| format!("{:.1} MiB", bytes as f64 / f64::from(1 << 20));
    let kept = model
        .run
        .iter()
        .flat_map(|r| &r.sides)
        .map(|s| s.handle.bytes())
        .sum();
    Grid::new("frames")
        .striped(true)
        .num_columns(2)
        .show(ui, |ui| {
            for (name, value) in [
                ("Graphics adapter", state.adapter.clone()),
                (
                    "From start to first frame",
                    f.first.map_or_else(String::new, ms),
                ),
                ("Frames", f.count.to_string()),
                ("Last frame, without drawing", ms(f.last)),
                (
                    "Mean",
                    ms(f.total / u32::try_from(f.count.max(1)).unwrap_or(u32::MAX)),
                ),
                ("Longest", ms(f.longest)),
                ("Stored states", mib(kept)),
                ("Peak memory of the process", mib(peak_memory() as usize)),
            ] {
                ui.label(name);
                ui.label(value);
                ui.end_row();
            }
        });
}
