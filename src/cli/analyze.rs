//! `meniscus analyze`.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::PathBuf;

use anyhow::Result;
use clap::Args;

use crate::analysis::{
    Analysis, AnalysisOptions, ChainReport, Plane, Range, Vertices, analyze as measure,
    measures_csv, patch_rims, report_json, sections_csv, sharp_edges, vertices_csv,
};
use crate::cli::UsageError;
use crate::cli::flow::write_text;
use crate::cli::hints::invalid_energy;
use crate::cli::parse::{parameter, plane};
use crate::cli::print::print;
use crate::cli::targets::check_targets;
use crate::energy::Energy;
use crate::io::{open, open_welded};
use crate::mesh::{LoadReport, Weld};

/// `meniscus analyze`.
#[derive(Debug, Args)]
pub struct AnalyzeArguments {
    /// The mesh to measure (.obj, .ply, .stl, .off, .glb, .gltf, .3mf).
    #[arg(value_name = "IN")]
    pub input: PathBuf,
    /// The distance within which vertices of IN count as one: auto (the rounding of its numbers) or a
    /// length.
    #[arg(long, value_name = "WELD", default_value = "auto", display_order = 999)]
    pub weld: Weld,
    /// An energy f(H,K) to integrate in addition to the standard ones.
    #[arg(long, value_name = "F", allow_hyphen_values = true)]
    pub energy: Option<String>,
    /// The value of a parameter in the energy (repeatable).
    #[arg(long, value_name = "NAME=VALUE", value_parser = parameter)]
    pub param: Vec<(String, f64)>,
    /// Measure the distances to and from this mesh.
    #[arg(long, value_name = "REF")]
    pub against: Option<PathBuf>,
    /// The number of original faces, which come first. The faces after them are patches. The
    /// boundary between the two is measured. For an output of `fill` this is the number of faces of
    /// its input.
    #[arg(long, value_name = "N")]
    pub first_faces: Option<usize>,
    /// Measure along the edges with a larger dihedral angle than this, in degrees.
    #[arg(long, value_name = "DEG")]
    pub edge_angle: Option<f64>,
    /// Treat the vertices as points of the limit surface, not as control points.
    #[arg(long)]
    pub on_surface: bool,
    /// Print JSON.
    #[arg(long)]
    pub json: bool,
    /// Write the curvatures (and distances) of all vertices as CSV.
    #[arg(long, value_name = "FILE.csv")]
    pub csv: Option<PathBuf>,
    /// Write all measures as CSV, one per line.
    #[arg(long, value_name = "FILE.csv")]
    pub measures: Option<PathBuf>,
    /// Cut the limit surface by a plane, given by a point and a normal (repeatable). The report
    /// contains the curves and their curvatures.
    #[arg(long, value_name = "X,Y,Z,NX,NY,NZ", value_parser = plane, allow_hyphen_values = true)]
    pub section: Vec<Plane>,
    /// Write the points of all sections as CSV.
    #[arg(long, value_name = "FILE.csv", requires = "section")]
    pub section_csv: Option<PathBuf>,
}

/// Runs `meniscus analyze`.
pub fn analyze(args: &AnalyzeArguments) -> Result<()> {
    check_targets(
        &[
            ("IN", Some(&args.input)),
            ("--against", args.against.as_deref()),
        ],
        &[],
        &[
            ("--csv", args.csv.as_deref()),
            ("--measures", args.measures.as_deref()),
            ("--section-csv", args.section_csv.as_deref()),
        ],
    )?;
    let params: BTreeMap<String, f64> = args.param.iter().cloned().collect();
    let energy = args
        .energy
        .as_deref()
        .map(|text| Energy::parse(text, &params));
    let energy = energy.transpose().map_err(|e| invalid_energy(&e))?;
    let opened = open_welded(&args.input, args.weld)?;
    let reference = args.against.as_deref().map(open).transpose()?;
    let mesh = &opened.mesh;
    let mut chains = Vec::new();
    if let Some(first) = args.first_faces {
        if first > mesh.face_count() {
            return Err(UsageError(format!(
                "--first-faces is {first}, but the mesh has only {} faces",
                mesh.face_count()
            ))
            .into());
        }
        let is_patch: Vec<bool> = (0..mesh.face_count()).map(|f| f >= first).collect();
        chains.extend(patch_rims(mesh, &is_patch, false));
    }
    if let Some(angle) = args.edge_angle {
        chains.extend(sharp_edges(mesh, angle.to_radians()));
    }
    let vertices = if args.on_surface {
        Vertices::OnSurface
    } else {
        Vertices::Control
    };
    let options = AnalysisOptions {
        vertices,
        energy,
        chains,
        reference: reference.as_ref().map(|r| &r.mesh),
        planes: args.section.clone(),
    };
    let analysis = measure(mesh, &options);
    if let Some(path) = &args.csv {
        write_text(path, &vertices_csv(mesh, vertices, &analysis))?;
    }
    if let Some(path) = &args.measures {
        write_text(path, &measures_csv(&analysis))?;
    }
    if let Some(path) = &args.section_csv {
        write_text(path, &sections_csv(&analysis.sections))?;
    }
    let input = args.input.display().to_string();
    if args.json {
        return print(&report_json(&input, Some(&opened.report), &analysis)?);
    }
    print(&text(&input, &opened.report, &analysis)?)
}

/// The report as plain text.
fn text(input: &str, report: &LoadReport, analysis: &Analysis) -> Result<String, std::fmt::Error> {
    let mut out = String::new();
    let (s, q) = (&analysis.shape, &analysis.quality);
    writeln!(out, "{input}")?;
    writeln!(
        out,
        "  {} vertices, {} faces, {} edges; {} components, {} boundary loops, Euler number {}, genus {}",
        s.vertices, s.faces, s.edges, s.components, s.boundary_loops, s.euler, s.genus
    )?;
    for line in report.attributes.iter().chain(&report.notes) {
        writeln!(out, "  {line}")?;
    }
    writeln!(
        out,
        "  triangles: area {:.6e}{}; limit surface: area {:.6e}{}",
        s.mesh_area,
        volume(s.mesh_volume),
        s.area,
        volume(s.volume)
    )?;
    let e = &s.energies;
    writeln!(
        out,
        "  energies: H^2 {:.6e}, K {:.6e}, K^2 {:.6e}, k1^2+k2^2 {:.6e}",
        e.willmore, e.total_curvature, e.gauss_squared, e.bending
    )?;
    if let Some(given) = e.given {
        writeln!(out, "  given energy: {given:.6e}")?;
    }
    for (name, range) in analysis.curvature.named() {
        writeln!(out, "  {}", curvature_line(name, range))?;
    }
    writeln!(
        out,
        "  triangles: angles {:.2} to {:.2} degrees, {} below 10, {} with zero area; edges {:.4e} \
         to {:.4e}",
        q.min_angle, q.max_angle, q.slivers, q.degenerate, q.edge_length[0], q.edge_length[2]
    )?;
    writeln!(
        out,
        "  {} self-intersections, {} folded edges, maximum dihedral angle {:.2} degrees",
        q.self_intersections, q.folded_edges, q.max_dihedral
    )?;
    for chain in &analysis.chains {
        chain_lines(&mut out, chain)?;
    }
    for (n, section) in analysis.sections.iter().enumerate() {
        for curve in &section.curves {
            let known = curve.points.iter().map(|p| p.averaged);
            let (low, high) = known
                .filter(|k| k.is_finite())
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), k| {
                    (a.min(k), b.max(k))
                });
            let kind = if curve.closed { "closed" } else { "open" };
            writeln!(
                out,
                "  section {}: {kind} curve of {} points, length {:.6e}, curvature {low:.4e} to {high:.4e}",
                n + 1,
                curve.points.len(),
                curve.length
            )?;
        }
        if section.curves.is_empty() {
            writeln!(
                out,
                "  section {}: the plane does not meet the surface",
                n + 1
            )?;
        }
    }
    if let Some(d) = &analysis.distances {
        for (name, one) in [("to", &d.to_reference), ("from", &d.from_reference)] {
            let [x, y, z] = one.max_at;
            writeln!(
                out,
                "  distance {name} the reference: RMS {:.4e}, mean {:.4e}, maximum {:.4e} at \
                 ({x:.5}, {y:.5}, {z:.5})",
                one.rms, one.mean, one.max
            )?;
        }
    }
    Ok(out)
}

fn volume(volume: Option<f64>) -> String {
    volume.map_or_else(String::new, |v| format!(", volume {v:.6e}"))
}

fn curvature_line(name: &str, r: &Range) -> String {
    let h = &r.histogram;
    format!(
        "{name:>2}: {:.4e} to {:.4e}, 98 % of the area {:.4e} to {:.4e}, mean {:.4e}, deviation \
         {:.4e}",
        r.min, r.max, h.from, h.to, r.average, r.deviation
    )
}

fn chain_lines(out: &mut String, chain: &ChainReport) -> std::fmt::Result {
    let kind = if chain.smooth_by_construction {
        "inside one limit surface: gap and angle are zero by construction"
    } else {
        "crease: both sides evaluated separately"
    };
    writeln!(out, "  {} ({} edges; {kind})", chain.name, chain.edges)?;
    for (name, s) in [
        ("gap", &chain.gap),
        ("angle between normals, degrees", &chain.normal_angle),
        ("dihedral angle of triangles, degrees", &chain.dihedral),
        ("jump of H", &chain.curvature_jump),
        (
            "difference of H between neighbouring faces",
            &chain.curvature_step,
        ),
    ] {
        let [x, y, z] = s.max_at;
        writeln!(
            out,
            "    {name}: {:.3e} to {:.3e}, mean {:.3e}, maximum at ({x:.5}, {y:.5}, {z:.5})",
            s.min, s.max, s.mean
        )?;
    }
    Ok(())
}
