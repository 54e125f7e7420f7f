//! Refines a coarse ball: each level splits every triangle into four, on a smooth surface through
//! the input vertices.

use std::error::Error;
use std::sync::Arc;

use meniscus::mesh::Mesh;
use meniscus::refine::{self, RefineControls, RefineEvent};
use meniscus::runner::Recording;
use meniscus::shapes::icosphere;

fn main() -> Result<(), Box<dyn Error>> {
    let (positions, triangles) = icosphere(1);
    let coarse = Arc::new(Mesh::from_triangles(positions, &triangles)?);
    let controls = RefineControls {
        levels: 2,
        energy: Some("H^2".into()),
        ..RefineControls::default()
    };
    let print = &mut |event| {
        if let RefineEvent::LevelDone(level) = event {
            println!(
                "level {}: {} triangles, ∫ H² dA = {:.4} (4π = 12.5664 for a sphere)",
                level.level, level.faces, level.energy_end
            );
        }
        true
    };
    let (refined, _) = refine::refine(
        Arc::clone(&coarse),
        controls.into(),
        &Recording::default(),
        print,
    )?;
    let given = coarse.vertex_count();
    assert_eq!(refined.mesh.positions[..given], coarse.positions);
    let radii = refined.mesh.positions.iter().map(|p| p.length());
    let (low, high) = radii.fold((f64::MAX, 0.0), |(a, b), r| (r.min(a), r.max(b)));
    println!("radii from {low:.4} to {high:.4}");
    Ok(())
}
