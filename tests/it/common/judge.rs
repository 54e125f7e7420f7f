//! Measures a filled mesh: the kept part, the added part, and the distance from the true surface.
//!
//! The error of a new vertex is its distance from the true surface divided by the radius of its
//! own hole (RMS distance of the hole's rim vertices from their mean). A case's error is the RMS
//! over all new vertices whose hole has a truth, so a hole counts by the vertices it got. A new
//! vertex belongs to the hole whose rim its connected patch touches most.

use std::collections::{HashMap, HashSet};

use meniscus::mesh::{
    DVec3, FaceId, HalfedgeId, Topology, VertexId, components, folded_edges, self_intersections,
};

use super::manifest::Loop;
use super::raw::RawMesh;
use super::truth::Truth;

/// Normals of neighbours that differ by more than this are called a fold; no test surface, cut
/// or uncut, bends by more than 70 degrees over an edge.
pub const FOLD_DEGREES: f64 = 150.0;

/// How strictly originals are compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Keep {
    /// All vertices first, bit-identical, and all faces with their orientation.
    Everything,
    /// Repair may weld, cut, drop and turn: every position must still occur, bit-identical.
    Positions,
}

/// The measures; `failures` lists the violated requirements.
#[derive(Clone, Debug, Default)]
pub struct Verdict {
    pub failures: Vec<String>,
    pub new_vertices: usize,
    pub new_faces: usize,
    pub loops_left: usize,
    pub intersections: usize,
    pub folds: usize,
    /// Connected pieces of the whole.
    pub components: usize,
    /// Mean angle between the normals of old and new faces across the rims, in degrees, edges counted
    /// alike.
    pub rim_angle: f64,
    /// RMS of error / hole radius over new vertices with a truth; NaN if there are none.
    pub rms: f64,
    /// The largest of them.
    pub max: f64,
    /// Hole by hole (in manifest order, those with new vertices): edges, RMS, maximum.
    pub holes: Vec<(usize, f64, f64)>,
}

/// Judges `output` as a filling of `input`.
pub fn judge(
    input: &RawMesh,
    output: &RawMesh,
    keep: Keep,
    loops: &[Loop],
    truth: Option<&Truth>,
) -> Verdict {
    let mut verdict = Verdict {
        rms: f64::NAN,
        max: f64::NAN,
        ..Verdict::default()
    };
    if let Some(v) = output.positions.iter().position(|p| !p.is_finite()) {
        verdict.failures.push(format!("vertex {v} is not finite"));
        return verdict;
    }
    if output.faces.is_empty() {
        verdict.failures.push("no faces".into());
        return verdict;
    }
    let is_new = kept_vertices(input, output, keep, &mut verdict);
    verdict.new_vertices = is_new.iter().filter(|&&n| n).count();
    let triangles = output.triangles();
    let new_faces = added_faces(input, output, &triangles, keep, &mut verdict);
    verdict.new_faces = new_faces.len();

    let pairs = self_intersections(&output.positions, &triangles, Some(&new_faces), 1000);
    verdict.intersections = pairs.len();
    if let Some([f, g]) = pairs.first() {
        verdict.failures.push(format!(
            "{} self-intersections, first of faces {f} and {g}",
            pairs.len()
        ));
    }
    match Topology::from_triangles(output.positions.len(), &triangles) {
        Err(error) => verdict.failures.push(error.to_string()),
        Ok(topology) => {
            verdict.loops_left = topology.boundary_loops().len();
            verdict.components = components(&topology).count;
            verdict.rim_angle = rim_angle(output, &topology, &new_faces);
            count_folds(output, &topology, &new_faces, &mut verdict);
            if let Some(truth) = truth {
                measure(output, &topology, &is_new, loops, truth, &mut verdict);
            }
        }
    }
    verdict
}

fn bits(p: DVec3) -> [u64; 3] {
    p.to_array().map(f64::to_bits)
}

/// Marks the new vertices, and reports originals that are missing.
fn kept_vertices(
    input: &RawMesh,
    output: &RawMesh,
    keep: Keep,
    verdict: &mut Verdict,
) -> Vec<bool> {
    let n = input.positions.len();
    let first_wrong = (0..n).find(|&v| {
        output
            .positions
            .get(v)
            .is_none_or(|&p| bits(p) != bits(input.positions[v]))
    });
    if keep == Keep::Everything {
        if let Some(v) = first_wrong {
            verdict
                .failures
                .push(format!("original vertex {v} is not where and as it was"));
        }
        return (0..output.positions.len()).map(|v| v >= n).collect();
    }
    let before: HashSet<_> = input.positions.iter().map(|&p| bits(p)).collect();
    if first_wrong.is_some() {
        let after: HashSet<_> = output.positions.iter().map(|&p| bits(p)).collect();
        let lost = before.difference(&after).count();
        if lost > 0 {
            verdict.failures.push(format!("{lost} vertices lost"));
        }
    }
    // copies from cuts have the position of their original
    output
        .positions
        .iter()
        .map(|&p| !before.contains(&bits(p)))
        .collect()
}

/// The faces that are not in the input (compared by corner positions). Also reports originals that
/// are missing.
fn added_faces(
    input: &RawMesh,
    output: &RawMesh,
    triangles: &[[u32; 3]],
    keep: Keep,
    verdict: &mut Verdict,
) -> Vec<u32> {
    let rotated = |[a, b, c]: [u32; 3]| [[a, b, c], [b, c, a], [c, a, b]].into_iter().min();
    if keep == Keep::Everything {
        let before: HashSet<_> = input.triangles().into_iter().map(rotated).collect();
        let after: HashSet<_> = triangles.iter().map(|&t| rotated(t)).collect();
        let lost = before.difference(&after).count();
        if lost > 0 {
            verdict.failures.push(format!("{lost} original faces lost"));
        }
        return (0..triangles.len() as u32)
            .filter(|&f| !before.contains(&rotated(triangles[f as usize])))
            .collect();
    }
    let key = |positions: &[DVec3], t: &[u32; 3]| {
        let mut corners = t.map(|v| bits(positions[v as usize]));
        corners.sort_unstable();
        corners
    };
    let before: HashSet<_> = input
        .triangles()
        .iter()
        .map(|t| key(&input.positions, t))
        .collect();
    (0..triangles.len() as u32)
        .filter(|&f| !before.contains(&key(&output.positions, &triangles[f as usize])))
        .collect()
}

fn rim_angle(output: &RawMesh, topology: &Topology, new_faces: &[u32]) -> f64 {
    let new: HashSet<u32> = new_faces.iter().copied().collect();
    let normal = |f: FaceId| {
        let corners = topology.face_vertices(f);
        let [a, b, c] = corners.map(|v| output.positions[v.index()]);
        (b - a).cross(c - a)
    };
    let (mut sum, mut count) = (0.0, 0usize);
    for h in topology.halfedges() {
        let (f, g) = (topology.face(h), topology.face(h.twin()));
        if f.is_some() && g.is_some() && new.contains(&f.0) && !new.contains(&g.0) {
            sum += normal(f).angle_between(normal(g)).to_degrees();
            count += 1;
        }
    }
    sum / count as f64
}

fn count_folds(output: &RawMesh, topology: &Topology, new_faces: &[u32], verdict: &mut Verdict) {
    let new: HashSet<u32> = new_faces.iter().copied().collect();
    let folds = folded_edges(&output.positions, topology, FOLD_DEGREES.to_radians());
    verdict.folds = folds
        .iter()
        .filter(|pair| pair.iter().any(|f| new.contains(f)))
        .count();
    if verdict.folds > 0 {
        verdict
            .failures
            .push(format!("{} folded edges in the patch", verdict.folds));
    }
}

/// For every new vertex the loop (index into `loops`) its connected patch touches most.
fn holes_of_new_vertices(
    output: &RawMesh,
    topology: &Topology,
    is_new: &[bool],
    loops: &[Loop],
) -> Vec<Option<usize>> {
    let mut rim = HashMap::new();
    for (l, one) in loops.iter().enumerate() {
        rim.extend(one.vertices.iter().map(|&v| (v, l)));
    }
    // without listed rims (only single-hole files) every patch is the one hole's
    let only = (rim.is_empty() && loops.len() == 1).then_some(0);
    let mut hole = vec![None; output.positions.len()];
    let mut seen = vec![false; output.positions.len()];
    for start in 0..output.positions.len() {
        if !is_new[start] || seen[start] {
            continue;
        }
        seen[start] = true;
        let mut patch = vec![start];
        let mut touched = vec![0usize; loops.len()];
        let mut next = 0;
        while let Some(&v) = patch.get(next) {
            next += 1;
            for w in topology.neighbours(VertexId::from(v)) {
                if !is_new[w.index()] {
                    if let Some(&l) = rim.get(&w.0) {
                        touched[l] += 1;
                    }
                } else if !seen[w.index()] {
                    seen[w.index()] = true;
                    patch.push(w.index());
                }
            }
        }
        let most = (0..loops.len())
            .filter(|&l| touched[l] > 0)
            .max_by_key(|&l| (touched[l], std::cmp::Reverse(l)));
        for v in patch {
            hole[v] = most.or(only);
        }
    }
    hole
}

fn measure(
    output: &RawMesh,
    topology: &Topology,
    is_new: &[bool],
    loops: &[Loop],
    truth: &Truth,
    verdict: &mut Verdict,
) {
    let hole = holes_of_new_vertices(output, topology, is_new, loops);
    let stray = (0..is_new.len())
        .filter(|&v| is_new[v] && hole[v].is_none())
        .count();
    if stray > 0 && !loops.is_empty() {
        verdict
            .failures
            .push(format!("{stray} new vertices belong to no hole"));
    }
    let (mut sum, mut count, mut max) = (0.0, 0usize, 0.0f64);
    for (l, one) in loops.iter().enumerate() {
        let errors: Vec<f64> = (0..is_new.len())
            .filter(|&v| hole[v] == Some(l) && one.has_truth)
            .map(|v| truth.distance(output.positions[v]) / one.radius)
            .collect();
        if errors.is_empty() {
            continue;
        }
        let squares: f64 = errors.iter().map(|e| e * e).sum();
        let worst = errors.iter().copied().fold(0.0, f64::max);
        verdict
            .holes
            .push((one.edges, (squares / errors.len() as f64).sqrt(), worst));
        sum += squares;
        count += errors.len();
        max = max.max(worst);
    }
    if count > 0 {
        verdict.rms = (sum / count as f64).sqrt();
        verdict.max = max;
    }
}

/// The boundary loops of a mesh as the manifest would list them, for generated meshes.
pub fn loops_of(mesh: &RawMesh) -> Result<Vec<Loop>, String> {
    let topology = Topology::from_triangles(mesh.positions.len(), &mesh.triangles())
        .map_err(|e| e.to_string())?;
    let describe = |ring: &Vec<HalfedgeId>| {
        let vertices: Vec<u32> = ring.iter().map(|&h| topology.origin(h).0).collect();
        let at = |v: &u32| mesh.positions[*v as usize];
        let mean = vertices.iter().map(at).sum::<DVec3>() / vertices.len() as f64;
        let square: f64 = vertices.iter().map(|v| at(v).distance_squared(mean)).sum();
        Loop {
            fill: true,
            has_truth: true,
            edges: vertices.len(),
            radius: (square / vertices.len() as f64).sqrt(),
            vertices,
        }
    };
    Ok(topology.boundary_loops().iter().map(describe).collect())
}
