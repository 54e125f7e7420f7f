//! Each stage of a level polls whether its run was cancelled, and ends early if it was.

use std::sync::Arc;

use crate::cancel::tests::is_polled;
use crate::mesh::Mesh;
use crate::refine::{Method, RefineControls, refine};
use crate::runner::Recording;
use crate::shapes;

#[test]
fn levels_are() {
    let (positions, triangles) = shapes::icosphere(4);
    let mesh = Arc::new(Mesh::from_triangles(positions, &triangles).expect("a manifold"));
    let controls = RefineControls {
        method: Method::Pde,
        levels: 2,
        ..RefineControls::default()
    };
    let recording = Recording::default();
    // the start of each level, each step, and within a step before the matrix is factorized
    is_polled(20, || {
        let options = controls.clone().into();
        refine(Arc::clone(&mesh), options, &recording, &mut |_| true).is_ok()
    });
}
