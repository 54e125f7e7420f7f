//! The menu of samples.

use eframe::egui::{
    self, Button, ColorImage, Context, FontSelection, Id, Image, TextureHandle, TextureOptions, Ui,
    Vec2,
    text::{LayoutJob, TextFormat},
};

use crate::app::action::{Action, FileAction};
use crate::images::Pixels;
use crate::shapes::{SAMPLES, Sample};

/// Size of a picture in points.
const SIZE: Vec2 = Vec2::new(64.0, 48.0);

/// An entry for each sample: its picture, its title and what it shows.
pub(super) fn samples_ui(ui: &mut Ui, actions: &mut Vec<Action>) {
    for sample in &SAMPLES {
        let text = description(ui, sample);
        let button = match picture(ui.ctx(), sample.name) {
            Some(texture) => {
                let image = Image::from_texture((texture.id(), SIZE));
                Button::image_and_text(image.fit_to_exact_size(SIZE), text)
            }
            None => Button::new(text),
        };
        if ui.add(button).clicked() {
            actions.push(FileAction::Sample(sample.name.into()).into());
            ui.close();
        }
    }
}

/// The title, and below it smaller what the sample shows.
fn description(ui: &Ui, sample: &Sample) -> LayoutJob {
    let style = ui.style();
    let font = |name| FontSelection::Style(name).resolve(style);
    let format = |font_id, color| TextFormat {
        font_id,
        color,
        ..TextFormat::default()
    };
    let mut job = LayoutJob::default();
    let title = font(egui::TextStyle::Button);
    let about = font(egui::TextStyle::Small);
    let colors = ui.visuals();
    job.append(sample.title, 0.0, format(title, colors.text_color()));
    job.append("\n", 0.0, TextFormat::default());
    job.append(sample.about, 0.0, format(about, colors.weak_text_color()));
    job
}

/// The picture of a sample, read once.
fn picture(ctx: &Context, name: &str) -> Option<TextureHandle> {
    let id = Id::unique(("picture of a sample", name));
    if let Some(texture) = ctx.data(|data| data.get_temp(id)) {
        return Some(texture);
    }
    let Pixels {
        width,
        height,
        rgba,
    } = Pixels::decode(file(name)?).ok()?;
    let size = [width, height].map(|n| n as usize);
    let image = ColorImage::from_rgba_unmultiplied(size, &rgba);
    let texture = ctx.load_texture(name, image, TextureOptions::LINEAR);
    ctx.data_mut(|data| data.insert_temp(id, texture.clone()));
    Some(texture)
}

/// The bytes of the picture of a sample, which `scripts/samples.sh` makes.
fn file(name: &str) -> Option<&'static [u8]> {
    macro_rules! files {
        ($($name:literal)*) => {
            match name {
                $($name => Some(include_bytes!(concat!("../../../assets/samples/", $name, ".png"))),)*
                _ => None,
            }
        };
    }
    files!(
        "creature" "sphere" "egg" "ring" "torus" "catenoid" "saddle" "four-cylinders" "three-y"
        "tube-onto-plane"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_sample_has_a_picture() {
        for sample in &SAMPLES {
            let picture = Pixels::decode(file(sample.name).expect(sample.name));
            let picture = picture.expect("an image");
            assert_eq!(
                [picture.width, picture.height],
                [160, 120],
                "{}",
                sample.name
            );
        }
    }
}
