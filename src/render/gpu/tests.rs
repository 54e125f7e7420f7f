use super::*;
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
        panic!("{name} is no struct");
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
        choice
    );
    assert_eq!(members, ours);
    assert_eq!(span as usize, size_of::<Frame>());
}
