//! Part of a surface made anew: erased and filled, or faired in place.

use crate::fill::{
    Controls, FillError, FillOptions, Filled, Gap, Group, Plan, Schedule, ScheduleError,
    ScheduledFillError, fill_gaps, fill_scheduled, run_plan, with_islands,
};
use crate::mesh::{
    BoundaryLoop, DVec3, Erased, FaceId, LoopId, Mesh, VertexId, boundary_loops, erase,
    inner_vertices,
};
use crate::solver::{SUPPORT_RINGS, StepRecord};

/// Why a selection cannot be made anew.
#[derive(Debug, thiserror::Error)]
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
    /// The schedule cannot be followed.
    #[error(transparent)]
    Schedule(#[from] ScheduleError),
}

impl From<ScheduledFillError> for RefillError {
    fn from(error: ScheduledFillError) -> Self {
        match error {
            ScheduledFillError::Schedule(error) => error.into(),
            ScheduledFillError::Fill(error) => error.into(),
        }
    }
}

/// A mesh whose selected faces are erased.
#[derive(Clone, Debug)]
pub struct Opening {
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
pub fn open_selection(mesh: &Mesh, selected: &[bool]) -> Result<Opening, RefillError> {
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
    Ok(Opening {
        erased,
        loops,
        opened,
    })
}

/// A refilled mesh.
#[derive(Debug)]
pub struct Refilled {
    /// What was left after erasing, and the loops around what was erased.
    pub opening: Opening,
    /// The fill of these.
    pub filled: Filled,
}

/// Erases the selected faces and fills the holes this leaves or widens, islands included.
///
/// # Errors
/// An empty selection, or one after which nothing is left to fill from.
pub fn refill(
    mesh: &Mesh,
    selected: &[bool],
    options: &FillOptions,
    observe: &(dyn Fn(usize, &StepRecord) -> bool + Sync),
) -> Result<Refilled, RefillError> {
    refill_by(mesh, selected, |left, gaps| {
        Ok(fill_gaps(left, gaps, options, observe)?)
    })
}

/// [`refill`] with changes on the way, as recorded by a live fill.
///
/// # Errors
/// As [`refill`], and a schedule that cannot be followed.
pub fn refill_scheduled(
    mesh: &Mesh,
    selected: &[bool],
    controls: &Controls,
    schedule: &Schedule,
    observe: &(dyn Fn(usize, &StepRecord) -> bool + Sync),
) -> Result<Refilled, RefillError> {
    refill_by(mesh, selected, |left, gaps| {
        Ok(fill_scheduled(left, gaps, controls, schedule, observe)?)
    })
}

fn refill_by(
    mesh: &Mesh,
    selected: &[bool],
    fill: impl FnOnce(&Mesh, &[Gap<'_>]) -> Result<Filled, RefillError>,
) -> Result<Refilled, RefillError> {
    let opening = open_selection(mesh, selected)?;
    let left = &opening.erased.mesh;
    let gaps = with_islands(left, &opening.loops, &opening.opened);
    let filled = fill(left, &gaps)?;
    Ok(Refilled { opening, filled })
}

/// Lets the inner vertices of the selected faces flow, the triangles staying as they are; G1 to the
/// rest. Like a new patch they start from the smooth spread of the warm start, so that it does not
/// matter how badly they lay. [`Plan::moved`] of the result says which they are.
///
/// # Errors
/// An empty, narrow or all-embracing selection; what the flow refuses is in the result.
pub fn fair(
    mesh: &Mesh,
    selected: &[bool],
    options: &FillOptions,
    observe: &(dyn Fn(usize, &StepRecord) -> bool + Sync),
) -> Result<Filled, RefillError> {
    let plan = Plan::fairing(mesh, selected)?;
    Ok(run_plan(mesh, &[], plan, options, &[], observe)?)
}

/// [`fair`] with changes on the way, as recorded by a live fill.
///
/// # Errors
/// As [`fair`], and a schedule that cannot be followed.
pub fn fair_scheduled(
    mesh: &Mesh,
    selected: &[bool],
    controls: &Controls,
    schedule: &Schedule,
    observe: &(dyn Fn(usize, &StepRecord) -> bool + Sync),
) -> Result<Filled, RefillError> {
    let (options, changes) = schedule.resolve(controls)?;
    let plan = Plan::fairing(mesh, selected)?;
    Ok(run_plan(mesh, &[], plan, &options, &changes, observe)?)
}

impl Plan {
    /// The plan of a fairing: the inner vertices of the selected faces, with everything near them
    /// as the collar.
    pub(super) fn fairing(mesh: &Mesh, selected: &[bool]) -> Result<Self, RefillError> {
        let faces = selected.iter().filter(|&&flag| flag).count();
        if faces == 0 {
            return Err(RefillError::Nothing);
        }
        let topology = &mesh.topology;
        let moved = inner_vertices(topology, selected);
        if moved.is_empty() {
            return Err(RefillError::NoInside { faces });
        }
        let (collar, ring_1) = around(mesh, &moved);
        if ring_1.is_empty() {
            return Err(RefillError::Everything);
        }
        let centre = ring_1.iter().map(|&v| mesh.position(v)).sum::<DVec3>() / ring_1.len() as f64;
        let square = |&v: &VertexId| mesh.position(v).distance_squared(centre);
        let radius = (ring_1.iter().map(square).sum::<f64>() / ring_1.len() as f64).sqrt();
        Ok(Self {
            old_vertices: mesh.vertex_count(),
            holes: Vec::new(),
            failed: Vec::new(),
            new_positions: moved.iter().map(|&v| mesh.position(v)).collect(),
            triangles: Vec::new(),
            groups: vec![Group {
                holes: Vec::new(),
                new_vertices: (0..moved.len() as u32).collect(),
                radius,
                collars: vec![collar],
            }],
            moved,
        })
    }
}

/// The faces within [`SUPPORT_RINGS`] rings of some vertices, sorted, and the vertices of the first ring.
fn around(mesh: &Mesh, moved: &[VertexId]) -> (Vec<FaceId>, Vec<VertexId>) {
    let topology = &mesh.topology;
    let mut reached = vec![false; mesh.vertex_count()];
    for v in moved {
        reached[v.index()] = true;
    }
    let mut has_face = vec![false; mesh.face_count()];
    let (mut faces, mut ring_1) = (Vec::new(), Vec::new());
    let mut front = moved.to_vec();
    for ring in 0..SUPPORT_RINGS {
        let mut next = Vec::new();
        for &v in &front {
            for h in topology.outgoing(v) {
                let (f, w) = (topology.face(h), topology.target(h));
                if f.is_some() && !std::mem::replace(&mut has_face[f.index()], true) {
                    faces.push(f);
                }
                if !std::mem::replace(&mut reached[w.index()], true) {
                    next.push(w);
                }
            }
        }
        if ring == 0 {
            ring_1.clone_from(&next);
        }
        front = next;
    }
    faces.sort_unstable();
    (faces, ring_1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Topology, check_mesh, faces_in_ball, grow};
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
        assert_eq!(new.opening.opened.len(), 1);
        check_mesh(&new.filled.mesh).expect("sound");
        assert!(new.filled.mesh.topology.boundary_loops().is_empty());
        for (p, &old) in new
            .filled
            .mesh
            .positions
            .iter()
            .zip(&new.opening.erased.old_vertex)
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
            assert!(new.plan.moved.contains(&VertexId::from(v)) || p == q);
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
