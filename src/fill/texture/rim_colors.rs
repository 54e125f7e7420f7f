//! The colours of texture images along rims.

use std::collections::{BTreeMap, BTreeSet};

use super::Light;
use crate::images::Pixels;
use crate::io;
use crate::mesh::{Attributes, ImageSource, Material, NO_VALUE, to_light, to_signal};

/// Texels from a rim to the places inside the given faces whose colours count. At the border of a chart
/// the image may have the colour of its background.
const INSET: f64 = 0.5;
/// The part of the places inside a rim that have one colour if the image is blank there.
const BLANK: f64 = 0.3;
/// How far outside the range of colours along a rim a colour is strange there, in parts of full intensity.
const STRANGE: f64 = 0.06;

/// The colours along one edge.
#[derive(Clone, Debug)]
pub struct RimEdge {
    /// At places evenly apart, at least two, from the first end to the second.
    pub lights: Vec<Light>,
    /// The length in texels of the image; 0 in a material of one colour.
    pub texels: f64,
}

impl RimEdge {
    /// The colour at `t` in 0..=1 of the way from the first end to the second.
    pub fn at(&self, t: f64) -> Light {
        let last = self.lights.len() - 1;
        let place = t.clamp(0.0, 1.0) * last as f64;
        let first = (place as usize).min(last - 1);
        let t = (place - first as f64) as f32;
        let [a, b] = [self.lights[first], self.lights[first + 1]];
        std::array::from_fn(|k| a[k] + t * (b[k] - a[k]))
    }
}

/// The colours that texture images and materials have along rims.
#[derive(Debug, Default)]
pub struct RimColors {
    /// By the corners of given faces at both ends of an edge.
    edges: BTreeMap<[u32; 2], RimEdge>,
    /// The names of all materials.
    pub materials: BTreeSet<String>,
    /// By the name of a material, why its image gives no colours.
    unread: BTreeMap<String, String>,
    /// For each rim whether the image is blank inside.
    blank: Vec<bool>,
}

impl RimColors {
    /// Reads the images at the edges of these rims: pairs of corners of given faces.
    pub fn read(attributes: &Attributes, rims: &[Vec<[u32; 2]>]) -> Self {
        let all = io::materials(attributes);
        let mut colors = Self {
            materials: all.iter().map(|material| material.name.clone()).collect(),
            blank: vec![false; rims.len()],
            ..Self::default()
        };
        let mut by_image: BTreeMap<&ImageSource, Vec<(&Material, [u32; 2])>> = BTreeMap::new();
        for &edge in rims.iter().flatten() {
            let name = attributes.material_of(edge[0] as usize / 3);
            let Some(material) = all.iter().find(|material| material.name == name) else {
                continue;
            };
            if let Some(image) = &material.image {
                // an image without places of it on the edge gives nothing
                if corner_places(attributes, edge, material).is_none() {
                    continue;
                }
                by_image.entry(image).or_default().push((material, edge));
            } else if let Some([r, g, b]) = material.color {
                let [r, g, b] = [r, g, b].map(|x| to_light(f64::from(x)) as f32);
                let lights = vec![[r, g, b, 1.0]; 2];
                let texels = 0.0;
                colors.edges.insert(edge, RimEdge { lights, texels });
            }
        }
        for (source, edges) in by_image {
            // one image at a time, because they may be large
            let read = source.bytes().map_err(|e| e.to_string());
            match read.and_then(|bytes| Pixels::decode(&bytes)) {
                Ok(pixels) => {
                    let image = LightImage::new(&pixels);
                    let sampled = edges.iter().filter_map(|&(material, edge)| {
                        Some((
                            edge,
                            image.along(corner_places(attributes, edge, material)?),
                        ))
                    });
                    colors.edges.extend(sampled);
                    let of_image = edges.iter().filter_map(|&(material, edge)| {
                        Some((edge, corner_places(attributes, edge, material)?))
                    });
                    let of_image: BTreeMap<[u32; 2], [[f64; 2]; 3]> = of_image.collect();
                    for (rim, blank) in rims.iter().zip(&mut colors.blank) {
                        let places = rim.iter().map(|edge| of_image.get(edge).copied());
                        if let Some(places) = places.collect::<Option<Vec<_>>>() {
                            *blank = image.is_blank_inside(&places, rim, &colors.edges);
                        }
                    }
                }
                Err(error) => {
                    let why = format!("the image '{}' is not read: {error}", source.name());
                    let names = edges.iter().map(|(material, _)| &material.name);
                    colors
                        .unread
                        .extend(names.map(|name| (name.clone(), why.clone())));
                }
            }
        }
        colors
    }

    /// Whether the image around a rim is blank inside it.
    pub fn is_blank(&self, rim: usize) -> bool {
        self.blank[rim]
    }

    /// The colours along an edge of a given face.
    pub fn along(&self, edge: [u32; 2]) -> Option<&RimEdge> {
        self.edges.get(&edge)
    }

    /// Why the image of a face gives no colours, if it has one.
    pub fn why_unread(&self, attributes: &Attributes, face: usize) -> Option<&str> {
        let why = self.unread.get(attributes.material_of(face));
        why.map(String::as_str)
    }
}

/// The places in the image of its material of the corners of the edge and of the third corner of the face,
/// with the second coordinate downwards; `None` if one has none.
fn corner_places(
    attributes: &Attributes,
    [a, b]: [u32; 2],
    material: &Material,
) -> Option<[[f64; 2]; 3]> {
    let third = (3 * (a / 3)..3 * (a / 3) + 3).find(|&corner| corner != a && corner != b)?;
    let [u, v] = attributes.texture.get(..2)? else {
        return None;
    };
    let place = |corner: u32| {
        let row = *attributes.faces.texture.get(corner as usize)?;
        (row != NO_VALUE).then(|| {
            let [u, v] = [u, v].map(|column| column.numbers.get(row as usize));
            let is_down = attributes.texture_is_down;
            material.place([u, if is_down { v } else { 1.0 - v }])
        })
    };
    Some([place(a)?, place(b)?, place(third)?])
}

/// Whether a point is inside a polygon with these sides: a ray crosses an odd number of them.
fn is_inside(sides: &[[[f64; 2]; 2]], p: [f64; 2]) -> bool {
    let crosses = |[a, b]: &&[[f64; 2]; 2]| {
        (a[1] > p[1]) != (b[1] > p[1])
            && p[0] < a[0] + (p[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0])
    };
    sides.iter().filter(crosses).count() % 2 == 1
}

/// An image in linear light, which repeats in both directions.
struct LightImage<'a> {
    pixels: &'a Pixels,
    light: Vec<f32>,
}

impl<'a> LightImage<'a> {
    fn new(pixels: &'a Pixels) -> Self {
        let light = (0..=255).map(|k| to_light(f64::from(k) / 255.0) as f32);
        Self {
            pixels,
            light: light.collect(),
        }
    }

    fn pixel(&self, x: i64, y: i64) -> [u8; 4] {
        let Pixels { width, height, .. } = *self.pixels;
        let [x, y] = [(x, width), (y, height)].map(|(i, n)| i.rem_euclid(i64::from(n)) as usize);
        let at = 4 * (y * width as usize + x);
        [0, 1, 2, 3].map(|k| self.pixels.rgba[at + k])
    }

    fn texel(&self, x: i64, y: i64) -> Light {
        let [r, g, b, a] = self.pixel(x, y);
        let [r, g, b] = [r, g, b].map(|x| self.light[usize::from(x)]);
        [r, g, b, f32::from(a) / 255.0]
    }

    /// The light at a place in pixels from the upper left corner, between the centres of pixels.
    fn at(&self, place: [f64; 2]) -> Light {
        let [x, y] = place.map(|x| x - 0.5);
        let (left, top) = (x.floor(), y.floor());
        let (s, t) = ((x - left) as f32, (y - top) as f32);
        let (left, top) = (left as i64, top as i64);
        let between =
            |a: Light, b: Light, t: f32| std::array::from_fn(|k| a[k] + t * (b[k] - a[k]));
        let row = |y: i64| between(self.texel(left, y), self.texel(left + 1, y), s);
        between(row(top), row(top + 1), t)
    }

    /// Whether a large part inside a rim has one colour that is not along the rim, as where no face was
    /// painted, or is transparent there only.
    fn is_blank_inside(
        &self,
        places: &[[[f64; 2]; 3]],
        rim: &[[u32; 2]],
        colors: &BTreeMap<[u32; 2], RimEdge>,
    ) -> bool {
        let size = [self.pixels.width, self.pixels.height].map(f64::from);
        let sides = places.iter();
        let sides = sides.map(|&[a, b, _]| [a, b].map(|[u, v]| [u * size[0], v * size[1]]));
        let sides: Vec<[[f64; 2]; 2]> = sides.collect();
        let middles: Vec<[f64; 2]> = sides
            .iter()
            .map(|[a, b]| [0, 1].map(|k| 0.5 * (a[k] + b[k])))
            .collect();
        let count = middles.len() as f64;
        let centre = [0, 1].map(|k| middles.iter().map(|p| p[k]).sum::<f64>() / count);
        let inwards = |p: &[f64; 2], t: f64| [0, 1].map(|k| p[k] + t * (centre[k] - p[k]));
        let places = middles
            .iter()
            .flat_map(|p| [0.2, 0.4, 0.6, 0.8].map(|t| inwards(p, t)));
        // similar colours together, because the colours of a JPEG image vary
        let mut alike: BTreeMap<[u8; 4], (usize, [f64; 4])> = BTreeMap::new();
        let mut all = 0;
        for place in places.filter(|&p| is_inside(&sides, p)) {
            let pixel = self.pixel(place[0].floor() as i64, place[1].floor() as i64);
            let (number, sum) = alike.entry(pixel.map(|x| x / 8)).or_default();
            *number += 1;
            *sum = std::array::from_fn(|k| sum[k] + f64::from(pixel[k]) / 255.0);
            all += 1;
        }
        let Some((number, sum)) = alike.into_values().max_by_key(|(number, _)| *number) else {
            return false;
        };
        let lights = || {
            rim.iter()
                .filter_map(|edge| colors.get(edge))
                .flat_map(|e| &e.lights)
        };
        let is_new = (0..4).any(|k| {
            let signal = |light: f32| match k {
                3 => f64::from(light),
                _ => to_signal(f64::from(light)),
            };
            let along = || lights().map(|light| light[k]);
            let (low, high) = (along().fold(1.0, f32::min), along().fold(0.0, f32::max));
            let mean = sum[k] / number as f64;
            mean < signal(low) - STRANGE || mean > signal(high) + STRANGE
        });
        is_new && number as f64 >= BLANK * f64::from(all)
    }

    /// The colours along the first side of a triangle, close inside it.
    fn along(&self, corners: [[f64; 2]; 3]) -> RimEdge {
        let size = [self.pixels.width, self.pixels.height].map(f64::from);
        let [a, b, c] = corners.map(|[u, v]| [u * size[0], v * size[1]]);
        let side = [b[0] - a[0], b[1] - a[1]];
        // of degenerate coordinates not more than an image has
        let texels = side[0].hypot(side[1]).min(f64::from(1 << 16));
        let mut inwards = [0.0; 2];
        if texels > 0.0 {
            let across = [-side[1] / texels, side[0] / texels];
            let height = across[0] * (c[0] - a[0]) + across[1] * (c[1] - a[1]);
            let far = INSET.min(height.abs() / 3.0).copysign(height);
            inwards = across.map(|x| far * x);
        }
        let count = (texels.ceil() as usize).clamp(1, 1024);
        let light = |i: usize| {
            let t = i as f64 / count as f64;
            self.at([0, 1].map(|k| a[k] + t * side[k] + inwards[k]))
        };
        RimEdge {
            lights: (0..=count).map(light).collect(),
            texels,
        }
    }
}
