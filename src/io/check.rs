//! Checks of a mesh for a format, and losses of a format.

use std::borrow::Cow;

use super::companions::materials;
use super::threemf::{self, Sheet};
use super::{Format, MeshFault, OutputMesh, gltf, off};
use crate::mesh::{Attributes, Colors, Column, DVec3, FaceTag, NO_VALUE, NumberType, row_count};

/// Checks that `mesh` can be written in `format`: finite coordinates, indices in range, attribute
/// arrays of the right length.
///
/// # Errors
/// The first [`MeshFault`].
pub fn check(format: Format, mesh: &OutputMesh<'_>) -> Result<(), MeshFault> {
    let vertices = mesh.positions.len();
    let triangles = mesh.triangles.len();
    for (what, count) in [("vertices", vertices), ("triangles", triangles)] {
        if u32::try_from(count).is_err() {
            return Err(MeshFault::TooMany { what, count });
        }
    }
    for (vertex, p) in mesh.positions.iter().enumerate() {
        for value in p.to_array() {
            if !value.is_finite() {
                return Err(MeshFault::NotFinite { vertex, value });
            }
            if format.is_single() && !(value as f32).is_finite() {
                return Err(MeshFault::BeyondSingle { vertex, value });
            }
        }
    }
    for (triangle, corners) in mesh.triangles.iter().enumerate() {
        for &index in corners {
            if index as usize >= vertices {
                return Err(MeshFault::IndexRange {
                    triangle,
                    index,
                    vertices,
                });
            }
        }
    }
    let all = mesh.attributes;
    let column = |what, column: &Column, wanted| (what, column.numbers.len(), wanted);
    let of_vertices = all.vertices.iter();
    let of_faces = all.faces.columns.iter();
    let lists = [
        ("face tags", all.faces.tags.len(), triangles),
        (
            "texture coordinates of corners",
            all.faces.texture.len(),
            3 * triangles,
        ),
        ("normals of corners", all.faces.normals.len(), 3 * triangles),
    ];
    let lengths = (lists.into_iter().filter(|list| list.1 != 0))
        .chain(of_vertices.map(|c| column("vertex properties", c, vertices)))
        .chain(of_faces.map(|c| column("face properties", c, triangles)));
    for (what, found, wanted) in lengths {
        if found != wanted {
            return Err(MeshFault::Attribute {
                what,
                found,
                wanted,
            });
        }
    }
    let references = [
        ("face tag index", &all.faces.tags, all.tags.len()),
        (
            "texture coordinate index",
            &all.faces.texture,
            row_count(&all.texture),
        ),
        ("normal index", &all.faces.normals, row_count(&all.normals)),
    ];
    for (what, list, wanted) in references {
        let is_wrong = |&&index: &&u32| index as usize >= wanted && index != NO_VALUE;
        if let Some(&index) = list.iter().find(is_wrong) {
            return Err(MeshFault::Attribute {
                what,
                found: index as usize,
                wanted,
            });
        }
    }
    Ok(())
}

/// The attributes of `mesh` that a file in `format` cannot store, as messages for the user.
pub fn losses(format: Format, mesh: &OutputMesh<'_>) -> Vec<String> {
    let attributes = storable(format, mesh);
    let stored = OutputMesh {
        attributes: &attributes,
        ..*mesh
    };
    let sheet = (format == Format::ThreeMf).then(|| Sheet::of(&stored));
    let mut lost = other_losses(format, &stored, sheet.as_ref());
    let has_no_images = matches!(format, Format::Stl | Format::Off);
    if has_no_images && !mesh.attributes.own_materials.is_empty() {
        lost.push(format!(
            "{} cannot store texture images of patches and samples, whose faces get no texture \
             coordinates; write OBJ, PLY, glTF or 3MF",
            name(format)
        ));
    }
    lost
}

/// The attributes in the form in which a format stores them, except the direction of texture coordinates: without
/// own materials where it has none (those of a PLY file have become numbers of images beside it), with materials
/// instead of numbers of images, and with texture coordinates of corners instead of those of vertices where the format
/// has no such columns.
pub(super) fn storable<'a>(format: Format, mesh: &OutputMesh<'a>) -> Cow<'a, Attributes> {
    let mut all = Cow::Borrowed(mesh.attributes);
    if !format.has_materials() && !all.own_materials.is_empty() {
        all = Cow::Owned(all.without_own_materials(mesh.triangles));
    }
    let is_embedded = matches!(format, Format::Glb | Format::Gltf | Format::ThreeMf);
    if is_embedded && let Some(numbered) = all.with_numbered_materials() {
        all = Cow::Owned(numbered);
    }
    let triangles = mesh.triangles.iter().copied();
    if matches!(format, Format::Obj | Format::ThreeMf)
        && let Some(mut of_corners) = all.with_texture_of_corners(triangles, &[])
    {
        let Attributes {
            vertices, texture, ..
        } = &mut of_corners;
        vertices.retain(|column| texture.iter().all(|other| other.name != column.name));
        all = Cow::Owned(of_corners);
    }
    all
}

/// The name of a format in messages.
fn name(format: Format) -> &'static str {
    match format {
        Format::Obj => "OBJ",
        Format::Ply => "PLY",
        Format::Stl => "STL",
        Format::Off => "OFF",
        Format::Glb | Format::Gltf => "glTF",
        Format::ThreeMf => "3MF",
    }
}

/// The losses of a mesh with [`storable`] attributes. A 3MF file has a sheet.
pub(super) fn other_losses(
    format: Format,
    mesh: &OutputMesh<'_>,
    sheet: Option<&Sheet<'_>>,
) -> Vec<String> {
    let name = name(format);
    let mut lost = Vec::new();
    let all = mesh.attributes;
    let colors = Colors::of(&all.vertices);
    let is_gltf = matches!(format, Format::Glb | Format::Gltf);
    let of_gltf = gltf::vertex_columns(all);
    if format == Format::Stl && colors.is_some() {
        lost.push("STL cannot store colours".to_owned());
    }
    let is_color = |k: usize| colors.is_some_and(|c| c.channels.contains(&k) || c.alpha == Some(k));
    let is_lost = |(k, column): &(usize, &Column)| match format {
        Format::Obj => !is_color(*k) && (column.is_typed || column.name != "w"),
        Format::Ply => false,
        Format::Stl | Format::ThreeMf => !is_color(*k),
        Format::Off => !is_color(*k) && !off::VERTEX_NUMBERS.contains(&column.name.as_str()),
        Format::Glb | Format::Gltf => !is_color(*k) && !of_gltf.contains(k),
    };
    let columns = all.vertices.iter().enumerate().filter(is_lost);
    let names: Vec<&str> = columns.map(|(_, column)| column.name.as_str()).collect();
    if !names.is_empty() {
        lost.push(format!(
            "{name} cannot store vertex properties: {}",
            names.join(", ")
        ));
    }
    if let (Format::Obj, Some(alpha)) = (format, colors.and_then(|c| c.alpha))
        && all.vertices[alpha].is_typed
        && all.vertex_colors().iter().any(|c| c[3] != 1.0)
    {
        lost.push("OBJ cannot store transparency".to_owned());
    }
    let off_colors = off::face_columns(&all.faces.columns);
    let of_3mf = threemf::face_columns(all);
    let is_lost = |(k, column): &(usize, &Column)| match format {
        Format::Obj | Format::Glb | Format::Gltf => true,
        Format::Ply => false,
        Format::Stl => !is_stl_attribute(column),
        Format::Off => !off_colors.iter().any(|color| std::ptr::eq(*color, *column)),
        Format::ThreeMf => !of_3mf.contains(k),
    };
    let columns = all.faces.columns.iter().enumerate().filter(is_lost);
    let names: Vec<&str> = columns.map(|(_, column)| column.name.as_str()).collect();
    if !names.is_empty() {
        lost.push(format!(
            "{name} cannot store face properties: {}",
            names.join(", ")
        ));
    }
    if format != Format::Obj && !is_gltf && !all.faces.normals.is_empty() {
        lost.push(format!("{name} cannot store normals of corners"));
    }
    if !all.faces.texture.is_empty() {
        match format {
            Format::Stl | Format::Off => {
                lost.push(format!(
                    "{name} cannot store texture coordinates of corners"
                ));
            }
            Format::Ply | Format::Glb | Format::Gltf | Format::ThreeMf if all.texture.len() > 2 => {
                lost.push(format!("{name} cannot store the third texture coordinate"));
            }
            _ => {}
        }
    }
    let is_rounded = |column: &Column| {
        let mut rows = 0..column.numbers.len();
        !column.is_typed
            && rows.any(|row| f64::from(column.numbers.get(row) as f32) != column.numbers.get(row))
    };
    if format == Format::Ply && !all.faces.texture.is_empty() && all.texture.iter().any(is_rounded)
    {
        lost.push("PLY coordinates of textures are rounded to single precision".to_owned());
    }
    if format != Format::Ply && all.texture_files().next().is_some() {
        lost.push(format!("{name} cannot store names of texture files"));
    }
    // PLY stores the groups of patches
    let is_stored = |tag: &FaceTag| {
        let group = tag.group.is_empty() || tag.patch().is_some();
        let others = [&tag.object, &tag.material, &tag.smoothing];
        let is_plain = group && others.iter().all(|name| name.is_empty());
        is_gltf || format == Format::ThreeMf || format == Format::Ply && is_plain
    };
    let mut tags = all.faces.tags.iter().map(|&tag| &all.tags[tag as usize]);
    if format != Format::Obj && !tags.all(is_stored) {
        lost.push("only OBJ, glTF and 3MF can store groups and materials".to_owned());
    }
    if is_gltf {
        lost.extend(gltf::losses(mesh, materials(mesh.attributes)));
    } else if let Some(sheet) = sheet {
        lost.extend(threemf::losses(mesh, sheet));
    } else if let Some(materials) = &all.gltf_materials {
        match format {
            Format::Obj if gltf::are_plain(materials) => {}
            Format::Obj => lost.push(
                "OBJ gets the colours and images of materials, and nothing else of them".to_owned(),
            ),
            Format::Ply => {
                lost.push("PLY gets the images of materials, and nothing else of them".to_owned());
            }
            _ => lost.push(format!(
                "{name} cannot store the colours and images of materials of glTF and 3MF"
            )),
        }
    }
    if format != Format::ThreeMf {
        let unit = (!all.unit.is_empty()).then(|| format!("the unit {}", all.unit));
        let metadata = all.metadata.iter().map(|[name, _]| name.clone());
        let given: Vec<String> = unit.into_iter().chain(metadata).collect();
        if !given.is_empty() {
            lost.push(format!("{name} cannot store {}", given.join(", ")));
        }
        if !all.objects.is_empty() {
            lost.push(format!(
                "{name} cannot store types and part numbers of objects"
            ));
        }
    }
    if format.is_single() {
        let moved = |p: &DVec3| (p.as_vec3().as_dvec3() - *p).abs().max_element();
        let moved = mesh.positions.iter().map(moved).fold(0.0, f64::max);
        if moved > 0.0 {
            lost.push(format!(
                "{name} coordinates are rounded to single precision, by up to {moved:.1e}; OBJ, PLY, OFF and 3MF keep \
                 them"
            ));
        }
        let single = |v: u32| mesh.positions[v as usize].as_vec3();
        let same = |a: u32, b: u32| {
            single(a) == single(b) && mesh.positions[a as usize] != mesh.positions[b as usize]
        };
        let collapsed = |t: &&[u32; 3]| same(t[0], t[1]) || same(t[1], t[2]) || same(t[2], t[0]);
        let count = mesh.triangles.iter().filter(collapsed).count();
        if count > 0 {
            lost.push(format!(
                "triangles that collapse in single precision: {count}; move the mesh to the \
                 origin, or write OBJ or PLY"
            ));
        }
    }
    lost
}

/// Whether a column has the attribute bytes of an STL file.
pub(super) fn is_stl_attribute(column: &Column) -> bool {
    column.name == "attribute" && column.numbers.kind() == NumberType::U16
}
