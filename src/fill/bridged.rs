//! Holes beside the strips of bridges: the strips flow with the patches of these holes.

use std::time::Instant;

use rustc_hash::FxHashMap;

use crate::fill::hole::{DraftHole, HoleRims};
use crate::fill::options::FillOptions;
use crate::fill::rim::RimSet;
use crate::mesh::union_find::{find, unite};
use crate::mesh::{
    BoundaryLoop, Erased, FaceId, HalfedgeId, LoopId, Mesh, Topology, VertexId, boundary_loops,
    erase, face_flags,
};
use crate::patch::{self, Patch, PatchError};

/// A mesh without the strips of bridges that flow with the patches of the holes beside them.
#[derive(Clone, Debug)]
pub struct Released {
    /// The mesh without the faces of these strips.
    pub erased: Erased,
    /// The rims of each patch in that mesh, with the numbers of the loops before.
    pub rims: Vec<Vec<BoundaryLoop>>,
    /// What the patch over each of these rims is first put together from.
    pub(super) parts: Vec<PatchParts>,
}

/// The parts of a patch, in the mesh with the strips.
#[derive(Clone, Debug, Default)]
pub(super) struct PatchParts {
    /// The rim sets between strips, by index.
    sets: Vec<usize>,
    /// The faces of the strips; none in a patch without bridges.
    pub strips: Vec<u32>,
}

/// Releases the strips whose holes are all filled. `strips` are the faces of bridges, ascending. A strip
/// beside a loop that stays open is kept, and so are strips whose holes would together get a handle.
/// `None` if no strip is released.
pub fn release(mesh: &Mesh, rim_sets: &[RimSet<'_>], strips: &[u32]) -> Option<Released> {
    let strips = beside_filled_loops(mesh, rim_sets, strips);
    if strips.is_empty() {
        return None;
    }
    let topology = &mesh.topology;
    let loop_at = loops_by_halfedge(rim_sets);
    let parts = parts(mesh, rim_sets.len(), &strips, &loop_at);
    let part_of_set: FxHashMap<usize, usize> = (parts.iter().enumerate())
        .flat_map(|(p, part)| part.sets.iter().map(move |&set| (set, p)))
        .collect();
    let erased = erase(mesh, &face_flags(&strips, mesh.face_count()));
    if erased.old_face.len() + strips.len() < mesh.face_count() {
        // other faces hang on a strip
        return None;
    }
    let old = |h: HalfedgeId| {
        let left = &erased.mesh.topology;
        let ends = [left.origin(h), left.target(h)];
        let [a, b] = ends.map(|v| VertexId(erased.old_vertex[v.index()]));
        topology.outgoing(a).find(|&g| topology.target(g) == b)
    };
    let mut rims = vec![Vec::new(); parts.len()];
    for mut one in boundary_loops(&erased.mesh) {
        let befores = || one.halfedges.iter().filter_map(|&h| old(h));
        let part = befores().find_map(|h| match loop_at.get(&h) {
            Some(&(set, _)) => part_of_set.get(&set).copied(),
            None if topology.is_boundary(h) => None,
            None => {
                let is_here =
                    |part: &PatchParts| part.strips.binary_search(&topology.face(h).0).is_ok();
                parts.iter().position(is_here)
            }
        });
        if let Some(part) = part {
            let id = befores().find_map(|h| loop_at.get(&h).map(|&(_, id)| id));
            let first = |&set: &usize| rim_sets[set][0].id;
            let id = id.or_else(|| parts[part].sets.iter().map(first).min());
            one.id = id.unwrap_or(one.id);
            rims[part].push(one);
        }
    }
    for (part, rims) in parts.iter().zip(&mut rims) {
        if part.strips.is_empty() {
            // the first loop stands for the hole, islands follow
            let order = &rim_sets[part.sets[0]];
            rims.sort_by_key(|rim| order.iter().position(|l| l.id == rim.id));
        }
    }
    // with a handle, or rims that touch
    let unfit: Vec<&PatchParts> = (parts.iter().zip(&rims))
        .filter(|(part, rims)| !part.strips.is_empty() && !is_sphere(mesh, rim_sets, part, rims))
        .map(|(part, _)| part)
        .collect();
    if !unfit.is_empty() {
        let is_fit = |f: &u32| {
            unfit
                .iter()
                .all(|part| part.strips.binary_search(f).is_err())
        };
        let rest: Vec<u32> = strips.into_iter().filter(is_fit).collect();
        return release(mesh, rim_sets, &rest);
    }
    Some(Released {
        erased,
        rims,
        parts,
    })
}

/// The loop at each of its half-edges, with its rim set.
fn loops_by_halfedge(rim_sets: &[RimSet<'_>]) -> FxHashMap<HalfedgeId, (usize, LoopId)> {
    let all = rim_sets.iter().enumerate();
    let all = all.flat_map(|(set, rims)| rims.iter().map(move |rim| (set, rim)));
    all.flat_map(|(set, rim)| rim.halfedges.iter().map(move |&h| (h, (set, rim.id))))
        .collect()
}

/// The half-edges on the other side of the edges of faces.
fn around(topology: &Topology, face: u32) -> impl Iterator<Item = HalfedgeId> + '_ {
    topology
        .face_halfedges(FaceId(face))
        .into_iter()
        .map(HalfedgeId::twin)
}

/// Those of `strips` (ascending) that are in a strip beside which every loop is in a rim set, and at
/// least one is.
fn beside_filled_loops(mesh: &Mesh, rim_sets: &[RimSet<'_>], strips: &[u32]) -> Vec<u32> {
    let topology = &mesh.topology;
    let loop_at = loops_by_halfedge(rim_sets);
    let mut parent: Vec<u32> = (0..strips.len() as u32).collect();
    let (mut is_beside, mut is_open) = (vec![false; strips.len()], vec![false; strips.len()]);
    for (i, &face) in strips.iter().enumerate() {
        for beyond in around(topology, face) {
            if !topology.is_boundary(beyond) {
                if let Ok(j) = strips.binary_search(&topology.face(beyond).0) {
                    unite(&mut parent, i as u32, j as u32);
                }
            } else if loop_at.contains_key(&beyond) {
                is_beside[i] = true;
            } else {
                is_open[i] = true;
            }
        }
    }
    for i in 0..strips.len() {
        let root = find(&mut parent, i as u32) as usize;
        is_beside[root] |= is_beside[i];
        is_open[root] |= is_open[i];
    }
    let mut is_free = |i: usize| {
        let root = find(&mut parent, i as u32) as usize;
        is_beside[root] && !is_open[root]
    };
    let free = (0..strips.len()).filter(|&i| is_free(i));
    free.map(|i| strips[i]).collect()
}

/// The parts of each patch: the rim sets and strips that touch each other, in the order of the rim sets.
fn parts(
    mesh: &Mesh,
    sets: usize,
    strips: &[u32],
    loop_at: &FxHashMap<HalfedgeId, (usize, LoopId)>,
) -> Vec<PatchParts> {
    let topology = &mesh.topology;
    let mut parent: Vec<u32> = (0..(sets + strips.len()) as u32).collect();
    for (i, &face) in strips.iter().enumerate() {
        for beyond in around(topology, face) {
            let other = match loop_at.get(&beyond) {
                Some(&(set, _)) => Some(set),
                None if topology.is_boundary(beyond) => None,
                None => {
                    let beside = strips.binary_search(&topology.face(beyond).0).ok();
                    beside.map(|j| sets + j)
                }
            };
            if let Some(other) = other {
                unite(&mut parent, (sets + i) as u32, other as u32);
            }
        }
    }
    let mut parts: Vec<PatchParts> = Vec::new();
    let mut part_of_root: FxHashMap<u32, usize> = FxHashMap::default();
    for i in 0..parent.len() {
        let root = find(&mut parent, i as u32);
        let part = *part_of_root.entry(root).or_insert_with(|| {
            parts.push(PatchParts::default());
            parts.len() - 1
        });
        match i.checked_sub(sets) {
            None => parts[part].sets.push(i),
            Some(strip) => parts[part].strips.push(strips[strip]),
        }
    }
    parts
}

/// Whether the union of the parts is a sphere with a hole for each of `rims`, and no vertex is on the
/// rims twice.
fn is_sphere(
    mesh: &Mesh,
    rim_sets: &[RimSet<'_>],
    part: &PatchParts,
    rims: &[BoundaryLoop],
) -> bool {
    let topology = &mesh.topology;
    let mut on_rims: Vec<VertexId> = rims.iter().flat_map(|l| l.vertices.clone()).collect();
    let count = on_rims.len();
    on_rims.sort_unstable();
    on_rims.dedup();
    let faces = part.strips.iter().map(|&f| FaceId(f));
    let mut vertices: Vec<VertexId> = faces
        .clone()
        .flat_map(|f| topology.face_vertices(f))
        .collect();
    vertices.sort_unstable();
    vertices.dedup();
    let mut edges: Vec<usize> = faces
        .flat_map(|f| topology.face_halfedges(f))
        .map(HalfedgeId::edge)
        .collect();
    edges.sort_unstable();
    edges.dedup();
    let is_of_strip = |h: &HalfedgeId| {
        let face = topology.face(h.twin());
        part.strips.binary_search(&face.0).is_ok()
    };
    // the Euler characteristics of the strips and of the patches beside them, less those of their
    // common arcs: what is added, and what is taken away
    let mut plus = vertices.len() + part.strips.len();
    let mut minus = edges.len();
    for &set in &part.sets {
        plus += 2;
        minus += rim_sets[set].len();
        for rim in &rim_sets[set] {
            let flags: Vec<bool> = rim.halfedges.iter().map(is_of_strip).collect();
            let n = flags.len();
            let starts = (0..n).filter(|&i| flags[i] && !flags[(i + n - 1) % n]);
            minus += starts.count();
        }
    }
    on_rims.len() == count && plus + rims.len() == minus + 2
}

/// The hole over `rims`, whose first patch is put together from the strips and patches over the rim sets
/// of `mesh` between them.
pub(super) fn joined_draft(
    mesh: &Mesh,
    rim_sets: &[RimSet<'_>],
    old_vertex: &[u32],
    parts: &PatchParts,
    mut rims: HoleRims,
    options: &FillOptions,
) -> DraftHole {
    let start = Instant::now();
    let beside = parts.sets.iter().flat_map(|&set| &rim_sets[set]);
    rims.closed = beside.map(|rim| rim.id).collect();
    let patch = joined_patch(mesh, rim_sets, old_vertex, parts, &rims, options);
    let patch = patch.map(|patch| patch::reblend(&rims.geometry, &patch, options.patch));
    DraftHole::with_patch(rims, patch, start)
}

fn joined_patch(
    mesh: &Mesh,
    rim_sets: &[RimSet<'_>],
    old_vertex: &[u32],
    parts: &PatchParts,
    rims: &HoleRims,
    options: &FillOptions,
) -> Result<Patch, PatchError> {
    let mut points: Vec<_> = rims.geometry.points().collect();
    let old = rims.vertices.iter().map(|v| old_vertex[v.index()]);
    let mut number: FxHashMap<u32, u32> = old.zip(0..).collect();
    let mut triangles = Vec::new();
    let mut numbered = |v: VertexId, points: &mut Vec<_>| {
        *number.entry(v.0).or_insert_with(|| {
            points.push(mesh.position(v));
            points.len() as u32 - 1
        })
    };
    for &face in &parts.strips {
        let corners = mesh.topology.face_vertices(FaceId(face));
        triangles.push(corners.map(|v| numbered(v, &mut points)));
    }
    for &set in &parts.sets {
        let own = HoleRims::new(mesh, &rim_sets[set]);
        let patch = patch::blend(&own.geometry, options.patch)?;
        let rim = own.vertices.iter().map(|&v| numbered(v, &mut points));
        let mut local: Vec<u32> = rim.collect();
        local.extend((points.len() as u32..).take(patch.new_points().len()));
        points.extend_from_slice(patch.new_points());
        let own = patch.triangles.iter();
        triangles.extend(own.map(|t| t.map(|v| local[v as usize])));
    }
    Ok(Patch {
        rim: rims.vertices.len(),
        points,
        triangles,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fill::{PreparedFill, bridge, rim_sets, segment_at};
    use crate::mesh::{DVec3, check_mesh, self_intersections};
    use crate::shapes;

    /// A sphere without its part above `top` and, if given, below `bottom`, with a bridge.
    fn bridged(top: f64, bottom: f64, ends: [DVec3; 2]) -> (Mesh, Mesh, Vec<u32>) {
        let ball = shapes::sphere(2000, 7);
        let (positions, triangles) = shapes::cut_where(&ball, |p| p.z > top || p.z < bottom);
        let mesh = Mesh::from_triangles(positions, &triangles).expect("manifold");
        let loops = boundary_loops(&mesh);
        let [from, to] = ends.map(|p| segment_at(&mesh, &loops, p, 2).expect("loops"));
        let with = bridge(&mesh, &loops, from, to).expect("a bridge");
        let strip = mesh.face_count() as u32..with.face_count() as u32;
        (mesh, with, strip.collect())
    }

    /// A sphere with one hole and a bridge across it.
    fn bridged_across() -> (Mesh, Mesh, Vec<u32>) {
        let ends = [-0.77, 0.77].map(|x| DVec3::new(x, 0.0, 0.64));
        bridged(0.64, -2.0, ends)
    }

    fn farthest(mesh: &Mesh) -> f64 {
        let off = mesh.positions.iter().map(|p| (p.length() - 1.0).abs());
        off.fold(0.0, f64::max)
    }

    #[test]
    fn a_bridge_across_a_hole_leaves_no_bump() {
        let (mesh, with, strip) = bridged_across();
        let loops = boundary_loops(&with);
        assert_eq!(loops.len(), 2);
        let sets = rim_sets(&with, &loops, &[LoopId::FIRST, 1.into()], true);
        let fill = |strip: &[u32]| {
            let filled =
                PreparedFill::new(&with, &sets, strip, &FillOptions::default()).run(&|_, _| true);
            filled.expect("filled").mesh
        };
        let (flowing, fixed) = (fill(&strip), fill(&[]));
        assert_eq!(flowing.positions[..mesh.vertex_count()], mesh.positions);
        let given = mesh.topology.triangles();
        assert!(given.eq(flowing.topology.triangles().take(mesh.face_count())));
        check_mesh(&flowing).expect("sound");
        assert!(flowing.topology.boundary_loops().is_empty());
        let triangles: Vec<_> = flowing.topology.triangles().collect();
        assert!(self_intersections(&flowing.positions, &triangles, None, 1).is_empty());
        let (off, bump) = (farthest(&flowing), farthest(&fixed));
        assert!(10.0 * off < bump && off < 4e-3, "{off} {bump}");
    }

    #[test]
    fn holes_joined_by_a_bridge_become_a_tube() {
        // a strip on the inside joins the two openings
        let (mesh, with, strip) = bridged(
            0.7,
            -0.7,
            [DVec3::new(0.7, 0.0, 0.7), DVec3::new(0.7, 0.0, -0.7)],
        );
        let loops = boundary_loops(&with);
        assert_eq!(loops.len(), 1);
        let sets = [vec![&loops[0]]];
        let released = release(&with, &sets, &strip).expect("released");
        assert_eq!(released.erased.mesh.positions, mesh.positions);
        assert_eq!(released.rims.len(), 1);
        assert_eq!(released.rims[0].len(), 2);
        let filled =
            PreparedFill::new(&with, &sets, &strip, &FillOptions::default()).run(&|_, _| true);
        let filled = filled.expect("filled").mesh;
        check_mesh(&filled).expect("sound");
        assert_eq!(filled.topology.boundary_loops().len(), 0);
        // a torus
        let t = &filled.topology;
        let faces = t.triangles().count();
        assert_eq!(filled.vertex_count() + faces, t.halfedge_count() / 2);
    }

    #[test]
    fn a_strip_beside_an_open_hole_is_kept() {
        let (_, with, strip) = bridged_across();
        let loops = boundary_loops(&with);
        assert!(release(&with, &[vec![&loops[0]]], &strip).is_none());
        let options = FillOptions::default();
        let prepared = PreparedFill::new(&with, &[vec![&loops[0]]], &strip, &options);
        let half = prepared.run(&|_, _| true).expect("filled").mesh;
        // with the second hole the strip flows too, beside the first patch
        let rest = boundary_loops(&half);
        let released = release(&half, &[vec![&rest[0]]], &strip).expect("released");
        assert_eq!(released.rims[0].len(), 1);
        assert!(released.rims[0][0].edges() > rest[0].edges() / 2);
    }
}
