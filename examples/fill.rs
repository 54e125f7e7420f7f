//! Fills all holes of a mesh, or of a sample: `cargo run --example fill -- scan.obj filled.obj`.

use std::error::Error;
use std::path::Path;

use meniscus::io;
use meniscus::mesh::{self, boundary_loops};
use meniscus::shapes::Sample;

fn main() -> Result<(), Box<dyn Error>> {
    let files: Vec<String> = std::env::args().skip(1).collect();
    let mesh = match files.first() {
        Some(input) => io::open(Path::new(input))?.mesh,
        None => mesh::build(&Sample::named("creature").ok_or("no such sample")?.soup())?.0,
    };
    let filled = meniscus::fill(&mesh)?;
    println!(
        "{} loops before, {} after; {} vertices more, in {:.0} ms",
        boundary_loops(&mesh).len(),
        boundary_loops(&filled.mesh).len(),
        filled.vertices_added(),
        filled.milliseconds
    );
    if !filled.complete() {
        println!("some holes are open or did not converge");
    }
    if let Some(output) = files.get(1) {
        io::save_mesh(Path::new(output), &filled.mesh)?;
    }
    Ok(())
}
