//! Part of a surface made anew: erased and filled, or faired in place.

use std::time::Instant;

use crate::fill::{
    FillError, FillOptions, Filled, GroupResult, Timings, fill_gaps, milliseconds, sheets,
    warm_start, with_islands,
};
use crate::mesh::{
    BoundaryLoop, DVec3, Erased, FaceId, Mesh, TopologyError, VertexId, boundary_loops, erase,
    inner_vertices,
};
use crate::solver::{COLLAR_RINGS, Flow, FlowProblem, SolverError, StepRecord};

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
    /// The fairing flow cannot run.
    #[error("the selected region cannot be faired: {0}")]
    Flow(#[from] SolverError),
}

/// A refilled mesh.
#[derive(Debug)]
pub struct Refilled {
    /// What was left after erasing, and where it was before.
    pub erased: Erased,
    /// The loops around what was erased.
    pub loops: Vec<BoundaryLoop>,
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
    let opened: Vec<usize> = (0..loops.len()).filter(|&i| had_face(&loops[i])).collect();
    if opened.is_empty() {
        return Err(RefillError::Everything);
    }
    let filled = {
        let gaps = with_islands(left, &loops, &opened);
        fill_gaps(left, &gaps, options, observe)?
    };
    let loops = opened.into_iter().map(|i| loops[i].clone()).collect();
    Ok(Refilled {
        erased,
        loops,
        filled,
    })
}

/// A faired mesh.
#[derive(Debug)]
pub struct Faired {
    /// The mesh with the inner vertices of the selection moved; everything else is untouched.
    pub mesh: Mesh,
    /// The vertices that moved.
    pub moved: Vec<VertexId>,
    /// How the flow went.
    pub flow: GroupResult,
}

/// Lets the inner vertices of the selected faces flow, the triangles staying as they are; G1 to the
/// rest. Like a new patch they start from the smooth spread of the warm start, so that it does not
/// matter how badly they lay.
///
/// # Errors
/// An empty, narrow or all-embracing selection, and what the flow refuses.
pub fn fair(
    mesh: &Mesh,
    selected: &[bool],
    options: &FillOptions,
    observe: &dyn Fn(&StepRecord) -> bool,
) -> Result<Faired, RefillError> {
    let faces = selected.iter().filter(|&&flag| flag).count();
    if faces == 0 {
        return Err(RefillError::Nothing);
    }
    let moved = inner_vertices(&mesh.topology, selected);
    if moved.is_empty() {
        return Err(RefillError::NoInside { faces });
    }
    let problem = region(mesh, &moved)?;
    let (flow, positions) = run(problem, options, observe)?;
    let mut fair = mesh.clone();
    for (v, &p) in moved.iter().zip(&positions) {
        fair.positions[v.index()] = p;
    }
    Ok(Faired {
        mesh: fair,
        moved,
        flow,
    })
}

/// Warm start and flow of a region: how it went, and where the vertices are.
fn run(
    problem: FlowProblem,
    options: &FillOptions,
    observe: &dyn Fn(&StepRecord) -> bool,
) -> Result<(GroupResult, Vec<DVec3>), SolverError> {
    let mut timings = Timings::default();
    let mut lap = Instant::now();
    let mut split = |slot: &mut f64| {
        *slot += milliseconds(lap);
        lap = Instant::now();
    };
    let problem = warm_start(problem)?;
    split(&mut timings.warm_start);
    let mut flow = Flow::new(problem, options.flow.clone())?;
    split(&mut timings.setup);
    let mut records = Vec::new();
    let outcome = flow.run(|_, record| {
        records.push(record.clone());
        observe(record)
    })?;
    split(&mut timings.flow);
    let positions = flow.problem().to_world(flow.positions());
    let result = GroupResult {
        outcome,
        records,
        timings,
    };
    Ok((result, positions))
}

/// The flow of some vertices of a mesh with everything near them.
fn region(mesh: &Mesh, moved: &[VertexId]) -> Result<FlowProblem, RefillError> {
    let topology = &mesh.topology;
    let mut local = vec![u32::MAX; mesh.vertex_count()];
    let mut order = moved.to_vec();
    for (i, v) in moved.iter().enumerate() {
        local[v.index()] = i as u32;
    }
    let mut has_face = vec![false; mesh.face_count()];
    let mut faces = Vec::new();
    let (mut begin, mut ring_1) = (0, Vec::new());
    for ring in 0..COLLAR_RINGS {
        let end = order.len();
        for k in begin..end {
            for h in topology.outgoing(order[k]) {
                let (f, w) = (topology.face(h), topology.target(h));
                if f.is_some() && !std::mem::replace(&mut has_face[f.index()], true) {
                    faces.push(f);
                }
                if local[w.index()] == u32::MAX {
                    local[w.index()] = order.len() as u32;
                    order.push(w);
                }
            }
        }
        begin = end;
        if ring == 0 {
            ring_1 = order[end..].to_vec();
        }
    }
    if ring_1.is_empty() {
        return Err(RefillError::Everything);
    }
    faces.sort_unstable();
    let mut positions: Vec<DVec3> = order.iter().map(|&v| mesh.position(v)).collect();
    let mut triangles: Vec<[u32; 3]> = faces
        .iter()
        .map(|&f: &FaceId| topology.face_vertices(f).map(|v| local[v.index()]))
        .collect();
    let interior: Vec<u32> = (0..moved.len() as u32).collect();
    let centre = ring_1.iter().map(|&v| mesh.position(v)).sum::<DVec3>() / ring_1.len() as f64;
    let square = |&v: &VertexId| mesh.position(v).distance_squared(centre);
    let radius = (ring_1.iter().map(square).sum::<f64>() / ring_1.len() as f64).sqrt();
    Ok(
        match FlowProblem::new(&positions, &triangles, &interior, radius) {
            Err(SolverError::Topology(TopologyError::NonManifoldVertex { .. })) => {
                sheets::separate(&mut positions, &mut triangles);
                FlowProblem::new(&positions, &triangles, &interior, radius)
            }
            problem => problem,
        }?,
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Topology, check_mesh, faces_in_ball, grow, shapes};
    use crate::solver::End;

    fn ball() -> Mesh {
        let (positions, triangles) = shapes::sphere(3000, 11);
        let topology = Topology::from_triangles(positions.len(), &triangles).expect("closed");
        Mesh::new(positions, topology)
    }

    /// A ball with a dent and noise where it is to be mended.
    fn dented(selected: &[bool]) -> Mesh {
        let mut mesh = ball();
        let mut random = shapes::SplitMix::new(2);
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
        assert_eq!(new.loops.len(), 1);
        check_mesh(&new.filled.mesh).expect("sound");
        assert!(new.filled.mesh.topology.boundary_loops().is_empty());
        for (p, &old) in new.filled.mesh.positions.iter().zip(&new.erased.old_vertex) {
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
        let new = fair(&mesh, &selected, &FillOptions::default(), &|_| true).expect("faired");
        assert_eq!(new.flow.outcome.end, End::Converged);
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
        let same = |s: &[bool]| fair(&mesh, s, &options, &|_| true).err();
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
