//! Refilling and fairing: part of a surface is erased and filled, or faired in place.

use crate::fill::islands::with_islands;
use crate::fill::prepared::{PreparedFill, ScheduledOptions};
use crate::fill::result::{Filled, RefillError};
use crate::fill::run::{Observer, fill_rim_sets};
use crate::mesh::{
    BoundaryLoop, Erased, LOOSE_FACES, LoopId, Mesh, VertexId, boundary_loops, components, erase,
};

/// A mesh whose selected faces are erased.
#[derive(Clone, Debug)]
pub struct ErasedRegion {
    /// The mesh after erasing, with the old indices.
    pub erased: Erased,
    /// All boundary loops of that mesh.
    pub loops: Vec<BoundaryLoop>,
    /// The loops that the erased faces opened or enlarged.
    pub opened: Vec<LoopId>,
}

/// Erases the selected faces, one flag each, and the scraps that this cuts off: parts of fewer than
/// [`LOOSE_FACES`] faces of components of which a larger part is left.
///
/// # Errors
/// The selection is empty, or no face remains at its border.
pub fn open_selection(mesh: &Mesh, selected: &[bool]) -> Result<ErasedRegion, RefillError> {
    if !selected.contains(&true) {
        return Err(RefillError::Nothing);
    }
    let mut erased = erase(mesh, selected);
    if let Some(with_scraps) = with_scraps(mesh, selected, &erased) {
        erased = erase(mesh, &with_scraps);
    }
    let left = &erased.mesh;
    // a rim half-edge is new if it had a face before
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

/// The selected faces and the scraps; `None` if there are none.
fn with_scraps(mesh: &Mesh, selected: &[bool], erased: &Erased) -> Option<Vec<bool>> {
    let parts = components(&erased.mesh.topology);
    let whole = components(&mesh.topology);
    let mut sizes = vec![0; parts.count];
    let mut largest = vec![0; whole.count];
    for &part in &parts.of_face {
        sizes[part as usize] += 1;
    }
    let left = || {
        let of_old = erased.old_face.iter();
        of_old
            .zip(&parts.of_face)
            .map(|(&old, &part)| (old as usize, sizes[part as usize]))
    };
    for (old, size) in left() {
        let most = &mut largest[whole.of_face[old] as usize];
        *most = size.max(*most);
    }
    let is_scrap = |&(old, size): &(usize, usize)| {
        size < LOOSE_FACES && size < largest[whole.of_face[old] as usize]
    };
    let scraps: Vec<usize> = left().filter(is_scrap).map(|(old, _)| old).collect();
    let mut all = selected.to_vec();
    for &old in &scraps {
        all[old] = true;
    }
    (!scraps.is_empty()).then_some(all)
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

/// Erases the selected faces and fills the opened or enlarged holes, islands included.
///
/// # Errors
/// The selection is empty, or no face remains at its border.
pub fn refill(
    mesh: &Mesh,
    selected: &[bool],
    options: impl Into<ScheduledOptions>,
    observe: Observer<'_>,
) -> Result<Refilled, RefillError> {
    let region = open_selection(mesh, selected)?;
    let left = &region.erased.mesh;
    let rim_sets = with_islands(left, &region.loops, &region.opened);
    let options = options.into().leaving_islands();
    let filled = fill_rim_sets(left, &rim_sets, options, observe)?;
    Ok(Refilled { region, filled })
}

/// Moves the inner vertices of the selected faces by a flow, with G1 continuity to the other faces.
/// The triangles do not change. As in a new patch the flow starts at the warm start, so the result
/// does not depend on the old positions of these vertices. [`Filled::moved`] lists them.
///
/// # Errors
/// The selection is empty, has no inner vertices, or has no faces around it. An error of the flow
/// is in the result.
pub fn fair(
    mesh: &Mesh,
    selected: &[bool],
    options: impl Into<ScheduledOptions>,
    observe: Observer<'_>,
) -> Result<Filled, RefillError> {
    Ok(PreparedFill::fairing(mesh, selected, options)?.run(observe)?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fill::FillOptions;
    use crate::mesh::{DVec3, check_mesh, faces_in_ball, grow, inner_vertices};
    use crate::random::SplitMix;
    use crate::shapes;

    fn ball() -> Mesh {
        let (positions, triangles) = shapes::sphere(3000, 11);
        Mesh::from_triangles(positions, &triangles).expect("closed")
    }

    /// A ball with a dent and noise at the selected faces.
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
    fn scraps_that_erasing_cuts_off_are_erased_too() {
        let whole = ball();
        // a ring of faces around a few others
        let mut disc = faces_in_ball(&whole, DVec3::Z, 0.09);
        let inside = disc.clone();
        let count = inside.iter().filter(|&&face| face).count();
        assert!((1..LOOSE_FACES).contains(&count), "{count}");
        grow(&whole.topology, &mut disc);
        let ring: Vec<bool> = disc.iter().zip(inside).map(|(&a, b)| a && !b).collect();
        let region = open_selection(&whole, &ring).expect("opened");
        assert_eq!(components(&region.erased.mesh.topology).count, 1);
        assert_eq!(region.opened.len(), 1);
        assert_eq!(region.erased.mesh, erase(&whole, &disc).mesh);
        // a part that is not small stays
        let mut disc = faces_in_ball(&whole, DVec3::Z, 0.3);
        let inside = disc.clone();
        grow(&whole.topology, &mut disc);
        let ring: Vec<bool> = disc.iter().zip(inside).map(|(&a, b)| a && !b).collect();
        let region = open_selection(&whole, &ring).expect("opened");
        assert_eq!(components(&region.erased.mesh.topology).count, 2);
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
