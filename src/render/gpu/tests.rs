use super::*;
use crate::render::{Vertex, ViewMode};
use naga::valid::{Capabilities, ValidationFlags, Validator};

/// The module, parsed and validated.
fn module(text: &str) -> naga::Module {
    let module =
        naga::front::wgsl::parse_str(text).unwrap_or_else(|e| panic!("{}", e.emit_to_string(text)));
    Validator::new(ValidationFlags::all(), Capabilities::empty())
        .validate(&module)
        .unwrap_or_else(|e| panic!("{}", e.emit_to_string(text)));
    module
}

#[test]
fn shaders_are_valid() {
    let scene = module(&shaders::scene());
    let names: Vec<&str> = scene.entry_points.iter().map(|e| e.name.as_str()).collect();
    assert_eq!(
        names,
        [
            "vs_ground",
            "fs_ground",
            "vs_surface",
            "fs_surface",
            "vs_line",
            "vs_wire",
            "vs_seam",
            "fs_casing",
            "fs_core",
            "fs_hidden"
        ]
    );
    module(shaders::composite());
}

/// Names and offsets of a struct of a module.
fn layout(module: &naga::Module, name: &str) -> (Vec<(String, u32)>, u32) {
    let (_, found) = module
        .types
        .iter()
        .find(|(_, t)| t.name.as_deref() == Some(name))
        .expect("the struct");
    let naga::TypeInner::Struct { members, span } = &found.inner else {
        panic!("{name} is not a struct");
    };
    let members = members
        .iter()
        .map(|m| (m.name.clone().unwrap_or_default(), m.offset))
        .collect();
    (members, *span)
}

macro_rules! offsets {
    ($type:ty, $($field:ident),+) => {
        vec![$((stringify!($field).to_owned(), std::mem::offset_of!($type, $field) as u32)),+]
    };
}

#[test]
fn uniforms_have_the_layout_of_the_shaders() {
    let (members, span) = layout(&module(&shaders::scene()), "Frame");
    let ours = offsets!(
        Frame,
        clip_from_scaled,
        right,
        up,
        back,
        eye,
        light,
        range,
        size,
        tile,
        ground_top,
        ground_bottom,
        wire,
        cut,
        choice
    );
    assert_eq!(members, ours);
    assert_eq!(span as usize, size_of::<Frame>());
}

/// Locations of a struct of a module by name.
fn locations(module: &naga::Module, name: &str) -> Vec<(String, u32)> {
    let (_, found) = module
        .types
        .iter()
        .find(|(_, t)| t.name.as_deref() == Some(name))
        .expect("the struct");
    let naga::TypeInner::Struct { members, .. } = &found.inner else {
        panic!("{name} is not a struct");
    };
    let location = |m: &naga::StructMember| match m.binding {
        Some(naga::Binding::Location { location, .. }) => location,
        _ => panic!("{:?} has no location", m.name),
    };
    members
        .iter()
        .map(|m| (m.name.clone().unwrap_or_default(), location(m)))
        .collect()
}

#[test]
fn vertices_have_the_layout_of_the_shaders() {
    let scene = module(&shaders::scene());
    for (name, ours, attributes) in [
        (
            "SurfaceVertex",
            offsets!(
                Vertex, position, normal, mean, gauss, deviation, flags, color, uv
            ),
            &pipelines::VERTEX[..],
        ),
        (
            "Segment",
            offsets!(cache::Segment, start, end, color, width),
            &pipelines::SEGMENT[..],
        ),
    ] {
        let theirs = locations(&scene, name);
        assert_eq!(theirs.len(), ours.len());
        for ((a, location), (b, offset)) in theirs.iter().zip(&ours) {
            assert_eq!(&a.replace("colour", "color"), b);
            let attribute = attributes.iter().find(|x| x.shader_location == *location);
            let attribute = attribute.expect("an attribute for each location");
            assert_eq!(attribute.offset, u64::from(*offset), "{name}.{b}");
        }
    }
}

/// The value of an unsigned constant.
fn constant(module: &naga::Module, name: &str) -> u32 {
    let (_, found) = module
        .constants
        .iter()
        .find(|(_, c)| c.name.as_deref() == Some(name))
        .expect(name);
    match module.global_expressions[found.init] {
        naga::Expression::Literal(naga::Literal::U32(value)) => value,
        ref other => panic!("{name}: {other:?}"),
    }
}

#[test]
fn modes_and_flags_have_the_numbers_of_the_shaders() {
    let scene = module(&shaders::scene());
    for (name, mode) in [
        ("SHADED", ViewMode::Shaded),
        ("COLOUR", ViewMode::Color),
        ("ISOPHOTES", ViewMode::Isophotes),
        ("ZEBRA", ViewMode::Zebra),
        ("MEAN", ViewMode::Mean),
        ("GAUSS", ViewMode::Gauss),
        ("K1", ViewMode::K1),
        ("K2", ViewMode::K2),
        ("DEVIATION", ViewMode::Deviation),
        ("DISTANCE", ViewMode::Distance),
    ] {
        assert_eq!(constant(&scene, name), mode as u32, "{name}");
    }
    for (name, flag) in [
        ("PATCH", Vertex::PATCH),
        ("ILL_POSED", Vertex::ILL_POSED),
        ("SELECTED", Vertex::SELECTED),
        ("CURVATURE", Vertex::CURVATURE),
        ("DEVIATION_KNOWN", Vertex::DEVIATION),
        ("DISTANCE_KNOWN", Vertex::DISTANCE),
        ("TEXTURED", Vertex::TEXTURED),
    ] {
        assert_eq!(constant(&scene, name), flag, "{name}");
    }
}
