//! Observes the steps of a flow and ends it early.

use std::error::Error;

use meniscus::Fill;
use meniscus::fill::LoopChoice;
use meniscus::mesh::{self, boundary_loops};
use meniscus::shapes::Sample;

fn main() -> Result<(), Box<dyn Error>> {
    let sample = Sample::named("torus").ok_or("no such sample")?;
    let (torus, _) = mesh::build(&sample.soup())?;
    let first = LoopChoice::Listed(vec![boundary_loops(&torus)[0].id]);
    let filled = Fill::new(&torus)
        .loops(first)
        .on_step(|step| {
            println!(
                "step {:>2}: energy {:.6}, residual {:.1e}{}",
                step.step,
                step.energy,
                step.residual,
                if step.is_rejected() { ", rejected" } else { "" }
            );
            step.is_rejected() || step.residual >= 1e-3
        })
        .run()?;
    for group in filled.groups {
        println!("ended: {:?}", group?.outcome.end);
    }
    Ok(())
}
