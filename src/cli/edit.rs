//! `meniscus erase` and `meniscus flip`: changes without a flow.

use std::path::{Path, PathBuf};

use anyhow::{Result, bail};
use clap::Args;

use crate::cli::UsageError;
use crate::cli::args::ball;
use crate::cli::print::print;
use crate::fill::{LoopChoice, choose};
use crate::io::{Opened, check_target, open, same_file, save_mesh};
use crate::mesh::{
    DVec3, LoopId, Mesh, boundary_loops, erase as erase_faces, face_flags, faces_in_ball, grow,
    parse_ranges,
};

/// A selection of faces: all that one of the options names.
#[derive(Debug, Args)]
pub struct SelectionArguments {
    /// Select the faces whose corners lie within this distance of this point (repeatable).
    #[arg(
        long,
        value_name = "X,Y,Z,R",
        value_parser = ball,
        allow_hyphen_values = true
    )]
    pub ball: Vec<(DVec3, f64)>,
    /// Select triangles by their numbers, counted from 1 in the order of the file after polygons were
    /// cut: 1-12,40.
    #[arg(long, value_name = "LIST")]
    pub faces: Option<String>,
    /// Read such a list from a file, as the window writes it.
    #[arg(long, value_name = "FILE")]
    pub faces_from: Option<PathBuf>,
    /// Widen the selection by this many rings of faces.
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub grow: usize,
}

/// `meniscus erase`.
#[derive(Debug, Args)]
pub struct EraseArguments {
    /// Mesh to read (.obj, .ply, .stl).
    #[arg(value_name = "IN")]
    pub input: PathBuf,
    /// Mesh to write (.obj, .ply, .stl): what is left, in the order of IN.
    #[arg(short, long, value_name = "OUT")]
    pub output: PathBuf,
    /// Which faces.
    #[command(flatten)]
    pub selection: SelectionArguments,
    /// Say nothing but errors.
    #[arg(short, long)]
    pub quiet: bool,
}

/// `meniscus flip`.
#[derive(Debug, Args)]
pub struct FlipArguments {
    /// Mesh to read (.obj, .ply, .stl).
    #[arg(value_name = "IN")]
    pub input: PathBuf,
    /// Mesh to write (.obj, .ply, .stl): the same vertices and faces in the same order.
    #[arg(short, long, value_name = "OUT")]
    pub output: PathBuf,
    /// Turn over the component of this loop (`meniscus info` lists them; repeatable).
    #[arg(long, value_name = "LOOP", required = true)]
    pub component_of: Vec<LoopId>,
    /// Say nothing but errors.
    #[arg(short, long)]
    pub quiet: bool,
}

impl SelectionArguments {
    /// Whether none of the options is given.
    pub fn is_empty(&self) -> bool {
        self.ball.is_empty() && self.faces.is_none() && self.faces_from.is_none()
    }

    /// The selected faces of a command that is about them, one flag each.
    ///
    /// # Errors
    /// None of the options is given, and as [`Self::flags`].
    pub fn required(&self, mesh: &Mesh) -> Result<Vec<bool>> {
        if self.is_empty() {
            let what = "say which faces: --ball X,Y,Z,R, --faces LIST or --faces-from FILE";
            return Err(UsageError(what.into()).into());
        }
        self.flags(mesh)
    }

    /// The selected faces, one flag each.
    ///
    /// # Errors
    /// A list that cannot be read or names faces that are not there.
    pub fn flags(&self, mesh: &Mesh) -> Result<Vec<bool>> {
        let count = mesh.face_count();
        let mut flags = vec![false; count];
        let mut add = |more: Vec<bool>| {
            for (flag, other) in flags.iter_mut().zip(more) {
                *flag |= other;
            }
        };
        for &(centre, radius) in &self.ball {
            add(faces_in_ball(mesh, centre, radius));
        }
        if let Some(list) = &self.faces {
            let faces = parse_ranges(list, count);
            let faces = faces.map_err(|fault| UsageError(format!("--faces: {fault}")))?;
            add(face_flags(&faces, count));
        }
        if let Some(path) = &self.faces_from {
            let name = path.display();
            let text = std::fs::read_to_string(path)
                .map_err(|e| UsageError(format!("cannot read {name}: {e}")))?;
            let faces = parse_ranges(&text, count);
            let faces = faces.map_err(|fault| UsageError(format!("{name}: {fault}")))?;
            add(face_flags(&faces, count));
        }
        for _ in 0..self.grow {
            grow(&mesh.topology, &mut flags);
        }
        Ok(flags)
    }
}

/// Opens IN, after a look at whether OUT can be written.
pub fn opened(input: &Path, output: &Path) -> Result<Opened> {
    if same_file(output, input) {
        bail!("OUT is the same file as IN; give another name, nothing was overwritten");
    }
    check_target(output)?;
    Ok(open(input)?)
}

/// Runs `meniscus erase`.
pub fn erase(args: &EraseArguments) -> Result<()> {
    let opened = opened(&args.input, &args.output)?;
    let flags = args.selection.required(&opened.mesh)?;
    if !flags.contains(&true) {
        bail!("no face is selected; choose a place nearer to the surface or a larger radius");
    }
    let left = erase_faces(&opened.mesh, &flags);
    save_mesh(&args.output, &left.mesh, &opened.material_libraries)?;
    if args.quiet {
        return Ok(());
    }
    print(&format!(
        "{}: {} faces and {} vertices erased; {} loops now\n",
        args.output.display(),
        opened.mesh.face_count() - left.old_face.len(),
        opened.mesh.vertex_count() - left.old_vertex.len(),
        left.mesh.topology.boundary_loops().len(),
    ))
}

/// The components of some loops.
///
/// # Errors
/// There is no such loop.
pub fn components_of(mesh: &Mesh, chosen: &[LoopId]) -> Result<Vec<u32>> {
    let loops = boundary_loops(mesh);
    let chosen = choose(&loops, &LoopChoice::Listed(chosen.to_vec()))?;
    Ok(chosen
        .iter()
        .map(|id| loops[id.index()].component)
        .collect())
}

/// Runs `meniscus flip`.
pub fn flip(args: &FlipArguments) -> Result<()> {
    let opened = opened(&args.input, &args.output)?;
    let turned = components_of(&opened.mesh, &args.component_of)?;
    let mesh = opened.mesh.turned_over(&turned);
    save_mesh(&args.output, &mesh, &opened.material_libraries)?;
    if args.quiet {
        return Ok(());
    }
    print(&format!("{}: turned over\n", args.output.display()))
}
