//! Fill-reducing order of a surface graph by geometric nested dissection.
//!
//! A plane across the longest principal axis halves the vertices. The vertices of one half that
//! have a neighbour in the other become the separator, which is eliminated last. The halves are
//! divided in the same way until they are small. A surface graph of n vertices has separators of
//! order √n (Lipton, Rose, Tarjan 1979), so the Cholesky factor has O(n log n) entries. A surface that
//! is crumpled in space has no such planes. A part whose separator has more than √(n d) vertices, d
//! being the mean number of neighbours, is halved by a breadth-first search in the graph instead; the
//! separators of smooth surfaces have at most 0.7 √(n d). Vertices with very many neighbours are
//! eliminated after all separators.

use glam::DVec3;

/// Parts of at most this many vertices are not divided further.
const LEAF: usize = 48;

/// Vertices with more neighbours than this are hubs. A part and the rest of it would all be
/// neighbours through them, so they are eliminated after all others.
const HUB: usize = 256;

/// Region label of vertices whose place is final.
const PLACED: u32 = u32::MAX;

/// Elimination order of the vertices of a graph embedded in space: `perm[new] = old`.
///
/// `points` gives the position of each vertex; `adjacency_offsets` (length n + 1) and `adjacency`
/// its neighbours, each edge from both ends. For the matrix of a finite element method pass the
/// graph of the *matrix* (vertices that share a patch are neighbours), not the edges of the mesh:
/// the separators must cut the former.
///
/// Any points are valid (coincident, collinear, not finite), and so are disconnected graphs; they
/// only increase the fill. Deterministic; O(n log n) plus one pass over the adjacency.
///
/// # Panics
/// If `adjacency_offsets` is not of length `points.len() + 1`, or an index is out of range.
pub fn nested_dissection(
    points: &[DVec3],
    adjacency_offsets: &[u32],
    adjacency: &[u32],
) -> Vec<u32> {
    let n = points.len();
    assert_eq!(
        adjacency_offsets.len(),
        n + 1,
        "one offset more than vertices"
    );
    let mut order: Vec<u32> = (0..n as u32).collect();
    if n <= LEAF {
        return order;
    }
    let graph = Graph {
        points,
        offsets: adjacency_offsets,
        adjacency,
    };
    let reach = graph.reach();
    let mut region = vec![0_u32; n];
    let mut next_region = 1;
    let mut scratch = Scratch::default();
    let is_hub = |v: u32| graph.neighbours(v).len() > HUB;
    // stable: without hubs the order is unchanged
    order.sort_by_key(|&v| is_hub(v));
    let others = order.partition_point(|&v| !is_hub(v));
    for &v in &order[others..] {
        region[v as usize] = PLACED;
    }
    let mut open = vec![(0, others)];
    while let Some((begin, end)) = open.pop() {
        let part = &mut order[begin..end];
        if part.len() <= LEAF {
            for &v in part.iter() {
                region[v as usize] = PLACED;
            }
            continue;
        }
        let labels = [next_region, next_region + 1];
        next_region += 2;
        let sizes = dissect(&graph, &reach, part, &mut region, labels, &mut scratch);
        open.push((begin, begin + sizes[0]));
        open.push((begin + sizes[0], begin + sizes[0] + sizes[1]));
    }
    order
}

struct Graph<'a> {
    points: &'a [DVec3],
    offsets: &'a [u32],
    adjacency: &'a [u32],
}

impl Graph<'_> {
    fn neighbours(&self, v: u32) -> &[u32] {
        let v = v as usize;
        &self.adjacency[self.offsets[v] as usize..self.offsets[v + 1] as usize]
    }

    /// Distance of the farthest neighbour of each vertex. A vertex farther than that from a plane
    /// has no neighbour beyond the plane, so its neighbours need no check.
    fn reach(&self) -> Vec<f64> {
        (0..self.points.len())
            .map(|v| {
                let farthest = self
                    .neighbours(v as u32)
                    .iter()
                    .map(|&u| self.points[u as usize].distance_squared(self.points[v]))
                    .fold(0.0, f64::max);
                // Room for the rounding of the comparison with distances along an axis.
                farthest.sqrt() * (1.0 + 1e-9)
            })
            .collect()
    }
}

#[derive(Default)]
struct Scratch {
    keyed: Vec<(f64, u32)>,
    boundary: [Vec<u32>; 2],
    queue: Vec<u32>,
}

/// Reorders `part` into first half, second half, separator; returns the sizes of the halves.
fn dissect(
    graph: &Graph,
    reach: &[f64],
    part: &mut [u32],
    region: &mut [u32],
    labels: [u32; 2],
    scratch: &mut Scratch,
) -> [usize; 2] {
    let (centre, axis) = principal_axis(graph.points, part);
    let keyed = &mut scratch.keyed;
    keyed.clear();
    keyed.extend(
        part.iter()
            .map(|&v| (axis.dot(graph.points[v as usize] - centre), v)),
    );
    let mut side = halve(graph, Some(reach), region, labels, scratch);
    let neighbours: usize = part.iter().map(|&v| graph.neighbours(v).len()).sum();
    if scratch.boundary[side].len().pow(2) > neighbours {
        breadth_first(graph, part, region, labels, scratch);
        side = halve(graph, None, region, labels, scratch);
    }
    let separator = &scratch.boundary[side];
    for &v in separator {
        region[v as usize] = PLACED;
    }
    let half = part.len() / 2;
    let mut at = 0;
    let mut sizes = [0; 2];
    for (size, side_keyed) in sizes
        .iter_mut()
        .zip([&scratch.keyed[..half], &scratch.keyed[half..]])
    {
        let begin = at;
        for &(_, v) in side_keyed {
            if region[v as usize] != PLACED {
                part[at] = v;
                at += 1;
            }
        }
        *size = at - begin;
    }
    part[at..].copy_from_slice(separator);
    sizes
}

/// Halves `scratch.keyed` at the median of the keys, labels the halves in `region`, and finds the
/// vertices of each half with neighbours in the other. Returns the half with fewer of those.
///
/// `reach` is that of [`Graph::reach`] if the keys are distances along an axis.
fn halve(
    graph: &Graph,
    reach: Option<&[f64]>,
    region: &mut [u32],
    labels: [u32; 2],
    scratch: &mut Scratch,
) -> usize {
    let keyed = &mut scratch.keyed;
    let half = keyed.len() / 2;
    let by_key = |a: &(f64, u32), b: &(f64, u32)| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1));
    let (_, &mut (cut, _), _) = keyed.select_nth_unstable_by(half, by_key);
    for (i, &(_, v)) in keyed.iter().enumerate() {
        region[v as usize] = labels[usize::from(i >= half)];
    }
    for (side, side_keyed) in [&keyed[..half], &keyed[half..]].into_iter().enumerate() {
        let other = labels[1 - side];
        let boundary = &mut scratch.boundary[side];
        boundary.clear();
        for &(key, v) in side_keyed {
            let too_far = reach.is_some_and(|reach| (key - cut).abs() > reach[v as usize]);
            if !too_far
                && graph
                    .neighbours(v)
                    .iter()
                    .any(|&u| region[u as usize] == other)
            {
                boundary.push(v);
            }
        }
    }
    usize::from(scratch.boundary[1].len() < scratch.boundary[0].len())
}

/// Sets the keys of `part` to the ranks in a breadth-first search within it, from the vertex that
/// a first search reaches last. Vertices of other components follow.
///
/// The vertices of `part` have one of `labels` in `region`, and have the first one afterwards.
fn breadth_first(
    graph: &Graph,
    part: &[u32],
    region: &mut [u32],
    labels: [u32; 2],
    scratch: &mut Scratch,
) {
    let [not_reached, reached] = labels;
    let queue = &mut scratch.queue;
    let mut first = part[0];
    for _ in 0..2 {
        for &v in part {
            region[v as usize] = not_reached;
        }
        queue.clear();
        for seed in std::iter::once(first).chain(part.iter().copied()) {
            let mut head = queue.len();
            if region[seed as usize] == not_reached {
                region[seed as usize] = reached;
                queue.push(seed);
            }
            while head < queue.len() {
                for &u in graph.neighbours(queue[head]) {
                    if region[u as usize] == not_reached {
                        region[u as usize] = reached;
                        queue.push(u);
                    }
                }
                head += 1;
            }
        }
        first = queue[queue.len() - 1];
    }
    scratch.keyed.clear();
    scratch
        .keyed
        .extend(queue.iter().enumerate().map(|(rank, &v)| (rank as f64, v)));
}

/// Centroid of some points and the unit direction of their largest variance.
fn principal_axis(points: &[DVec3], part: &[u32]) -> (DVec3, DVec3) {
    let sum: DVec3 = part.iter().map(|&v| points[v as usize]).sum();
    let centre = sum / part.len() as f64;
    let [mut xx, mut xy, mut xz, mut yy, mut yz, mut zz] = [0.0; 6];
    for &v in part {
        let d = points[v as usize] - centre;
        xx += d.x * d.x;
        xy += d.x * d.y;
        xz += d.x * d.z;
        yy += d.y * d.y;
        yz += d.y * d.z;
        zz += d.z * d.z;
    }
    let mut m = glam::DMat3::from_cols(
        DVec3::new(xx, xy, xz),
        DVec3::new(xy, yy, yz),
        DVec3::new(xz, yz, zz),
    );
    // Squaring six times is the power method with exponent 64; near ties any direction is
    // acceptable.
    for _ in 0..6 {
        let scale = m.x_axis.x.max(m.y_axis.y).max(m.z_axis.z);
        m *= 1.0 / scale;
        m = m * m;
    }
    let longest = [m.x_axis, m.y_axis, m.z_axis]
        .into_iter()
        .fold(DVec3::ZERO, |a, b| {
            if b.length_squared() > a.length_squared() {
                b
            } else {
                a
            }
        });
    (centre, longest.try_normalize().unwrap_or(DVec3::X))
}

#[cfg(test)]
#[path = "ordering_tests.rs"]
mod tests;
