//! Selections of faces on the command line.

use std::path::PathBuf;

use anyhow::Result;
use clap::Args;

use crate::cli::UsageError;
use crate::cli::parse::{ball, positive};
use crate::mesh::{
    DVec3, Flaw, Mesh, face_flags, face_list, faces_in_ball, flawed_faces, grow, parse_ranges,
};
use crate::ops::Faces;

/// A selection of faces: the union of those named by the options.
#[derive(Debug, Args)]
pub struct SelectionArguments {
    /// Select the faces with all corners within the distance R of a point (repeatable).
    #[arg(
        long,
        value_name = "X,Y,Z,R",
        value_parser = ball,
        allow_hyphen_values = true
    )]
    pub ball: Vec<(DVec3, f64)>,
    /// Select triangles by number, as in 1-12,40. Triangles are counted from 1 in the order of the
    /// file, after polygons have been triangulated.
    #[arg(long, value_name = "LIST")]
    pub faces: Option<String>,
    /// Read a list of triangles from a file, as written by the window.
    #[arg(long, value_name = "FILE")]
    pub faces_from: Option<PathBuf>,
    /// Select triangles whose smallest angle is below this limit, in degrees.
    #[arg(long, value_name = "DEG", value_parser = positive, allow_hyphen_values = true)]
    pub faces_worse_than: Option<f64>,
    /// Select triangles with an edge longer than this.
    #[arg(long, value_name = "LENGTH", value_parser = positive, allow_hyphen_values = true)]
    pub faces_longer_than: Option<f64>,
    /// Select triangles that intersect others.
    #[arg(long)]
    pub faces_crossing: bool,
    /// Select triangles folded onto a neighbour (their normals differ by 150 degrees or more).
    #[arg(long)]
    pub faces_folded: bool,
    /// Grow the selection by N rings of faces.
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub grow: usize,
}

impl SelectionArguments {
    /// Whether no option is given.
    pub fn is_empty(&self) -> bool {
        let by_place = !self.ball.is_empty() || self.faces.is_some() || self.faces_from.is_some();
        !by_place && self.flaws().is_empty()
    }

    /// The flaws for which faces are selected.
    fn flaws(&self) -> Vec<Flaw> {
        let worse = self.faces_worse_than.map(Flaw::WorseThan);
        let longer = self.faces_longer_than.map(Flaw::LongerThan);
        let crossing = self.faces_crossing.then_some(Flaw::Crossing);
        let folded = self.faces_folded.then_some(Flaw::Folded);
        [worse, longer, crossing, folded]
            .into_iter()
            .flatten()
            .collect()
    }

    /// The selected faces, at least one.
    ///
    /// # Errors
    /// No option is given, or as for [`Self::faces`].
    pub fn required(&self, mesh: &Mesh) -> Result<Faces> {
        if self.is_empty() {
            let what = "choose faces with --ball X,Y,Z,R, --faces LIST, --faces-from FILE, \
                        --faces-worse-than DEG, --faces-longer-than LENGTH, --faces-crossing \
                        or --faces-folded";
            return Err(UsageError(what.into()).into());
        }
        self.faces(mesh)
    }

    /// The selected faces.
    ///
    /// # Errors
    /// A list cannot be read or contains faces that do not exist.
    pub fn faces(&self, mesh: &Mesh) -> Result<Faces> {
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
            add(face_flags(&listed_faces("--faces", list, count)?, count));
        }
        if let Some(path) = &self.faces_from {
            let name = path.display();
            let text = std::fs::read_to_string(path)
                .map_err(|e| UsageError(format!("cannot read {name}: {e}")))?;
            let name = name.to_string();
            add(face_flags(&listed_faces(&name, &text, count)?, count));
        }
        for flaw in self.flaws() {
            add(flawed_faces(mesh, flaw));
        }
        for _ in 0..self.grow {
            grow(&mesh.topology, &mut flags);
        }
        Ok(Faces::new(face_list(&flags)))
    }
}

/// Face indices from a list of face numbers, counted from 1, of a mesh with `count` faces. `name` is where
/// the list comes from.
///
/// # Errors
/// The list is invalid or contains faces that do not exist.
pub fn listed_faces(name: &str, list: &str, count: usize) -> Result<Vec<u32>> {
    let faces = parse_ranges(list, count);
    Ok(faces.map_err(|fault| UsageError(format!("{name}: {fault}")))?)
}
