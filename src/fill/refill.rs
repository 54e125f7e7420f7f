//! Part of a surface replaced: erased and filled.

use crate::fill::islands::with_islands;
use crate::fill::result::{FillError, Filled};
use crate::fill::run::{Observer, ScheduledOptions, fill_rim_sets};
use crate::mesh::{BoundaryLoop, Erased, LoopId, Mesh, VertexId, boundary_loops, erase};

/// Why a selection cannot be refilled or faired.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RefillError {
    /// No face is selected.
    #[error("no face is selected; choose a place nearer to the surface or a larger radius")]
    Nothing,
    /// Every face at the selection is selected: nothing is left to continue.
    #[error("the selection is a whole component: nothing is left for the new surface to join")]
    Everything,
    /// The selection is too narrow to have inner vertices.
    #[error(
        "the {faces} selected faces have no vertex that could move: all lie on the selection's \
         border; select a wider region"
    )]
    NoInside {
        /// Faces selected.
        faces: usize,
    },
    /// Filling failed as a whole.
    #[error(transparent)]
    Fill(#[from] FillError),
}

/// A mesh whose selected faces are erased.
#[derive(Clone, Debug)]
pub struct ErasedRegion {
    /// What was left after erasing, and where it was before.
    pub erased: Erased,
    /// All its boundary loops.
    pub loops: Vec<BoundaryLoop>,
    /// Those that the erased faces opened or widened.
    pub opened: Vec<LoopId>,
}

/// Erases the selected faces, one flag each.
///
/// # Errors
/// An empty selection, or one that leaves nothing to fill from.
pub fn open_selection(mesh: &Mesh, selected: &[bool]) -> Result<ErasedRegion, RefillError> {
    if !selected.contains(&true) {
        return Err(RefillError::Nothing);
    }
    let erased = erase(mesh, selected);
    let left = &erased.mesh;
    // a rim half-edge is new if there was a face beside it
    let had_face = |one: &BoundaryLoop| {
        one.halfedges.iter().any(|&h| {
            let old = |v: VertexId| VertexId(erased.old_vertex[v.index()]);
            let (from, to) = (left.topology.origin(h), left.topology.target(h));
            let mut out = mesh.topology.outgoing(old(from));
            out.any(|g| mesh.topology.target(g) == old(to) && !mesh.topology.is_boundary(g))
        })
    };
    let loops = boundary_loops(left);
    let opened: Vec<LoopId> = loops.iter().filter(|l| had_face(l)).map(|l| l.id).collect();
    if opened.is_empty() {
        return Err(RefillError::Everything);
    }
    Ok(ErasedRegion {
        erased,
        loops,
        opened,
    })
}

/// A refilled mesh.
#[derive(Debug)]
#[non_exhaustive]
pub struct Refilled {
    /// The mesh without the selected faces, and the loops around them.
    pub region: ErasedRegion,
    /// The fill of these loops.
    pub filled: Filled,
}

/// Erases the selected faces and fills the holes this opens or widens, islands included.
///
/// # Errors
/// An empty selection, or one after which nothing is left to fill from.
pub fn refill(
    mesh: &Mesh,
    selected: &[bool],
    options: impl Into<ScheduledOptions>,
    observe: Observer<'_>,
) -> Result<Refilled, RefillError> {
    let region = open_selection(mesh, selected)?;
    let left = &region.erased.mesh;
    let rim_sets = with_islands(left, &region.loops, &region.opened);
    let filled = fill_rim_sets(left, &rim_sets, options, observe)?;
    Ok(Refilled { region, filled })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fill::{FillOptions, fair};
    use crate::mesh::{DVec3, Topology, check_mesh, faces_in_ball, grow, inner_vertices};
    use crate::random::SplitMix;
    use crate::shapes;

    fn ball() -> Mesh {
        let (positions, triangles) = shapes::sphere(3000, 11);
        let topology = Topology::from_triangles(positions.len(), &triangles).expect("closed");
        Mesh::new(positions, topology)
    }

    /// A ball with a dent and noise where it is to be mended.
    fn dented(selected: &[bool]) -> Mesh {
        let mut mesh = ball();
        let mut random = SplitMix::new(2);
        for v in inner_vertices(&mesh.topology, selected) {
            mesh.positions[v.index()] *= 0.8 + 0.05 * random.unit();
        }
        mesh
    }

    fn selection() -> Vec<bool> {
        faces_in_ball(&ball(), DVec3::new(0.0, 0.6, 0.8), 0.6)
    }

    #[test]
    fn a_dent_is_erased_and_the_sphere_comes_back() {
        let selected = selection();
        let mesh = dented(&selected);
        let new =
            refill(&mesh, &selected, &FillOptions::default(), &|_, _| true).expect("refilled");
        assert!(new.filled.complete());
        assert_eq!(new.region.opened.len(), 1);
        check_mesh(&new.filled.mesh).expect("sound");
        assert!(new.filled.mesh.topology.boundary_loops().is_empty());
        for (p, &old) in new
            .filled
            .mesh
            .positions
            .iter()
            .zip(&new.region.erased.old_vertex)
        {
            assert_eq!(*p, mesh.positions[old as usize]);
        }
        let worst = new
            .filled
            .mesh
            .positions
            .iter()
            .map(|p| (p.length() - 1.0).abs());
        assert!(worst.fold(0.0, f64::max) < 3e-3);
    }

    #[test]
    fn a_dent_is_faired_away_with_the_same_triangles() {
        let selected = selection();
        let mesh = dented(&selected);
        let new = fair(&mesh, &selected, &FillOptions::default(), &|_, _| true).expect("faired");
        assert!(new.complete());
        assert_eq!(new.mesh.topology, mesh.topology);
        for (v, (p, q)) in new.mesh.positions.iter().zip(&mesh.positions).enumerate() {
            assert!(new.moved.contains(&VertexId::from(v)) || p == q);
            assert!((p.length() - 1.0).abs() < 3e-3);
        }
    }

    #[test]
    fn widening_an_open_hole_fills_it_all() {
        let whole = ball();
        let mut hole = faces_in_ball(&whole, DVec3::Z, 0.3);
        let holed = erase(&whole, &hole);
        grow(&whole.topology, &mut hole);
        let ring: Vec<bool> = holed.old_face.iter().map(|&f| hole[f as usize]).collect();
        let new = refill(&holed.mesh, &ring, &FillOptions::default(), &|_, _| true);
        let new = new.expect("refilled");
        assert!(new.filled.mesh.topology.boundary_loops().is_empty());
    }

    #[test]
    fn useless_selections_are_named() {
        let mesh = ball();
        let options = FillOptions::default();
        let none = vec![false; mesh.face_count()];
        let all = vec![true; mesh.face_count()];
        let mut one = none.clone();
        one[5] = true;
        let again = |s: &[bool]| refill(&mesh, s, &options, &|_, _| true).err();
        let same = |s: &[bool]| fair(&mesh, s, &options, &|_, _| true).err();
        assert!(matches!(again(&none), Some(RefillError::Nothing)));
        assert!(matches!(again(&all), Some(RefillError::Everything)));
        assert!(matches!(same(&none), Some(RefillError::Nothing)));
        assert!(matches!(
            same(&one),
            Some(RefillError::NoInside { faces: 1 })
        ));
        assert!(matches!(same(&all), Some(RefillError::Everything)));
    }
}
