//! `meniscus info`.

use anyhow::Result;
use serde::Serialize;

use crate::cli::args::InfoArguments;
use crate::cli::open::open;
use crate::mesh::{BoundaryLoop, LoadReport, boundary_loops};

#[derive(Serialize)]
struct Info<'a> {
    version: &'static str,
    input: String,
    #[serde(flatten)]
    load: &'a LoadReport,
    loops: Vec<LoopInfo<'a>>,
}

#[derive(Serialize)]
struct LoopInfo<'a> {
    number: usize,
    edges: usize,
    perimeter: f64,
    diameter: f64,
    radius: f64,
    centroid: [f64; 3],
    component: u32,
    outer_rim: bool,
    reason: &'a str,
}

impl<'a> From<&'a BoundaryLoop> for LoopInfo<'a> {
    fn from(l: &'a BoundaryLoop) -> Self {
        Self {
            number: l.number,
            edges: l.edges(),
            perimeter: l.perimeter,
            diameter: l.diameter,
            radius: l.radius,
            centroid: l.centroid.to_array(),
            component: l.component,
            outer_rim: l.outer_rim,
            reason: &l.reason,
        }
    }
}

/// Runs the command.
pub fn info(args: &InfoArguments) -> Result<()> {
    let opened = open(&args.input)?;
    let loops = boundary_loops(&opened.mesh);
    let info = Info {
        version: env!("CARGO_PKG_VERSION"),
        input: args.input.display().to_string(),
        load: &opened.report,
        loops: loops.iter().map(LoopInfo::from).collect(),
    };
    if args.json {
        println!("{}", serde_json::to_string_pretty(&info)?);
        return Ok(());
    }
    let r = &opened.report;
    println!("{}", info.input);
    println!(
        "  {} vertices, {} faces in the file",
        r.file_vertices, r.file_faces
    );
    println!("  {} vertices, {} triangles as a mesh", r.vertices, r.faces);
    for (i, c) in r.components.iter().enumerate() {
        println!(
            "  component {i}: {} faces, {} vertices, {} boundary loops, Euler number {}{}",
            c.faces,
            c.vertices,
            c.loops,
            c.euler,
            if c.orientable {
                ""
            } else {
                ", one-sided (left alone)"
            }
        );
    }
    for note in &r.notes {
        println!("  {note}");
    }
    for d in &r.defects {
        let p = d.position;
        println!("  defect {:?} at ({}, {}, {})", d.kind, p.x, p.y, p.z);
    }
    if info.loops.is_empty() {
        println!("  no boundary loops: closed");
    } else {
        println!("  loop   edges    perimeter     diameter  centroid");
    }
    for l in &info.loops {
        println!(
            "  {:>4}  {:>6}  {:>11.5e}  {:>11.5e}  ({:.5}, {:.5}, {:.5}){}",
            l.number,
            l.edges,
            l.perimeter,
            l.diameter,
            l.centroid[0],
            l.centroid[1],
            l.centroid[2],
            if l.outer_rim {
                format!("  outer rim? {}", l.reason)
            } else {
                String::new()
            }
        );
    }
    Ok(())
}
