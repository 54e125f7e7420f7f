//! Joins the rims of three tubes by one smooth patch.

use std::error::Error;

use meniscus::Fill;
use meniscus::mesh::{self, boundary_loops, components};
use meniscus::shapes::Sample;

fn main() -> Result<(), Box<dyn Error>> {
    let sample = Sample::named("three-y").ok_or("no such sample")?;
    let (tubes, _) = mesh::build(&sample.soup())?;
    // the three rims; the outer ends of the tubes are classified as outer boundaries
    let blended = Fill::new(&tubes).joined().energy("H^2+K^2")?.run()?;
    println!(
        "{} pieces with {} boundary loops became {} with {}",
        components(&tubes.topology).count,
        boundary_loops(&tubes).len(),
        components(&blended.mesh.topology).count,
        boundary_loops(&blended.mesh).len()
    );
    for group in blended.groups {
        let outcome = group?.outcome;
        println!(
            "{} steps, energy {:.4} at the start and {:.4} at the end",
            outcome.steps, outcome.energy_start, outcome.energy_end
        );
    }
    Ok(())
}
