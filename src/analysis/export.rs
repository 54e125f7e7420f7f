//! Reports as text: JSON, and tables as CSV. The command line and the window write the same texts.

use std::fmt::Write as _;

use serde::Serialize;

use crate::analysis::{
    Analysis, ChainReport, Deviation, Range, Section, Statistic, Vertices, control_points,
    vertex_curvatures,
};
use crate::mesh::{LoadReport, Mesh};

#[derive(Serialize)]
struct Output<'a> {
    version: &'static str,
    input: &'a str,
    #[serde(skip_serializing_if = "Option::is_none")]
    load: Option<&'a LoadReport>,
    #[serde(flatten)]
    analysis: &'a Analysis,
}

/// The whole report as JSON. `input` is the name of the mesh and `load` its load report (omitted
/// for a mesh without a file).
///
/// # Errors
/// Those of the serializer; there are none for these plain data.
pub fn report_json(
    input: &str,
    load: Option<&LoadReport>,
    analysis: &Analysis,
) -> serde_json::Result<String> {
    let output = Output {
        version: env!("CARGO_PKG_VERSION"),
        input,
        load,
        analysis,
    };
    Ok(serde_json::to_string_pretty(&output)? + "\n")
}

/// A line for each vertex: position, curvatures, distance to the reference if there was one.
pub fn vertices_csv(mesh: &Mesh, vertices: Vertices, analysis: &Analysis) -> String {
    let control = control_points(mesh, vertices);
    let curvatures = vertex_curvatures(&mesh.topology, &control);
    let distances = analysis
        .distances
        .as_ref()
        .map(|d| &d.to_reference.vertices);
    let mut csv = String::from("vertex,x,y,z,H,K,k1,k2,distance\n");
    for (v, (p, [h, k])) in mesh.positions.iter().zip(&curvatures).enumerate() {
        let root = (h * h - k).max(0.0).sqrt();
        let distance = distances.map_or_else(String::new, |d| format!("{:e}", d[v]));
        let (k1, k2) = (h + root, h - root);
        // writing to a String cannot fail
        let _ = writeln!(
            csv,
            "{v},{},{},{},{h:e},{k:e},{k1:e},{k2:e},{distance}",
            p.x, p.y, p.z
        );
    }
    csv
}

/// A line for each point of the sections.
pub fn sections_csv(sections: &[Section]) -> String {
    let mut csv =
        String::from("section,curve,closed,arc,x,y,z,nx,ny,nz,curvature,averaged_curvature\n");
    for (s, section) in sections.iter().enumerate() {
        for (c, curve) in section.curves.iter().enumerate() {
            for p in &curve.points {
                let ([x, y, z], [u, v, w]) = (p.at, p.normal);
                let _ = writeln!(
                    csv,
                    "{},{},{},{:e},{x},{y},{z},{u:e},{v:e},{w:e},{:e},{:e}",
                    s + 1,
                    c + 1,
                    curve.closed,
                    p.arc,
                    p.curvature,
                    p.averaged
                );
            }
        }
    }
    csv
}

/// A line for each measure: subject, name, value, position and remark.
pub fn measures_csv(analysis: &Analysis) -> String {
    let mut table = Table(String::from("of,measure,value,x,y,z,remark\n"));
    shape_rows(&mut table, analysis);
    for (name, range) in analysis.curvature.named() {
        range_rows(&mut table, name, range);
    }
    for chain in &analysis.chains {
        chain_rows(&mut table, chain);
    }
    quality_rows(&mut table, analysis);
    if let Some(d) = &analysis.distances {
        distance_rows(&mut table, "to the reference", &d.to_reference);
        distance_rows(&mut table, "from the reference", &d.from_reference);
        let of = "distance both ways";
        table.row(of, "RMS", d.rms, None, "");
        table.row(of, "max", d.max, None, "");
    }
    table.0
}

struct Table(String);

impl Table {
    fn row(&mut self, of: &str, measure: &str, value: f64, at: Option<[f64; 3]>, remark: &str) {
        let place = at.map_or_else(|| ",,".into(), |[x, y, z]| format!("{x},{y},{z}"));
        let _ = writeln!(
            self.0,
            "{},{},{value:?},{place},{}",
            quoted(of),
            quoted(measure),
            quoted(remark)
        );
    }
}

fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.into()
    }
}

fn shape_rows(table: &mut Table, analysis: &Analysis) {
    let s = &analysis.shape;
    for (measure, count) in [
        ("vertices", s.vertices as f64),
        ("faces", s.faces as f64),
        ("edges", s.edges as f64),
        ("components", s.components as f64),
        ("boundary loops", s.boundary_loops as f64),
        ("Euler number", s.euler as f64),
        ("genus", s.genus as f64),
        ("area", s.mesh_area),
    ] {
        table.row("mesh", measure, count, None, "");
    }
    if let Some(volume) = s.mesh_volume {
        table.row("mesh", "volume", volume, None, "");
    }
    let of = "limit surface";
    let e = &s.energies;
    for (measure, value) in [
        ("area", Some(s.area)),
        ("volume", s.volume),
        ("energy H^2", Some(e.willmore)),
        ("energy K", Some(e.total_curvature)),
        ("energy K^2", Some(e.gauss_squared)),
        ("energy k1^2+k2^2", Some(e.bending)),
        ("energy given", e.given),
    ] {
        if let Some(value) = value {
            table.row(of, measure, value, None, "");
        }
    }
}

fn range_rows(table: &mut Table, name: &str, r: &Range) {
    table.row(name, "min", r.min, Some(r.min_at), "");
    table.row(name, "max", r.max, Some(r.max_at), "");
    table.row(name, "average", r.average, None, "");
    table.row(name, "deviation", r.deviation, None, "");
    let h = &r.histogram;
    let width = (h.to - h.from) / h.share.len() as f64;
    for (i, &share) in h.share.iter().enumerate() {
        let from = h.from + i as f64 * width;
        let measure = format!("share from {from:e} to {:e}", from + width);
        table.row(name, &measure, share, None, "");
    }
}

fn chain_rows(table: &mut Table, chain: &ChainReport) {
    table.row(&chain.name, "edges", chain.edges as f64, None, "");
    table.row(&chain.name, "length", chain.length, None, "");
    let zero = if chain.smooth_by_construction {
        "zero by construction"
    } else {
        "one-sided limits"
    };
    for (measure, s, remark) in [
        ("G0 gap", &chain.gap, zero),
        (
            "G1 angle of the normals in degrees",
            &chain.normal_angle,
            zero,
        ),
        (
            "dihedral angle of the triangles in degrees",
            &chain.dihedral,
            "",
        ),
        ("G2 jump of H", &chain.curvature_jump, ""),
        ("step of H from face to face", &chain.curvature_step, ""),
    ] {
        let Statistic {
            min,
            mean,
            max,
            max_at,
        } = *s;
        table.row(&chain.name, &format!("{measure}, min"), min, None, remark);
        table.row(&chain.name, &format!("{measure}, mean"), mean, None, remark);
        let measure = format!("{measure}, max");
        table.row(&chain.name, &measure, max, Some(max_at), remark);
    }
}

fn quality_rows(table: &mut Table, analysis: &Analysis) {
    let of = "triangles";
    let q = &analysis.quality;
    let at = Some(q.min_angle_at);
    table.row(of, "smallest angle in degrees", q.min_angle, at, "");
    let first = q.self_intersections_at.first().copied();
    for (measure, value) in [
        ("mean smallest angle in degrees", q.mean_min_angle),
        ("largest angle in degrees", q.max_angle),
        ("angles below 10 degrees", q.slivers as f64),
        ("without area", q.degenerate as f64),
        ("least radius ratio", q.radius_ratio[0]),
        ("mean radius ratio", q.radius_ratio[1]),
        ("shortest edge", q.edge_length[0]),
        ("mean edge", q.edge_length[1]),
        ("longest edge", q.edge_length[2]),
        ("greatest dihedral angle in degrees", q.max_dihedral),
        ("folded edges", q.folded_edges as f64),
    ] {
        table.row(of, measure, value, None, "");
    }
    let count = q.self_intersections as f64;
    table.row(of, "self-intersections", count, first, "");
}

fn distance_rows(table: &mut Table, of: &str, d: &Deviation) {
    let of = format!("distance {of}");
    table.row(&of, "RMS", d.rms, None, "");
    table.row(&of, "mean", d.mean, None, "");
    table.row(&of, "max", d.max, Some(d.max_at), "");
}
