//! `meniscus info`.

use std::fmt::Write as _;
use std::path::PathBuf;

use anyhow::Result;
use clap::Args;
use serde::Serialize;

use crate::cli::print::{largest, print};
use crate::io::open_welded;
use crate::mesh::{
    BoundaryLoop, ComponentReport, Defect, DefectKind, LoadReport, LoopId, Weld, boundary_loops,
};
use crate::warning::{Place, counted};

/// `meniscus info`.
#[derive(Debug, Args)]
pub struct InfoArguments {
    /// The mesh to read (.obj, .ply, .stl, .off, .glb, .gltf, .3mf).
    #[arg(value_name = "IN")]
    pub input: PathBuf,
    /// The distance within which vertices of IN count as one: auto (the rounding of its numbers) or a
    /// length.
    #[arg(long, value_name = "WELD", default_value = "auto", display_order = 999)]
    pub weld: Weld,
    /// Print JSON.
    #[arg(long)]
    pub json: bool,
}

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
    number: LoopId,
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
            number: l.id,
            edges: l.edges(),
            perimeter: l.perimeter,
            diameter: l.diameter,
            radius: l.radius,
            centroid: l.centroid.to_array(),
            component: l.component,
            outer_rim: l.is_outer_boundary,
            reason: &l.reason,
        }
    }
}

/// Runs `meniscus info`.
pub fn info(args: &InfoArguments) -> Result<()> {
    let opened = open_welded(&args.input, args.weld)?;
    let loops = boundary_loops(&opened.mesh);
    let info = Info {
        version: env!("CARGO_PKG_VERSION"),
        input: args.input.display().to_string(),
        load: &opened.report,
        loops: loops.iter().map(LoopInfo::from).collect(),
    };
    if args.json {
        let mut text = serde_json::to_string_pretty(&info)?;
        text.push('\n');
        return print(&text);
    }
    print(&text(&info)?)
}

/// The report as plain text.
fn text(info: &Info<'_>) -> Result<String, std::fmt::Error> {
    let r = info.load;
    let mut out = String::new();
    writeln!(out, "{}", info.input)?;
    writeln!(
        out,
        "  {} vertices, {} faces in the file",
        r.file_vertices, r.file_faces
    )?;
    writeln!(
        out,
        "  {} vertices, {} triangles in the mesh",
        r.vertices, r.faces
    )?;
    components(&mut out, &r.components)?;
    for line in &r.attributes {
        writeln!(out, "  {line}")?;
    }
    for note in &r.notes {
        writeln!(out, "  {note}")?;
    }
    defects(&mut out, &r.defects)?;
    loops(&mut out, &info.loops)?;
    Ok(out)
}

/// Maximum number of components and loops that are listed. A scan may have hundreds of loose triangles.
const MAX_LISTED: usize = 40;

fn components(out: &mut String, all: &[ComponentReport]) -> std::fmt::Result {
    let (listed, others) = largest(all, MAX_LISTED, |c| c.faces);
    for (i, c) in listed {
        let one_sided = if c.orientable {
            ""
        } else {
            ", non-orientable (not filled)"
        };
        writeln!(
            out,
            "  component {i}: {} faces, {} vertices, {} boundary loops, Euler number {}{one_sided}",
            c.faces, c.vertices, c.loops, c.euler
        )?;
    }
    match others.iter().map(|c| c.faces).max() {
        Some(most) => writeln!(
            out,
            "  {} more components of at most {} (--json lists them)",
            others.len(),
            counted(most, "face", "faces")
        ),
        None => Ok(()),
    }
}

/// Maximum number of places of defects of one kind that are listed.
const MAX_PLACES: usize = 3;

/// The kinds of defects with some places.
fn defects(out: &mut String, all: &[Defect]) -> std::fmt::Result {
    let mut kinds: Vec<DefectKind> = all.iter().map(|d| d.kind).collect();
    kinds.sort_unstable();
    kinds.dedup();
    for kind in kinds {
        let of_kind: Vec<&Defect> = all.iter().filter(|d| d.kind == kind).collect();
        write!(out, "  {}: at", kind.words())?;
        for d in of_kind.iter().take(MAX_PLACES) {
            write!(out, " {}", Place(d.position))?;
        }
        if of_kind.len() > MAX_PLACES {
            write!(out, " and other places (--json lists more)")?;
        }
        out.push('\n');
    }
    Ok(())
}

fn loops(out: &mut String, all: &[LoopInfo<'_>]) -> std::fmt::Result {
    if all.is_empty() {
        return writeln!(out, "  no boundary loops: the mesh is closed");
    }
    writeln!(out, "  loop   edges    perimeter     diameter  centroid")?;
    let (listed, others) = largest(all, MAX_LISTED, |l| l.edges);
    for (_, l) in listed {
        let [x, y, z] = l.centroid;
        write!(
            out,
            "  {:>4}  {:>6}  {:>11.5e}  {:>11.5e}  ({x:.5}, {y:.5}, {z:.5})",
            l.number, l.edges, l.perimeter, l.diameter
        )?;
        if l.outer_rim {
            write!(out, "  outer boundary: {}", l.reason)?;
        }
        out.push('\n');
    }
    let Some(most) = others.iter().map(|l| l.edges).max() else {
        return Ok(());
    };
    let outer = others.iter().filter(|l| l.outer_rim).count();
    writeln!(
        out,
        "  {} more loops of at most {}, {outer} of them outer boundaries (--json lists them)",
        others.len(),
        counted(most, "edge", "edges")
    )
}
