//! `meniscus bridge`.

use anyhow::{Result, bail};

use crate::cli::args::BridgeArguments;
use crate::cli::edit::opened;
use crate::cli::print::print;
use crate::fill::{self, segment_at};
use crate::io::save_mesh;
use crate::mesh::boundary_loops;

/// Runs the command.
pub fn bridge(args: &BridgeArguments) -> Result<()> {
    let opened = opened(&args.input, &args.output)?;
    let mesh = &opened.mesh;
    let loops = boundary_loops(mesh);
    let end = |point| segment_at(mesh, &loops, point, args.width);
    let (Some(from), Some(to)) = (end(args.from), end(args.to)) else {
        bail!("the mesh has no boundary loop, so there is nothing to bridge");
    };
    let bridged = fill::bridge(mesh, &loops, from, to)?;
    save_mesh(&args.output, &bridged, &opened.material_libraries)?;
    if args.quiet {
        return Ok(());
    }
    let ends = if from.hole == to.hole {
        format!("across loop {}", from.hole)
    } else {
        format!("from loop {} to loop {}", from.hole, to.hole)
    };
    print(&format!(
        "{}: a bridge {ends}, {} vertices and {} faces added; {} loops now\n",
        args.output.display(),
        bridged.vertex_count() - mesh.vertex_count(),
        bridged.face_count() - mesh.face_count(),
        bridged.topology.boundary_loops().len(),
    ))
}
