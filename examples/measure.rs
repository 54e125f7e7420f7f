//! Measures a filled surface: energies, curvatures, triangles, and the distance to another surface.

use std::error::Error;

use meniscus::analysis::{AnalysisOptions, analyze};
use meniscus::mesh::{self, Mesh};
use meniscus::shapes::{Sample, icosphere};

fn main() -> Result<(), Box<dyn Error>> {
    let sample = Sample::named("sphere").ok_or("no such sample")?;
    let (holed, _) = mesh::build(&sample.soup())?;
    let filled = meniscus::fill(&holed)?.mesh;
    let (positions, triangles) = icosphere(30);
    let sphere = Mesh::from_triangles(positions, &triangles)?;
    let found = analyze(
        &filled,
        &AnalysisOptions {
            reference: Some(&sphere),
            ..AnalysisOptions::default()
        },
    );
    let energies = &found.shape.energies;
    println!("area {:.5} of the limit surface", found.shape.area);
    println!(
        "∫ H² dA = {:.5}, ∫ K dA = {:.5}",
        energies.willmore, energies.total_curvature
    );
    println!(
        "genus {}, {} boundary loops",
        found.shape.genus, found.shape.boundary_loops
    );
    println!(
        "everything as JSON:\n{}",
        serde_json::to_string_pretty(&found)?
    );
    Ok(())
}
