//! One hole with custom energies: `(H - H0)²` favours spheres of mean curvature H0.

use std::error::Error;

use meniscus::Fill;
use meniscus::fill::LoopChoice;
use meniscus::mesh::{self, boundary_loops};
use meniscus::shapes::Sample;

fn main() -> Result<(), Box<dyn Error>> {
    let sample = Sample::named("sphere").ok_or("no such sample")?;
    let (sphere, _) = mesh::build(&sample.soup())?;
    let first = LoopChoice::Listed(vec![boundary_loops(&sphere)[0].id]);
    // the sphere has radius 1 and outward normals: H = -1
    for h0 in [-0.5, -1.0, -1.5] {
        let fill = Fill::new(&sphere).loops(first.clone()).param("H0", h0);
        let filled = fill.energy("(H-H0)^2 + 0.1*K^2")?.run()?;
        let new = &filled.mesh.positions[sphere.vertex_count()..];
        let farthest = new.iter().map(|p| p.length()).fold(0.0, f64::max);
        println!("H0 = {h0}: the patch reaches {farthest:.4} from the centre");
    }
    // the message marks the position of an error
    if let Err(error) = Fill::new(&sphere).energy("H^2 + k1") {
        println!("{error}");
    }
    Ok(())
}
