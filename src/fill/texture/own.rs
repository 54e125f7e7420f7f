//! Charts of patches in an image of their own.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::sync::Arc;

use super::atlas::packed;
use super::chart::Chart;
use super::rim_colors::RimColors;
use super::{Light, RimEdge};
use crate::images::Pixels;
use crate::mesh::union_find::{find, unite};
use crate::mesh::{Attributes, DVec3, FaceTag, OwnMaterial, row_count, sides, to_signal};

/// Greatest side of an image in texels; its charts are drawn smaller to fit.
const MAX_SIZE: usize = 4096;
/// The name of the first material of patches.
const NAME: &str = "patches";

/// A patch that gets a chart.
pub struct Uncharted<'a> {
    /// Its number among the holes.
    pub hole: usize,
    /// Its faces in the filled mesh.
    pub faces: Range<usize>,
    /// Its triangles.
    pub triangles: &'a [[u32; 3]],
    /// Its edges with a given face beyond them: the ends in the direction of the patch, and their corners
    /// in the given face.
    pub rim: Vec<([u32; 2], [u32; 2])>,
}

/// Patches that share edges and get one chart.
struct Part<'a> {
    /// Their numbers in the list of all.
    patches: Vec<usize>,
    triangles: Vec<[u32; 3]>,
    colors: BTreeMap<[u32; 2], &'a RimEdge>,
    /// The material that the new one resembles.
    like: String,
}

/// Gives patches charts in a new image whose texels continue the colours along their rims, and a material
/// with that image. A patch without an image beside its rim stays as it is. Returns for the holes whose
/// patches could get no chart the reason.
pub fn append_own_charts(
    attributes: &mut Attributes,
    patches: &[Uncharted<'_>],
    positions: &[DVec3],
    colors: &RimColors,
) -> Vec<(usize, String)> {
    let parts = parts(attributes, patches, colors);
    let mut why_not: Vec<Option<String>> = patches
        .iter()
        .map(|patch| {
            let faces = patch.rim.iter().map(|(_, corners)| corners[0] as usize / 3);
            let mut why = faces.filter_map(|face| colors.why_unread(attributes, face));
            why.next().map(str::to_owned)
        })
        .collect();
    let mut drawn: Vec<(&Part<'_>, Chart<'_>)> = Vec::new();
    let (mut size, mut corners) = ([0; 2], Vec::new());
    // smaller until all charts fit
    for scale in (0..16).map(|k| 0.7_f64.powi(k)) {
        let charts = parts.iter().filter_map(|part| {
            let colors = |edge: [u32; 2]| part.colors.get(&edge).copied();
            let chart = Chart::new(&part.triangles, positions, scale, colors)?;
            Some((part, chart))
        });
        drawn = charts.collect();
        let sizes: Vec<[usize; 2]> = drawn.iter().map(|(_, chart)| chart.size).collect();
        (size, corners) = packed(&sizes);
        if size[0].max(size[1]) <= MAX_SIZE {
            break;
        }
    }
    for &patch in parts.iter().flat_map(|part| &part.patches) {
        why_not[patch] = Some("its border touches itself".to_owned());
    }
    if !drawn.is_empty() {
        let made = image(&drawn, size, &corners).to_png().map(|png| {
            refer_to_image(attributes, patches, colors, &drawn, &corners, size, png);
        });
        for &patch in drawn.iter().flat_map(|(part, _)| &part.patches) {
            why_not[patch] = made.clone().err();
        }
    }
    let failed = patches.iter().zip(why_not);
    failed
        .filter_map(|(patch, why)| Some((patch.hole, why?)))
        .collect()
}

/// Adds the material of an image, and gives the faces of its charts the material and their places.
fn refer_to_image(
    attributes: &mut Attributes,
    patches: &[Uncharted<'_>],
    colors: &RimColors,
    drawn: &[(&Part<'_>, Chart<'_>)],
    corners: &[[usize; 2]],
    size: [usize; 2],
    png: Vec<u8>,
) {
    let png = Arc::new(png);
    let likes: BTreeSet<&str> = drawn.iter().map(|(part, _)| part.like.as_str()).collect();
    let names = new_names(attributes, colors, &likes);
    for (like, name) in &names {
        attributes.own_materials.push(OwnMaterial {
            name: name.clone(),
            like: (*like).to_owned(),
            png: Arc::clone(&png),
        });
    }
    for ((part, chart), corner) in drawn.iter().zip(corners) {
        let rows = append_places(attributes, chart, *corner, size);
        for &patch in &part.patches {
            let Uncharted {
                faces, triangles, ..
            } = &patches[patch];
            let list = &mut attributes.faces.texture[3 * faces.start..3 * faces.end];
            for (row, v) in list.iter_mut().zip(triangles.as_flattened()) {
                *row = rows[v];
            }
            retag(attributes, faces.clone(), &names[part.like.as_str()]);
        }
    }
}

/// Patches that share edges together, if a face beside their rims has an image.
fn parts<'a>(
    attributes: &Attributes,
    patches: &[Uncharted<'_>],
    colors: &'a RimColors,
) -> Vec<Part<'a>> {
    let mut link: Vec<u32> = (0..patches.len() as u32).collect();
    let mut patch_at: BTreeMap<[u32; 2], u32> = BTreeMap::new();
    for (i, patch) in (0..).zip(patches) {
        for &t in patch.triangles {
            for [from, to] in sides(t) {
                patch_at.insert([from, to], i);
                if let Some(&other) = patch_at.get(&[to, from]) {
                    unite(&mut link, i, other);
                }
            }
        }
    }
    let mut groups: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    for i in 0..patches.len() {
        groups.entry(find(&mut link, i as u32)).or_default().push(i);
    }
    let part = |group: Vec<usize>| {
        let rim = group.iter().flat_map(|&i| &patches[i].rim);
        let edges =
            rim.filter_map(|&(ends, corners)| Some((ends, corners, colors.along(corners)?)));
        let edges: Vec<_> = edges.collect();
        // without an image, the patch has the colour of a material
        let with_image = edges.iter().find(|(.., edge)| edge.texels > 0.0)?;
        let triangles = group.iter().flat_map(|&i| patches[i].triangles);
        Some(Part {
            like: attributes
                .material_of(with_image.1[0] as usize / 3)
                .to_owned(),
            triangles: triangles.copied().collect(),
            colors: edges.iter().map(|&(ends, _, edge)| (ends, edge)).collect(),
            patches: group,
        })
    };
    groups.into_values().filter_map(part).collect()
}

/// The image of the charts at these corners.
fn image(
    drawn: &[(&Part<'_>, Chart<'_>)],
    [width, height]: [usize; 2],
    corners: &[[usize; 2]],
) -> Pixels {
    let mut rgba = vec![0; 4 * width * height];
    let mut is_drawn = vec![false; width * height];
    let (mut sum, mut count) = ([0.0_f64; 4], 0);
    for ((_, chart), [left, top]) in drawn.iter().zip(corners) {
        for (row, lights) in chart.texels().chunks_exact(chart.size[0]).enumerate() {
            for (column, light) in lights.iter().enumerate() {
                let at = (top + row) * width + left + column;
                rgba[4 * at..4 * at + 4].copy_from_slice(&bytes(*light));
                is_drawn[at] = true;
                sum = std::array::from_fn(|k| sum[k] + f64::from(light[k]));
                count += 1;
            }
        }
    }
    // what no chart covers has the mean colour, which disturbs reduced images least
    let mean = bytes(sum.map(|x| (x / f64::from(count.max(1))) as f32));
    for (pixel, _) in rgba.chunks_exact_mut(4).zip(&is_drawn).filter(|p| !p.1) {
        pixel.copy_from_slice(&mean);
    }
    Pixels {
        width: width as u32,
        height: height as u32,
        rgba,
    }
}

fn bytes([r, g, b, a]: Light) -> [u8; 4] {
    let byte = |x: f64| (255.0 * x.clamp(0.0, 1.0)).round() as u8;
    let [r, g, b] = [r, g, b].map(|x| byte(to_signal(f64::from(x.max(0.0)))));
    [r, g, b, byte(f64::from(a))]
}

/// For each material that a new one resembles, a name that no material has.
fn new_names<'a>(
    attributes: &Attributes,
    colors: &RimColors,
    likes: &BTreeSet<&'a str>,
) -> BTreeMap<&'a str, String> {
    let mut taken = colors.materials.clone();
    taken.extend(attributes.tags.iter().map(|tag| tag.material.clone()));
    let own = attributes.own_materials.iter();
    taken.extend(own.map(|material| material.name.clone()));
    let mut names = (1..).map(|n| match n {
        1 => NAME.to_owned(),
        n => format!("{NAME}_{n}"),
    });
    let mut name = || {
        names
            .find(|name| !taken.contains(name))
            .expect("endless names")
    };
    likes.iter().map(|&like| (like, name())).collect()
}

/// Appends the places of the vertices of a chart in an image of this size. Returns their rows.
fn append_places(
    attributes: &mut Attributes,
    chart: &Chart<'_>,
    corner: [usize; 2],
    size: [usize; 2],
) -> BTreeMap<u32, u32> {
    let is_down = attributes.texture_is_down;
    let columns = Arc::make_mut(&mut attributes.texture);
    let first = row_count(columns) as u32;
    for place in chart.places.values() {
        let [u, down] = [0, 1].map(|k| (corner[k] as f64 + place[k]) / size[k] as f64);
        let numbers = [u, if is_down { down } else { 1.0 - down }];
        // few digits in a text file: less than a hundredth of a texel
        let numbers = numbers.map(|x| (x * 1e6).round() / 1e6);
        for (column, number) in columns.iter_mut().zip(numbers.into_iter().chain([0.0])) {
            column.numbers.push(number);
        }
    }
    chart.places.keys().copied().zip(first..).collect()
}

/// Gives faces a material.
fn retag(attributes: &mut Attributes, faces: Range<usize>, material: &str) {
    let all = &mut attributes.tags;
    if all.is_empty() {
        all.push(FaceTag::default());
    }
    for data in [&mut attributes.faces, &mut attributes.non_orientable] {
        data.tags.resize(data.texture.len() / 3, 0);
    }
    let mut new: BTreeMap<u32, u32> = BTreeMap::new();
    for tag in &mut attributes.faces.tags[faces] {
        *tag = *new.entry(*tag).or_insert_with(|| {
            let tag = FaceTag {
                material: material.to_owned(),
                ..all[*tag as usize].clone()
            };
            let known = all.iter().position(|other| *other == tag);
            known.unwrap_or_else(|| {
                all.push(tag);
                all.len() - 1
            }) as u32
        });
    }
}
