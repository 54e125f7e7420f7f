//! Samples with colours.

use std::f64::consts::FRAC_PI_2;
use std::sync::Arc;

use super::{TriangleMesh, sphere};
use crate::images::Pixels;
use crate::mesh::{Column, DVec3, FaceTag, OwnMaterial, Soup, color_columns, to_signal};

/// Width and height of the image of the egg in pixels: a square for each chart.
const SIZE: [u32; 2] = [1024, 512];
/// Angle from the middle of a chart to the side of its square. A chart reaches beyond the quarter turn
/// by the faces on the seam.
const REACH: f64 = 1.15 * FRAC_PI_2;
const MATERIAL: &str = "egg";

/// A standing egg whose tip is at +y.
pub fn painted_egg() -> TriangleMesh {
    let (mut positions, triangles) = sphere(5000, 41);
    for p in &mut positions {
        *p = egg(*p);
    }
    (positions, triangles)
}

/// The point of the egg in a direction: longer and more pointed upwards.
fn egg(d: DVec3) -> DVec3 {
    let width = 0.85 - 0.12 * d.y;
    DVec3::new(width * d.x, 1.1 * d.y, width * d.z)
}

/// The direction of a point of the egg.
fn direction(p: DVec3) -> DVec3 {
    let y = p.y / 1.1;
    let width = 0.85 - 0.12 * y;
    DVec3::new(p.x / width, y, p.z / width)
}

/// Gives the egg texture coordinates in two charts, left and right of the seam `x = 0`, and a material
/// with the image. Without the cargo feature `textures` it stays plain.
pub fn paint_egg(soup: &mut Soup) {
    let Ok(png) = image().to_png() else {
        return;
    };
    let (mut us, mut vs) = (Vec::new(), Vec::new());
    let mut rows = vec![[None; 2]; soup.positions.len()];
    let texture = &mut soup.attributes.faces.texture;
    for face in soup.corners.chunks_exact(3) {
        let sum: DVec3 = face.iter().map(|&v| soup.positions[v as usize]).sum();
        let side = usize::from(sum.x > 0.0);
        for &v in face {
            texture.push(*rows[v as usize][side].get_or_insert_with(|| {
                let [u, down] = place(direction(soup.positions[v as usize]), side);
                us.push(u);
                vs.push(1.0 - down);
                us.len() as u32 - 1
            }));
        }
    }
    let all = &mut soup.attributes;
    all.texture = Arc::new(vec![Column::decimals("u", us), Column::decimals("v", vs)]);
    all.tags.push(FaceTag {
        material: MATERIAL.to_owned(),
        ..FaceTag::default()
    });
    all.faces.tags = vec![0; soup.corners.len() / 3];
    all.own_materials.push(OwnMaterial {
        name: MATERIAL.to_owned(),
        like: String::new(),
        png: Arc::new(png),
    });
}

/// The place of a direction in the image, rightwards and downwards in 0..=1: at its angle from the middle
/// of the chart (azimuthal equidistant projection).
fn place(d: DVec3, side: usize) -> [f64; 2] {
    let outwards = if side == 1 { d.x } else { -d.x };
    let angle = outwards.clamp(-1.0, 1.0).acos();
    let around = d.y.hypot(d.z).max(f64::MIN_POSITIVE);
    // seen from outside
    let right = if side == 1 { -d.z } else { d.z } / around;
    let [x, y] = [right, -d.y / around].map(|x| 0.5 + 0.5 * x * angle / REACH);
    [0.5 * (x + side as f64), y]
}

/// The direction at a place in the image: the inverse of [`place`].
fn direction_at([u, y]: [f64; 2]) -> DVec3 {
    let side = usize::from(u >= 0.5);
    let [right, down] = [2.0 * u - side as f64, y].map(|x| (2.0 * x - 1.0) * REACH);
    let angle = right.hypot(down);
    let around = angle.sin() / angle.max(f64::MIN_POSITIVE);
    let sign = if side == 1 { 1.0 } else { -1.0 };
    DVec3::new(sign * angle.cos(), -down * around, -sign * right * around)
}

fn image() -> Pixels {
    let [width, height] = SIZE;
    let mut rgba = Vec::with_capacity(4 * (width * height) as usize);
    for y in 0..height {
        for x in 0..width {
            let place = [(x, width), (y, height)].map(|(i, n)| (f64::from(i) + 0.5) / f64::from(n));
            let light = paint(direction_at(place));
            rgba.extend(light.map(|x| (255.0 * to_signal(x)).round() as u8));
            rgba.push(u8::MAX);
        }
    }
    Pixels {
        width,
        height,
        rgba,
    }
}

/// The colour of the egg in a direction, in linear light: three, with wavy borders.
fn paint(d: DVec3) -> [f64; 3] {
    const LOWER: DVec3 = DVec3::new(0.03, 0.22, 0.36);
    const MIDDLE: DVec3 = DVec3::new(0.82, 0.62, 0.3);
    const UPPER: DVec3 = DVec3::new(0.6, 0.1, 0.08);
    let wave = 0.12 * (4.0 * d.x + 1.0).sin() + 0.1 * (4.0 * d.z).cos();
    let height = (1.6 * (d.y + wave)).sin();
    let soft = |x: f64| {
        let x = x.clamp(0.0, 1.0);
        x * x * (3.0 - 2.0 * x)
    };
    let lower = LOWER.lerp(MIDDLE, soft(1.0 + height));
    lower.lerp(UPPER, soft(height)).to_array()
}

/// Gives the ring colours of its vertices: around it and from inside outwards.
pub fn paint_ring(soup: &mut Soup) {
    let color = |p: &DVec3| {
        let around = p.y.atan2(p.x);
        let rainbow = [0.0, 1.0, 2.0].map(|k| 0.5 + 0.42 * (around - 2.1 * k).cos());
        let [r, g, b] = rainbow.map(|x| to_signal(x * (0.55 + 0.4 * p.z)) as f32);
        [r, g, b, 1.0].map(|x| (255.0 * x).round() / 255.0)
    };
    let colors: Vec<[f32; 4]> = soup.positions.iter().map(color).collect();
    soup.attributes.vertices = color_columns(&colors);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_in_the_image_are_those_of_the_directions() {
        for d in sphere(300, 1).0 {
            for side in [0, 1] {
                let outwards = if side == 1 { d.x } else { -d.x };
                if outwards > -0.1 {
                    let at = place(d, side);
                    assert!(at.iter().all(|x| (0.0..=1.0).contains(x)), "{at:?}");
                    assert!(direction_at(at).distance(d) < 1e-9);
                }
            }
            assert!(direction(egg(d)).distance(d) < 1e-12);
        }
    }
}
